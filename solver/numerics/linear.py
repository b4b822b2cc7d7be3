"""Linear systems A x = b: exact for small ones, refined floating point for large ones.

A float is a rational number, so a small system is decided, not estimated: its rank, what it leaves free,
and which rows contradict one another are facts about the numbers given.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from solver.numerics.linear_large import solve_large
from solver.numerics.linear_outcome import LinearOutcome
from solver.numerics.outcome import Outcome

EXACT_LIMIT = 30


def solve_linear(
    matrix: Sequence[Sequence[float | Fraction]],
    rhs: Sequence[float | Fraction],
    columns: int | None = None,
) -> LinearOutcome:
    """Solve A x = b for m × n rows of finite floats or fractions. ``columns`` is n where there are no rows.

    Up to 30 rows and columns by fractions; beyond by LU with iterative refinement, where a matrix that
    is singular to rounding gives ``SINGULAR_JACOBIAN`` with its numerical rank.
    """
    n = columns if columns is not None else len(matrix[0]) if matrix else 0
    if max(n, len(matrix)) <= EXACT_LIMIT:
        return _Elimination(matrix, rhs, n).outcome()
    return solve_large(matrix, rhs)


class _Elimination:
    """Gauss–Jordan elimination over the rationals that remembers how each row was combined."""

    def __init__(
        self, matrix: Sequence[Sequence[float | Fraction]], rhs: Sequence[float | Fraction], columns: int
    ) -> None:
        self.n = columns
        self.rows = [[Fraction(a) for a in row] for row in matrix]
        self.rhs = [Fraction(b) for b in rhs]
        self.made_of = [{i: Fraction(1)} for i in range(len(self.rows))]
        self.pivots: list[tuple[int, int]] = []
        for column in range(self.n):
            self._pivot(column)

    def _pivot(self, column: int) -> None:
        used = {row for row, _ in self.pivots}
        pivot = next((i for i, row in enumerate(self.rows) if i not in used and row[column]), None)
        if pivot is None:
            return
        self.pivots.append((pivot, column))
        for i, row in enumerate(self.rows):
            if i != pivot and row[column]:
                self._subtract(i, pivot, row[column] / self.rows[pivot][column])

    def _subtract(self, i: int, pivot: int, factor: Fraction) -> None:
        self.rows[i] = [a - factor * p for a, p in zip(self.rows[i], self.rows[pivot], strict=True)]
        self.rhs[i] -= factor * self.rhs[pivot]
        for origin, share in self.made_of[pivot].items():
            self.made_of[i][origin] = self.made_of[i].get(origin, Fraction(0)) - factor * share

    def outcome(self) -> LinearOutcome:
        rank, nullspace, contradicting = len(self.pivots), self._nullspace(), self._contradicting()
        if contradicting:
            row = min(contradicting, key=lambda i: (len(self._origins(i)), i))
            origins = self._origins(row)
            multipliers = tuple(_rounded(self.made_of[row][i]) for i in origins)
            miss = _rounded(self.rhs[row])
            return LinearOutcome(Outcome.NO_ROOT, rank, None, nullspace, origins, multipliers, miss)
        outcome = Outcome.SINGULAR_JACOBIAN if nullspace else Outcome.CONVERGED
        return LinearOutcome(outcome, rank, self._solution(), nullspace)

    def _contradicting(self) -> list[int]:
        """Rows that elimination turned into 0 = something else."""
        used = {row for row, _ in self.pivots}
        return [i for i, b in enumerate(self.rhs) if b and i not in used]

    def _origins(self, row: int) -> tuple[int, ...]:
        """The original rows that make up this one. A dependent row is a combination of the independent
        pivot rows in one way only, so that no part of this set is dependent by itself."""
        return tuple(sorted(i for i, share in self.made_of[row].items() if share))

    def _solution(self) -> tuple[float | None, ...]:
        values: list[float | None] = [None] * self.n
        for row, column in self.pivots:
            if sum(1 for a in self.rows[row] if a) == 1:
                values[column] = _rounded(self.rhs[row] / self.rows[row][column])
        return tuple(values)

    def _nullspace(self) -> tuple[tuple[float, ...], ...]:
        bound = {column for _, column in self.pivots}
        basis = []
        for free in (j for j in range(self.n) if j not in bound):
            vector = [0.0] * self.n
            vector[free] = 1.0
            for row, column in self.pivots:
                vector[column] = _rounded(-self.rows[row][free] / self.rows[row][column])
            basis.append(tuple(vector))
        return tuple(basis)


def _rounded(value: Fraction) -> float:
    """The nearest float; infinite where it is out of range."""
    try:
        return float(value)
    except OverflowError:
        return float("inf") if value > 0 else float("-inf")
