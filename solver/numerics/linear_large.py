"""Linear systems too large for fractions: factor once, refine with residuals in extended precision.

Fixed-point refinement after N. J. Higham, *Accuracy and Stability of Numerical Algorithms* (2nd ed.,
2002), chapter 12: with residuals in more digits the answer is right to working precision unless the
condition number nears 1/eps.
"""

from __future__ import annotations

from typing import Any

from solver.numerics.linear_algebra import factorise
from solver.numerics.linear_outcome import LinearOutcome
from solver.numerics.outcome import Outcome

SPARSE_BELOW = 0.1
REFINEMENTS = 5
CONSISTENT = 1e-11


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
