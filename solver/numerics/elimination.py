"""Gaussian elimination in whatever arithmetic the numbers bring along: floats, fractions, many digits."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


def eliminate(matrix: Sequence[Sequence[Any]], rhs: Sequence[Any]) -> list[Any] | None:
    """The solution x (n,) of A x = b with partial pivoting; None where a pivot is exactly 0."""
    rows = [[*row, b] for row, b in zip(matrix, rhs, strict=True)]
    n = len(rows)
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(rows[i][k]))
        if not rows[pivot][k]:
            return None
        rows[k], rows[pivot] = rows[pivot], rows[k]
        for i in range(k + 1, n):
            if rows[i][k]:
                factor = rows[i][k] / rows[k][k]
                rows[i] = [a - factor * b for a, b in zip(rows[i], rows[k], strict=True)]
    found: list[Any] = []
    for k in reversed(range(n)):
        known = sum(a * x for a, x in zip(rows[k][k + 1 : n], reversed(found), strict=True))
        found.append((rows[k][n] - known) / rows[k][k])
    return found[::-1]
