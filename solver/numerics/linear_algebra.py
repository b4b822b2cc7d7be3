"""Matrices of floats by LAPACK and SuperLU: one factorisation to solve with several times, singular vectors.

A factor holds the matrix with its columns in units of the unknowns and its rows of unit size, so that neither
the units of a sheet nor the size of a rule changes its rank. What overflows is seen by its result.

Gaussian elimination works in whatever arithmetic the numbers bring along: floats, fractions, many digits.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from solver.numerics.tolerances import EPS, INDEPENDENT, MOVES

LARGE = 16
"""Unknowns from which on LU is much faster than singular values, and worth loading ``scipy.linalg``."""

Array: TypeAlias = NDArray[np.float64]
Rows: TypeAlias = Sequence[Sequence[float]] | Array


class Factor:
    """``rank`` < ``columns`` tells that the matrix does not determine its unknowns.

    ``solved`` takes a right-hand side (m,) in units of the rows to unknowns (n,) in units of the weights.
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
        """The solution (n,); of least squares and least scaled norm where there is none or many."""
        with np.errstate(all="ignore"):
            return self._weights * self._solved(rhs / self._row_sizes)

    def solve(self, rhs: Sequence[float]) -> list[float]:
        """The same as a list."""
        solution: list[float] = self.solution(np.asarray(rhs)).tolist()
        return solution


def sparse_matrix(numbers: Any, rows: Any, columns: Any, shape: tuple[int, int]) -> Any:
    """The sparse matrix of entries (k,); those at one place are added."""
    import scipy.sparse  # small blocks do without scipy, which takes as long to load as to solve them

    return scipy.sparse.csr_array((numbers, (rows, columns)), shape=shape)


def as_matrix(matrix: Any, columns: int) -> Any:
    """Rows as an array; a scipy sparse matrix as it is."""
    return matrix if hasattr(matrix, "dtype") else np.array(matrix, dtype=float).reshape(-1, columns)


def factorise(matrix: Any, column_weights: Sequence[float]) -> Factor:
    """Factor an m × n matrix given as rows, array, or scipy sparse matrix, with column weights (n,).

    By LU where it is large, square and regular, else by singular values; 0 where some number is not finite.
    """
    weights = np.asarray(column_weights, dtype=float)
    with np.errstate(all="ignore"):
        if hasattr(matrix, "tocsc"):
            return _sparse(matrix, weights) or any_rank(matrix.toarray(), weights)
        scaled = as_matrix(matrix, len(weights)) * weights
        sizes = np.abs(scaled).sum(axis=1)
        if len(sizes) == len(weights) >= LARGE and sizes.min() > 0.0 and sizes.max() < np.inf:
            from scipy.linalg import lapack

            lu, pivots, _ = lapack.dgetrf(scaled / sizes[:, None])
            if _is_regular(lu.diagonal()):
                return Factor(
                    lambda b: lapack.dgetrs(lu, pivots, b)[0],
                    lambda: 1.0 / float(lapack.dgecon(lu, 1.0, norm="I")[0]),
                    len(weights),
                    sizes,
                    weights,
                )
    return any_rank(matrix, weights)


def _is_regular(pivots: Any) -> bool:
    """Rows being of unit size, pivots come of more than rounding."""
    return bool(np.abs(pivots).min() > 2 * len(pivots) * EPS)


def _sparse(matrix: Any, weights: Any) -> Factor | None:
    import scipy.sparse.linalg

    sizes = row_sizes(matrix, weights)
    if not sizes.all() or matrix.shape[0] != matrix.shape[1]:
        return None
    try:
        scaled = scipy.sparse.diags_array(1 / sizes) @ matrix @ scipy.sparse.diags_array(weights)
        lu = scipy.sparse.linalg.splu(scaled.tocsc())
    except RuntimeError:  # "Factor is exactly singular"
        return None
    if not _is_regular(lu.U.diagonal()):
        return None
    alternating = np.where(np.arange(len(weights)) % 2, -1.0, 1.0)

    def condition() -> float:
        """A lower bound from two solves: |A⁻¹ b| in the infinity norm, A having rows of unit 1-norm."""
        return max(float(np.abs(lu.solve(b)).max()) for b in (np.ones(len(weights)), alternating))

    return Factor(lu.solve, condition, len(weights), sizes, weights)


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
        lambda b: vt[:rank].T @ (u[:, :rank].T @ b / singular[:rank]),
        lambda: float("inf") if deficient else float(singular[0] / singular[-1]),
        rank,
        sizes,
        weights,
    )


def row_sizes(matrix: Any, column_weights: Any) -> Array:
    """Σ_j |A_ij| w_j for every row i; w may hold signed values, of which the absolute ones count."""
    with np.errstate(all="ignore"):  # an infinite size tells of what overflows
        sizes: Array = abs(as_matrix(matrix, len(column_weights))) @ np.abs(column_weights)
    return sizes


def inverse(matrix: Rows) -> Any:
    """The inverse (n, n) of a square matrix; None where LAPACK finds it singular."""
    try:
        with np.errstate(all="ignore"):
            return np.linalg.inv(np.asarray(matrix, dtype=float))
    except np.linalg.LinAlgError:
        return None


def null_direction(matrix: Rows, x: Sequence[float]) -> tuple[float, ...]:
    """The direction (n,), its largest part ± 1, along which A x changes least in units scaled by |x|.

    The right singular vector of the smallest singular value of A with rows equilibrated and
    columns scaled by |x|, 1 where that is 0 (Golub & Van Loan, *Matrix Computations*, section 2.4).
    """
    scale = np.array([abs(v) or 1.0 for v in x])
    with np.errstate(all="ignore"):
        scaled = as_matrix(matrix, len(x)) * scale
        sizes = np.abs(scaled).max(axis=1)
    if not np.isfinite(sizes).all():  # what overflows is refused
        return (1.0,) * len(scale)
    direction = np.linalg.svd(scaled / np.where(sizes > 0.0, sizes, 1.0)[:, None])[2][-1] * scale
    return tuple((direction / np.abs(direction).max()).tolist())


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
    from scipy.linalg import qr

    r, order = qr(a.T, mode="r", pivoting=True)
    pivots = np.abs(np.diagonal(r))
    rank = int((pivots > INDEPENDENT * pivots[0]).sum()) if pivots.size and pivots[0] else 0
    rows = tuple(sorted(int(i) for i in order[:rank]))
    if rank == a.shape[1]:
        return Independence(rows, (), ())
    null = np.linalg.svd(a)[2][rank:]
    free = tuple(int(j) for j in np.flatnonzero(np.abs(null).max(axis=0) > MOVES))
    held = qr(a[list(rows)], mode="r", pivoting=True)[1][rank:]
    return Independence(rows, free, tuple(sorted(int(j) for j in held)))


Number: TypeAlias = Any
"""A number that adds, multiplies, divides and compares, of whatever precision (mpmath, Fraction, float)."""

Entries: TypeAlias = Mapping[int, Number]
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
    rows: Sequence[Entries], columns: Sequence[Sequence[Number]], tiny: Number = 0
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


def _equilibrated(row: Entries, right: Sequence[int], beside: Sequence[Number]) -> dict[int, Number]:
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
