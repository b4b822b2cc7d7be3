"""Linear systems in numbers of any precision: elimination with equilibrated rows and row pivots."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


def solve_extended(matrix: Sequence[Sequence[Any]], rhs: Sequence[Any], tiny: Any) -> list[Any] | None:
    """x with A x = b for A (n, n) and b (n,); None where a pivot is below ``tiny`` beside its scaled row."""
    n = len(rhs)
    rows = []
    for line, b in zip(matrix, rhs, strict=True):
        size = max(abs(a) for a in line)
        if size == 0:
            return None
        rows.append([*(a / size for a in line), b / size])
    columns = [max(abs(row[j]) for row in rows) for j in range(n)]
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(rows[i][k]))
        if abs(rows[pivot][k]) <= tiny * columns[k]:
            return None
        rows[k], rows[pivot] = rows[pivot], rows[k]
        top = rows[k]
        for i in range(k + 1, n):
            row = rows[i]
            if row[k]:
                factor = row[k] / top[k]
                rows[i] = [
                    *row[: k + 1],
                    *(a - factor * p for a, p in zip(row[k + 1 :], top[k + 1 :], strict=True)),
                ]
    x: list[Any] = [0] * n
    for i in reversed(range(n)):
        rest = rows[i][n] - sum(rows[i][j] * x[j] for j in range(i + 1, n))
        x[i] = rest / rows[i][i]
    return x
