"""The Hansen–Sengupta step on many boxes at once.

For F: Rⁿ → Rⁿ on a box X with centre c, the preconditioned interval Gauss–Seidel image of X holds every
root of F in X. If it is empty, X holds none; if it lies in the interior of X, X holds exactly one
(A. Neumaier, *Interval Methods for Systems of Equations*, 1990, theorem 5.1.8 and section 5.2).
Intervals are held as middle and radius; every product widens the radius by a bound of its rounding.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from solver.numerics.tolerances import EPS

Array: TypeAlias = NDArray[np.float64]
Mask: TypeAlias = NDArray[np.bool_]
BoxFunction: TypeAlias = Callable[[Array, Array], tuple[Array, Array]]


@dataclass(frozen=True, slots=True)
class NewtonImage:
    """``lo``, ``hi`` (k, n): image cut with the box. Masks (k,): ``empty``: no root in the box;
    ``unique``: exactly one; ``regular``: the Jacobian is invertible all over the box."""

    lo: Array
    hi: Array
    empty: Mask
    unique: Mask
    regular: Mask


def interval_newton(enclose: BoxFunction, enclose_jacobian: BoxFunction, lo: Array, hi: Array) -> NewtonImage:
    """One step on the boxes ``lo``, ``hi`` (k, n). Boxes with an unbounded Jacobian stay as they are."""
    k, n = lo.shape
    centre = lo + (hi - lo) / 2
    jacobian_lo, jacobian_hi = enclose_jacobian(lo, hi)
    at_lo, at_hi = enclose(centre, centre)
    usable = _finite(jacobian_lo, jacobian_hi) & _finite(at_lo, at_hi)
    middle = np.where(usable[:, None, None], _middle(jacobian_lo, jacobian_hi), np.eye(n))
    inverse, invertible = _inverses(middle)
    usable &= invertible
    jacobian = _product(inverse, jacobian_lo, jacobian_hi)
    shift = _product(inverse, at_lo[:, :, None], at_hi[:, :, None])
    state = _Boxes(lo.copy(), hi.copy(), centre, np.zeros(k, bool), usable.copy())
    for i in range(n):
        row = (jacobian[0][:, i, :], jacobian[1][:, i, :])
        _sweep(state, row, (shift[0][:, i, 0], shift[1][:, i, 0]), i, usable)
    from_identity = np.sum(abs(jacobian[0] - np.eye(n)) + jacobian[1], axis=2)
    regular = usable & (from_identity < 1).all(axis=1)
    return NewtonImage(state.lo, state.hi, state.empty, state.inside & ~state.empty, regular)


@dataclass(slots=True)
class _Boxes:
    """Boxes under contraction: ``inside`` while every image so far lay in the interior."""

    lo: Array
    hi: Array
    centre: Array
    empty: Mask
    inside: Mask


def _sweep(
    boxes: _Boxes, equation: tuple[Array, Array], shift: tuple[Array, Array], i: int, usable: Mask
) -> None:
    """Contract side i by row i: x_i ∈ c_i − (shift_i + Σ_{j≠i} A_ij (x_j − c_j)) / A_ii."""
    row, radius = equation
    half = np.maximum(boxes.hi - boxes.centre, boxes.centre - boxes.lo)
    offset = (boxes.hi - boxes.centre) / 2 - (boxes.centre - boxes.lo) / 2
    spread = np.maximum(half - abs(offset), 0.0)
    others = np.arange(row.shape[1]) != i
    middle = shift[0] + np.sum((row * offset)[:, others], axis=1)
    reach = shift[1] + np.sum((abs(row) * spread + radius * half)[:, others], axis=1)
    reach = reach * (1 + 8 * EPS * row.shape[1]) + 4 * EPS * (abs(middle) + abs(shift[0]))
    nonzero = usable & (abs(row[:, i]) > radius[:, i])
    low, high = _quotient(middle, reach, row[:, i], radius[:, i], nonzero)
    centre = boxes.centre[:, i]
    image_lo = np.where(nonzero, np.nextafter(centre - high, -np.inf), -np.inf)
    image_hi = np.where(nonzero, np.nextafter(centre - low, np.inf), np.inf)
    boxes.inside &= (image_lo > boxes.lo[:, i]) & (image_hi < boxes.hi[:, i])
    boxes.empty |= (image_lo > boxes.hi[:, i]) | (image_hi < boxes.lo[:, i])
    boxes.lo[:, i] = np.where(boxes.empty, boxes.lo[:, i], np.maximum(boxes.lo[:, i], image_lo))
    boxes.hi[:, i] = np.where(boxes.empty, boxes.hi[:, i], np.minimum(boxes.hi[:, i], image_hi))


def _quotient(
    middle: Array, reach: Array, divisor: Array, radius: Array, nonzero: Mask
) -> tuple[Array, Array]:
    """(middle ± reach) / (divisor ± radius) where the divisor excludes 0."""
    ends = (np.where(nonzero, divisor - radius, 1.0), np.where(nonzero, divisor + radius, 1.0))
    quotients = [top / bottom for top in (middle - reach, middle + reach) for bottom in ends]
    slack = 4 * EPS * np.maximum.reduce([abs(q) for q in quotients])
    return np.minimum.reduce(quotients) - slack, np.maximum.reduce(quotients) + slack


def _product(matrix: Array, lo: Array, hi: Array) -> tuple[Array, Array]:
    """Middle and radius of a point matrix times an interval matrix, both stacked (k, ·, ·)."""
    middle = _middle(lo, hi)
    radius = np.maximum(hi - middle, middle - lo)
    size = abs(matrix)
    rounding = (matrix.shape[-1] + 3) * EPS * (size @ abs(middle))
    return matrix @ middle, (size @ radius) * (1 + 8 * EPS * matrix.shape[-1]) + rounding


def _middle(lo: Array, hi: Array) -> Array:
    return lo / 2 + hi / 2


def _finite(lo: Array, hi: Array) -> Mask:
    axes = tuple(range(1, lo.ndim))
    finite: Mask = np.logical_and.reduce(np.isfinite(lo) & np.isfinite(hi), axis=axes)
    return finite


def _inverses(matrices: Array) -> tuple[Array, Mask]:
    """Inverses of the regular ones of (k, n, n) finite matrices; the identity, and False, for the others."""
    identity = np.eye(matrices.shape[-1])
    rows = abs(matrices).sum(axis=2, keepdims=True)
    sizes = np.where(rows > 0, rows, 1.0)
    scaled = matrices / sizes
    regular: Mask = (abs(np.linalg.det(scaled)) > 1e-100) & _finite(scaled, scaled)
    scaled = np.where(regular[:, None, None], scaled, identity)
    try:
        inverse = np.linalg.inv(scaled)
    except np.linalg.LinAlgError:  # a pivot has vanished all the same
        inverse = np.linalg.pinv(scaled)
    inverse = inverse / sizes.swapaxes(1, 2)
    regular &= _finite(inverse, inverse)
    return np.where(regular[:, None, None], inverse, identity), regular
