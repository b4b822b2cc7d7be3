"""Newton's method inside a trust region, by Powell's dogleg: no step beyond where slopes held.

M. J. D. Powell, *A hybrid method for nonlinear equations* (1970); J. Nocedal and S. Wright, *Numerical
Optimization* (2006), sections 4.1 and 11.2. The step is the Newton step where that lies in the region, else
where the bent line from the steepest descent to it meets the edge. The region, round in the scaled unknowns,
grows where the linear model foretold the gain and shrinks where it did not. Damped Newton keeps the direction
and shortens the step; this turns it downhill as it shortens, and so gets round where the Jacobian is nearly
singular. What it comes near to is judged by damped Newton.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from rulesheets.deadline import expect_time
from solver.numerics.factor import row_products, row_sizes, transposed_product
from solver.numerics.newton import STANDARD_LIMITS, NewtonLimits, NewtonResult, newton
from solver.numerics.outcome import Outcome
from solver.numerics.system import Jacobian, Point, Residual, System

NEAR = 1e-3
"""A scaled Newton step as short as this begins the end game."""


@dataclass(frozen=True, slots=True)
class TrustLimits:
    """Radii in scaled unknowns; ``gain`` is the least share of the foretold gain that a step must bring."""

    iterations: int = 200
    first: float = 1.0
    longest: float = 1e3
    shortest: float = 1e-9
    gain: float = 1e-4
    newton: NewtonLimits = STANDARD_LIMITS


STANDARD_TRUST = TrustLimits()


def dogleg(
    residual: Residual,
    jacobian: Jacobian,
    start: Sequence[float],
    scale: Sequence[float],
    limits: TrustLimits = STANDARD_TRUST,
) -> NewtonResult:
    """Search a root of F: Rⁿ → Rᵐ from ``start`` (n,) with typical magnitudes ``scale`` (n,) of the unknowns.

    The outcome is that of damped Newton from the first point with a short Newton step; STALLED where the
    region shrinks to nothing, LIMIT where the iterations end before.
    """
    system = System(residual, jacobian, [abs(s) or 1.0 for s in scale])
    point = system.point([float(v) for v in start])
    if point is None:
        return NewtonResult(tuple(start), tuple(system.residual_at(list(start)) or ()), Outcome.DOMAIN, 0)
    rows = [size or 1.0 for size in row_sizes(point.jacobian, point.weight)]
    radius = limits.first * math.sqrt(len(start))
    for used in range(1, limits.iterations + 1):
        expect_time()
        newtons, steepest = _legs(point, rows)
        if max(map(abs, newtons), default=0.0) <= NEAR:
            found = newton(residual, jacobian, point.x, scale, limits.newton)
            count = found.iterations + used
            return NewtonResult(found.x, found.residual, found.outcome, count, found.condition)
        step = _bent(newtons, steepest, radius)
        length = _norm(step)
        following, ratio = _tried(system, point, rows, step)
        if ratio < 0.25:
            radius = 0.25 * min(length, radius)
        elif ratio > 0.75 and length > 0.9 * radius:
            radius = min(2.0 * radius, limits.longest * math.sqrt(len(start)))
        if following is not None and ratio >= limits.gain:
            point = following
        if radius < limits.shortest:
            return _ended(point, Outcome.STALLED, used)
    return _ended(point, Outcome.LIMIT, limits.iterations)


def _ended(point: Point, outcome: Outcome, used: int) -> NewtonResult:
    return NewtonResult(tuple(point.x), tuple(point.residual), outcome, used, point.factor.condition())


def _legs(point: Point, rows: Sequence[float]) -> tuple[list[float], list[float]]:
    """In scaled unknowns: the Newton step, and the step of steepest descent to where the model is least."""
    newtons = [d / w for d, w in zip(point.correction(point.residual), point.weight, strict=True)]
    shares = [r / size / size for r, size in zip(point.residual, rows, strict=True)]
    slopes = transposed_product(point.jacobian, shares)
    gradient = [w * g for w, g in zip(point.weight, slopes, strict=True)]
    change = row_products(point.jacobian, [w * g for w, g in zip(point.weight, gradient, strict=True)])
    turned = [c / size for c, size in zip(change, rows, strict=True)]
    bend = sum(c * c for c in turned)  # a power would raise where it overflows
    slope = sum(g * g for g in gradient)
    share = slope / bend if bend > 0.0 else 0.0
    return newtons, [-share * g for g in gradient]


def _bent(newtons: list[float], steepest: list[float], radius: float) -> list[float]:
    """The dogleg: where the line from 0 by the steepest step to the Newton step leaves the region."""
    if _norm(newtons) <= radius:
        return newtons
    length = _norm(steepest)
    if length >= radius:
        return [radius / length * d for d in steepest]
    leg = [n - d for n, d in zip(newtons, steepest, strict=True)]
    a, b, c = (
        sum(v * v for v in leg),
        sum(d * v for d, v in zip(steepest, leg, strict=True)),
        length * length - radius * radius,
    )
    root = math.sqrt(max(b * b - a * c, 0.0))
    share = -c / (b + root) if b > 0.0 else (root - b) / a
    return [d + share * v for d, v in zip(steepest, leg, strict=True)]


def _tried(
    system: System, point: Point, rows: Sequence[float], step: list[float]
) -> tuple[Point | None, float]:
    """The point a step ahead, and the share of the foretold gain that it brings; -1 where it is undefined."""
    moved = [w * d for w, d in zip(point.weight, step, strict=True)]
    following = system.point([v + d for v, d in zip(point.x, moved, strict=True)])
    if following is None:
        return None, -1.0
    linear = row_products(point.jacobian, moved)
    before = _cost(point.residual, rows)
    foretold = before - _cost([r + p for r, p in zip(point.residual, linear, strict=True)], rows)
    gain = before - _cost(following.residual, rows)
    return following, gain / foretold if foretold > 0.0 else -1.0


def _cost(residual: Sequence[float], rows: Sequence[float]) -> float:
    shares = [r / size for r, size in zip(residual, rows, strict=True)]
    return sum(share * share for share in shares)


def _norm(step: Sequence[float]) -> float:
    return math.hypot(*step)
