"""Linear systems A x = b: exact for small ones, refined floating point for large ones.

A float is a rational number, so a small system is decided, not estimated: its rank, what it leaves free,
and which rows contradict one another are facts about the numbers given.

Larger ones are factored once and refined with residuals in extended precision (N. J. Higham, *Accuracy and
Stability of Numerical Algorithms*, 2nd ed., 2002, chapter 12): the answer is right to working precision
unless the condition number nears 1/eps.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from math import inf, lcm
from typing import Any, NamedTuple

from solver.numerics.linear_algebra import factorise
from solver.numerics.tolerances import CONSISTENT, Outcome


class LinearOutcome(NamedTuple):
    """The facts about A x = b with A of m rows and n columns.

    ``solution``: correctly rounded where exact; entry j is None where unknown j is not determined. None
    as a whole where the rows contradict one another.
    ``nullspace``: a basis, each vector (n,); unknown j is free if any vector has a nonzero j-th entry.
    ``conflict``: a smallest-by-inclusion set of rows whose combination reads 0 = miss with miss ≠ 0;
    ``multipliers`` are the factors of those rows, ``miss`` their combined right-hand side.
    ``condition``: of the row-scaled matrix in the 1-norm, None where decided exactly.
    """

    outcome: Outcome
    rank: int
    solution: tuple[float | None, ...] | None
    nullspace: tuple[tuple[float, ...], ...] = ()
    conflict: tuple[int, ...] = ()
    multipliers: tuple[float, ...] = ()
    miss: float = 0.0
    exact: bool = True
    condition: float | None = None

    @property
    def free(self) -> tuple[int, ...]:
        """Indices of the unknowns that the rows leave free."""
        size = len(self.nullspace[0]) if self.nullspace else 0
        return tuple(j for j in range(size) if any(vector[j] for vector in self.nullspace))


EXACT_LIMIT = 30


def solve_linear(
    matrix: Sequence[Sequence[float | Fraction]],
    rhs: Sequence[float | Fraction],
) -> LinearOutcome:
    """Solve A x = b for m × n rows of finite floats or fractions.

    Up to 30 rows and columns by fractions; beyond by LU with iterative refinement, where a matrix that
    is singular to rounding gives ``SINGULAR_JACOBIAN`` with its numerical rank.
    """
    n = len(matrix[0]) if matrix else 0
    if max(n, len(matrix)) <= EXACT_LIMIT:
        return _Elimination(matrix, rhs, n).outcome()
    return solve_large(matrix, rhs)


def echelon(matrix: Sequence[Sequence[Fraction]], rhs: Sequence[Fraction]) -> Iterator[list[int]]:
    """Rows (n + 1,) that follow from those of A x = b, exact multiples: in reduced echelon form."""
    found = _Elimination(matrix, rhs, len(matrix[0]))
    return (row[: found.n + 1] for row in found.rows)


class _Elimination:
    """Fraction-free Gauss–Jordan elimination that remembers how each row was combined.

    E. H. Bareiss, "Sylvester's identity and multistep integer-preserving Gaussian elimination", Math.
    Comp. 22 (1968): with rows of integers every division is exact, and no common divisor is ever sought.
    A row is the ``n`` coefficients, the right-hand side, and the shares of the original rows in it.
    """

    def __init__(
        self, matrix: Sequence[Sequence[float | Fraction]], rhs: Sequence[float | Fraction], columns: int
    ) -> None:
        self.n = columns
        self.rows = [
            _integers(row, b, i, len(matrix)) for i, (row, b) in enumerate(zip(matrix, rhs, strict=True))
        ]
        self.pivots: list[tuple[int, int]] = []
        self.last = 1
        for column in range(self.n):
            self._pivot(column)

    def _pivot(self, column: int) -> None:
        used = {row for row, _ in self.pivots}
        chosen = next((i for i, row in enumerate(self.rows) if i not in used and row[column]), None)
        if chosen is None:
            return
        self.pivots.append((chosen, column))
        source, last = self.rows[chosen], self.last
        pivot = self.last = source[column]
        for i, row in enumerate(self.rows):
            if i == chosen:
                continue
            if factor := row[column]:
                self.rows[i] = [(pivot * a - factor * p) // last for a, p in zip(row, source, strict=True)]
            elif pivot != last:
                self.rows[i] = [pivot * a // last for a in row]

    def outcome(self) -> LinearOutcome:
        rank, nullspace, contradicting = len(self.pivots), self._nullspace(), self._contradicting()
        if contradicting:
            row = min(contradicting, key=lambda i: (len(self._origins(i)), i))
            origins, shares = self._origins(row), self._shares(row)
            multipliers = tuple(_quotient(shares[i], shares[row]) for i in origins)
            miss = _quotient(self.rows[row][self.n], shares[row])
            return LinearOutcome(Outcome.NO_ROOT, rank, None, nullspace, origins, multipliers, miss)
        outcome = Outcome.SINGULAR_JACOBIAN if nullspace else Outcome.CONVERGED
        return LinearOutcome(outcome, rank, self._solution(), nullspace)

    def _contradicting(self) -> list[int]:
        """Rows that elimination turned into 0 = something else."""
        used = {row for row, _ in self.pivots}
        return [i for i, row in enumerate(self.rows) if row[self.n] and i not in used]

    def _shares(self, row: int) -> list[int]:
        """How much of each original row is in this one. (A row without a pivot is in itself alone.)"""
        return self.rows[row][self.n + 1 :]

    def _origins(self, row: int) -> tuple[int, ...]:
        """The original rows that make up this one. A dependent row is a combination of the independent
        pivot rows in one way only, so that no part of this set is dependent by itself."""
        return tuple(i for i, share in enumerate(self._shares(row)) if share)

    def _solution(self) -> tuple[float | None, ...]:
        values: list[float | None] = [None] * self.n
        for i, column in self.pivots:
            row = self.rows[i]
            if sum(1 for a in row[: self.n] if a) == 1:
                values[column] = _quotient(row[self.n], row[column])
        return tuple(values)

    def _nullspace(self) -> tuple[tuple[float, ...], ...]:
        bound = {column for _, column in self.pivots}
        basis = []
        for free in (j for j in range(self.n) if j not in bound):
            vector = [0.0] * self.n
            vector[free] = 1.0
            for row, column in self.pivots:
                vector[column] = _quotient(-self.rows[row][free], self.rows[row][column])
            basis.append(tuple(vector))
        return tuple(basis)


def _integers(row: Sequence[float | Fraction], rhs: float | Fraction, place: int, count: int) -> list[int]:
    """A row times the common denominator of its numbers, with the share of itself among ``count`` rows."""
    ratios = [number.as_integer_ratio() for number in (*row, rhs)]
    common = lcm(*(denominator for _, denominator in ratios))
    shares = [0] * count
    shares[place] = common
    return [numerator * (common // denominator) for numerator, denominator in ratios] + shares


def _quotient(numerator: int, denominator: int) -> float:
    """The nearest float; infinite where it is out of range."""
    try:
        return numerator / denominator
    except OverflowError:
        return inf if (numerator > 0) == (denominator > 0) else -inf


SPARSE_BELOW = 0.1
REFINEMENTS = 5


def solve_large(matrix: Any, rhs: Any) -> LinearOutcome:
    """Solve A x = b for m × n rows of floats (or a scipy sparse matrix) by LU, or by SVD where singular."""
    import numpy as np

    with np.errstate(all="ignore"):  # what overflows is not consistent
        return _solved(matrix, rhs)


def _solved(matrix: Any, rhs: Any) -> LinearOutcome:
    import numpy as np

    a = _as_array(matrix)
    b = np.asarray(rhs, dtype=float)
    n = a.shape[1]
    factor = factorise(a, [1.0] * n)
    x, residual = _refined(a, b, factor)
    if not _is_consistent(a, x, b, residual):
        contradiction = _contradiction(a, b, factor.rank)
        if contradiction is not None:
            return contradiction
    condition = factor.condition()
    if factor.rank == n:
        return LinearOutcome(Outcome.CONVERGED, n, tuple(map(float, x)), exact=False, condition=condition)
    return _underdetermined(a, x, factor.rank, condition)


def _as_array(matrix: Any) -> Any:
    """Sparse where few entries differ from zero, else a dense array."""
    import numpy as np
    from scipy.sparse import csr_array, issparse

    if issparse(matrix):
        return csr_array(matrix)
    dense = np.asarray(matrix, dtype=float)
    filled = np.count_nonzero(dense) / max(1, dense.size)
    return csr_array(dense) if filled < SPARSE_BELOW and dense.shape[0] == dense.shape[1] else dense


def _refined(a: Any, b: Any, factor: Any) -> tuple[Any, Any]:
    """x and b - A x, refined until the correction no longer halves."""
    import numpy as np

    x = np.asarray(factor.solve(b))
    previous = np.inf
    for _ in range(REFINEMENTS):
        correction = np.asarray(factor.solve(_residual(a, x, b)))
        size = float(np.abs(correction).max(initial=0.0))
        if not size < 0.5 * previous:
            break
        x, previous = x + correction, size
    return x, _residual(a, x, b)


def _residual(a: Any, x: Any, b: Any) -> Any:
    """b - A x with products and sums in extended precision."""
    import numpy as np

    if hasattr(a, "tocoo"):
        entries = a.tocoo()
        row, column = entries.coords
        total = b.astype(np.longdouble)
        np.subtract.at(total, row, entries.data.astype(np.longdouble) * x[column])
        return total.astype(float)
    return (b.astype(np.longdouble) - a.astype(np.longdouble) @ x.astype(np.longdouble)).astype(float)


def _is_consistent(a: Any, x: Any, b: Any, residual: Any) -> bool:
    import numpy as np

    sizes = abs(a) @ np.abs(x) + np.abs(b)
    return bool((np.abs(residual) <= CONSISTENT * sizes).all())


def _svd(a: Any) -> tuple[Any, Any]:
    import numpy as np

    dense = a.toarray() if hasattr(a, "toarray") else a
    u, _, vt = np.linalg.svd(dense)
    return u, vt


def _contradiction(a: Any, b: Any, rank: int) -> LinearOutcome | None:
    """Rows in the left null direction along which b sticks out most. Small, but not proven smallest.

    None where b sticks out by no more than rounding, as it always does where the rows are independent: what
    residual there is comes of elimination.
    """
    import numpy as np

    if rank == len(b):
        return None
    dense = a.toarray() if hasattr(a, "toarray") else a
    rows = np.abs(dense).max(axis=1, initial=0.0)
    rows = np.where(rows > 0.0, rows, 1.0)
    left = _svd(dense / rows[:, None])[0][:, rank:]
    out = left.T @ (b / rows)
    if not (np.abs(out) > CONSISTENT * (np.abs(left).T @ np.abs(b / rows))).any():
        return None
    direction = (left @ out) / rows
    direction = direction / np.abs(direction).max()
    named = np.flatnonzero(np.abs(direction) * rows > 1e-8 * np.abs(direction * rows).max())
    return LinearOutcome(
        Outcome.NO_ROOT,
        rank,
        None,
        (),
        tuple(map(int, named)),
        tuple(map(float, direction[named])),
        float(direction @ b),
        exact=False,
    )


def _underdetermined(a: Any, x: Any, rank: int, condition: float) -> LinearOutcome:
    """Unknowns without a part in the null space keep their value, the others are None."""
    import numpy as np

    _, vt = _svd(a)
    basis = np.where(np.abs(vt[rank:]) > 1e-10, vt[rank:], 0.0)
    free = [bool(part.any()) for part in basis.T]
    return LinearOutcome(
        Outcome.SINGULAR_JACOBIAN,
        rank,
        tuple(None if f else float(v) for f, v in zip(free, x, strict=True)),
        tuple(tuple(map(float, vector)) for vector in basis),
        exact=False,
        condition=condition,
    )
