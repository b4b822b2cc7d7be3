"""Tearing: a simultaneous block as a short list of iterated unknowns and explicit steps after them.

H. Elmqvist & M. Otter, "Methods for tearing systems of equations in object-oriented modeling"
(ESM 1994); F. E. Cellier & E. Kofman, "Continuous System Simulation" (2006), section 7.8;
A. Baharev, H. Schichl & A. Neumaier, "Tearing systems of nonlinear equations" I and II (2016).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from heapq import heappop, heappush
from typing import NamedTuple, TypeAlias

from rulesheets.deadline import expect_time
from solver.structure.incidence import Incidence
from solver.structure.tear_sets import smallest_sets

EFFORT = 20_000
"""Edges looked at before the search gives way to taking the cheapest step each time."""

Steps: TypeAlias = tuple[tuple[int, int], ...]


class Order(NamedTuple):
    """``steps`` are (equation, unknown) pairs; ``cost`` is the sum of theirs."""

    cost: int
    steps: Steps


class _Peeled(NamedTuple):
    """What is known after ``order``, and the (cost, equation, unknown) that go on from there."""

    known: frozenset[int]
    order: Order
    offers: list[tuple[int, int, int]]


def cheapest_order(incidence: Incidence, tears: Iterable[int]) -> Order:
    """Steps that reach whatever ``tears`` reach, at the least total cost.

    Where the block is large and forks a lot, each step is merely the cheapest of those on offer.
    """
    known = frozenset(tears)
    return _searched(incidence, known) or cheap_order(incidence, known)


def cheap_order(incidence: Incidence, tears: Iterable[int]) -> Order:
    """Steps that reach whatever ``tears`` reach, each the cheapest, then first, on offer."""
    return _peel(incidence, frozenset(tears), ceiling=None).order


def _searched(incidence: Incidence, known: frozenset[int]) -> Order | None:
    """The best of all orders; None where the search takes too long."""
    first = _peel(incidence, known, ceiling=0)
    queue = [(first.order, 0, first)]
    closed: set[frozenset[int]] = set()
    pushed = 0
    while queue:
        expect_time()
        order, _, state = heappop(queue)
        if not state.offers:
            return order
        if state.known in closed:
            continue
        closed.add(state.known)
        for cost, equation, unknown in state.offers:
            pushed += 1
            if pushed * incidence.edges > EFFORT:
                return None
            after = _peel(incidence, state.known | {unknown}, ceiling=0)
            steps = (*order.steps, (equation, unknown), *after.order.steps)
            total = Order(order.cost + cost, steps)
            heappush(queue, (total, pushed, _Peeled(after.known, total, after.offers)))
    raise AssertionError("every order ends")


def _peel(incidence: Incidence, known: frozenset[int], ceiling: int | None) -> _Peeled:
    """Take the cheapest step, then the first, as long as it costs no more than ``ceiling``."""
    reached = set(known)
    missing = {e: sum(u not in known for u in incidence.occurs[e]) for e in incidence.block.equations}
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
    return _Peeled(frozenset(reached), Order(total, tuple(steps)), going_on)


SHORT_LIST = 20
"""How many sets of tears have their steps ordered with full care; the others are judged by a quick order."""

QUICK = 400
"""How many sets of tears are judged at all, the lightest, then first."""


class Tearing(NamedTuple):
    """Guess ``tears``, follow ``order`` (equation, unknown), and ``residuals`` must vanish.

    Every step's equation is resolvable for its unknown and holds no other but tears and those of
    steps before it. A square block has as many residuals as tears.
    """

    tears: tuple[int, ...]
    order: tuple[tuple[int, int], ...]
    residuals: tuple[int, ...]


def tearings(
    incidence: Incidence, weights: Mapping[int, int] | None = None, limit: int = 10
) -> tuple[Tearing, ...]:
    """Up to ``limit`` tearings with equally many tears, at least one: least cost of the steps first, then
    least weight, then source order.

    The number of tears is the minimum where all sets can be tried; else it is a heuristic's. Unknowns without
    a weight weigh 0.
    """
    weights = weights or {}

    def weight(tears: tuple[int, ...]) -> tuple[int, tuple[int, ...]]:
        return sum(weights.get(u, 0) for u in tears), tears

    def rank(judged: tuple[Order, tuple[int, ...]]) -> tuple[int, int, tuple[int, ...]]:
        return judged[0].cost, *weight(judged[1])

    judged: list[tuple[Order, tuple[int, ...]]] = []
    safe = 0
    for tears in sorted(smallest_sets(incidence, weights), key=weight)[: max(QUICK, limit)]:
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
