"""Gaussian elimination in whatever arithmetic the numbers bring along: floats, fractions, many digits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

from solver.numerics.linear_algebra import Factor, factorise
from solver.numerics.tolerances import ENOUGH

Number: TypeAlias = Any
"""A number that adds, multiplies, divides and compares, of whatever precision (mpmath, Fraction, float)."""

Row: TypeAlias = Mapping[int, Number]
"""The entries of one row that are not 0, by column."""


class Singular(ArithmeticError):
    """The matrix has no inverse, or none to the digits of its numbers."""


def eliminate(
    matrix: Sequence[Sequence[Number]], rhs: Sequence[Number], tiny: Number = 0
) -> list[Number] | None:
    """x (n,) with A x = b for A (n, n) and b (n,); None where a pivot is no more than ``tiny`` beside the
    entries of its column, rows brought to unit size."""
    try:
        return eliminate_rows([dict(enumerate(row)) for row in matrix], [rhs], tiny)[0]
    except Singular:
        return None


def eliminate_rows(
    rows: Sequence[Row], columns: Sequence[Sequence[Number]], tiny: Number = 0
) -> list[list[Number]]:
    """X with A X = B, with partial pivoting on rows of unit size, zeros left out: the columns of X.

    ``rows`` (n,) of A, ``columns`` of B (each (n,)). Raises Singular where a pivot is no more than ``tiny``
    beside the entries of its column.
    """
    n = len(rows)
    right = range(n, n + len(columns))
    left = [_equilibrated(row, right, [column[i] for column in columns]) for i, row in enumerate(rows)]
    sizes = [max((abs(row[j]) for row in left if j in row), default=0) for j in range(n)] if tiny else []
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(left[i].get(k, 0)))
        left[k], left[pivot] = left[pivot], left[k]
        if not abs(left[k].get(k, 0)) > (tiny * sizes[k] if tiny else 0):  # nor where either is no number
            raise Singular("a pivot vanishes")
        for i in range(k + 1, n):
            if left[i].get(k, 0):
                _subtract(left[i], left[k], k)
    for k in reversed(range(n)):
        for place in right:
            known = sum((left[k][j] * left[j][place] for j in left[k] if k < j < n), left[k][k] * 0)
            left[k][place] = (left[k].get(place, 0) - known) / left[k][k]
    return [[left[k][place] for k in range(n)] for place in right]


def _equilibrated(row: Row, right: Sequence[int], beside: Sequence[Number]) -> dict[int, Number]:
    """A row and its right-hand sides over its largest entry."""
    size = max((abs(entry) for entry in row.values()), default=0)
    if not size:
        raise Singular("a row is 0")
    whole = {**row, **dict(zip(right, beside, strict=True))}
    return {j: entry / size for j, entry in whole.items() if entry}


def _subtract(row: dict[int, Number], pivot: Mapping[int, Number], k: int) -> None:
    factor = row.pop(k) / pivot[k]
    for j, entry in pivot.items():
        if j > k:
            row[j] = row.get(j, 0) - factor * entry


ELIMINATED = 40
"""Unknowns up to which elimination takes less time than refinement."""

ROUNDS = 60


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
