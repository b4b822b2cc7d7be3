"""Every root of a square system in a box: interval branch and prune in n dimensions.

A box is narrowed by one equation after another; it is dropped if an enclosure of some equation excludes 0 or
its Hansen–Sengupta image is empty, settled if that image proves exactly one root, otherwise contracted and,
where that gains little, cut across the side along which the equations vary most (Kearfott's smear, added
up). A front of boxes is treated at once, the newest first.

The step on many boxes is that of Hansen and Sengupta: for F: Rⁿ → Rⁿ on a box X with centre c, the
preconditioned interval Gauss–Seidel image of X holds every root of F in X. If it is empty, X holds none; if
it lies in the interior of X, X holds exactly one (A. Neumaier, *Interval Methods for Systems of Equations*,
1990, theorem 5.1.8 and section 5.2). Intervals are held as middle and radius; every product widens the
radius by a bound of its rounding.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.deadline import expect_time
from solver.numerics.one_unknown import split_point
from solver.numerics.tolerances import EPS, NARROW

Array: TypeAlias = NDArray[np.float64]
Mask: TypeAlias = NDArray[np.bool_]
BoxFunction: TypeAlias = Callable[[Array, Array], tuple[Array, Array]]


class NewtonImage(NamedTuple):
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


def narrowed_by_rows(
    enclose: BoxFunction, enclose_jacobian: BoxFunction, lo: Array, hi: Array
) -> tuple[Array, Array]:
    """The boxes ``lo``, ``hi`` (k, n) with every side narrowed by every equation as it stands:

    x_j ∈ c_j − (F_i(c) + Σ_{m≠j} J_im (x_m − c_m)) / J_ij, where J_ij excludes 0. No root is lost; an empty
    box has its ends crossed. Over wide boxes, for which no inverse of a middle is of use, this gains most.
    """
    centre = lo + (hi - lo) / 2
    below, above = enclose_jacobian(lo, hi)
    at_lo, at_hi = (end[:, :, None] for end in enclose(centre, centre))
    n = lo.shape[1]
    reach = np.maximum(abs(below), abs(above)) * np.maximum(hi - centre, centre - lo)[:, None, :]
    others = (reach @ (1.0 - np.eye(n))) * (1 + 8 * EPS * n)
    smooth = np.isfinite(reach).all(axis=2)[:, :, None]
    apart = smooth & ((below > 0) | (above < 0))
    divisors = np.where(apart, below, 1.0), np.where(apart, above, 1.0)
    least, most = _divided((at_lo - others, at_hi + others), divisors)
    middle = centre[:, None, :]
    low = np.where(apart, np.nextafter(middle - most, -np.inf), -np.inf)
    high = np.where(apart, np.nextafter(middle - least, np.inf), np.inf)
    return np.fmax(lo, np.fmax.reduce(low, axis=1)), np.fmin(hi, np.fmin.reduce(high, axis=1))


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
    ends = np.where(nonzero, divisor - radius, 1.0), np.where(nonzero, divisor + radius, 1.0)
    return _divided((middle - reach, middle + reach), ends)


def _divided(dividend: tuple[Array, Array], divisor: tuple[Array, Array]) -> tuple[Array, Array]:
    """The quotient of two intervals by their ends; the divisor excludes 0."""
    quotients = [top / bottom for top in dividend for bottom in divisor]
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


Box: TypeAlias = tuple[tuple[float, float], ...]


PASSES, GAIN = 2, 0.9
"""Steps by single equations, and the share of its length below which a side has to come for another one."""
FRONT = 2_000
"""So many boxes, the last ones, are treated together."""


class SubdivisionLimits(NamedTuple):
    """``boxes`` in all, ``alive`` at once."""

    boxes: int = 100_000
    alive: int = 8_000


STANDARD_LIMITS = SubdivisionLimits()


class Subdivision(NamedTuple):
    """``proved``: boxes, as narrow as rounding allows, each with exactly one root, no two with the same.

    ``complete``: no box was left of which nothing is known, so that every root in the box searched is there.
    """

    proved: tuple[Box, ...]
    complete: bool
    boxes: int = 0

    @property
    def roots(self) -> tuple[tuple[float, ...], ...]:
        """The middles of the proved boxes."""
        return tuple(tuple(lo + (hi - lo) / 2 for lo, hi in box) for box in self.proved)


def branch_and_prune(
    enclose: BoxFunction,
    enclose_jacobian: BoxFunction,
    box: Sequence[tuple[float, float]],
    limits: SubdivisionLimits = STANDARD_LIMITS,
) -> Subdivision:
    """Search the roots of F: Rⁿ → Rⁿ in a finite box of n sides, given as (low, high), faces included.

    ``enclose(lo, hi)`` takes corners (k, n) and returns bounds (k, n) of F over each box, nan, nan for an
    equation undefined all over it; ``enclose_jacobian`` likewise bounds (k, n, n) of ∂F_i/∂x_j, infinite
    or nan on a box on which F may be undefined or discontinuous somewhere.
    """
    low, high = (np.array([[side[end] for side in box]], dtype=float) for end in (0, 1))
    search = _Search(enclose, enclose_jacobian, low, high, limits)
    with np.errstate(all="ignore"):
        return search.run()


class _Search:
    def __init__(
        self,
        enclose: BoxFunction,
        enclose_jacobian: BoxFunction,
        low: Array,
        high: Array,
        limits: SubdivisionLimits,
    ) -> None:
        self.enclose, self.enclose_jacobian = enclose, enclose_jacobian
        self.low, self.high, self.limits = low, high, limits
        self.proved: list[tuple[Array, Array]] = []
        self.unresolved = 0
        self.boxes = 0

    def run(self) -> Subdivision:
        lo, hi = self.low, self.high
        while len(lo) and len(lo) <= self.limits.alive and self.boxes <= self.limits.boxes:
            expect_time()
            next_lo, next_hi = self._level(lo[-FRONT:], hi[-FRONT:])
            lo = np.concatenate([lo[:-FRONT], next_lo])
            hi = np.concatenate([hi[:-FRONT], next_hi])
        self.unresolved += len(lo)
        proved = tuple(_as_box(*pair) for pair in self._distinct())
        return Subdivision(proved, not self.unresolved, self.boxes)

    def _level(self, lo: Array, hi: Array) -> tuple[Array, Array]:
        """Treat every box once; the boxes of the next level."""
        whole_lo, whole_hi = lo, hi
        lo, hi, empty = self._narrowed_by_rows(lo, hi)
        whole_lo, whole_hi, lo, hi = (ends[~empty] for ends in (whole_lo, whole_hi, lo, hi))
        kept = self._may_hold_root(lo, hi)
        whole_lo, whole_hi, lo, hi = (ends[kept] for ends in (whole_lo, whole_hi, lo, hi))
        image = self._newton(lo, hi)
        self._settle(lo, hi, image.unique)
        covered = self._settle_inflated(lo, hi, image.regular & ~image.unique & ~image.empty)
        rest = ~image.empty & ~image.unique & ~covered
        return self._divide(whole_lo[rest], whole_hi[rest], image.lo[rest], image.hi[rest])

    def _narrowed_by_rows(self, lo: Array, hi: Array) -> tuple[Array, Array, Mask]:
        """The boxes narrowed for as long as that gains much, and which of them hold no root."""
        lo, hi, empty = lo.copy(), hi.copy(), np.zeros(len(lo), bool)
        live = np.arange(len(lo))
        for _ in range(PASSES):
            new_lo, new_hi = narrowed_by_rows(self.enclose, self.enclose_jacobian, lo[live], hi[live])
            gained = ((new_hi - new_lo) < GAIN * (hi[live] - lo[live])).any(axis=1)
            lo[live], hi[live] = new_lo, new_hi
            empty[live] = (new_lo > new_hi).any(axis=1)
            live = live[gained & ~empty[live]]
            if not len(live):
                break
        return lo, hi, empty

    def _may_hold_root(self, lo: Array, hi: Array) -> Mask:
        self.boxes += len(lo)
        below, above = self.enclose(lo, hi)
        excluding = (below > 0) | (above < 0) | (np.isnan(below) & np.isnan(above))
        kept: Mask = ~np.logical_or.reduce(excluding, axis=1)
        return kept

    def _newton(self, lo: Array, hi: Array) -> NewtonImage:
        return interval_newton(self.enclose, self.enclose_jacobian, lo, hi)

    # -- proofs ------------------------------------------------------------------------------------------

    def _settle(self, lo: Array, hi: Array, chosen: Mask) -> None:
        """Keep each proved box with the narrow box that its one root lies in."""
        for low, high in zip(lo[chosen], hi[chosen], strict=True):
            self.proved.append(self._narrowed(low, high))

    def _narrowed(self, low: Array, high: Array) -> tuple[Array, Array]:
        lo, hi = low[None], high[None]
        for _ in range(30):
            image = self._newton(lo, hi)
            if image.empty[0] or not ((image.hi - image.lo) < 0.9 * (hi - lo)).any():
                break
            lo, hi = image.lo, image.hi
        return lo[0], hi[0]

    def _settle_inflated(self, lo: Array, hi: Array, chosen: Mask) -> Mask:
        """Prove the boxes that lie in a wider one with exactly one root: roots on faces and corners."""
        covered = np.zeros(len(lo), bool)
        index = np.flatnonzero(chosen)
        if not index.size:
            return covered
        pad = hi[index] - lo[index] + 8 * np.spacing(np.maximum(abs(lo[index]), abs(hi[index])))
        wide_lo, wide_hi = lo[index] - pad, hi[index] + pad
        unique = self._newton(wide_lo, wide_hi).unique
        self._settle(wide_lo, wide_hi, unique)
        covered[index[unique]] = True
        return covered

    def _distinct(self) -> list[tuple[Array, Array]]:
        """Proved boxes inside the range; two narrow ones that overlap hold the same root."""
        distinct: list[tuple[Array, Array]] = []
        for lo, hi in self.proved:
            in_range = bool(((lo <= self.high[0]) & (hi >= self.low[0])).all())
            if in_range and not any(((lo <= h) & (hi >= g)).all() for g, h in distinct):
                distinct.append((lo, hi))
        return sorted(distinct, key=lambda pair: pair[0].tolist())

    # -- division ----------------------------------------------------------------------------------------

    def _divide(self, lo: Array, hi: Array, new_lo: Array, new_hi: Array) -> tuple[Array, Array]:
        """Boxes that shrank much go on as they are; others are cut, or left where too narrow to cut."""
        widths = self._relative_widths(new_lo, new_hi)
        wide = widths > NARROW
        shrunk = (((new_hi - new_lo) < 0.5 * (hi - lo)) & wide).any(axis=1)
        narrow = ~wide.any(axis=1)
        self.unresolved += int(narrow.sum())
        kept, cut = shrunk & ~narrow, ~shrunk & ~narrow
        halves = self._halves(new_lo[cut], new_hi[cut], widths[cut])
        return np.concatenate([new_lo[kept], halves[0]]), np.concatenate([new_hi[kept], halves[1]])

    def _relative_widths(self, lo: Array, hi: Array) -> Array:
        floor = NARROW * (self.high - self.low)
        size = np.maximum(np.maximum(abs(lo), abs(hi)), np.maximum(floor, 1e-300))
        widths: Array = (hi - lo) / size
        return widths

    def _halves(self, lo: Array, hi: Array, widths: Array) -> tuple[Array, Array]:
        """Cut across the side of largest smear max_i |∂F_i/∂x_j| w_j, or the widest where unbounded."""
        if not len(lo):
            return lo, hi
        below, above = self.enclose_jacobian(lo, hi)
        slopes = np.maximum(abs(below), abs(above))
        rows = slopes * (hi - lo)[:, None, :]
        smear = (rows / np.maximum(rows.sum(axis=2, keepdims=True), 1e-300)).sum(axis=1)
        measure = np.where(np.isfinite(smear).all(axis=1)[:, None], smear, (hi - lo) / (self.high - self.low))
        side = np.where(widths > NARROW, measure, -1.0).argmax(axis=1)
        each = np.arange(len(lo))
        ends = zip(lo[each, side].tolist(), hi[each, side].tolist(), strict=True)
        middle = np.array([split_point(a, b) for a, b in ends])
        left_hi, right_lo = hi.copy(), lo.copy()
        left_hi[each, side] = right_lo[each, side] = middle
        return np.concatenate([lo, right_lo]), np.concatenate([left_hi, hi])


def _as_box(lo: Array, hi: Array) -> Box:
    return tuple(zip(lo.tolist(), hi.tolist(), strict=True))
