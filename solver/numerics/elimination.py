"""Gaussian elimination in whatever arithmetic the numbers bring along: floats, fractions, many digits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

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
