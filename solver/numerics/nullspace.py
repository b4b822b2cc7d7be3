"""The direction in which a singular system can move."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def null_direction(matrix: Sequence[Sequence[float]], x: Sequence[float]) -> tuple[float, ...]:
    """Unit vector (n,) along which A x changes least, in units scaled by |x| (1 where x is 0).

    The right singular vector of the smallest singular value of A with rows equilibrated and
    columns scaled (Golub & Van Loan, *Matrix Computations*, section 2.4).
    """
    scale = np.array([abs(v) or 1.0 for v in x])
    with np.errstate(all="ignore"):  # what overflows is refused
        a = np.asarray(matrix, dtype=float) * scale
        rows = np.abs(a).max(axis=1)
        a = a / np.where(rows > 0, rows, 1.0)[:, None]
    if not np.isfinite(a).all():
        return tuple(1.0 for _ in x)
    direction = np.linalg.svd(a)[2][-1] * scale
    return tuple(float(v) for v in direction / np.abs(direction).max())
