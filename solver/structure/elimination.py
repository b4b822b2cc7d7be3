"""The cheapest order of explicit steps once the tears of a block are known.

Uniform cost search (E. W. Dijkstra 1959) over sets of knowns. Steps that cost nothing are taken
at once: they can only help, because more follows from more.
"""

from __future__ import annotations

from collections.abc import Iterable
from heapq import heappop, heappush
from typing import NamedTuple, TypeAlias

from rulesheets.deadline import expect_time
from solver.structure.incidence import Incidence

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
