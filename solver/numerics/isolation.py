"""Every root of one equation in one unknown, over a range or over the whole line.

Branch and prune with interval enclosures (A. Neumaier, *Interval Methods for Systems of Equations*,
1990, chapter 5; R. B. Kearfott, *Rigorous Global Search*, 1996). The boxes of a level are enclosed
together: the range of f, the range of its slope, and f at the ends and the middle of each box. A
box is dropped if f or its mean value form excludes 0; it is settled if the slope excludes 0 and f
changes sign; the others are split, in exponents if a box spans decades. Boxes at rounding level are
merged into clusters of adjacent boxes. A cluster is first enlarged a little (epsilon inflation,
after S. M. Rump): a root on its boundary is then inside and can be proven. Otherwise it is searched
for changes of sign and for the least |f|.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from enum import Enum
from itertools import pairwise
from math import inf, isfinite, isnan, nextafter
from typing import NamedTuple, TypeAlias

from rulesheets.deadline import expect_time
from solver.numerics.one_unknown import (
    MAX,
    ScalarFunction,
    bracketed_root,
    is_zero_crossing,
    lowest_point,
    split_point,
    value_at,
)
from solver.numerics.tolerances import MULTIPLE, PLATEAU

Interval: TypeAlias = tuple[float, float]
Intervals: TypeAlias = list[Interval]
Enclosure: TypeAlias = Callable[[Sequence[Interval]], Sequence[Interval]]

HORIZON = 1e100
UNKNOWN = -inf, inf
SAMPLES = 129
INFLATIONS = (4.0, 64.0, 4096.0, 2.0**20)
POLE_ULPS = 16
GAP = 4.0


class IsolationLimits(NamedTuple):
    """``boxes`` evaluated in all, ``alive`` at once, ``levels`` of splitting."""

    boxes: int = 200_000
    alive: int = 8_000
    levels: int = 220


PRESPLIT = 5
"""Levels that are split blindly."""
BOXES_ASKED = 5
"""Evaluations for a box of a level: the range of f, three points, and its slope."""
CALMEST, LAST_LOOK = 50, 1.25
"""Boxes of a level that are still split at the limits, those in which f changes least; and the work
for this, as a multiple of the limit."""
FEW_FLOATS = 64
"""Floats of a cluster that are looked at one by one."""
LOOKED_INTO = 50
"""Remaining clusters that are examined."""
MANY = 50
"""Roots beyond which no others are searched if boxes had to be left undecided."""
REMOTE_LEVELS = 6
"""Levels after which boxes beyond 1e±100 are abandoned."""


class RootSearch(NamedTuple):
    """The roots of f in a range.

    ``roots``: ascending; f changes sign there, or is exactly 0 with a nonzero slope. ``complete``:
    proven that there are no others and that each is simple. (For an infinite range this covers x =
    0 and 1e-100 < |x| < 1e100; roots beyond are found if that is easy.) ``touching``: points of
    least |f| in boxes that could not be decided: a double root, a root at the boundary of the
    domain, or a near miss, for the caller to verify. ``flat``: intervals on which f is 0 to
    rounding throughout. ``unresolved``: the undecided boxes. ``crossings``: the roots that are only
    a change of sign of computed values.
    """

    roots: tuple[float, ...]
    complete: bool
    unresolved: tuple[tuple[float, float], ...] = ()
    touching: tuple[float, ...] = ()
    flat: tuple[tuple[float, float], ...] = ()
    evaluations: int = 0
    levels: int = 0
    crossings: tuple[float, ...] = ()


def isolate_roots(
    enclose: Enclosure,
    enclose_slope: Enclosure | None,
    value: ScalarFunction,
    low: float,
    high: float,
    limits: IsolationLimits,
    within: Sequence[Interval] | None = None,
) -> RootSearch:
    """Search the roots of f in [low, high], ends included; an infinite one stands for the largest
    float. ``within``: only in these parts, others have none that are not known.

    ``enclose`` takes boxes (low, high) and returns for each a pair that encloses the values of f on
    it, outward rounded; nan, nan where f is undefined on the whole box, or known to have no root
    there. ``enclose_slope`` does the same for the difference quotients of f; it must be infinite or
    nan on a box on which f may be undefined or discontinuous somewhere. ``value(x)`` is f at one
    point, or raises ArithmeticError or ValueError, or is nan. ``complete`` is as true as these
    enclosures are.
    """
    if not low <= high:
        return RootSearch((), True)
    return _RootBoxes(enclose, enclose_slope, value, float(low), float(high)).run(limits, within)


class Cluster(NamedTuple):
    """Adjacent boxes. ``rough`` if one of them was still to be split at the limits."""

    low: float
    high: float
    rough: bool


class Section(NamedTuple):
    """A box cut at its middle, with f enclosed at both ends and there.

    ``smooth`` tells whether a finite slope is known that agrees with those three values.
    """

    low: float
    middle: float
    high: float
    at_low: Interval
    at_middle: Interval
    at_high: Interval
    slope: Interval
    smooth: bool


class _RootBoxes:
    """f with its enclosures, the results so far, and the number of boxes evaluated."""

    def __init__(
        self,
        enclose: Enclosure,
        enclose_slope: Enclosure | None,
        value: ScalarFunction,
        low: float,
        high: float,
    ) -> None:
        self._enclose, self._enclose_slope = enclose, enclose_slope
        self.value, self.low, self.high = value, low, high
        self.evaluations = 0
        self._known: dict[float, Interval] = {}
        self.roots: list[float] = []
        self.crossings: list[float] = []
        self.touching: list[float] = []
        self.flat: Intervals = []
        self.unresolved: Intervals = []

    def run(self, limits: IsolationLimits, within: Sequence[Interval] | None) -> RootSearch:
        front = presplit(self.low, self.high) if within is None else [*within]
        settled, at_rounding, unsplit, levels = self._branch_and_prune(front, limits)
        self.roots = [bracketed_root(self.value, *box) for box in settled]
        valueless = [isnan(value_at(self.value, root)) for root in self.roots]
        blank = [box for box, nowhere in zip(settled, valueless, strict=True) if nowhere]
        clusters = []
        for cluster in merged(at_rounding, unsplit):
            tiny = (
                cluster.low <= 0.0 <= cluster.high
                and max(-cluster.low, cluster.high) <= 1 / HORIZON
            )
            if not self._is_remote(cluster.low, cluster.high) and (
                not tiny or self._may_vanish(0.0)
            ):
                clusters.append(cluster)
        for number, cluster in enumerate(
            sorted(clusters, key=lambda c: (c.rough, *_ordinary(*c[:2])))
        ):
            if number < LOOKED_INTO and not (cluster.rough and len(self.roots) > MANY):
                self._resolve(cluster)
            else:
                self.unresolved.append((cluster.low, cluster.high))
        return RootSearch(
            roots=tuple(sorted(set(self.roots))),
            complete=not (self.unresolved or blank),
            unresolved=(*self.unresolved, *blank),
            touching=tuple(self.touching),
            flat=tuple(self.flat),
            evaluations=self.evaluations,
            levels=levels,
            crossings=tuple(self.crossings),
        )

    # --- f over boxes ---

    def _is_remote(self, low: float, high: float) -> bool:
        """Whether a box is out of scope: beyond ±1e100 for an infinite range, or nearer to 0 than
        1e-100 without holding it. Enclosures overflow there, and an undecided box means nothing."""
        if (self.low == -inf and high <= -HORIZON) or (self.high == inf and low >= HORIZON):
            return True
        near = max(abs(low), abs(high)) <= 1 / HORIZON and (low > 0.0 or high < 0.0)
        return near and max(-self.low, self.high) > HORIZON**-0.5

    def _ranges(self, boxes: Sequence[Interval]) -> list[Interval | None]:
        """Enclosures of f, a single nan widened to infinity; None if f is undefined all over the
        box, or known to have no root there."""
        self.evaluations += len(boxes)
        return [
            None if isnan(below) and isnan(above) else _widened(below, above)
            for below, above in self._enclose(boxes)
        ]

    def _slopes(self, boxes: Sequence[Interval]) -> list[Interval]:
        """Enclosures of the slope, infinite if unknown."""
        if self._enclose_slope is None:
            return [UNKNOWN] * len(boxes)
        self.evaluations += len(boxes)
        return [_widened(below, above) for below, above in self._enclose_slope(boxes)]

    def _at_points(self, points: Sequence[float]) -> list[Interval]:
        """Enclosures of f at points. The ends of a half are an end and the middle of its box: they
        are not evaluated again, but count as if they were."""
        asked = [x for x in dict.fromkeys(points) if x not in self._known]
        self.evaluations += len(points) - len(asked)
        for x, values in zip(asked, self._ranges([(x, x) for x in asked]), strict=True):
            self._known[x] = UNKNOWN if values is None else values
        return [self._known[x] for x in points]

    def _sections(self, boxes: Sequence[Interval]) -> list[Section]:
        """Evaluate f at the ends and at the middle of each box, and its slope on the box."""
        k, middles = len(boxes), [split_point(low, high) for low, high in boxes]
        points = [low for low, _ in boxes] + middles + [high for _, high in boxes]
        at = self._at_points(points)
        found = []
        for (low, high), middle, left, centre, right, slope in zip(
            boxes, middles, at[:k], at[k : 2 * k], at[2 * k :], self._slopes(boxes), strict=True
        ):
            smooth = (
                all(isfinite(end) for pair in (slope, left, centre, right) for end in pair)
                and _agrees(left, centre, slope, middle - low)
                and _agrees(centre, right, slope, high - middle)
            )
            found.append(Section(low, middle, high, left, centre, right, slope, smooth))
        return found

    # --- branch and prune ---

    def _branch_and_prune(
        self, front: Intervals, limits: IsolationLimits
    ) -> tuple[Intervals, Intervals, Intervals, int]:
        """Boxes that hold exactly one root, boxes at rounding level, boxes left at the limits, and
        the number of levels. Remote boxes are given up."""
        settled: Intervals = []
        at_rounding: Intervals = []
        unsplit: Intervals = []
        level = 0
        for level in range(limits.levels):
            expect_time()
            if not front or self.evaluations > LAST_LOOK * limits.boxes:
                break
            ranges = zip(front, self._ranges(front), strict=True)
            kept = [
                (box, f[1] - f[0]) for box, f in ranges if f is not None and f[0] <= 0.0 <= f[1]
            ]
            opened: list[Section] = []
            for section, (box, width) in zip(
                self._sections([b for b, _ in kept]), kept, strict=True
            ):
                match judge(section, width):
                    case BoxState.SINGLE:
                        settled.append(box)
                    case BoxState.ROUNDING:
                        at_rounding.append(box)
                    case BoxState.OPEN:
                        opened.append(section)
            if level >= REMOTE_LEVELS:
                opened = [
                    section for section in opened if not self._is_remote(section.low, section.high)
                ]
            work = self.evaluations + 2 * BOXES_ASKED * len(opened)
            if unsplit or 2 * len(opened) > limits.alive or work > limits.boxes:
                opened.sort(key=lambda s: (_rise(s), *_ordinary(s.low, s.high)))
                unsplit += [(section.low, section.high) for section in opened[CALMEST:]]
                del opened[CALMEST:]
            front = [half for s in opened for half in ((s.low, s.middle), (s.middle, s.high))]
        left = [box for box in unsplit if not self._is_remote(*box)]
        return settled, at_rounding, left + front, level + 1

    # --- what is left over ---

    def _may_vanish(self, x: float) -> bool:
        """Whether f is defined at x, and 0 there to rounding."""
        (at,) = self._ranges([(x, x)])
        return at is not None and at[0] <= 0.0 <= at[1]

    def _resolve(self, cluster: Cluster) -> None:
        known = self._enclose_slope is not None
        if self._is_empty(cluster) or (known and (self._prove(cluster) or self._is_edge(cluster))):
            return
        whole = (cluster.low, cluster.high)
        self.unresolved.append(whole)
        zeros = [x for x in _spread(*whole) if value_at(self.value, x) == 0.0]
        step = [(zeros[0], zeros[-1])] if len(zeros) > 1 else []  # which ends in it
        spans = step or [whole] if cluster.rough else [whole, *step]
        if flat := next((span for span in spans if self._is_flat(*span)), None):
            self.flat.append(flat)
        elif crossings := self._crossings(cluster):
            self.roots += crossings
            self.crossings += crossings
        elif not cluster.rough:
            self._add_touching(cluster)

    def _is_empty(self, cluster: Cluster) -> bool:
        """Whether there is no root between any two neighbours of a cluster of few floats, of which
        one may be a pole or the end of the domain."""
        floats = _floats(cluster)
        few = 1 < len(floats) <= FEW_FLOATS
        ranges = self._ranges([*pairwise(floats)]) if few else [UNKNOWN]
        return all(f is None or f[0] > 0.0 or f[1] < 0.0 for f in ranges)

    def _inflated(self, cluster: Cluster, factor: float) -> Interval:
        """The cluster, wider by ``factor`` times its width (or its last bit) on each side, in
        range."""
        low, high = max(cluster.low, -MAX), min(cluster.high, MAX)
        pad = factor * max(high - low, math.ulp(max(abs(low), abs(high))))
        return max(self.low, low - pad, -MAX), min(self.high, high + pad, MAX)

    def _prove(self, cluster: Cluster) -> bool:
        """Whether f is monotone across the inflated cluster, which then holds one root or none."""
        for factor in INFLATIONS:
            low, high = self._inflated(cluster, factor)
            (cut,) = self._sections([(low, high)])
            if cut.slope[0] <= 0.0 <= cut.slope[1]:
                return False
            signs = self._sign(low, self.low, cut.at_low), self._sign(high, self.high, cut.at_high)
            if not cut.smooth:
                # A pole: f rises wherever it is defined and yet goes from + to - (or falls, from -
                # to +) within a few floats. Then each piece that reaches an end keeps its sign.
                # Pieces that reach neither would need two singularities between neighbouring
                # floats; that is not expected.
                direction = 1 if cut.slope[0] > 0.0 else -1
                narrowest = POLE_ULPS * math.ulp(max(abs(cluster.low), abs(cluster.high)))
                return cluster.high - cluster.low <= narrowest and signs == (direction, -direction)
            if 0 not in signs:
                if signs[0] != signs[1] and not any(low <= x <= high for x in self.roots):
                    self.roots.append(bracketed_root(self.value, low, high))
                return True
            for edge in {low, high} & {self.low, self.high}:
                if value_at(self.value, edge) == 0.0:
                    self.roots.append(edge)
                    return True
        return False

    def _is_edge(self, cluster: Cluster) -> bool:
        """Whether f is 0 at one of a few floats alone and, on each side of it, undefined or
        monotone, though its slope may be infinite there, as that of x^0.3 at 0."""
        floats = _floats(cluster)
        zeros = [x for x in floats if value_at(self.value, x) == 0.0]
        if len(floats) > FEW_FLOATS or len(zeros) != 1:
            return False
        (zero,) = zeros
        for end in self._inflated(cluster, INFLATIONS[0]):
            side, beyond = sorted((zero, end)), sorted((nextafter(zero, end), end))
            ((least, most),) = self._slopes([(side[0], side[1])])
            if not (least > 0.0 or most < 0.0) and self._ranges([(beyond[0], beyond[1])]) != [None]:
                return False
        self.roots.append(zero)
        return True

    def _sign(self, x: float, edge: float, bounds: Interval) -> int:
        """The sign of f: by enclosure, 0 if that holds 0; at an end of the range as computed."""
        sign = int(bounds[0] > 0.0) - int(bounds[1] < 0.0)
        if sign or x != edge:
            return sign
        f = value_at(self.value, x)
        return int(f > 0) - int(f < 0)

    # Where nothing can be proven:

    def _is_flat(self, low: float, high: float) -> bool:
        """Whether f is 0 to rounding at every sample of a cluster wider than rounding and
        underflow. For a narrower one, as wide as that of a multiple root, also whether f is the
        same throughout, and nothing shows a slope."""
        points, size = _spread(low, high)[1:-1], max(abs(low), abs(high))
        still = self._enclose_slope is None or self._slopes([(points[0], points[-1])]) == [(0, 0)]
        steps = still and len({value_at(self.value, x) for x in points}) == 1
        if not isfinite(high - low) or high - low <= max(
            (PLATEAU if steps else MULTIPLE) * size, 1 / HORIZON
        ):
            return False
        values = (self._ranges([(x, x)])[0] for x in points)  # the first mostly tells
        return all(f is not None and f[0] <= 0.0 <= f[1] and isfinite(f[1] - f[0]) for f in values)

    def _crossings(self, cluster: Cluster) -> list[float]:
        """Roots at changes of sign: between samples of a rough cluster, else between its two sides
        only, because inside it signs are noise. Poles and jumps are left out."""
        low, high = self._inflated(cluster, 2.0)
        points = _spread(low, high) if cluster.rough and high - low < MAX else [low, high]
        defined = [(x, f) for x in points if not isnan(f := value_at(self.value, x))]
        roots = set()
        for (a, f_a), (b, f_b) in pairwise(defined):
            if min(f_a, f_b) < 0.0 < max(f_a, f_b):
                root = bracketed_root(self.value, a, b)
                if is_zero_crossing(self.value, root, self.low, self.high):
                    roots.add(root)
        return sorted(roots)

    def _add_touching(self, cluster: Cluster) -> None:
        """Add the point where the slope changes sign, if f is 0 to rounding there: for a double
        root far better conditioned than the least |f|. Otherwise, the least |f|, if f is defined at
        all."""

        def slope(x: float) -> float:
            ((below, above),) = self._slopes([(x, x)])
            return (below + above) / 2

        low, high = self._inflated(cluster, 2.0)
        points = [lowest_point(self.value, low, high)]
        if slope(low) * slope(high) < 0.0:  # nan where no slope is known
            points.insert(0, bracketed_root(slope, low, high))
        for x in points:
            if not isnan(value_at(self.value, x)) and (x == points[-1] or self._may_vanish(x)):
                self.touching.append(x + 0.0)
                return


def _floats(cluster: Cluster) -> list[float]:
    """The floats of a cluster, or too many of them."""
    floats = [cluster.low]
    while floats[-1] < cluster.high and len(floats) <= FEW_FLOATS:
        floats.append(nextafter(floats[-1], inf))
    return floats


def _rise(section: Section) -> float:
    """How far f may rise or fall over a section."""
    return max(map(abs, section.slope)) * (section.high - section.low) if section.smooth else inf


def _ordinary(low: float, high: float) -> tuple[float, bool]:
    """Sort key: boxes of usual sizes come first, positive ones before negative ones."""
    middle = split_point(low, high)
    return abs(math.log(abs(middle))) if middle else 0.0, middle < 0.0


def _widened(below: float, above: float) -> Interval:
    return -inf if isnan(below) else below, inf if isnan(above) else above


def _agrees(left: Interval, right: Interval, slope: Interval, distance: float) -> bool:
    """Whether f can change from ``left`` to ``right`` with such slopes; mostly not at a jump."""
    least, most = slope[0] * distance, slope[1] * distance
    slack = 1e-14 * (abs(left[0]) + abs(right[0]) + abs(least) + abs(most))
    return right[1] >= left[0] + least - slack and right[0] <= left[1] + most + slack


def _spread(low: float, high: float) -> list[float]:
    """Points at equal distances, including the ends."""
    step = (high - low) / (SAMPLES - 1)
    return [*(low + i * step for i in range(SAMPLES - 1)), high]


def merged(at_rounding: Iterable[Interval], unsplit: Iterable[Interval]) -> list[Cluster]:
    """Intervals joined if they touch, overlap, or are separated by less than a few of their widths
    (rounding noise leaves such fragments), ascending."""
    boxes = [Cluster(*box, False) for box in at_rounding] + [Cluster(*box, True) for box in unsplit]
    clusters: list[Cluster] = []
    for box in sorted(boxes, key=lambda b: (b.low, b.high)):
        expect_time()
        last = clusters[-1] if clusters else box
        rough = box.rough or last.rough
        width = 0.0 if rough else max(box.high - box.low, last.high - last.low)
        if clusters and box.low - last.high <= GAP * width:
            clusters.pop()
            box = Cluster(last.low, max(last.high, box.high), rough)
        clusters.append(box)
    return clusters


def presplit(low: float, high: float) -> Intervals:
    boxes = [(low, high)]
    for _ in range(PRESPLIT if low < high else 0):
        cut = [(a, split_point(a, b), b) for a, b in boxes]
        boxes = [
            half for a, middle, b in cut for half in ((a, middle), (middle, b)) if half[0] < half[1]
        ]
    return [(max(a, -MAX), min(b, MAX)) for a, b in boxes if a < MAX and b > -MAX]


class BoxState(Enum):
    """The state of a box."""

    EMPTY = "it holds no root"
    SINGLE = "it holds exactly one"
    ROUNDING = "it cannot usefully be split any more"
    OPEN = "it is to be split"


def judge(section: Section, width: float) -> BoxState:
    """``width`` is that of the natural enclosure of f on the box."""
    (low_0, low_1), (high_0, high_1) = section.at_low, section.at_high
    spread = width
    if section.smooth:
        slope_0, slope_1 = section.slope
        steepest = max(abs(slope_0), abs(slope_1))
        reaches = (
            (section.high - section.low, section.at_low),
            (max(section.middle - section.low, section.high - section.middle), section.at_middle),
            (section.high - section.low, section.at_high),
        )
        # f(a) + [-s, s] (x - a) excludes 0 for some a of the ends and the middle
        if any(
            below > steepest * reach or above < -steepest * reach
            for reach, (below, above) in reaches
        ):
            return BoxState.EMPTY
        if (
            (slope_0 > 0.0 or slope_1 < 0.0)
            and (low_0 > 0.0 or low_1 < 0.0)
            and (high_0 > 0.0 or high_1 < 0.0)
        ):
            return BoxState.SINGLE if (low_0 > 0.0) is not (high_0 > 0.0) else BoxState.EMPTY
        reach = steepest * max(section.middle - section.low, section.high - section.middle)
        spread = min(width, 2.0 * reach)
    blurs = [high - low for low, high in (section.at_low, section.at_middle, section.at_high)]
    noise = min(blurs) if all(map(isfinite, blurs)) else 0.0
    narrow = nextafter(nextafter(section.low, inf), inf) >= section.high
    done = narrow or spread <= 4.0 * noise or not section.low < section.middle < section.high
    return BoxState.ROUNDING if done else BoxState.OPEN
