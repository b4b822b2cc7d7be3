"""Tearing: a simultaneous block as a short list of iterated unknowns and explicit steps after them.

H. Elmqvist & M. Otter, "Methods for tearing systems of equations in object-oriented modeling" (ESM
1994); F. E. Cellier & E. Kofman, "Continuous System Simulation" (2006), section 7.8. Finding a
smallest set of tears is NP-complete (it contains feedback vertex set; see A. Baharev, H. Schichl &
A. Neumaier, "Tearing systems of nonlinear equations" II, 2016), so exact for small blocks only. The
heuristic is Cellier's: among the equations with the fewest unknowns left, the unknown from which
most follows.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from heapq import heappop, heappush
from math import comb
from typing import NamedTuple, TypeAlias

from rulesheets.deadline import expect_time
from solver.structure.decomposition import Incidence

Tears: TypeAlias = tuple[int, ...]
Steps: TypeAlias = tuple[tuple[int, int], ...]
"""(equation, unknown) pairs."""

EFFORT = 50_000
"""Sets times unknowns up to which all sets are tried: five of 15, one or two tears in larger
blocks."""
ORDERING = 20_000
"""Edges looked at before the search of the best order gives way to taking the cheapest step each
time."""
TRIM = 1_000_000
"""Tears times edges up to which a set is searched for idle tears."""
CANDIDATES = 40
"""How many unknowns the heuristic tries before it takes the best as a tear."""
SHORT_LIST = 20
"""How many sets of tears have their steps ordered with full care; the others are judged by a quick
order."""


class Tearing(NamedTuple):
    """Guess ``tears``, follow ``order`` (equation, unknown), and ``residuals`` must vanish.

    Every step's equation is resolvable for its unknown and holds no other but tears and those of
    steps before it. A square block has as many residuals as tears.
    """

    tears: Tears
    order: Steps
    residuals: tuple[int, ...]


def tearings(
    incidence: Incidence, weights: Mapping[int, int], limit: int, effort: int = EFFORT
) -> tuple[Tearing, ...]:
    """Up to ``limit`` tearings with equally many tears, at least one: least cost of the steps
    first, then least weight, then source order.

    The number of tears is the minimum if all sets can be tried with an ``effort`` of sets times
    unknowns; else it is a heuristic's. Unknowns without a weight weigh 0.
    """

    def rank(judged: tuple[Tears, _Partial]) -> tuple[int, int, Tears]:
        return judged[1].cost, sum(weights.get(u, 0) for u in judged[0]), judged[0]

    judged = sorted(_smallest_sets(incidence, weights, effort), key=rank)[: max(SHORT_LIST, limit)]
    judged = [
        (tears, _searched(incidence, tears) or order if order.cost else order)
        for tears, order in judged
    ]
    found = []
    for tears, order in sorted(judged, key=rank)[:limit]:
        used = {equation for equation, _ in order.steps}
        found.append(
            Tearing(
                tears, order.steps, tuple(e for e in incidence.block.equations if e not in used)
            )
        )
    return tuple(found)


# --- orders of steps ------------------------------------------------------------


class _Partial(NamedTuple):
    """``steps`` and their cost; the known variables after them, the (cost, equation, unknown) that
    may follow, and the ``fewest`` unknowns left in an equation that has several, 0 without one."""

    cost: int
    steps: Steps
    known: frozenset[int]
    offers: list[tuple[int, int, int]]
    fewest: int


def _order(incidence: Incidence, known: Collection[int], ceiling: int | None = None) -> _Partial:
    """Steps that follow from the known variables, each the cheapest, then first, available, as long
    as it costs no more than ``ceiling``. (Without one, the known variables at the end do not depend
    on the order.)"""
    reached = set(known)
    missing = {
        e: sum(u not in reached for u in incidence.occurs[e]) for e in incidence.block.equations
    }
    offers: list[tuple[int, int, int]] = []
    total, steps = 0, list[tuple[int, int]]()

    def offer(equation: int) -> None:
        if missing[equation] == 1:
            unknown = next(u for u in incidence.occurs[equation] if u not in reached)
            cost = incidence.resolvable[equation].get(unknown)
            if cost is not None:
                heappush(offers, (cost, equation, unknown))

    for equation in incidence.block.equations:
        offer(equation)
    while offers and (ceiling is None or offers[0][0] <= ceiling):
        expect_time()
        cost, equation, unknown = heappop(offers)
        if unknown in reached:
            continue
        total += cost
        steps.append((equation, unknown))
        reached.add(unknown)
        for user in incidence.users[unknown]:
            missing[user] -= 1
            offer(user)
    going_on = [step for step in offers if step[2] not in reached]
    fewest = min((left for left in missing.values() if left > 1), default=0)
    return _Partial(total, tuple(steps), frozenset(reached), going_on, fewest)


def _searched(incidence: Incidence, tears: Tears) -> _Partial | None:
    """The order of least total cost; None if the search takes too long."""
    queue = [_order(incidence, tears, ceiling=0)]
    closed: set[frozenset[int]] = set()
    pushed = 0
    while queue:
        expect_time()
        here = heappop(queue)
        if not here.offers:
            return here
        if here.known in closed:
            continue
        closed.add(here.known)
        for cost, equation, unknown in here.offers:
            pushed += 1
            if pushed * incidence.edges > ORDERING:
                return None
            after = _order(incidence, here.known | {unknown}, ceiling=0)
            steps = (*here.steps, (equation, unknown), *after.steps)
            heappush(queue, after._replace(cost=here.cost + cost, steps=steps))
    raise AssertionError("every order ends")


# --- sets of tears --------------------------------------------------------------


def _smallest_sets(
    incidence: Incidence, weights: Mapping[int, int], effort: int
) -> list[tuple[Tears, _Partial]]:
    """Sets of tears of one size with their steps: all of the least size, or the one of the
    heuristic."""
    unknowns = incidence.block.unknowns
    first = _order(incidence, ())
    given = {u for e in incidence.block.equations for u in incidence.resolvable[e]}
    never_given = len(set(unknowns) - given)
    complete = len(first.known) == len(unknowns)
    for size in range(0 if complete else max(never_given, first.fewest - 1, 1), len(unknowns) + 1):
        if comb(len(unknowns), size) * len(unknowns) > effort:
            break
        if sets := list(_complete(incidence, (), first, size, 0)):
            return sets
    tears = _greedy(incidence, weights)
    return [(tears, _order(incidence, tears))]


def _complete(
    incidence: Incidence, tears: Tears, order: _Partial, size: int, start: int
) -> Iterator[tuple[Tears, _Partial]]:
    """Sets with ``size`` further tears from which everything follows, in lexicographic order.

    An unknown that follows from the tears before it is skipped: a set with it is not smallest. Sets
    of fewer tears have been searched before.
    """
    unknowns = incidence.block.unknowns
    if len(order.known) == len(unknowns):
        yield tears, order
    elif size and order.fewest <= size + 1:  # else too few tears for any further step
        for i in range(start, len(unknowns) - size + 1):
            if unknowns[i] not in order.known:
                expect_time()
                more = (*tears, unknowns[i])
                yield from _complete(incidence, more, _order(incidence, more), size - 1, i + 1)


def _greedy(incidence: Incidence, weights: Mapping[int, int]) -> Tears:
    """One tear after another; those that follow from the others are dropped, the first taken
    first."""
    unknowns, equations = incidence.block.unknowns, incidence.block.equations
    tears: list[int] = []
    known = _order(incidence, ()).known
    while len(known) < len(unknowns):
        expect_time()
        left = [(e, [u for u in incidence.occurs[e] if u not in known]) for e in equations]
        open_ = [
            some
            for e, some in left
            if len(some) > 1 and not known.issuperset(incidence.resolvable[e])
        ]
        fewest = min(map(len, open_), default=0)
        near = dict.fromkeys(u for some in open_ if len(some) == fewest for u in some)
        candidates = list(near)[:CANDIDATES] or [next(u for u in unknowns if u not in known)]
        after = {u: _order(incidence, (*known, u)).known for u in candidates}
        best = max(candidates, key=lambda u: (len(after[u]), -weights.get(u, 0), -u))
        tears.append(best)
        known = after[best]
    if len(tears) * incidence.edges <= TRIM:
        for idle in tuple(tears):
            rest = [u for u in tears if u != idle]
            if len(_order(incidence, rest).known) == len(unknowns):
                tears = rest
    return tuple(sorted(tears))
