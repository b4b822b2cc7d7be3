"""Every root of one equation in one unknown, over a range or over the whole line.

Branch and prune with interval enclosures (A. Neumaier, *Interval Methods for Systems of Equations*,
1990, chapter 5; R. B. Kearfott, *Rigorous Global Search*, 1996). All boxes of a level are treated in
three vectorised evaluations: the range of f, the range of its slope, and f at the ends and the middle of
each box. A box is dropped if f or its mean value form excludes 0; it is settled if the slope excludes 0
and f changes sign; the others are split, in exponents where a box spans decades. What is left when boxes
reach rounding level goes to ``clusters.py``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from solver.numerics.bracket import MAX, ScalarFunction, bracketed_root
from solver.numerics.clusters import resolve_clusters
from solver.numerics.interval_function import (
    Array,
    Enclosure,
    IntervalFunction,
    Mask,
    Sections,
    section,
    split_points,
)

Intervals: TypeAlias = list[tuple[float, float]]

EVEN = 1e3
"""Largest ratio of slopes across a box from whose ends an interval Newton step is worth taking."""


@dataclass(frozen=True, slots=True)
class IsolationLimits:
    """``boxes`` evaluated in all, ``alive`` at once, ``levels`` of splitting, ``presplit`` of them blind;
    ``candidates`` is how many of the clusters left over are looked into. Boxes beyond 1e±100 are given up
    after ``remote_levels``."""

    boxes: int = 200_000
    alive: int = 8_000
    levels: int = 220
    presplit: int = 5
    candidates: int = 24
    remote_levels: int = 6


@dataclass(frozen=True, slots=True)
class RootSearch:
    """What is known of the roots of f in a range.

    ``roots``: ascending; f changes sign there, or is exactly 0 with a slope that is not.
    ``complete``: proven that there are no others and that each is a single one. (Of an infinite range that
    is said for x = 0 and 1e-100 < |x| < 1e100; roots beyond are found where that is easy, and looked for to
    the end where there is none nearer, so that nobody is told that there is none at all.)
    ``touching``: (x, f(x)) where |f| is least in a box that could not be settled: a double root, a root at
    the edge of the domain, or a near miss. For the caller to verify.
    ``flat``: intervals on which f is 0 to rounding throughout. ``unresolved``: what was not settled.
    """

    roots: tuple[float, ...]
    complete: bool
    unresolved: tuple[tuple[float, float], ...] = ()
    touching: tuple[tuple[float, float], ...] = ()
    flat: tuple[tuple[float, float], ...] = ()
    evaluations: int = 0
    levels: int = 0


def isolate_roots(
    enclose: Enclosure,
    enclose_slope: Enclosure | None,
    value: ScalarFunction,
    low: float,
    high: float,
    limits: IsolationLimits = IsolationLimits(),
) -> RootSearch:
    """Search the roots of f in [low, high], ends included; an infinite one stands for the largest float.

    ``enclose(lo, hi)`` takes arrays (k,) of boxes and returns arrays (k,) that enclose the values of f on
    each, outward rounded; nan, nan where f is undefined on the whole box. ``enclose_slope`` does the same
    for the difference quotients of f; it must be infinite or nan on a box on which f may be undefined or
    discontinuous somewhere. ``value(x)`` is f at one point, or raises ArithmeticError or ValueError, or is
    nan. ``complete`` is as true as these enclosures are.
    """
    if not low <= high:
        return RootSearch((), True)
    function = IntervalFunction(enclose, enclose_slope, value, float(low), float(high))
    with np.errstate(all="ignore"):
        settled, at_rounding, unsplit, remote, levels = _branch_and_prune(function, limits)
        if not (settled or at_rounding or unsplit) and remote:
            settled, at_rounding, unsplit, _, more = _branch_and_prune(function, limits, remote)
            levels += more
        roots = [bracketed_root(value, a, b) for a, b in settled]
        found = resolve_clusters(function, at_rounding, unsplit, roots, limits.candidates)
    return RootSearch(
        roots=tuple(sorted(set(found.roots))),
        complete=not found.unresolved,
        unresolved=tuple(found.unresolved),
        touching=tuple(found.touching),
        flat=tuple(found.flat),
        evaluations=function.evaluations,
        levels=levels,
    )


def _branch_and_prune(
    function: IntervalFunction, limits: IsolationLimits, boxes: Intervals | None = None
) -> tuple[Intervals, Intervals, Intervals, Intervals, int]:
    """Boxes that hold exactly one root, boxes at rounding level, boxes left at the limits, remote boxes that
    were given up, and the levels. Of ``boxes``, where there are any, none is given up for being remote.
    """
    settled: Intervals = []
    at_rounding: Intervals = []
    remote: Intervals = []
    if boxes is None:
        lo, hi = _presplit(function.low, function.high, limits.presplit)
    else:
        lo, hi = (np.array(ends) for ends in zip(*boxes, strict=True))
    level = 0
    for level in range(limits.levels):
        if not lo.size or lo.size > limits.alive or function.evaluations > limits.boxes:
            break
        below, above, defined = function.range_on(lo, hi)
        kept = defined & (below <= 0) & (above >= 0)
        sections = section(function, lo[kept], hi[kept])
        verdict = judge(sections, (above - below)[kept])
        settled += _pairs(sections, verdict.single)
        at_rounding += _pairs(sections, verdict.rounding) + _noise_at_ends(sections, verdict.noisy_end)
        lo, hi = _split(sections, verdict.open)
        if boxes is None and level >= limits.remote_levels:
            far = function.is_remote(lo, hi)
            remote += zip(lo[far].tolist(), hi[far].tolist(), strict=True)
            lo, hi = lo[~far], hi[~far]
    return settled, at_rounding, list(zip(lo.tolist(), hi.tolist(), strict=True)), remote, level + 1


def _presplit(low: float, high: float, levels: int) -> tuple[Array, Array]:
    lo, hi = np.array([low]), np.array([high])
    for _ in range(levels if low < high else 0):
        middle = split_points(lo, hi)
        lo, hi = np.stack([lo, middle], 1).ravel(), np.stack([middle, hi], 1).ravel()
        proper = lo < hi
        lo, hi = lo[proper], hi[proper]
    finite = (lo < MAX) & (hi > -MAX)
    return np.maximum(lo[finite], -MAX), np.minimum(hi[finite], MAX)


@dataclass(frozen=True, slots=True)
class Verdict:
    """Masks (k,) over boxes; a box in none of them holds no root."""

    single: Mask
    noisy_end: Mask
    rounding: Mask
    open: Mask


def judge(sections: Sections, width: Array) -> Verdict:
    """``width`` is that of the natural enclosure of f on each box."""
    (low_0, low_1), _, (high_0, high_1) = sections.at
    smooth, (slope_0, slope_1) = sections.smooth, sections.slope
    steepest = np.maximum(abs(slope_0), abs(slope_1))
    reach = steepest * np.maximum(sections.middle - sections.lo, sections.hi - sections.middle)
    empty = smooth & _mean_value_excludes(sections, steepest)
    monotone = smooth & ((slope_0 > 0) | (slope_1 < 0)) & ~empty
    signs_known = ((low_0 > 0) | (low_1 < 0)) & ((high_0 > 0) | (high_1 < 0))
    opposite = ((low_1 < 0) & (high_0 > 0)) | ((low_0 > 0) & (high_1 < 0))
    even = np.minimum(abs(slope_0), abs(slope_1)) * EVEN >= steepest
    noisy_end = monotone & ~signs_known & even
    rest = ~empty & ~(monotone & signs_known) & ~noisy_end
    blurs = np.stack([high - low for low, high in sections.at])
    noise = np.where(np.isfinite(blurs).all(axis=0), blurs.min(axis=0), 0.0)
    spread = np.where(smooth, np.minimum(width, 2 * reach), width)
    narrow = np.nextafter(np.nextafter(sections.lo, np.inf), np.inf) >= sections.hi
    inside = (sections.lo < sections.middle) & (sections.middle < sections.hi)
    done = narrow | (spread <= 4 * noise) | ~inside
    return Verdict(monotone & opposite, noisy_end, rest & done, rest & ~done)


def _mean_value_excludes(sections: Sections, steepest: Array) -> Mask:
    """f(a) + [-s, s] (x - a) excludes 0 for some a of the ends and the middle."""
    excludes = np.zeros(steepest.shape, bool)
    for anchor, (below, above) in zip((sections.lo, sections.middle, sections.hi), sections.at, strict=True):
        reach = steepest * np.maximum(anchor - sections.lo, sections.hi - anchor)
        excludes |= (below > reach) | (above < -reach)
    return excludes


def _noise_at_ends(sections: Sections, chosen: Mask) -> Intervals:
    """The ends of monotone boxes near which f is 0 to rounding, by an interval Newton step from there."""
    shallow = np.minimum(abs(sections.slope[0]), abs(sections.slope[1]))
    boxes = []
    for i in np.flatnonzero(chosen):
        lo, hi = float(sections.lo[i]), float(sections.hi[i])
        for end, (below, above) in ((lo, sections.at[0]), (hi, sections.at[2])):
            if below[i] <= 0 <= above[i]:
                reach = float(max(above[i], -below[i]) / shallow[i])
                boxes.append((max(lo, end - reach), min(hi, end + reach)))
    return boxes


def _pairs(sections: Sections, chosen: Mask) -> Intervals:
    return list(zip(sections.lo[chosen].tolist(), sections.hi[chosen].tolist(), strict=True))


def _split(sections: Sections, chosen: Mask) -> tuple[Array, Array]:
    lo, middle, hi = sections.lo[chosen], sections.middle[chosen], sections.hi[chosen]
    return np.stack([lo, middle], 1).ravel(), np.stack([middle, hi], 1).ravel()
