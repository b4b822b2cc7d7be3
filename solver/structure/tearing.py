"""Tearing: a simultaneous block as a short list of iterated unknowns and explicit steps after them.

H. Elmqvist & M. Otter, "Methods for tearing systems of equations in object-oriented modeling"
(ESM 1994); F. E. Cellier & E. Kofman, "Continuous System Simulation" (2006), section 7.8;
A. Baharev, H. Schichl & A. Neumaier, "Tearing systems of nonlinear equations" I and II (2016).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from solver.structure.elimination import Order, cheap_order, cheapest_order
from solver.structure.incidence import Incidence
from solver.structure.tear_sets import smallest_sets

SHORT_LIST = 20
"""How many sets of tears have their steps ordered with full care; the others are judged by a quick order."""

QUICK = 400
"""How many sets of tears are judged at all, the lightest, then first."""


@dataclass(frozen=True, slots=True)
class Tearing:
    """Guess ``tears``, follow ``order`` (equation, unknown), and ``residuals`` must vanish.

    Every step's equation is resolvable for its unknown and holds no other but tears and those of
    steps before it. A square block has as many residuals as tears.
    """

    tears: tuple[int, ...]
    order: tuple[tuple[int, int], ...]
    residuals: tuple[int, ...]


def tear(incidence: Incidence, weights: Mapping[int, int] | None = None) -> Tearing:
    """The best tearing: fewest tears, then least cost of the steps, then least weight, then source order.

    The number of tears is the minimum for blocks of up to 15 unknowns and for larger ones that
    need few; else it is a heuristic's. Unknowns without a weight weigh 0.
    """
    return tearings(incidence, weights, limit=1)[0]


def tearings(
    incidence: Incidence, weights: Mapping[int, int] | None = None, limit: int = 10
) -> tuple[Tearing, ...]:
    """At least one tearing and up to ``limit``, all with equally many tears, best first."""
    weights = weights or {}

    def weight(tears: tuple[int, ...]) -> tuple[int, tuple[int, ...]]:
        return sum(weights.get(u, 0) for u in tears), tears

    def rank(judged: tuple[Order, tuple[int, ...]]) -> tuple[int, int, tuple[int, ...]]:
        return judged[0].cost, *weight(judged[1])

    judged: list[tuple[Order, tuple[int, ...]]] = []
    safe = 0
    for tears in sorted(smallest_sets(incidence, weights, limit), key=weight)[: max(QUICK, limit)]:
        judged.append((cheap_order(incidence, tears), tears))
        safe += judged[-1][0].cost == 0
        if safe == limit:  # the sets come by weight, so no later one is better
            break
    judged = sorted(judged, key=rank)[: max(SHORT_LIST, limit)]
    short_list = [(_improved(incidence, order, tears), tears) for order, tears in judged]
    return tuple(_tearing(incidence, *best) for best in sorted(short_list, key=rank)[:limit])


def _improved(incidence: Incidence, order: Order, tears: tuple[int, ...]) -> Order:
    return cheapest_order(incidence, tears) if order.cost else order


def _tearing(incidence: Incidence, order: Order, tears: tuple[int, ...]) -> Tearing:
    used = {equation for equation, _ in order.steps}
    return Tearing(tears, order.steps, tuple(e for e in incidence.block.equations if e not in used))
