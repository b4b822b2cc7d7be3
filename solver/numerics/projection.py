"""Gauss–Newton of least norm on many starts at once: to the nearest solution, where solutions form a curve.

Newton's method is lost on a curve of solutions, where the Jacobian is singular: rounding, divided by next to
nothing, sends it anywhere along. A step that leaves out the directions in which the equations do not change
goes straight to the curve and stays where it has met it (A. Ben-Israel, *A Newton–Raphson method for the
solution of systems of equations*, J. Math. Anal. Appl. 15 (1966) 243–252).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.deadline import expect_time

Array: TypeAlias = NDArray[np.float64]
BatchFunction: TypeAlias = Callable[[Array], Array]

LENGTHS = (1.0, 0.3, 0.05)
"""Fractions of a step that are tried."""
KEPT = 0.1
"""Share of the distance to the end of a range that a step beyond it leaves."""


@dataclass(frozen=True, slots=True)
class ProjectionLimits:
    """``null``: share of the largest singular value up to which others count as 0. ``near``: a step, in units
    of the unknowns' sizes, that has arrived; ``longest``: where a longer one is cut. ``patience``: steps
    without a gain of a tenth.
    """

    iterations: int = 60
    null: float = 1e-8
    near: float = 1e-11
    patience: int = 12
    longest: float = 2.0


STANDARD_LIMITS = ProjectionLimits()


def project(
    residual: BatchFunction,
    jacobian: BatchFunction,
    starts: Array,
    scale: Array,
    low: Array,
    high: Array,
    limits: ProjectionLimits = STANDARD_LIMITS,
) -> Array:
    """The ends (m, n) of those ``starts`` (k, n) that arrive at a zero of F: Rⁿ → Rᵐ, in no certain order.

    ``residual`` maps (k, n) to (k, m), ``jacobian`` to (k, m, n), both nan outside their domain. ``scale``
    (n,): typical sizes of the unknowns; ``low`` and ``high`` (n,): their ranges, in which the way stays.
    """
    with np.errstate(all="ignore"):
        x = starts[np.isfinite(residual(starts)).all(axis=1)]
        best, idle = np.full(len(x), np.inf), np.zeros(len(x), dtype=int)
        arrived: list[Array] = []
        for _ in range(limits.iterations):
            expect_time()
            if not len(x):
                break
            x, norm, length = _step(residual, jacobian, x, scale, low, high, limits)
            finite = np.isfinite(norm) & np.isfinite(x).all(axis=1)
            done = finite & (length <= limits.near)
            arrived.extend(x[done])
            gained = norm < 0.9 * best
            idle, best = np.where(gained, 0, idle + 1), np.where(gained, norm, best)
            going = finite & ~done & (idle < limits.patience)
            x, best, idle = x[going], best[going], idle[going]
    return np.array(arrived).reshape(len(arrived), len(scale))


def _step(
    residual: BatchFunction,
    jacobian: BatchFunction,
    x: Array,
    scale: Array,
    low: Array,
    high: Array,
    limits: ProjectionLimits,
) -> tuple[Array, Array, Array]:
    """The points after a step, the scaled residuals there, infinite where none is defined, and its length."""
    weight = np.maximum(abs(x), scale)
    matrix = jacobian(x) * weight[:, None, :]
    rows = abs(matrix).sum(axis=2)
    rows = np.where(np.isfinite(rows) & (rows > 0.0), rows, np.inf)
    step = _least_norm(np.nan_to_num(matrix / rows[:, :, None]), residual(x) / rows, limits.null)
    length = abs(step).max(axis=1)
    step *= np.minimum(1.0, limits.longest / np.maximum(length, 1e-300))[:, None]
    trials = np.stack([_within(x, x + share * weight * step, low, high) for share in LENGTHS])
    values = residual(trials.reshape(-1, x.shape[1])).reshape(len(LENGTHS), len(x), -1)
    norms = abs(values / rows).max(axis=2)
    norms = np.where(np.isfinite(norms), norms, np.inf)
    chosen, each = norms.argmin(axis=0), np.arange(len(x))
    return trials[chosen, each], norms[chosen, each], length


def _least_norm(matrices: Array, rhs: Array, null: float) -> Array:
    """-A⁺ b for each of (k, m, n) and (k, m); singular values up to a share ``null`` of the largest are 0."""
    u, s, v = np.linalg.svd(matrices, full_matrices=False)
    inverse = np.where(s > null * s[:, :1], 1.0 / s, 0.0)
    parts: Any = inverse * np.einsum("kmi,km->ki", u, rhs)
    found: Array = -np.einsum("kin,ki->kn", v, np.where(inverse > 0.0, parts, 0.0))
    return found


def _within(x: Array, moved: Array, low: Array, high: Array) -> Array:
    """Where a step beyond the end of a range stops: before it, for the end may not belong to the range."""
    moved = np.where((moved <= low) & (x > low), low + KEPT * (x - low), moved)
    return np.where((moved >= high) & (x < high), high - KEPT * (high - x), moved)
