"""Facts about linear systems: independent rows, elimination in any arithmetic, and exact solutions.

A float is a rational number, so the facts about a small system are exact: its rank, its free
unknowns, and which rows contradict one another. Larger systems are factored once and refined with
residuals in extended precision (N. J. Higham, *Accuracy and Stability of Numerical Algorithms*, 2nd
ed., 2002, chapter 12): the answer is right to working precision unless the condition number nears
1/eps.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import inf, lcm
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from solver.numerics.linear_algebra import Array, equilibrated, factorise
from solver.numerics.tolerances import CONSISTENT, INDEPENDENT, MOVES, NULL_ENTRY


class Independence(NamedTuple):
    """``rows`` (r,) are independent rows, r the rank; ``free`` the columns that no row determines.

    With the columns ``held`` (n - r,) taken away, the independent rows are a regular square matrix.
    """

    rows: tuple[int, ...]
    free: tuple[int, ...]
    held: tuple[int, ...]


def independent_rows(matrix: Any, scale: Any, share: float = INDEPENDENT) -> Independence:
    """As many independent rows of an m × n matrix as there are, and the columns left free.

    QR with column pivoting of the transpose (P. Businger & G. H. Golub, "Linear least squares
    solutions by Householder transformations", 1965). ``scale`` (n,) are the magnitudes of the
    unknowns; ``share`` is that of the largest pivot below which a row adds nothing.
    """
    a, _ = equilibrated(np.asarray(matrix, dtype=float), scale)
    columns = np.abs(a).max(axis=0, initial=0.0)
    a = a / np.where(columns > 0, columns, 1.0)
    if not a.size:
        columns_left = tuple(range(a.shape[1]))
        return Independence((), columns_left, columns_left)
    from scipy.linalg import qr

    r, order = qr(a.T, mode="r", pivoting=True)
    pivots = np.abs(np.diagonal(r))
    rank = int((pivots > share * pivots[0]).sum()) if pivots.size and pivots[0] else 0
    rows = tuple(sorted(int(i) for i in order[:rank]))
    if rank == a.shape[1]:
        return Independence(rows, (), ())
    null = np.linalg.svd(a)[2][rank:]
    free = tuple(int(j) for j in np.flatnonzero(np.abs(null).max(axis=0) > MOVES))
    held = qr(a[list(rows)], mode="r", pivoting=True)[1][rank:]
    return Independence(rows, free, tuple(sorted(int(j) for j in held)))


Number: TypeAlias = Any
"""A number that adds, multiplies, divides and compares, of whatever precision (mpmath, Fraction,
float)."""

Entries: TypeAlias = Mapping[int, Number]
"""The entries of one row that are not 0, by column."""


class Singular(ArithmeticError):
    """The matrix has no inverse to the digits of its numbers."""


def eliminate(
    matrix: Sequence[Sequence[Number]], rhs: Sequence[Number], tiny: Number = 0
) -> list[Number] | None:
    """x (n,) with A x = b for A (n, n) and b (n,); None if a pivot is at most ``tiny`` relative to
    the entries of its column, rows scaled to unit size."""
    try:
        return eliminate_rows([dict(enumerate(row)) for row in matrix], [rhs], tiny)[0]
    except Singular:
        return None


def eliminate_rows(
    rows: Sequence[Entries], columns: Sequence[Sequence[Number]], tiny: Number = 0
) -> list[list[Number]]:
    """X with A X = B, with partial pivoting on rows of unit size, zeros left out: the columns of X.

    ``rows`` (n,) of A, ``columns`` of B (each (n,)). Raises Singular if a pivot is at most ``tiny``
    relative to the entries of its column.
    """
    n, right = len(rows), range(len(rows), len(rows) + len(columns))
    left: list[dict[int, Number]] = []
    for i, entries in enumerate(rows):
        size = max((abs(entry) for entry in entries.values()), default=0)
        if not size:
            raise Singular("a row is 0")
        whole = {
            **entries,
            **{place: column[i] for place, column in zip(right, columns, strict=True)},
        }
        left.append({j: entry / size for j, entry in whole.items() if entry})
    sizes = (
        [max((abs(row[j]) for row in left if j in row), default=0) for j in range(n)]
        if tiny
        else []
    )
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(left[i].get(k, 0)))
        left[k], left[pivot] = left[pivot], left[k]
        # nor where either is no number
        if not abs(left[k].get(k, 0)) > (tiny * sizes[k] if tiny else 0):
            raise Singular("a pivot vanishes")
        for row in left[k + 1 :]:
            if factor := row.pop(k, 0):
                factor /= left[k][k]
                for j, entry in left[k].items():
                    if j > k:
                        row[j] = row.get(j, 0) - factor * entry
    for k in reversed(range(n)):
        for place in right:
            known = sum((left[k][j] * left[j][place] for j in left[k] if k < j < n), left[k][k] * 0)
            left[k][place] = (left[k].get(place, 0) - known) / left[k][k]
    return [[left[k][place] for k in range(n)] for place in right]


# --- the facts about a linear system --------------------------------------------


class LinearOutcome(NamedTuple):
    """The facts about A x = b with A of m rows and n columns.

    ``solution``: correctly rounded if exact; entry j is None if unknown j is not determined. None
    as a whole if the rows contradict one another. ``nullspace``: a basis, each vector (n,); unknown
    j is free if any vector has a nonzero j-th entry. ``conflict``: a smallest-by-inclusion set of
    rows whose combination reads 0 = miss with miss ≠ 0; ``multipliers`` are the factors of those
    rows, ``miss`` their combined right-hand side. ``dependent``: rows that follow from the others,
    if that was exact.
    """

    solution: tuple[float | None, ...] | None
    nullspace: tuple[tuple[float, ...], ...] = ()
    conflict: tuple[int, ...] = ()
    multipliers: tuple[float, ...] = ()
    miss: float = 0.0
    dependent: tuple[int, ...] = ()

    @property
    def free(self) -> tuple[int, ...]:
        """Indices of the unknowns that the rows leave free."""
        return tuple(j for j, parts in enumerate(zip(*self.nullspace, strict=True)) if any(parts))


EXACT_LIMIT = 30
REFINEMENTS = 5


def solve_linear(
    matrix: Sequence[Sequence[float | Fraction]], rhs: Sequence[float | Fraction]
) -> LinearOutcome:
    """Solve A x = b for m × n rows of finite floats or fractions.

    Up to 30 rows and columns by fractions; beyond by LU with iterative refinement, with the rank to
    rounding.
    """
    n = len(matrix[0]) if matrix else 0
    if max(n, len(matrix)) > EXACT_LIMIT:
        with np.errstate(all="ignore"):  # what overflows is not consistent
            return _solved(np.array(matrix, dtype=float), np.array(rhs, dtype=float))
    rows, pivots = gauss_jordan(matrix, rhs)
    basis = []
    for free in sorted(set(range(n)).difference(pivots.values())):
        vector = [0.0] * n
        vector[free] = 1.0
        for i, column in pivots.items():
            vector[column] = _quotient(-rows[i][free], rows[i][column])
        basis.append(tuple(vector))
    # A dependent row is a combination of the independent pivot rows in one way only, so that no
    # part of the rows that make it up is dependent by itself.
    contradicting = {
        i: tuple(k for k, share in enumerate(row[n + 1 :]) if share)
        for i, row in enumerate(rows)
        if row[n] and i not in pivots
    }
    if contradicting:
        i, origins = min(contradicting.items(), key=lambda found: (len(found[1]), found[0]))
        own = rows[i][n + 1 + i]
        multipliers = tuple(_quotient(rows[i][n + 1 + k], own) for k in origins)
        miss = _quotient(rows[i][n], own)
        return LinearOutcome(None, tuple(basis), origins, multipliers, miss)
    values: list[float | None] = [None] * n
    for i, column in pivots.items():
        if sum(map(bool, rows[i][:n])) == 1:
            values[column] = _quotient(rows[i][n], rows[i][column])
    dependent = tuple(i for i in range(len(rows)) if i not in pivots)
    return LinearOutcome(tuple(values), tuple(basis), dependent=dependent)


def gauss_jordan(
    matrix: Sequence[Sequence[float | Fraction]], rhs: Sequence[float | Fraction]
) -> tuple[list[list[int]], dict[int, int]]:
    """Rows that follow from those of A x = b, in reduced echelon form; the column of each pivot by
    row.

    A row is the n coefficients, the right-hand side, and the shares of the original rows in it, all
    integers. E. H. Bareiss, "Sylvester's identity and multistep integer-preserving Gaussian
    elimination", Math. Comp. 22 (1968): with rows of integers every division is exact, and no
    common divisor is ever sought.
    """
    rows: list[list[int]] = []
    for i, (row, b) in enumerate(zip(matrix, rhs, strict=True)):
        ratios = [number.as_integer_ratio() for number in (*row, b)]
        common = lcm(*(denominator for _, denominator in ratios))
        whole = [numerator * (common // denominator) for numerator, denominator in ratios]
        rows.append([*whole, *(common * (k == i) for k in range(len(matrix)))])
    pivots: dict[int, int] = {}
    last = 1
    for column in range(len(matrix[0]) if matrix else 0):
        chosen = next((i for i, row in enumerate(rows) if i not in pivots and row[column]), None)
        if chosen is None:
            continue
        pivots[chosen] = column
        source = rows[chosen]
        pivot = source[column]
        for i, row in enumerate(rows):
            if i != chosen and (factor := row[column]):
                rows[i] = [
                    (pivot * a - factor * p) // last for a, p in zip(row, source, strict=True)
                ]
            elif i != chosen and pivot != last:
                rows[i] = [pivot * a // last for a in row]
        last = pivot
    return rows, pivots


def _quotient(numerator: int, denominator: int) -> float:
    """The nearest float; infinite if it is out of range."""
    try:
        return numerator / denominator
    except OverflowError:
        return inf if (numerator > 0) == (denominator > 0) else -inf


def _solved(a: Array, b: Array) -> LinearOutcome:
    """By LU, refined until the correction no longer halves; by singular values if it is
    singular."""
    n = a.shape[1]
    factor = factorise(a, [1.0] * n)
    long, right = a.astype(np.longdouble), b.astype(np.longdouble)
    x, previous = factor.solution(b), inf
    for _ in range(REFINEMENTS):
        correction = factor.solution((right - long @ x).astype(float))
        size = float(np.abs(correction).max(initial=0.0))
        if not size < 0.5 * previous:
            break
        x, previous = x + correction, size
    missed = np.abs((right - long @ x).astype(float))
    if (
        factor.rank < len(b)
        and not (missed <= CONSISTENT * (np.abs(a) @ np.abs(x) + np.abs(b))).all()
    ):
        contradiction = _contradiction(a, b, factor.rank)
        if contradiction is not None:
            return contradiction
    if factor.rank == n:
        return LinearOutcome(tuple(x.tolist()))
    null = np.linalg.svd(a)[2][factor.rank :]
    basis = np.where(np.abs(null) > NULL_ENTRY, null, 0.0)
    values = [None if part.any() else v for part, v in zip(basis.T, x.tolist(), strict=True)]
    return LinearOutcome(tuple(values), tuple(map(tuple, basis.tolist())))


def _contradiction(a: Array, b: Array, rank: int) -> LinearOutcome | None:
    """Rows in the left null direction with the largest residual. Few, but not proven smallest.

    None if the residual is at most rounding.
    """
    scaled, rows = equilibrated(a, np.ones(a.shape[1]))
    left = np.linalg.svd(scaled)[0][:, rank:]
    out = left.T @ (b / rows)
    if not (np.abs(out) > CONSISTENT * (np.abs(left).T @ np.abs(b / rows))).any():
        return None
    direction = (left @ out) / rows
    direction = direction / np.abs(direction).max()
    named = np.flatnonzero(np.abs(direction) * rows > MOVES * np.abs(direction * rows).max())
    multipliers, miss = tuple(direction[named].tolist()), float(direction @ b)
    return LinearOutcome(None, (), tuple(named.tolist()), multipliers, miss)
