"""Levenberg–Marquardt descent for the stretches where Newton's direction is of no use.

Minimises ½ Σ (F_i / r_i)² in the scaled unknowns x_j / w_j, with row scales r_i and weights w_j fixed at
entry, with the damping update of H. B. Nielsen, *Damping parameter in Marquardt's method* (1999).
"""

from __future__ import annotations

from math import isfinite
from typing import Any

from rulesheets.deadline import expect_time
from solver.numerics.factor import SMALL, factorise, row_sizes
from solver.numerics.system import Point, System

GRADIENT = 1e-14


def descend(system: System, start: Point, limit: int) -> tuple[Point, int]:
    """Descend until the scaled residual is a tenth of what it was at ``start``, or no further.

    Returns the lowest point (``start`` itself where no step goes down) and the number of steps tried.
    """
    rows = [size or 1.0 for size in row_sizes(start.jacobian, start.weight)]
    first = lowest = _cost(start.residual, rows)
    if not isfinite(first):
        return start, 0
    point, damping, growth = start, 1e-3, 2.0
    for used in range(min(limit, 60)):
        expect_time()
        normal, gradient = _normal_equations(point, rows, start.weight)
        if max(map(abs, gradient), default=0.0) <= GRADIENT * lowest**0.5:
            return point, used
        step = _damped_solution(normal, gradient, damping)
        following = _follow(system, point, step, start.weight)
        gain = lowest - _cost(following.residual, rows) if following else -1.0
        if following is None or gain <= 0.0:
            damping, growth = damping * growth, growth * 2
            if damping > 1e16:
                return point, used + 1
            continue
        predicted = 0.5 * sum(s * (damping * s - g) for s, g in zip(step, gradient, strict=True))
        point, lowest = following, lowest - gain
        damping *= max(1 / 3, 1 - min(2 * gain / predicted - 1, 1.0) ** 3) if predicted > 0 else 1.0
        growth = 2.0
        if lowest <= 0.01 * first:
            return point, used + 1
    return point, min(limit, 60)


def _cost(residual: list[float], rows: list[float]) -> float:
    """Half the sum of squares; infinite where it overflows (a product does, a power would raise)."""
    shares = [r / s for r, s in zip(residual, rows, strict=True)]
    return 0.5 * sum(share * share for share in shares)


def _normal_equations(point: Point, rows: list[float], weight: list[float]) -> tuple[Any, list[float]]:
    """Scaled JᵀJ and JᵀF: lists for small systems, arrays for large ones."""
    n = len(weight)
    if n > SMALL or hasattr(point.jacobian, "toarray"):
        return _array_normal_equations(point, rows, weight)
    scaled = [
        [a * w / size for a, w in zip(row, weight, strict=True)]
        for row, size in zip(point.jacobian, rows, strict=True)
    ]
    residual = [r / s for r, s in zip(point.residual, rows, strict=True)]
    normal = [[sum(row[i] * row[j] for row in scaled) for j in range(n)] for i in range(n)]
    return normal, [sum(row[j] * r for row, r in zip(scaled, residual, strict=True)) for j in range(n)]


def _array_normal_equations(point: Point, rows: list[float], weight: list[float]) -> tuple[Any, list[float]]:
    import numpy as np

    matrix = point.jacobian.toarray() if hasattr(point.jacobian, "toarray") else point.jacobian
    scaled = np.asarray(matrix, dtype=float) * np.asarray(weight) / np.asarray(rows)[:, None]
    gradient: list[float] = (scaled.T @ (np.asarray(point.residual) / np.asarray(rows))).tolist()
    return scaled.T @ scaled, gradient


def _damped_solution(normal: Any, gradient: list[float], damping: float) -> list[float]:
    """-(JᵀJ + μ max diag(JᵀJ) I)⁻¹ JᵀF in scaled unknowns."""
    n = len(gradient)
    largest = max(normal[i][i] for i in range(n)) or 1.0
    damped = [[float(normal[i][j]) for j in range(n)] for i in range(n)]
    for i in range(n):
        damped[i][i] += damping * largest
    return [-d for d in factorise(damped, [1.0] * n).solve(gradient)]


def _follow(system: System, point: Point, step: list[float], weight: list[float]) -> Point | None:
    x = [v + w * d for v, w, d in zip(point.x, weight, step, strict=True)]
    return None if x == point.x else system.point(x)
