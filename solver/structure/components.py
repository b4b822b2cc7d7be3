"""Strong components of a directed graph.

R. Tarjan, "Depth-first search and linear graph algorithms", SIAM J. Comput. 1 (1972), without
recursion, so that a chain of any length is no depth.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence


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
