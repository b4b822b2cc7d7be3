"""The directions in which a singular system can move."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from solver.numerics.small_svd import LARGEST, Decomposition, decomposed

if TYPE_CHECKING:
    from collections.abc import Sequence

ORDINARY = 1e-100, 1e100
"""The size of a matrix of which no square overflows or is lost."""


def null_direction(matrix: Sequence[Sequence[float]], x: Sequence[float]) -> tuple[float, ...]:
    """Unit vector (n,) along which A x changes least, in units scaled by |x| (1 where x is 0).

    The right singular vector of the smallest singular value of A with rows equilibrated and
    columns scaled (Golub & Van Loan, *Matrix Computations*, section 2.4).
    """
    scale = [abs(v) or 1.0 for v in x]
    scaled = [[float(a) * s for a, s in zip(row, scale, strict=True)] for row in matrix]
    sizes = [max(map(abs, row)) or 1.0 for row in scaled]
    if not all(math.isfinite(a) for row in scaled for a in row):  # what overflows is refused
        return tuple(1.0 for _ in x)
    equilibrated = [[a / size for a in row] for row, size in zip(scaled, sizes, strict=True)]
    _, vector = last_singular(equilibrated)
    direction = [v * s for v, s in zip(vector, scale, strict=True)]
    longest = max(map(abs, direction))
    return tuple(v / longest for v in direction)


def last_singular(matrix: Sequence[Sequence[float]]) -> tuple[list[float], list[float]]:
    """The singular values (n,) of a matrix (n, n) of finite numbers, descending, and the right singular
    vector (n,) of the last one."""
    if len(matrix) <= LARGEST:
        found = decomposed(matrix)
        return found.values, found.right[-1]
    import numpy as np

    _, values, right = np.linalg.svd(np.array(matrix))
    return values.tolist(), right[-1].tolist()


def decompose(matrix: Sequence[Sequence[float]]) -> Decomposition:
    """Of finite numbers (m, n): where m < n, the last n - m of the n values are 0 to rounding."""
    largest = max(abs(a) for row in matrix for a in row)
    ordinary = not largest or ORDINARY[0] < largest < ORDINARY[1]
    if ordinary and max(len(matrix), len(matrix[0])) <= LARGEST:
        return decomposed(matrix)
    import numpy as np

    array = np.array(matrix)
    _, values, right = np.linalg.svd(array)
    short = [0.0] * (len(right) - len(values))
    return Decomposition([*values.tolist(), *short], right.tolist(), (right @ array.T).tolist())
