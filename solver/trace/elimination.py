"""Gaussian elimination as operations of a program: the pivots are chosen once, at the numbers of a sample.

Only entries that are there are computed, so that a sparse matrix costs what it holds. The order is that of
Markowitz (Management Science 3, 1957, 255-269) among the pivots that are not small in their row.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from solver.trace.flow import Flow, NotCompilable

THRESHOLD = 0.05
"""Share of the largest entry of its row, each by the size of its column, that a pivot must have."""


@dataclass
class Matrix:
    """A sparse matrix of nodes, with the numbers that these have at the sample."""

    nodes: dict[tuple[int, int], int]
    numbers: dict[tuple[int, int], float]


@dataclass
class Elimination:
    """Solves linear systems of one matrix. ``steps`` are the row operations, ``pivots`` in their order."""

    flow: Flow
    size: int
    steps: list[tuple[int, int, int]] = field(default_factory=list)
    pivots: list[tuple[int, int]] = field(default_factory=list)
    upper: dict[tuple[int, int], int] = field(default_factory=dict)

    def solve(self, right: Sequence[int]) -> list[int]:
        """The nodes of the solution for a right-hand side (n,)."""
        add, rest = self.flow.add, list(right)
        for row, pivot, factor in self.steps:
            rest[row] = add("sub", rest[row], add("mul", factor, rest[pivot]))
        found = [0] * self.size
        done: list[int] = []
        for row, column in reversed(self.pivots):
            total = rest[row]
            for other in done:
                if (row, other) in self.upper:
                    total = add("sub", total, add("mul", self.upper[row, other], found[other]))
            found[column] = add("div", total, self.upper[row, column])
            done.append(column)
        return found


def eliminate(flow: Flow, matrix: Matrix, scale: Sequence[float]) -> Elimination:
    """The elimination of a matrix (n, n) whose columns are of the sizes ``scale``.

    Raises NotCompilable where the matrix of the sample is singular.
    """
    size = len(scale)
    nodes, numbers = dict(matrix.nodes), dict(matrix.numbers)
    rows = {i: {j for (r, j) in nodes if r == i} for i in range(size)}
    columns = {j: {i for (i, c) in nodes if c == j} for j in range(size)}
    found = Elimination(flow, size)
    while rows:
        row, column = _pivot(rows, columns, numbers, scale)
        for other in sorted(columns[column] - {row}):
            factor = flow.add("div", nodes[other, column], nodes[row, column])
            share = numbers[other, column] / numbers[row, column]
            found.steps.append((other, row, factor))
            for at in sorted(rows[row] - {column}):
                product = flow.add("mul", factor, nodes[row, at])
                known = nodes.get((other, at))
                nodes[other, at] = (
                    flow.add("neg", product) if known is None else flow.add("sub", known, product)
                )
                numbers[other, at] = numbers.get((other, at), 0.0) - share * numbers[row, at]
                rows[other].add(at)
                columns[at].add(other)
            rows[other].discard(column)
        found.upper.update({(row, at): nodes[row, at] for at in rows[row]})
        found.pivots.append((row, column))
        for at in rows.pop(row):
            columns[at].discard(row)
        del columns[column]
    return found


def _pivot(
    rows: dict[int, set[int]],
    columns: dict[int, set[int]],
    numbers: dict[tuple[int, int], float],
    scale: Sequence[float],
) -> tuple[int, int]:
    """The entry that fills in least, of those that are not small in their row."""
    best: tuple[float, float, int, int] | None = None
    for row, places in rows.items():
        sizes = {at: abs(numbers[row, at]) * scale[at] for at in places}
        largest = max(sizes.values(), default=0.0)
        for at, size in sizes.items():
            if size > THRESHOLD * largest:
                fill = (len(places) - 1) * (len(columns[at]) - 1)
                best = min(best or (fill, -size / largest, row, at), (fill, -size / largest, row, at))
    if best is None:
        raise NotCompilable
    return best[2], best[3]
