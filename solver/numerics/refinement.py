"""Linear systems in numbers of more digits than floats have.

Small ones are eliminated in these numbers. Large ones are factored in floats, and the solution is
refined by residuals that are computed exactly enough (J. H. Wilkinson, *Rounding Errors in Algebraic
Processes*, 1963, chapter 3), which gains the same number of digits each time.
"""

from __future__ import annotations

from collections.abc import Sequence

from solver.numerics.elimination import Number, Row, Singular, eliminate_rows
from solver.numerics.linear_algebra import Factor, factorise

ELIMINATED = 40
"""Unknowns up to which elimination takes less time than refinement."""

ROUNDS = 60
ENOUGH = 1e-30


def solve_exactly(rows: Sequence[Row], columns: Sequence[Sequence[Number]]) -> list[list[Number]]:
    """X with A X = B: ``rows`` (n,) of A, ``columns`` of B (each (n,)); the columns of X.

    Raises Singular where A has no inverse to the digits of its numbers.
    """
    if len(rows) == 1:
        divisor = rows[0].get(0, 0)
        if not divisor:
            raise Singular("a pivot vanishes")
        return [[column[0] / divisor] for column in columns]
    return eliminate_rows(rows, columns) if len(rows) <= ELIMINATED else _refined(rows, columns)


def _refined(rows: Sequence[Row], columns: Sequence[Sequence[Number]]) -> list[list[Number]]:
    """Rows and columns are brought to unit size first: digits are counted in each unknown's own size."""
    n = len(rows)
    sizes = [max((abs(entry) for entry in row.values()), default=0) for row in rows]
    if not all(sizes):
        raise Singular("a row is 0")
    weights: list[Number] = [0] * n
    for row, size in zip(rows, sizes, strict=True):
        for j, entry in row.items():
            weights[j] = max(weights[j], abs(entry) / size)
    if not all(weights):
        raise Singular("a column is 0")
    scaled = [
        {j: entry / size / weights[j] for j, entry in row.items()}
        for row, size in zip(rows, sizes, strict=True)
    ]
    factor = factorise([[float(row.get(j, 0)) for j in range(n)] for row in scaled], [1.0] * n)
    if factor.rank < n:
        raise Singular("the matrix has lost rank to rounding")
    found = []
    for column in columns:
        target = [b / size for b, size in zip(column, sizes, strict=True)]
        solution = _one_refined(scaled, target, factor)
        found.append([x / weight for x, weight in zip(solution, weights, strict=True)])
    return found


def _one_refined(rows: Sequence[Row], target: Sequence[Number], factor: Factor) -> list[Number]:
    solution: list[Number] = [b * 0 for b in target]
    for _ in range(ROUNDS):
        residual = [
            b - sum(entry * solution[j] for j, entry in row.items())
            for row, b in zip(rows, target, strict=True)
        ]
        largest = max(map(abs, residual))
        if not largest:
            return solution
        correction = factor.solve([float(r / largest) for r in residual])  # scaled: nothing underflows
        solution = [x + c * largest for x, c in zip(solution, correction, strict=True)]
        if max(map(abs, correction)) * largest <= ENOUGH * max(map(abs, solution)):
            return solution
    raise Singular("refinement does not converge")
