"""The inverse of a small matrix in plain Python: a block of a few unknowns needs no numpy."""

from __future__ import annotations

from collections.abc import Sequence

LARGEST = 16
"""Order up to which some hundreds of them take no longer than to import numpy."""


def inverse(matrix: Sequence[Sequence[float]]) -> list[list[float]] | None:
    """The inverse of a square matrix (n, n) by Gauss and Jordan with partial pivoting.

    None for a matrix that is singular to working precision at some pivot.
    """
    n = len(matrix)
    rows = [[*map(float, row), *(float(i == j) for j in range(n))] for i, row in enumerate(matrix)]
    for k in range(n):
        best = max(range(k, n), key=lambda i: abs(rows[i][k]))
        rows[k], rows[best] = rows[best], rows[k]
        pivot = rows[k][k]
        if pivot == 0.0:
            return None
        rows[k] = [entry / pivot for entry in rows[k]]
        for i in range(n):
            factor = rows[i][k]
            if i != k and factor != 0.0:
                rows[i] = [entry - factor * top for entry, top in zip(rows[i], rows[k], strict=True)]
    return [row[n:] for row in rows]
