"""Linear systems A x = b: exact for small ones, refined floating point for large ones.

A float is a rational number, so a small system is decided, not estimated: its rank, what it leaves free,
and which rows contradict one another are facts about the numbers given.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import inf, lcm

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
