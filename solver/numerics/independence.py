"""Which rows of a matrix are independent, and which unknowns the rest leaves free."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import qr

RANK = 1e-11
"""Share of the largest pivot (rows and columns equilibrated) below which a row adds nothing."""

MOVES = 1e-8
"""Share of a null vector above which an unknown takes part in it."""


class Independence(NamedTuple):
    """``rows`` (r,) are independent rows, r the rank; ``free`` the columns that no row determines.

    With the columns ``held`` (n - r,) taken away, the independent rows are a regular square matrix.
    """

    rows: tuple[int, ...]
    free: tuple[int, ...]
    held: tuple[int, ...]


def independent_rows(matrix: Any, scale: Any) -> Independence:
    """As many independent rows of an m × n matrix as there are, and the columns left free.

    QR with column pivoting of the transpose (P. Businger & G. H. Golub, "Linear least squares solutions
    by Householder transformations", 1965). ``scale`` (n,) are the magnitudes of the unknowns.
    """
    a = np.asarray(matrix, dtype=float) * np.asarray(scale, dtype=float)
    sizes = np.abs(a).max(axis=1, initial=0.0)
    a = a / np.where(sizes > 0, sizes, 1.0)[:, None]
    columns = np.abs(a).max(axis=0, initial=0.0)
    a = a / np.where(columns > 0, columns, 1.0)
    if not a.size:
        columns_left = tuple(range(a.shape[1]))
        return Independence((), columns_left, columns_left)
    r, order = qr(a.T, mode="r", pivoting=True)
    pivots = np.abs(np.diagonal(r))
    rank = int((pivots > RANK * pivots[0]).sum()) if pivots.size and pivots[0] else 0
    rows = tuple(sorted(int(i) for i in order[:rank]))
    if rank == a.shape[1]:
        return Independence(rows, (), ())
    null = np.linalg.svd(a)[2][rank:]
    free = tuple(int(j) for j in np.flatnonzero(np.abs(null).max(axis=0) > MOVES))
    held = qr(a[list(rows)], mode="r", pivoting=True)[1][rank:]
    return Independence(rows, free, tuple(sorted(int(j) for j in held)))
