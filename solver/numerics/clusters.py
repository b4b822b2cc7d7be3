"""What branch and prune leaves over: roots on box boundaries, multiple roots, edges, poles, flat stretches.

Adjacent boxes are merged into clusters. A cluster is first blown up a little (epsilon inflation, after
S. M. Rump): a root that sat on a boundary is then inside and can be proven. Otherwise it is searched for
changes of sign and for the least |f|.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING

from rulesheets.deadline import expect_time
from solver.numerics.bracket import MAX, bracketed_root, is_zero_crossing, lowest_point, value_at
from solver.numerics.interval_function import HORIZON, IntervalFunction, NoValue, sections

if TYPE_CHECKING:
    from collections.abc import Iterable

    from solver.numerics.interval_function import Interval, Section

SAMPLES = 129
INFLATIONS = (4.0, 64.0, 4096.0, 2.0**20)
POLE_ULPS = 16
GAP = 4.0


@dataclass(frozen=True, slots=True)
class Cluster:
    """Touching boxes. ``rough`` where one of them was still to be split when the limits were reached."""

    low: float
    high: float
    rough: bool


@dataclass(slots=True)
class Found:
    """Filled cluster by cluster. The fields are those of ``RootSearch``."""

    roots: list[float]
    unresolved: list[Interval] = field(default_factory=list)
    touching: list[tuple[float, float]] = field(default_factory=list)
    flat: list[Interval] = field(default_factory=list)
    crossings: list[float] = field(default_factory=list)


def resolve_clusters(
    function: IntervalFunction,
    at_rounding: Iterable[Interval],
    unsplit: Iterable[Interval],
    roots: list[float],
    candidates: int,
) -> Found:
    """Settle the boxes left over as far as may be; ``roots`` are those already proven.

    ``at_rounding`` can't usefully be split any more, ``unsplit`` could have been. After ``candidates``
    clusters the rest is merely listed.
    """
    found = Found(list(roots))
    clusters = [cluster for cluster in merged(at_rounding, unsplit) if _is_asked(function, cluster)]
    for number, cluster in enumerate(clusters):
        if number < candidates:
            _resolve(function, cluster, found)
        else:
            found.unresolved.append((cluster.low, cluster.high))
    return found


def merged(at_rounding: Iterable[Interval], unsplit: Iterable[Interval] = ()) -> list[Cluster]:
    """Intervals joined that touch, overlap, or are parted by less than a few of their widths (rounding
    noise leaves such fragments), ascending."""
    boxes = [Cluster(*box, False) for box in at_rounding] + [Cluster(*box, True) for box in unsplit]
    clusters: list[Cluster] = []
    for box in sorted(boxes, key=lambda b: (b.low, b.high)):
        expect_time()
        if clusters and box.low - clusters[-1].high <= GAP * _width(box, clusters[-1]):
            last = clusters.pop()
            box = Cluster(last.low, max(last.high, box.high), last.rough or box.rough)
        clusters.append(box)
    return clusters


def _is_asked(function: IntervalFunction, cluster: Cluster) -> bool:
    """False for remote clusters, and for one that is tiny around 0 where f is not 0 at 0 itself."""
    if function.is_remote(cluster.low, cluster.high):
        return False
    if not cluster.low <= 0.0 <= cluster.high or max(-cluster.low, cluster.high) > 1 / HORIZON:
        return True
    at_zero = function.at(0.0)
    return at_zero is not None and at_zero[0] <= 0.0 <= at_zero[1]


def _width(box: Cluster, last: Cluster) -> float:
    return 0.0 if box.rough or last.rough else max(box.high - box.low, last.high - last.low)


def _resolve(function: IntervalFunction, cluster: Cluster, found: Found) -> None:
    if function.has_slope and _prove(function, cluster, found):
        return
    interval = (cluster.low, cluster.high)
    found.unresolved.append(interval)
    if _is_flat(function, cluster):
        found.flat.append(interval)
        return
    crossings = _crossings(function, cluster)
    if crossings:
        found.roots += crossings
        found.crossings += crossings
    elif not cluster.rough:
        _add_touching(function, cluster, found)


def _inflated(function: IntervalFunction, cluster: Cluster, factor: float) -> Interval:
    """The cluster, wider by ``factor`` times its width (or its last bit) on each side, within the range."""
    low, high = max(cluster.low, -MAX), min(cluster.high, MAX)
    pad = factor * max(high - low, math.ulp(max(abs(low), abs(high))))
    return max(function.low, low - pad, -MAX), min(function.high, high + pad, MAX)


# -- proof by inflation -----------------------------------------------------------------------------------


def _prove(function: IntervalFunction, cluster: Cluster, found: Found) -> bool:
    """Whether f is monotone across the inflated cluster, which then holds one root or none."""
    for factor in INFLATIONS:
        low, high = _inflated(function, cluster, factor)
        (cut,) = sections(function, [(low, high)])
        if cut.slope[0] <= 0.0 <= cut.slope[1]:
            return False
        signs = _end_signs(function, cut)
        if not cut.smooth:
            return _is_pole(cluster, cut, signs)
        if 0 not in signs:
            if signs[0] != signs[1] and not any(low <= x <= high for x in found.roots):
                try:
                    found.roots.append(bracketed_root(function.signed, low, high))
                except NoValue:
                    return False
            return True
        for edge in {low, high} & {function.low, function.high}:
            if value_at(function.value, edge) == 0.0:
                found.roots.append(edge)
                return True
    return False


def _end_signs(function: IntervalFunction, cut: Section) -> tuple[int, int]:
    """Signs of f at both ends: by enclosure, 0 where that holds 0; at an end of the range as computed."""
    signs = []
    for x, edge, (below, above) in (
        (cut.low, function.low, cut.at_low),
        (cut.high, function.high, cut.at_high),
    ):
        sign = int(below > 0.0) - int(above < 0.0)
        signs.append(sign or (_computed_sign(function, x) if x == edge else 0))
    return signs[0], signs[1]


def _computed_sign(function: IntervalFunction, x: float) -> int:
    f = value_at(function.value, x)
    return int(f > 0) - int(f < 0)


def _is_pole(cluster: Cluster, cut: Section, signs: tuple[int, int]) -> bool:
    """f rises wherever it is defined and yet goes from + to - (or falls, from - to +) within a few floats.

    Then each piece that reaches an end keeps its sign. Pieces that reach neither would need two
    singularities between neighbouring floats; that is taken not to happen.
    """
    direction = 1 if cut.slope[0] > 0.0 else -1
    size = max(abs(cluster.low), abs(cluster.high))
    narrow = cluster.high - cluster.low <= POLE_ULPS * math.ulp(size)
    return narrow and signs == (direction, -direction)


# -- search where nothing can be proven ------------------------------------------------------------------


def _is_flat(function: IntervalFunction, cluster: Cluster) -> bool:
    """Whether f is 0 to rounding at every sample of a cluster wider than rounding and underflow."""
    low, high = cluster.low, cluster.high
    if not math.isfinite(high - low) or high - low <= max(1e-4 * max(abs(low), abs(high)), 1 / HORIZON):
        return False
    values = map(function.at, _spread(low, high)[1:-1])  # the first of them mostly tells
    return all(f is not None and f[0] <= 0.0 <= f[1] and math.isfinite(f[1] - f[0]) for f in values)


def _spread(low: float, high: float) -> list[float]:
    """Points at equal distances, the ends among them."""
    step = (high - low) / (SAMPLES - 1)
    return [*(low + i * step for i in range(SAMPLES - 1)), high]


def _crossings(function: IntervalFunction, cluster: Cluster) -> list[float]:
    """Roots at changes of sign: between samples of a rough cluster, else between its two sides only,
    because inside it signs are noise. Poles and jumps are left out."""
    low, high = _inflated(function, cluster, 2.0)
    points = _spread(low, high) if cluster.rough and high - low < MAX else [low, high]
    defined = [(x, f) for x in points if not math.isnan(f := value_at(function.value, x))]
    roots = set()
    for (a, f_a), (b, f_b) in pairwise(defined):
        if min(f_a, f_b) < 0.0 < max(f_a, f_b):
            root = bracketed_root(function.value, a, b)
            if is_zero_crossing(function.value, root, function.low, function.high):
                roots.add(root)
    return sorted(roots)


def _add_touching(function: IntervalFunction, cluster: Cluster, found: Found) -> None:
    """The extremum where f is 0 to rounding; failing that, the least |f|, if f is defined at all."""
    low, high = _inflated(function, cluster, 2.0)
    lowest = lowest_point(function.value, low, high)
    for x in (_stationary_point(function, low, high), lowest):
        if x is not None and not math.isnan(f := value_at(function.value, x)):
            found.touching.append((x + 0.0, f + 0.0))
            return


def _stationary_point(function: IntervalFunction, low: float, high: float) -> float | None:
    """Where the slope changes sign, if f is 0 to rounding there: for a double root far better
    conditioned than the least |f|."""
    if not function.has_slope:
        return None

    def slope(x: float) -> float:
        ((below, above),) = function.slopes([(x, x)])
        return (below + above) / 2

    if not slope(low) * slope(high) < 0.0:
        return None
    x = bracketed_root(slope, low, high)
    at_x = function.at(x)
    return x if at_x is None or at_x[0] <= 0.0 <= at_x[1] else None
