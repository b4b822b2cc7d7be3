"""Matrices of floats, factored.

A factor holds the matrix with its columns in units of the unknowns and its rows of unit size, so
that neither the units of a sheet nor the size of a rule changes its rank. Overflow shows in its
result.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from itertools import repeat
from math import inf, isnan
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from solver.numerics.tolerances import EPS

LARGE = 16
"""Unknowns from which on LU is much faster than singular values, and worth loading
``scipy.linalg``."""
MOST_DENSE = 600
"""Unknowns of a sparse matrix up to which singular values are taken of a deficient one."""

PANEL = 1
"""Columns that SuperLU takes at once: networks have few that are alike."""

Array: TypeAlias = NDArray[np.float64]
Triplets: TypeAlias = tuple[Array, NDArray[np.intp], NDArray[np.intp]]
"""The entries of a sparse matrix, their rows and their columns; entries at one place are added."""


class Factor:
    """``rank`` < ``columns`` means that the matrix does not determine its unknowns.

    ``solved`` maps a right-hand side (m,) in units of the rows to unknowns (n,) in units of the
    weights.
    """

    def __init__(
        self,
        solved: Callable[[Any], Any],
        condition: Callable[[], float],
        rank: int,
        row_sizes: Any,
        weights: Any,
    ) -> None:
        self._solved, self.condition = solved, condition
        self.rank, self.columns = rank, len(weights)
        self._row_sizes, self._weights = row_sizes, weights

    def solution(self, rhs: Any) -> Any:
        """The solution (n,), of columns (m, k) all of them (n, k); of least squares and least
        scaled norm if there is none or many."""
        with np.errstate(all="ignore"):
            return (self._weights * self._solved((np.transpose(rhs) / self._row_sizes).T).T).T


class SparseFactor:
    """LU of a Jacobian (n, n) given by its entries, rows scaled to their largest entry.

    Raises ArithmeticError if an entry is not finite or the matrix is singular.
    """

    def __init__(self, entries: Triplets, n: int) -> None:
        import scipy.sparse.linalg  # small blocks do without

        data, rows, columns = entries
        if not np.isfinite(data).all():
            raise ArithmeticError("a slope is not finite")
        largest = np.zeros(n)
        np.maximum.at(largest, rows, np.abs(data))
        if not largest.all():
            raise ZeroDivisionError("a row is 0")
        self.rows, self.n = largest, n
        matrix = scipy.sparse.csc_array((data / largest[rows], (rows, columns)), shape=(n, n))
        try:
            self.lu: Any = scipy.sparse.linalg.splu(matrix, panel_size=PANEL)
        except RuntimeError as error:
            raise ZeroDivisionError("the matrix is singular") from error

    def solve(self, rhs: Array) -> Array:
        with np.errstate(over="ignore"):
            return np.asarray(self.lu.solve(rhs / self.rows))

    def spread(self, tolerance: Array, sizes: Array) -> float:
        """The largest of |J⁻¹|·t relative to the ``sizes``: a norm, estimated as by N. J. Higham &
        F. Tisseur (SIAM J. Matrix Anal. Appl. 21 (2000) 1185–1201), from below and rarely off by a
        factor of 3."""
        from scipy.sparse import linalg

        weight = tolerance / self.rows
        operator: Any = linalg.LinearOperator(
            (self.n, self.n),
            matvec=lambda v: weight * self.lu.solve(np.ravel(v) / sizes, "T"),
            rmatvec=lambda v: self.lu.solve(weight * np.ravel(v)) / sizes,
            dtype=float,
        )
        return float(linalg.onenormest(operator))


def sparse_matrix(numbers: Any, rows: Any, columns: Any, shape: tuple[int, int]) -> Any:
    """The sparse matrix of entries (k,); entries at one place are added."""
    # small blocks do without scipy, which takes as long to load as to solve them
    import scipy.sparse

    return scipy.sparse.csr_array((numbers, (rows, columns)), shape=shape)


def as_matrix(matrix: Any, columns: int) -> Any:
    """Rows as an array; a scipy sparse matrix unchanged."""
    return (
        matrix if hasattr(matrix, "dtype") else np.array(matrix, dtype=float).reshape(-1, columns)
    )


def factorise(matrix: Any, column_weights: Sequence[float] | Array) -> Factor:
    """Factor an m × n matrix given as rows, array, or scipy sparse matrix, with column weights
    (n,).

    By its inverse if it is large, square and regular, by LU if it is sparse as well; else by
    singular values, of which there are none if some number is not finite. A large sparse matrix
    that is singular is not factored: the rank given is a bound, solutions are nan.
    """
    weights = np.asarray(column_weights, dtype=float)
    with np.errstate(all="ignore"):
        if hasattr(matrix, "tocsc"):
            if (found := _sparse(matrix, weights)) is not None:
                return found
            large = matrix.shape[0] == matrix.shape[1] > MOST_DENSE
            return _singular(weights) if large else any_rank(matrix.toarray(), weights)
        scaled = as_matrix(matrix, n := len(weights)) * weights
        sizes = np.abs(scaled).sum(axis=1)
        if len(sizes) == n >= LARGE and sizes.min() > 0.0 and sizes.max() < np.inf:
            with suppress(np.linalg.LinAlgError):
                inverse = np.linalg.inv(scaled / sizes[:, None])
                condition = float(np.abs(inverse).sum(axis=1).max())
                if 2 * n * EPS * condition < 1.0:
                    return Factor(lambda b: inverse @ b, lambda: condition, n, sizes, weights)
    return any_rank(matrix, weights)


def _sparse(matrix: Any, weights: Array) -> Factor | None:
    entries = (matrix * weights).tocoo()
    try:
        factor = SparseFactor((entries.data, entries.row, entries.col), n := len(weights))
    except (ArithmeticError, ValueError):
        return None
    if matrix.shape[0] != n or not np.abs(factor.lu.U.diagonal()).min() > 2 * n * EPS:
        return None
    one = np.ones(n)
    return Factor(factor.lu.solve, lambda: factor.spread(factor.rows, one), n, factor.rows, weights)


def _singular(weights: Any) -> Factor:
    ones = np.ones(len(weights))
    return Factor(lambda b: np.full_like(b, np.nan), lambda: inf, len(weights) - 1, ones, weights)


def any_rank(matrix: Any, column_weights: Any) -> Factor:
    """Factor an m × n matrix, given as rows or as an array, by its singular values."""
    weights = np.asarray(column_weights, dtype=float)
    with np.errstate(all="ignore"):
        scaled = as_matrix(matrix, len(weights)) * weights
        sizes = np.abs(scaled).sum(axis=1)
        if not np.isfinite(sizes).all():
            scaled, sizes = np.zeros_like(scaled), np.zeros_like(sizes)
        sizes = np.where(sizes > 0, sizes, 1.0)
    u, singular, vt = np.linalg.svd(scaled / sizes[:, None], full_matrices=False)
    rank = int((singular > 2 * max(scaled.shape) * EPS * singular[:1]).sum())
    deficient = rank < len(weights)
    return Factor(
        lambda b: vt[:rank].T @ ((u[:, :rank].T @ b).T / singular[:rank]).T,
        lambda: float("inf") if deficient else float(singular[0] / singular[-1]),
        rank,
        sizes,
        weights,
    )


def row_sizes(matrix: Any, column_weights: Any) -> Array:
    """Σ_j |A_ij| |w_j| for every row i."""
    with np.errstate(all="ignore"):  # an infinite size tells of what overflows
        sizes: Array = abs(as_matrix(matrix, len(column_weights))) @ np.abs(column_weights)
    return sizes


def equilibrated(matrix: Any, column_weights: Any) -> tuple[Array, Array]:
    """A matrix (m, n) in units of its columns, rows divided by their largest entries, and these
    (m,), 1 for a row of zeros. Raises OverflowError if a number is not finite."""
    with np.errstate(all="ignore"):
        scaled = as_matrix(matrix, len(column_weights)) * column_weights
        sizes = np.abs(scaled).max(axis=1, initial=0.0)
    if not np.isfinite(sizes).all():
        raise OverflowError("a number is not finite")
    sizes = np.where(sizes > 0.0, sizes, 1.0)
    return scaled / sizes[:, None], sizes


def null_direction(matrix: Any, x: Sequence[float]) -> tuple[float, ...]:
    """The direction (n,), its largest part ± 1, along which A x changes least in units scaled by
    |x|; all ones for a large sparse matrix.

    The right singular vector of the smallest singular value of A with rows equilibrated and
    columns scaled by |x|, 1 where that is 0 (Golub & Van Loan, *Matrix Computations*, section 2.4).
    """
    scale = np.array([abs(v) or 1.0 for v in x])
    if hasattr(matrix, "toarray"):
        if len(x) > MOST_DENSE:
            return (1.0,) * len(x)
        matrix = matrix.toarray()
    try:
        direction = np.linalg.svd(equilibrated(matrix, scale)[0])[2][-1] * scale
    except OverflowError:
        return (1.0,) * len(x)
    return tuple((direction / np.abs(direction).max()).tolist())


def are_alike(
    row: Iterable[Any], other: Iterable[Any], tolerance: float, sizes: Iterable[Any] = repeat(0.0)
) -> bool:
    """Whether values are the same: numbers, up to a share of the larger of each two, or of
    ``sizes``."""

    def near(a: Any, b: Any, size: Any) -> bool:
        if isinstance(a, str) or isinstance(b, str) or a == b:
            return bool(a == b)
        return abs(a - b) <= tolerance * max(abs(a), abs(b), size) or (isnan(a) and isnan(b))

    return all(map(near, row, other, sizes))


Map: TypeAlias = Callable[[Array], Array]
SparseMap: TypeAlias = tuple[Map, Callable[[Array], Triplets]]
"""A function and its Jacobian."""
