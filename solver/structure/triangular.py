"""Block lower triangular form of a square system, by the strong components of its graph.

R. Tarjan, "Depth-first search and linear graph algorithms", SIAM J. Comput. 1 (1972), without recursion, so
that a chain of any length is no depth; I. S. Duff & J. K. Reid, "An implementation of Tarjan's algorithm for
the block triangularization of a matrix", ACM TOMS 4 (1978).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from heapq import heapify, heappop, heappush

from solver.structure.incidence import Block, Incidence
from solver.structure.matching import Matching, maximum_matching


def strong_components(successors: Sequence[Sequence[int]]) -> list[int]:
    """A label for every node, equal for nodes that reach one another; the labels mean nothing else."""
    search = _Search(successors)
    for node in range(len(successors)):
        if search.index[node] < 0:
            search.run(node)
    return search.label


class _Search:
    """``low[n]`` is the least index of an open node that ``n`` is known to reach."""

    def __init__(self, successors: Sequence[Sequence[int]]) -> None:
        self.successors = successors
        self.index = [-1] * len(successors)
        self.low = [0] * len(successors)
        self.label = [-1] * len(successors)
        self.entered = 0
        self.open: list[int] = []
        self.path: list[tuple[int, Iterator[int]]] = []

    def run(self, root: int) -> None:
        self._enter(root)
        while self.path:
            node, rest = self.path[-1]
            fresh = self._next(node, rest)
            if fresh is None:
                self._leave(node)
            else:
                self._enter(fresh)

    def _enter(self, node: int) -> None:
        self.index[node] = self.low[node] = self.entered
        self.entered += 1
        self.open.append(node)
        self.path.append((node, iter(self.successors[node])))

    def _next(self, node: int, rest: Iterator[int]) -> int | None:
        """A successor not seen before; those that are open are taken note of."""
        for successor in rest:
            if self.index[successor] < 0:
                return successor
            if self.label[successor] < 0:
                self.low[node] = min(self.low[node], self.index[successor])
        return None

    def _leave(self, node: int) -> None:
        self.path.pop()
        if self.path:
            before = self.path[-1][0]
            self.low[before] = min(self.low[before], self.low[node])
        if self.low[node] == self.index[node]:
            self._close(node)

    def _close(self, root: int) -> None:
        """Label the component that ``root`` was the first to enter."""
        node = -1
        while node != root:
            node = self.open.pop()
            self.label[node] = root


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
    labels = strong_components(successors)
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
