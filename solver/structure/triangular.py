"""Block lower triangular form of a square system.

I. S. Duff & J. K. Reid, "An implementation of Tarjan's algorithm for the block triangularization
of a matrix", ACM TOMS 4 (1978).
"""

from __future__ import annotations

from collections.abc import Sequence
from heapq import heapify, heappop, heappush

from solver.structure import csgraph
from solver.structure.components import strong_components
from solver.structure.incidence import Block, Incidence
from solver.structure.matching import Matching, maximum_matching

SMALL = 100_000
"""Up to so many nodes plain Python is faster than importing scipy."""


def block_triangular(
    incidence: Incidence, square: Block | None = None, matching: Matching | None = None
) -> tuple[Block, ...]:
    """The blocks to solve one after another, each simultaneous in itself.

    The blocks are unique, whatever the matching that they are found with; among orders in which
    every block comes after those that it needs, it is the one that keeps closest to the source.
    ``matching`` may be any maximum matching of the whole, where that is known already.
    Raises ValueError where the part can't be matched completely.
    """
    part = incidence if square is None else incidence.restrict(square)
    equations = part.block.equations
    matching = matching or maximum_matching(part)
    matched = {matching.unknown_of[e] for e in equations}
    if len(equations) != len(part.block.unknowns) or matched != set(part.block.unknowns):
        raise ValueError("a block triangular form needs as many independent equations as unknowns")
    number = {matching.unknown_of[e]: i for i, e in enumerate(equations)}
    needs = [[number[u] for u in part.occurs[e]] for e in equations]
    members = _components(needs)
    unknowns = [matching.unknown_of[e] for e in equations]
    return tuple(
        Block.of((equations[i] for i in group), (u for i in group if (u := unknowns[i]) is not None))
        for group in _in_order(members, needs)
    )


def _components(successors: Sequence[Sequence[int]]) -> list[list[int]]:
    """Strong components, by their first node; nodes ascend in each."""
    large = len(successors) > SMALL
    labels = csgraph.strong_components(successors) if large else strong_components(successors)
    groups: dict[int, list[int]] = {}
    for node, label in enumerate(labels):
        groups.setdefault(label, []).append(node)
    return list(groups.values())


def _in_order(groups: Sequence[list[int]], needs: Sequence[Sequence[int]]) -> list[list[int]]:
    """Groups so that each follows those it needs; among the ready ones the first in the source goes first."""
    group_of = {node: g for g, group in enumerate(groups) for node in group}
    waits: list[set[int]] = []
    followers: list[list[int]] = [[] for _ in groups]
    for g, group in enumerate(groups):
        waits.append({group_of[other] for node in group for other in needs[node]} - {g})
        for other in waits[g]:
            followers[other].append(g)
    missing = [len(wait) for wait in waits]
    ready = [g for g, count in enumerate(missing) if count == 0]
    heapify(ready)
    order: list[list[int]] = []
    while ready:
        g = heappop(ready)
        order.append(groups[g])
        for follower in followers[g]:
            missing[follower] -= 1
            if missing[follower] == 0:
                heappush(ready, follower)
    return order
