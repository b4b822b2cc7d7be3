"""Fix one unknown, solve for the others, release it: what is done by hand where nothing else helps.

With one unknown held at its start, one equation is left out: the one without which the others are determined
best (the largest entry of the left null vector of the Jacobian without the column). What is left is smaller
and often tame. As the unknown is let go, its answers form a curve, which is followed both ways and over its
folds (``homotopy.py``) to where the equation that was left out holds again: a root of all. The other
equations hold all along, so that one residual is brought to zero, whatever hills the size of all of them has.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from solver.numerics.factor import row_sizes
from solver.numerics.homotopy import STANDARD_HOMOTOPY, HomotopyLimits, follow_homotopy
from solver.numerics.newton import NewtonLimits, NewtonResult, newton
from solver.numerics.outcome import Outcome
from solver.numerics.system import Jacobian, Point, Residual, System

HELD = NewtonLimits(iterations=60, escapes=3)


def fix_and_release(
    residual: Residual,
    jacobian: Jacobian,
    start: Sequence[float],
    scale: Sequence[float],
    held: int,
    limits: HomotopyLimits = STANDARD_HOMOTOPY,
) -> NewtonResult:
    """Search a root of F: Rⁿ → Rⁿ with the unknown ``held`` fixed at its ``start`` (n,) first.

    ``scale`` (n,) gives typical magnitudes of the unknowns, two at least. The outcome is that of the smaller
    system where that has no answer, STALLED where it has none that is isolated, DOMAIN where F is undefined
    at the start, else how the curve ended.
    """
    system = System(residual, jacobian, [abs(s) or 1.0 for s in scale])
    point = system.point([float(v) for v in start])
    if point is None:
        return NewtonResult(tuple(start), tuple(system.residual_at(list(start)) or ()), Outcome.DOMAIN, 0)
    dropped = _superfluous(point, held)
    inner = _without(residual, jacobian, point.x[held], held, dropped)
    free = [place for place in range(len(start)) if place != held]
    found = newton(*inner, [start[j] for j in free], [scale[j] for j in free], HELD)
    x = [*found.x[:held], point.x[held], *found.x[held:]]
    if found.outcome is not Outcome.CONVERGED:
        ended = Outcome.STALLED if found.outcome.found else found.outcome  # of the smaller system alone
        return NewtonResult(tuple(x), tuple(system.residual_at(x) or ()), ended, found.iterations)
    used = found.iterations
    for forward in (True, False):
        end = follow_homotopy(residual, jacobian, x, scale, limits, forward)
        used += end.iterations
        if end.outcome.found:
            break
    return NewtonResult(end.x, end.residual, end.outcome, used, end.condition)


def _superfluous(point: Point, held: int) -> int:
    """The equation to leave out, so that the others determine the unknowns but ``held`` best."""
    import numpy as np

    dense = _rows(point.jacobian)
    rows = np.array([size or 1.0 for size in row_sizes(dense, point.weight)])
    scaled = np.asarray(dense, dtype=float) * np.asarray(point.weight) / rows[:, None]
    left = np.linalg.svd(np.delete(scaled, held, axis=1))[0]
    return int(np.abs(left[:, -1]).argmax())


def _without(
    residual: Residual, jacobian: Jacobian, value: float, held: int, dropped: int
) -> tuple[Residual, Jacobian]:
    """The same without the equation ``dropped``, the unknown ``held`` being ``value``."""

    def values(x: list[float]) -> Sequence[float]:
        full = residual([*x[:held], value, *x[held:]])
        return [r for i, r in enumerate(full) if i != dropped]

    def slopes(x: list[float]) -> Any:
        full = _rows(jacobian([*x[:held], value, *x[held:]]))
        return [[a for j, a in enumerate(row) if j != held] for i, row in enumerate(full) if i != dropped]

    return values, slopes


def _rows(matrix: Any) -> Any:
    """Rows, of a scipy sparse matrix too."""
    return matrix.toarray() if hasattr(matrix, "toarray") else matrix
