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
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.deadline import expect_time
from solver.numerics.linear_algebra import Array
from solver.numerics.one_unknown import split_point
from solver.numerics.tolerances import EPS, NARROW

Mask: TypeAlias = NDArray[np.bool_]
BoxFunction: TypeAlias = Callable[[Array, Array], tuple[Array, Array]]


class NewtonImage(NamedTuple):
    """``box`` (2, k, n): image cut with the box. Masks (k,): ``empty``: no root in the box;
    ``unique``: exactly one; ``regular``: the Jacobian is invertible all over the box."""

    box: Array
    empty: Mask
    unique: Mask
    regular: Mask


def interval_newton(enclose: BoxFunction, enclose_jacobian: BoxFunction, box: Array) -> NewtonImage:
    """One step on boxes (2, k, n). Those with an unbounded Jacobian stay as they are."""
    lo, hi = box.copy()
    k, n = lo.shape
    centre = lo + (hi - lo) / 2
    slopes, at = np.array(enclose_jacobian(lo, hi)), np.array(enclose(centre, centre))
    usable = np.logical_and(np.isfinite(slopes).all(axis=(0, 2, 3)), np.isfinite(at).all(axis=(0, 2)))
    inverse, invertible = _inverses(np.where(usable[:, None, None], _middle(*slopes), np.eye(n)))
    usable &= invertible
    jacobian, radius = _product(inverse, *slopes)
    shift, slack = (part[:, :, 0] for part in _product(inverse, *at[:, :, :, None]))
    empty, inside = np.zeros(k, bool), usable.copy()
    for i in range(n):  # x_i ∈ c_i − (shift_i + Σ_{j≠i} A_ij (x_j − c_j)) / A_ii
        row, wide, others = jacobian[:, i], radius[:, i], np.arange(n) != i
        half = np.maximum(hi - centre, centre - lo)
        offset = (hi - centre) / 2 - (centre - lo) / 2
        spread = np.maximum(half - abs(offset), 0.0)
        middle = shift[:, i] + np.sum((row * offset)[:, others], axis=1)
        reach = slack[:, i] + np.sum((abs(row) * spread + wide * half)[:, others], axis=1)
        reach = reach * (1 + 8 * EPS * n) + 4 * EPS * (abs(middle) + abs(shift[:, i]))
        nonzero = usable & (abs(row[:, i]) > wide[:, i])
        divisor = [np.where(nonzero, row[:, i] + side * wide[:, i], 1.0) for side in (-1, 1)]
        low, high = _divided((middle - reach, middle + reach), divisor)
        image_lo = np.where(nonzero, np.nextafter(centre[:, i] - high, -np.inf), -np.inf)
        image_hi = np.where(nonzero, np.nextafter(centre[:, i] - low, np.inf), np.inf)
        inside &= (image_lo > lo[:, i]) & (image_hi < hi[:, i])
        empty |= (image_lo > hi[:, i]) | (image_hi < lo[:, i])
        lo[:, i] = np.where(empty, lo[:, i], np.maximum(lo[:, i], image_lo))
        hi[:, i] = np.where(empty, hi[:, i], np.minimum(hi[:, i], image_hi))
    from_identity = np.sum(abs(jacobian - np.eye(n)) + radius, axis=2)
    regular = usable & (from_identity < 1).all(axis=1)
    return NewtonImage(np.stack([lo, hi]), empty, inside & ~empty, regular)


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


def _divided(dividend: Sequence[Array], divisor: Sequence[Array]) -> tuple[Array, Array]:
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


def _inverses(matrices: Array) -> tuple[Array, Mask]:
    """Inverses of the regular ones of (k, n, n) finite matrices; the identity, and False, for the others."""
    identity = np.eye(matrices.shape[-1])
    rows = abs(matrices).sum(axis=2, keepdims=True)
    sizes = np.where(rows > 0, rows, 1.0)
    scaled = matrices / sizes
    regular: Mask = (abs(np.linalg.det(scaled)) > 1e-100) & np.isfinite(scaled).all(axis=(1, 2))
    scaled = np.where(regular[:, None, None], scaled, identity)
    try:
        inverse = np.linalg.inv(scaled)
    except np.linalg.LinAlgError:  # a pivot has vanished all the same
        inverse = np.linalg.pinv(scaled)
    inverse = inverse / sizes.swapaxes(1, 2)
    regular &= np.isfinite(inverse).all(axis=(1, 2))
    return np.where(regular[:, None, None], inverse, identity), regular


Box: TypeAlias = tuple[tuple[float, float], ...]


PASSES, GAIN = 2, 0.9
"""Steps by single equations, and the share of its length below which a side has to come for another one."""
FRONT = 2_000
"""So many boxes, the last ones, are treated together."""


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
    most_boxes: int,
    most_alive: int,
) -> Subdivision:
    """Search the roots of F: Rⁿ → Rⁿ in a finite box of n sides, given as (low, high), faces included, by
    so many boxes in all, and at once.

    ``enclose(lo, hi)`` takes corners (k, n) and returns bounds (k, n) of F over each box, nan, nan for an
    equation undefined all over it; ``enclose_jacobian`` likewise bounds (k, n, n) of ∂F_i/∂x_j, infinite
    or nan on a box on which F may be undefined or discontinuous somewhere.
    """
    search = _Search(enclose, enclose_jacobian, np.array(box, dtype=float).T[:, None, :])
    with np.errstate(all="ignore"):
        return search.run(most_boxes, most_alive)


class _Search:
    """Boxes are arrays (2, k, n), their lower ends first."""

    def __init__(self, enclose: BoxFunction, enclose_jacobian: BoxFunction, whole: Array) -> None:
        self.enclose, self.enclose_jacobian, self.whole = enclose, enclose_jacobian, whole
        self.proved: list[Array] = []
        self.unresolved = self.boxes = 0

    def run(self, most_boxes: int, most_alive: int) -> Subdivision:
        waiting = self.whole
        while 0 < waiting.shape[1] <= most_alive and self.boxes <= most_boxes:
            expect_time()
            waiting = np.concatenate([waiting[:, :-FRONT], self._level(waiting[:, -FRONT:])], axis=1)
        self.unresolved += waiting.shape[1]
        distinct: list[Array] = []  # inside the range; two narrow ones that overlap hold the same root
        for box in self.proved:
            if _meet(box, self.whole[:, 0]) and not any(_meet(box, other) for other in distinct):
                distinct.append(box)
        proved = sorted(distinct, key=lambda box: box.tolist())
        return Subdivision(
            tuple(tuple((lo, hi) for lo, hi in box.T.tolist()) for box in proved),
            not self.unresolved,
            self.boxes,
        )

    def _level(self, whole: Array) -> Array:
        """Treat every box once; the boxes of the next level."""
        box = whole.copy()
        live = np.arange(box.shape[1])
        for _ in range(PASSES):  # the ends of boxes without a root are crossed
            new = np.stack(narrowed_by_rows(self.enclose, self.enclose_jacobian, *box[:, live]))
            gained = (_widths(new) < GAIN * _widths(box[:, live])).any(axis=1)
            box[:, live] = new
            live = live[gained & ~(new[0] > new[1]).any(axis=1)]
            if not len(live):
                break
        possible = ~(box[0] > box[1]).any(axis=1)
        whole, box = whole[:, possible], box[:, possible]
        self.boxes += box.shape[1]
        below, above = self.enclose(*box)
        kept = ~((below > 0) | (above < 0) | (np.isnan(below) & np.isnan(above))).any(axis=1)
        whole, box = whole[:, kept], box[:, kept]
        image = interval_newton(self.enclose, self.enclose_jacobian, box)
        self._settle(box[:, image.unique])
        open_ = ~image.empty & ~image.unique
        near = np.flatnonzero(open_ & image.regular)
        if near.size:  # roots on faces and corners lie in a wider box with exactly one root
            lo, hi = box[:, near]
            pad = hi - lo + 8 * np.spacing(np.maximum(abs(lo), abs(hi)))
            wide = np.stack([lo - pad, hi + pad])
            unique = interval_newton(self.enclose, self.enclose_jacobian, wide).unique
            self._settle(wide[:, unique])
            open_[near[unique]] = False
        return self._divide(whole[:, open_], image.box[:, open_])

    def _settle(self, boxes: Array) -> None:
        """Keep of each proved box the narrow box that its one root lies in."""
        for place in range(boxes.shape[1]):
            box = boxes[:, place : place + 1]
            for _ in range(30):
                image = interval_newton(self.enclose, self.enclose_jacobian, box)
                if image.empty[0] or not (_widths(image.box) < 0.9 * _widths(box)).any():
                    break
                box = image.box
            self.proved.append(box[:, 0])

    def _divide(self, whole: Array, box: Array) -> Array:
        """Boxes that shrank much go on as they are; others are left where they are too narrow, or cut across
        the side of largest smear max_i |∂F_i/∂x_j| w_j, the widest where that is unbounded."""
        floor = np.maximum(NARROW * _widths(self.whole), 1e-300)
        wide = _widths(box) / np.maximum(abs(box).max(axis=0), floor) > NARROW
        shrunk = ((_widths(box) < 0.5 * _widths(whole)) & wide).any(axis=1)
        cuttable = wide.any(axis=1)
        self.unresolved += int((~cuttable).sum())
        kept, box, wide = box[:, shrunk], box[:, cuttable & ~shrunk], wide[cuttable & ~shrunk]
        if not len(wide):
            return kept
        slopes = abs(np.array(self.enclose_jacobian(*box))).max(axis=0)
        rows = slopes * _widths(box)[:, None, :]
        smear = (rows / np.maximum(rows.sum(axis=2, keepdims=True), 1e-300)).sum(axis=1)
        bounded = np.isfinite(smear).all(axis=1)[:, None]
        measure = np.where(bounded, smear, _widths(box) / _widths(self.whole))
        each, side = np.arange(len(wide)), np.where(wide, measure, -1.0).argmax(axis=1)
        middle = [split_point(*ends) for ends in box[:, each, side].T.tolist()]
        left, right = box.copy(), box.copy()
        left[1, each, side] = right[0, each, side] = middle
        return np.concatenate([kept, left, right], axis=1)


def _widths(box: Array) -> Array:
    widths: Array = box[1] - box[0]
    return widths


def _meet(one: Array, other: Array) -> bool:
    return bool(((one[0] <= other[1]) & (one[1] >= other[0])).all())
