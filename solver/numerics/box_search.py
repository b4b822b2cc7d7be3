"""Searches of a box: by Newton's method from many starts at once, and by branch and prune."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from rulesheets.deadline import expect_time, in_one_chunk
from solver.numerics.linear_algebra import Array, Map
from solver.numerics.one_unknown import split_point
from solver.numerics.tolerances import ARRIVED, EPS, NARROW, NULL, ON_LINE

PATIENCE = 12
"""Steps without a gain of a tenth after which a start is abandoned."""
KEPT = 0.1
"""Share of the distance to the end of a range that a step beyond it leaves."""


def _solved(matrices: Array, rhs: Array) -> Array:
    """-A⁻¹ b for each of (k, n, n) and (k, n), nan if a row is 0; if a matrix is singular, all are
    regularised by rounding."""
    usable = (abs(matrices).max(axis=2) > 0.0).all(axis=1)
    matrices = np.where(usable[:, None, None], matrices, np.eye(matrices.shape[1]))
    try:
        found = np.linalg.solve(matrices, -rhs[:, :, None])[:, :, 0]
    except np.linalg.LinAlgError:
        turned = np.swapaxes(matrices, 1, 2)
        normal = turned @ matrices + 1e-12 * np.eye(matrices.shape[1])
        found = np.linalg.solve(normal, turned @ -rhs[:, :, None])[:, :, 0]
    return np.where(usable[:, None], found, np.nan)


def _least_norm(matrices: Array, rhs: Array) -> Array:
    """-A⁺ b for each of (k, m, n) and (k, m); singular values up to a share ``NULL`` of the largest
    are 0."""
    found: Array = -(np.linalg.pinv(matrices, rcond=NULL) @ rhs[:, :, None])[:, :, 0]
    return found


class Iteration(NamedTuple):
    """``solved`` gives a step; the best of its ``lengths`` is taken, none of ``longest`` sizes of
    the unknowns or more. A step as short as ``arrived`` is the last one; there are at most
    ``most``."""

    solved: Callable[[Array, Array], Array]
    lengths: tuple[float, ...]
    longest: float
    arrived: float
    most: int


NEWTON = Iteration(_solved, (1.0, 0.3), 10.0, ARRIVED, 80)
GAUSS_NEWTON = Iteration(_least_norm, (1.0, 0.3, 0.05), 2.0, ON_LINE, 60)
"""Steps of least norm: they keep to the point of a curve that is nearest."""


def arrivals(
    residual: Map,
    jacobian: Map,
    starts: Array,
    scale: Array,
    by: Iteration = NEWTON,
    ranges: tuple[Array, Array] | None = None,
) -> Array:
    """The ends (m, n) of those ``starts`` (k, n) that reach a zero of F: Rⁿ → Rᵐ, in their order.

    ``residual`` maps (k, n) to (k, m), ``jacobian`` to (k, m, n), both nan outside their domain.
    ``scale`` (n,): typical sizes of the unknowns; ``ranges``: their lower and upper ends (n,),
    which iterates do not leave. The ends are neither polished nor made distinct.
    """
    with np.errstate(all="ignore"):
        f = residual(starts)
        place = np.flatnonzero(np.isfinite(f).all(axis=1))
        x, f = starts[place], f[place]
        best, idle = np.full(len(x), np.inf), np.zeros(len(x), dtype=int)
        arrived: list[tuple[int, Array]] = []
        for _ in range(by.most):
            expect_time()
            if not len(x):
                break
            weight = np.maximum(abs(x), scale)
            matrix = jacobian(x) * weight[:, None, :]
            rows = abs(matrix).sum(axis=2)
            rows = np.where(np.isfinite(rows) & (rows > 0.0), rows, np.inf)
            step = by.solved(np.nan_to_num(matrix / rows[:, :, None]), f / rows)
            length = abs(step).max(axis=1)
            step *= np.minimum(1.0, by.longest / np.maximum(length, 1e-300))[:, None]
            trials = np.stack(
                [_inside(x, x + share * (weight * step), ranges) for share in by.lengths]
            )
            values = residual(trials.reshape(-1, x.shape[1])).reshape(*trials.shape[:2], -1)
            norms = abs(values / rows).max(axis=2)
            norms = np.where(np.isfinite(norms), norms, np.inf)
            chosen, each = norms.argmin(axis=0), np.arange(len(x))
            x, f, norm = trials[chosen, each], values[chosen, each], norms[chosen, each]
            near, finite = length <= by.arrived, np.isfinite(norm)
            arrived += zip(place[near & finite].tolist(), x[near & finite], strict=True)
            gained = norm < 0.9 * best
            best, idle = np.where(gained, norm, best), np.where(gained, 0, idle + 1)
            going = ~near & finite & (idle < PATIENCE)
            x, f, place, best, idle = x[going], f[going], place[going], best[going], idle[going]
    ends = [end for _, end in sorted(arrived, key=lambda pair: pair[0])]
    return np.array(ends).reshape(len(ends), len(scale))


def _inside(x: Array, moved: Array, ranges: tuple[Array, Array] | None) -> Array:
    """Where a step beyond the end of a range stops: before it, as the end may not belong to it."""
    if ranges is None:
        return moved
    low, high = ranges
    moved = np.where((moved <= low) & (x > low), low + KEPT * (x - low), moved)
    return np.where((moved >= high) & (x < high), high - KEPT * (high - x), moved)


# --- where to start ---

Range = tuple[float, float]

DECADES = 3.0
"""An unbounded unknown is searched from 10⁻³ to 10³ times its size, on both sides."""


def spread(
    ranges: Sequence[Range], sizes: Sequence[float], count: int, offset: int = 0
) -> Iterator[list[float]]:
    """``count`` points that fill the ranges evenly, after the first ``offset``: the k-th at the
    shares k/φ^j, modulo 1, for j = 1 … n, with φ the positive root of φ^(n+1) = φ + 1."""
    n, phi = len(ranges), 2.0
    for _ in range(64):
        phi = (1.0 + phi) ** (1.0 / (n + 1))
    for k in range(offset + 1, offset + count + 1):
        yield [
            place((0.5 + k * phi**-j) % 1.0, *ends, size)
            for j, (ends, size) in enumerate(zip(ranges, sizes, strict=True), 1)
        ]


def place(share: float, low: float, high: float, size: float) -> float:
    """The point of a range at ``share`` in [0, 1): even over a finite range, else over some decades
    around ``size`` from its finite end, or on both sides of 0."""
    if math.isfinite(low) and math.isfinite(high):
        return low + share * (high - low)
    if math.isfinite(low):
        return low + _magnitude(share, size)
    if math.isfinite(high):
        return high - _magnitude(share, size)
    return _magnitude(2 * share - 1, size) if share >= 0.5 else -_magnitude(1 - 2 * share, size)


def _magnitude(share: float, size: float) -> float:
    """From 10⁻³ to 10³ times the size, most of them near it."""
    centred = 2.0 * share - 1.0
    return size * math.pow(10.0, DECADES * centred * abs(centred))


# --- interval branch and prune ---

BoxFunction: TypeAlias = Callable[[Array, Array], tuple[Array, Array]]
Box: TypeAlias = tuple[tuple[float, float], ...]

FRONT = 2_000
"""So many boxes, the last ones, are treated together."""
PADDING = 0.1
"""Share of a side by which a box is widened before it is asked for a single root: one may lie on a
face."""
SHRUNK = 0.9
"""Share of its length below which a side has to come for another step."""


class Subdivision(NamedTuple):
    """``proved``: boxes, as narrow as rounding allows, each with exactly one root, all different.

    ``complete``: no box was left undecided, so every root in the searched box is there.
    """

    proved: tuple[Box, ...]
    complete: bool
    boxes: int = 0

    @property
    def roots(self) -> tuple[tuple[float, ...], ...]:
        """The middles of the proved boxes."""
        return tuple(tuple(lo + (hi - lo) / 2 for lo, hi in box) for box in self.proved)


@in_one_chunk
def branch_and_prune(
    enclose: BoxFunction,
    enclose_jacobian: BoxFunction,
    box: Sequence[tuple[float, float]],
    most_boxes: int,
    most_alive: int,
) -> Subdivision:
    """Search the roots of F: Rⁿ → Rⁿ in a finite box of n sides, given as (low, high), faces
    included, by so many boxes in all, and at once.

    ``enclose(lo, hi)`` takes corners (k, n) and returns bounds (k, n) of F over each box, nan, nan
    for an equation undefined all over it; ``enclose_jacobian`` likewise bounds (k, n, n) of
    ∂F_i/∂x_j, infinite or nan on a box on which F may be undefined or discontinuous somewhere.
    """
    search = _BoxSearch(enclose, enclose_jacobian, np.array(box, dtype=float).T[:, None, :])
    with np.errstate(all="ignore"):
        return search.run(most_boxes, most_alive)


class _BoxSearch:
    """Boxes are arrays (2, k, n), lower ends first; in those without a root the ends are crossed.

    A box is narrowed by its equations as they are, then by combinations of them whose Jacobian is
    nearly the identity: the step of Hansen and Sengupta (A. Neumaier, *Interval Methods for Systems
    of Equations*, 1990, theorem 5.1.8). Its image holds every root in the box; if it is empty there
    is none, and if it lies in the interior there is exactly one. Otherwise the box is cut across
    the side along which the equations vary most (Kearfott's smear, summed). A front of boxes is
    treated at once, the newest first.
    """

    def __init__(self, enclose: BoxFunction, enclose_jacobian: BoxFunction, whole: Array) -> None:
        self.enclose, self.enclose_jacobian, self.whole = enclose, enclose_jacobian, whole
        self.proved: list[Array] = []
        self.unresolved = self.boxes = 0

    def run(self, most_boxes: int, most_alive: int) -> Subdivision:
        waiting = self.whole
        while 0 < waiting.shape[1] <= most_alive and self.boxes <= most_boxes:
            expect_time()
            waiting = np.concatenate(
                [waiting[:, :-FRONT], self._level(waiting[:, -FRONT:])], axis=1
            )
        self.unresolved += waiting.shape[1]
        range_, distinct = self.whole[:, 0], list[Array]()
        for box in self.proved:  # two narrow ones that overlap hold the same root
            if _meet(box, range_) and not any(_meet(box, other) for other in distinct):
                distinct.append(box.clip(*range_))
        proved = sorted(distinct, key=lambda box: box.tolist())
        boxes = tuple(tuple((lo, hi) for lo, hi in box.T.tolist()) for box in proved)
        return Subdivision(boxes, not self.unresolved, self.boxes)

    def _level(self, box: Array) -> Array:
        """Treat every box once; the boxes of the next level."""
        self.boxes += box.shape[1]
        below, above = self.enclose(*box)
        kept = ~((below > 0) | (above < 0) | (np.isnan(below) & np.isnan(above))).any(axis=1)
        box = _possible(self._narrowed(box[:, kept]))
        pad = PADDING * (box[1] - box[0]) + 8 * np.spacing(abs(box).max(axis=0))
        wide = np.stack([box[0] - pad, box[1] + pad])
        image = self._image(wide)
        unique = ((image[0] > wide[0]) & (image[1] < wide[1])).all(axis=1)
        self._settle(image[:, unique])
        left = np.stack([np.fmax(box[0], image[0]), np.fmin(box[1], image[1])])[:, ~unique]
        return self._divide(_possible(left))

    def _narrowed(self, box: Array) -> Array:
        """The boxes narrowed by every equation as it is, which gains most for wide boxes."""
        centre = box[0] + (box[1] - box[0]) / 2
        low, high = _bounds(
            box, centre, *self.enclose(centre, centre), *self.enclose_jacobian(*box)
        )
        low, high = np.fmax.reduce(low, axis=1), np.fmin.reduce(high, axis=1)
        return np.stack([np.fmax(box[0], low), np.fmin(box[1], high)])

    def _image(self, box: Array) -> Array:
        """The image under combinations of equations; infinite if they give no bound."""
        centre = box[0] + (box[1] - box[0]) / 2
        slopes, at = np.array(self.enclose_jacobian(*box)), np.array(self.enclose(centre, centre))
        usable = np.isfinite(slopes).all(axis=(0, 2, 3)) & np.isfinite(at).all(axis=(0, 2))
        inverse = np.full(slopes.shape[1:], np.nan)
        inverse[usable] = _inverses(slopes[:, usable].sum(axis=0) / 2)
        at = _product(inverse, at[..., None])[..., 0]
        low, high = _bounds(box, centre, *at, *_product(inverse, slopes))
        return np.stack([np.diagonal(low, axis1=1, axis2=2), np.diagonal(high, axis1=1, axis2=2)])

    def _settle(self, boxes: Array) -> None:
        """Keep of each box that holds exactly one root a narrow one around it."""
        for place in range(boxes.shape[1]):
            box = boxes[:, place : place + 1]
            for _ in range(30):
                image = self._image(box)
                image = np.stack([np.fmax(box[0], image[0]), np.fmin(box[1], image[1])])
                if (
                    not ((new := image[1] - image[0]) >= 0).all()
                    or (new > SHRUNK * (box[1] - box[0])).all()
                ):
                    break
                box = image
            self.proved.append(box[:, 0])

    def _divide(self, box: Array) -> Array:
        """Boxes halved across the side of largest smear max_i |∂F_i/∂x_j| w_j, the widest if that
        is unbounded; boxes that are too narrow are unchanged."""
        widths, range_ = box[1] - box[0], self.whole[1] - self.whole[0]
        wide = widths > NARROW * np.maximum(abs(box).max(axis=0), NARROW * range_)
        self.unresolved += int((~wide.any(axis=1)).sum())
        box, widths, wide = (part[..., wide.any(axis=1), :] for part in (box, widths, wide))
        rows = abs(np.array(self.enclose_jacobian(*box))).max(axis=0) * widths[:, None, :]
        smear = (rows / np.maximum(rows.sum(axis=2, keepdims=True), 1e-300)).sum(axis=1)
        measure = np.where(np.isfinite(smear).all(axis=1)[:, None], smear, widths / range_)
        each, side = np.arange(len(wide)), np.where(wide, measure, -1.0).argmax(axis=1)
        left, right = box.copy(), box.copy()
        middle = [split_point(*ends) for ends in box[:, each, side].T.tolist()]
        left[1, each, side] = right[0, each, side] = middle
        return np.concatenate([left, right], axis=1)


def _possible(box: Array) -> Array:
    return box[:, (box[0] <= box[1]).all(axis=1)]


def _meet(one: Array, other: Array) -> bool:
    return bool(((one[0] <= other[1]) & (one[1] >= other[0])).all())


def _bounds(
    box: Array, centre: Array, at_low: Array, at_high: Array, below: Array, above: Array
) -> tuple[Array, Array]:
    """The bounds (k, n, n) on every unknown from every equation, infinite if its slope may be 0.

    x_j ∈ c_j − (F_i(c) + Σ_{m≠j} J_im (x_m − c_m)) / J_ij: no root in the box is lost.
    """
    n = box.shape[2]
    reach = (
        np.maximum(abs(below), abs(above))
        * np.maximum(box[1] - centre, centre - box[0])[:, None, :]
    )
    others = (reach @ (1.0 - np.eye(n))) * (1 + 8 * EPS * n)
    apart = np.isfinite(reach).all(axis=2)[:, :, None] & ((below > 0) | (above < 0))
    ends = [end[:, :, None] + side * others for end, side in ((at_low, -1), (at_high, 1))]
    quotients = [end / np.where(apart, slope, 1.0) for end in ends for slope in (below, above)]
    slack = 4 * EPS * np.maximum.reduce([abs(q) for q in quotients])
    least, most = np.minimum.reduce(quotients) - slack, np.maximum.reduce(quotients) + slack
    low = np.where(apart, np.nextafter(centre[:, None, :] - most, -np.inf), -np.inf)
    return low, np.where(apart, np.nextafter(centre[:, None, :] - least, np.inf), np.inf)


def _product(matrix: Array, ends: Array) -> Array:
    """A point matrix (k, n, n) times an interval matrix (2, k, n, m), its rounding included."""
    middle = ends[0] / 2 + ends[1] / 2
    size, more = abs(matrix), 8 * EPS * matrix.shape[-1]
    radius = size @ np.maximum(ends[1] - middle, middle - ends[0])
    product, radius = matrix @ middle, radius * (1 + more) + more * (size @ abs(middle))
    return np.stack([product - radius, product + radius])


def _inverses(matrices: Array) -> Array:
    """Inverses of matrices (k, n, n), nan for singular ones."""
    sizes = abs(matrices).sum(axis=2, keepdims=True)
    scaled = matrices / np.where(sizes > 0, sizes, 1.0)
    regular = abs(np.linalg.det(scaled)) > 1e-100
    scaled[~regular] = np.eye(matrices.shape[-1])
    found = np.linalg.inv(scaled) / np.where(sizes > 0, sizes, 1.0).swapaxes(1, 2)
    found[~regular] = np.nan
    return found
