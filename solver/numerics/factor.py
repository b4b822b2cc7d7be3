"""Solve with one Jacobian several times: small ones in plain Python, large or deficient ones by scipy.

A factor holds the column-scaled, row-equilibrated matrix. Rank is decided on that scaled matrix, so
neither the units of the unknowns nor the size of a rule changes it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, Protocol

from solver.numerics.termination import EPS
from solver.numerics.tiny_factor import TINY, TinyFactor

SMALL = 16
"""Up to so many unknowns LAPACK, with the import of scipy, takes longer than plain Python over a solve: a
factorisation takes a tenth of a millisecond more, the import hundreds of them."""
Matrix = Sequence[Sequence[float]]


class Factor(Protocol):
    """``rank`` < ``columns`` tells that the matrix does not determine its unknowns."""

    rank: int
    columns: int

    def solve(self, rhs: Sequence[float]) -> list[float]:
        """The solution; of least squares and least scaled norm where there is none or many."""
        ...

    def condition(self) -> float:
        """Condition number of the scaled matrix (infinity norm, or 2-norm for large ones)."""
        ...


def as_matrix(matrix: Any, columns: int) -> Any:
    """Rows of a small matrix as they are; a large one as an array; a scipy sparse one as it is."""
    if hasattr(matrix, "dtype") or (columns <= SMALL and len(matrix) <= SMALL):
        return matrix
    import numpy as np

    return np.asarray(matrix, dtype=float).reshape(len(matrix), columns)


def sparse_matrix(entries: Iterable[tuple[int, int, float]], rows: int, columns: int) -> Any:
    """The sparse matrix of (row, column, number) entries."""
    from scipy.sparse import csr_array

    i, j, numbers = zip(*entries, strict=True)
    return csr_array((numbers, (i, j)), shape=(rows, columns))


def factorise(matrix: Any, column_weights: Sequence[float]) -> Factor:
    """Factor an m × n matrix given as rows, array, or scipy sparse matrix, with column weights (n,).

    Raises nothing for a singular matrix: the factor then gives minimum-norm least-squares solutions.
    """
    if hasattr(matrix, "tocsc"):
        return _sparse(matrix, column_weights)
    n = len(column_weights)
    if len(matrix) == n:
        regular = _small(_rows(matrix), column_weights) if n <= SMALL else _large(matrix, column_weights)
        if regular is not None:
            return regular
    return any_rank(matrix, column_weights)


def any_rank(matrix: Any, column_weights: Sequence[float]) -> Factor:
    """Factor an m × n matrix, given as rows or as an array, by its singular values."""
    if not hasattr(matrix, "dtype") and 0 < len(matrix) <= TINY and 0 < len(column_weights) <= TINY:
        return TinyFactor(matrix, column_weights)
    return DenseFactor(matrix, column_weights)


def _rows(matrix: Any) -> Matrix:
    """Rows of floats, of an array too: its own numbers are slower, and warn of what overflows."""
    rows: Matrix = matrix.tolist() if hasattr(matrix, "dtype") else matrix
    return rows


def row_sizes(matrix: Any, column_weights: Sequence[float]) -> list[float]:
    """Σ_j |A_ij| w_j for every row i; w may hold signed values, of which the absolute ones count."""
    if hasattr(matrix, "dtype"):
        import numpy as np

        with np.errstate(all="ignore"):  # an infinite size tells of what overflows
            sizes: list[float] = (abs(matrix) @ np.abs(np.asarray(column_weights, dtype=float))).tolist()
        return sizes
    return [sum(abs(a * w) for a, w in zip(row, column_weights, strict=True)) for row in matrix]


def row_products(matrix: Any, vector: Sequence[float]) -> list[float]:
    """A v, for rows, array, or scipy sparse matrix."""
    if hasattr(matrix, "dtype"):
        products: list[float] = (matrix @ vector).tolist()
        return products
    return [sum(a * v for a, v in zip(row, vector, strict=True)) for row in matrix]


def transposed_product(matrix: Any, vector: Sequence[float]) -> list[float]:
    """Aᵀ v (columns,), for rows, array, or scipy sparse matrix."""
    if hasattr(matrix, "dtype"):
        products: list[float] = (matrix.T @ vector).tolist()
        return products
    return [sum(a * v for a, v in zip(column, vector, strict=True)) for column in zip(*matrix, strict=True)]


class SmallFactor:
    """LU of a regular n × n matrix by Gaussian elimination with partial pivoting."""

    def __init__(
        self, lower: list[list[float]], order: list[int], row_scale: list[float], weight: Sequence[float]
    ) -> None:
        self._lu, self._order, self._row_scale, self._weight = lower, order, row_scale, weight
        self.rank = self.columns = len(order)

    def solve(self, rhs: Sequence[float]) -> list[float]:
        scaled = [rhs[i] / self._row_scale[i] for i in self._order]
        return [w * v for w, v in zip(self._weight, self._substitute(scaled), strict=True)]

    def _substitute(self, y: list[float]) -> list[float]:
        n, lu = self.columns, self._lu
        for i in range(n):
            y[i] -= sum(lu[i][j] * y[j] for j in range(i))
        for i in reversed(range(n)):
            y[i] = (y[i] - sum(lu[i][j] * y[j] for j in range(i + 1, n))) / lu[i][i]
        return y

    def condition(self) -> float:
        n = self.columns
        inverse = [self._substitute([float(i == j) for i in range(n)]) for j in range(n)]
        return max((sum(abs(column[i]) for column in inverse) for i in range(n)), default=1.0)


def _small(matrix: Matrix, weight: Sequence[float]) -> SmallFactor | None:
    """Equilibrated LU, or None where a pivot vanishes to rounding. Rows are scaled to unit 1-norm."""
    n = len(weight)
    row_scale = row_sizes(matrix, weight)
    if not all(0.0 < size < float("inf") for size in row_scale):
        return None
    lu = [
        [a * w / size for a, w in zip(row, weight, strict=True)]
        for row, size in zip(matrix, row_scale, strict=True)
    ]
    order = list(range(n))
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(lu[i][k]))
        if abs(lu[pivot][k]) <= 2 * n * EPS:
            return None
        lu[k], lu[pivot] = lu[pivot], lu[k]
        order[k], order[pivot] = order[pivot], order[k]
        for i in range(k + 1, n):
            _eliminate(lu[i], lu[k], k, n)
    return SmallFactor(lu, order, row_scale, weight)


def _eliminate(row: list[float], pivot_row: list[float], k: int, n: int) -> None:
    factor = row[k] = row[k] / pivot_row[k]
    if factor:
        row[k + 1 : n] = [a - factor * b for a, b in zip(row[k + 1 : n], pivot_row[k + 1 : n], strict=True)]


class DenseFactor:
    """Singular value decomposition of an m × n matrix of any rank: 0 where some number is not finite."""

    def __init__(self, matrix: Any, weight: Sequence[float]) -> None:
        import numpy as np

        self._weight = np.asarray(weight, dtype=float)
        with np.errstate(all="ignore"):  # overflow is seen to below
            scaled = np.asarray(matrix, dtype=float).reshape(len(matrix), len(weight)) * self._weight
            sizes = np.abs(scaled).sum(axis=1)
        if not np.isfinite(sizes).all():
            scaled, sizes = np.zeros_like(scaled), np.zeros_like(sizes)
        self._row_scale = np.where(sizes > 0, sizes, 1.0)
        self._u, self._s, self._vt = np.linalg.svd(scaled / self._row_scale[:, None], full_matrices=False)
        largest = self._s[0] if self._s.size else 0.0
        self.rank = int((self._s > 2 * max(scaled.shape) * EPS * largest).sum())
        self.columns = len(weight)

    def solve(self, rhs: Sequence[float]) -> list[float]:
        import numpy as np

        with np.errstate(all="ignore"):  # a step that overflows is refused by its length
            projected = self._u.T @ (np.asarray(rhs, dtype=float) / self._row_scale)
            kept = projected[: self.rank] / self._s[: self.rank]
            solution: list[float] = (self._weight * (self._vt[: self.rank].T @ kept)).tolist()
        return solution

    def condition(self) -> float:
        if self.rank < self.columns:
            return float("inf")
        return float(self._s[0] / self._s[-1])


class ArrayFactor:
    """Dense or sparse LU of a regular n × n matrix."""

    def __init__(self, solve: Callable[[Any], Any], row_scale: Any, weight: Any) -> None:
        self._solve, self._row_scale, self._weight = solve, row_scale, weight
        self.rank = self.columns = len(weight)

    def solve(self, rhs: Sequence[float]) -> list[float]:
        import numpy as np

        with np.errstate(all="ignore"):  # a step that overflows is refused by its length
            solved = self._weight * self._solve(np.asarray(rhs, dtype=float) / self._row_scale)
        solution: list[float] = solved.tolist()
        return solution

    def condition(self) -> float:
        """A lower bound from two solves: |A⁻¹ b| in the infinity norm, A having rows of unit 1-norm."""
        import numpy as np

        signs = np.where(np.arange(self.columns) % 2, -1.0, 1.0)
        return max(float(np.abs(self._solve(b)).max()) for b in (np.ones(self.columns), signs))


def _large(matrix: Any, weight: Sequence[float]) -> Factor | None:
    """Dense LU by LAPACK, or None where a pivot vanishes to rounding."""
    import numpy as np
    from scipy.linalg import get_lapack_funcs

    w = np.asarray(weight, dtype=float)
    scaled = np.asarray(matrix, dtype=float) * w
    sizes = np.abs(scaled).sum(axis=1)
    if not sizes.all() or not np.isfinite(sizes).all():
        return None
    getrf, getrs = get_lapack_funcs(("getrf", "getrs"), (scaled,))
    lu, pivots, _ = getrf(scaled / sizes[:, None])
    if np.abs(lu.diagonal()).min() <= 2 * len(w) * EPS:
        return None
    return ArrayFactor(lambda b: getrs(lu, pivots, b)[0], sizes, w)


def _sparse(matrix: Any, weight: Sequence[float]) -> Factor:
    """Sparse LU; a singular matrix falls back to the dense decomposition."""
    import numpy as np
    from scipy.sparse import diags_array
    from scipy.sparse.linalg import splu

    w = np.asarray(weight, dtype=float)
    sizes = np.asarray(row_sizes(matrix, weight))
    if sizes.all() and matrix.shape[0] == matrix.shape[1]:
        scaled = (diags_array(1 / sizes) @ matrix @ diags_array(w)).tocsc()
        try:
            lu = splu(scaled)
        except RuntimeError:  # "Factor is exactly singular"
            return DenseFactor(matrix.toarray(), weight)
        if np.abs(lu.U.diagonal()).min() > 2 * len(w) * EPS:
            return ArrayFactor(lu.solve, sizes, w)
    return DenseFactor(matrix.toarray(), weight)
