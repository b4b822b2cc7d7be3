"""Sparse linear least squares, of the solutions the one of least norm, as near as some iterations come."""

from __future__ import annotations

import numpy as np
import scipy

from solver.numerics.batch_newton import Array
from solver.numerics.sparse_newton import Triplets

ITERATIONS = 60


def sparse_least_squares(entries: Triplets, shape: tuple[int, int], rhs: Array) -> Array:
    """An x (n,) for which |A x - b| is nearly least, by LSMR (D. Fong & M. Saunders, 2011)."""
    data, rows, columns = entries
    matrix = scipy.sparse.csr_array((data, (rows, columns)), shape=shape)
    return np.asarray(scipy.sparse.linalg.lsmr(matrix, rhs, maxiter=ITERATIONS)[0])
