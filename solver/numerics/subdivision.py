"""Every root of a square system in a box: interval branch and prune in n dimensions.

A box is dropped if an enclosure of some equation excludes 0 or its Hansen–Sengupta image is empty,
settled if that image proves exactly one root, otherwise contracted and, where that gains little, cut
across the side along which the equations vary most (Kearfott's smear, added up). A front of
boxes is treated at once, the newest first.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from rulesheets.deadline import expect_time
from solver.numerics.bracket import split_point
from solver.numerics.interval_newton import Array, BoxFunction, Mask, NewtonImage, interval_newton

Box: TypeAlias = tuple[tuple[float, float], ...]
Contractor: TypeAlias = Callable[[Array, Array], tuple[Array, Array, Mask]]


@dataclass(frozen=True, slots=True)
class SubdivisionLimits:
    """``boxes`` in all, ``alive`` at once, of which the last ``front`` are treated together; sides below
    ``resolution`` relative to |x| (or to ``resolution`` times the side of the whole box) are not cut."""

    boxes: int = 100_000
    alive: int = 8_000
    front: int = 2_000
    resolution: float = 1e-12


STANDARD_LIMITS = SubdivisionLimits()


@dataclass(frozen=True, slots=True)
class Subdivision:
    """``proved``: boxes, as narrow as rounding allows, each with exactly one root, no two with the same.

    ``unresolved``: boxes of which nothing is known, those that touch merged into one around them.
    ``complete``: there are none, so that ``proved`` holds every root in the box searched.
    """

    proved: tuple[Box, ...]
    unresolved: tuple[Box, ...]
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
    contract: Contractor | None = None,
) -> Subdivision:
    """Search the roots of F: Rⁿ → Rⁿ in a finite box of n sides, given as (low, high), faces included.

    ``enclose(lo, hi)`` takes corners (k, n) and returns bounds (k, n) of F over each box, nan, nan for an
    equation undefined all over it; ``enclose_jacobian`` likewise bounds (k, n, n) of ∂F_i/∂x_j, infinite
    or nan on a box on which F may be undefined or discontinuous somewhere. ``contract(lo, hi)`` narrows
    boxes without losing a root: corners (k, n), and which of them hold none.
    """
    low, high = (np.array([[side[end] for side in box]], dtype=float) for end in (0, 1))
    search = _Search(enclose, enclose_jacobian, low, high, limits, contract)
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
        contract: Contractor | None,
    ) -> None:
        self.enclose, self.enclose_jacobian = enclose, enclose_jacobian
        self.low, self.high, self.limits, self.contract = low, high, limits, contract
        self.proved: list[tuple[Array, Array]] = []
        self.unresolved: list[tuple[Array, Array]] = []
        self.boxes = 0

    def run(self) -> Subdivision:
        lo, hi = self.low, self.high
        while len(lo) and len(lo) <= self.limits.alive and self.boxes <= self.limits.boxes:
            expect_time()
            next_lo, next_hi = self._level(lo[-self.limits.front :], hi[-self.limits.front :])
            lo = np.concatenate([lo[: -self.limits.front], next_lo])
            hi = np.concatenate([hi[: -self.limits.front], next_hi])
        self.unresolved += list(zip(lo, hi, strict=True))
        proved = tuple(_as_box(*pair) for pair in self._distinct())
        unresolved = tuple(_as_box(*pair) for pair in _hulls(self.unresolved))
        return Subdivision(proved, unresolved, not unresolved, self.boxes)

    def _level(self, lo: Array, hi: Array) -> tuple[Array, Array]:
        """Treat every box once; the boxes of the next level."""
        whole_lo, whole_hi = lo, hi
        if self.contract is not None:
            lo, hi, empty = self.contract(lo, hi)
            whole_lo, whole_hi, lo, hi = (ends[~empty] for ends in (whole_lo, whole_hi, lo, hi))
        kept = self._may_hold_root(lo, hi)
        whole_lo, whole_hi, lo, hi = (ends[kept] for ends in (whole_lo, whole_hi, lo, hi))
        image = self._newton(lo, hi)
        self._settle(lo, hi, image.unique)
        covered = self._settle_inflated(lo, hi, image.regular & ~image.unique & ~image.empty)
        rest = ~image.empty & ~image.unique & ~covered
        return self._divide(whole_lo[rest], whole_hi[rest], image.lo[rest], image.hi[rest])

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
        wide = widths > self.limits.resolution
        shrunk = (((new_hi - new_lo) < 0.5 * (hi - lo)) & wide).any(axis=1)
        narrow = ~wide.any(axis=1)
        self.unresolved += list(zip(new_lo[narrow], new_hi[narrow], strict=True))
        kept, cut = shrunk & ~narrow, ~shrunk & ~narrow
        halves = self._halves(new_lo[cut], new_hi[cut], widths[cut])
        return np.concatenate([new_lo[kept], halves[0]]), np.concatenate([new_hi[kept], halves[1]])

    def _relative_widths(self, lo: Array, hi: Array) -> Array:
        floor = self.limits.resolution * (self.high - self.low)
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
        side = np.where(widths > self.limits.resolution, measure, -1.0).argmax(axis=1)
        each = np.arange(len(lo))
        ends = zip(lo[each, side].tolist(), hi[each, side].tolist(), strict=True)
        middle = np.array([split_point(a, b) for a, b in ends])
        left_hi, right_lo = hi.copy(), lo.copy()
        left_hi[each, side] = right_lo[each, side] = middle
        return np.concatenate([lo, right_lo]), np.concatenate([left_hi, hi])


def _hulls(boxes: list[tuple[Array, Array]], cells: int = 32) -> list[tuple[Array, Array]]:
    """Boxes around each group of boxes that touch; those in one cell of a coarse grid count as touching."""
    if not boxes:
        return []
    lo, hi = np.array([b[0] for b in boxes]), np.array([b[1] for b in boxes])
    low, high = lo.min(axis=0), hi.max(axis=0)
    cell = np.floor((lo - low) / np.where(high > low, high - low, 1.0) * cells)
    _, group = np.unique(cell, axis=0, return_inverse=True)
    members = [group.ravel() == g for g in range(int(group.max()) + 1)]
    return _merged([(lo[m].min(axis=0), hi[m].max(axis=0)) for m in members])


def _merged(boxes: list[tuple[Array, Array]]) -> list[tuple[Array, Array]]:
    hulls: list[tuple[Array, Array]] = []
    for low, high in boxes:
        apart = []
        for other_low, other_high in hulls:
            if ((other_low <= high) & (other_high >= low)).all():
                low, high = np.minimum(low, other_low), np.maximum(high, other_high)
            else:
                apart.append((other_low, other_high))
        hulls = [*apart, (low, high)]
    return hulls


def _as_box(lo: Array, hi: Array) -> Box:
    return tuple(zip(lo.tolist(), hi.tolist(), strict=True))
