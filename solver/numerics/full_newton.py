"""Newton's method at full length: no descent is asked for, so that no local minimum of |F| holds it.

It wanders where the damped method is held to its way, and sometimes that leads on. Steps are cut only to
stay in the domain and within some powers of ten. What it comes near to is judged by damped Newton.
"""

from __future__ import annotations

from collections.abc import Sequence

from rulesheets.deadline import expect_time
from solver.numerics.newton import STANDARD_LIMITS, NewtonLimits, NewtonResult, newton
from solver.numerics.outcome import Outcome
from solver.numerics.system import Jacobian, Point, Residual, System
from solver.numerics.termination import scaled_norm

NEAR = 1e-3
"""A scaled step as short as this begins the end game."""
LONGEST = 1e3
CUTS = 12


def full_newton(
    residual: Residual,
    jacobian: Jacobian,
    start: Sequence[float],
    scale: Sequence[float],
    iterations: int = 60,
    limits: NewtonLimits = STANDARD_LIMITS,
) -> NewtonResult:
    """Search a root of F: Rⁿ → Rᵐ from ``start`` (n,) with typical magnitudes ``scale`` (n,) of the unknowns.

    The outcome is that of damped Newton from the first point with a short step; LIMIT where there is none.
    """
    system = System(residual, jacobian, [abs(s) or 1.0 for s in scale])
    point = system.point([float(v) for v in start])
    if point is None:
        return NewtonResult(tuple(start), tuple(system.residual_at(list(start)) or ()), Outcome.DOMAIN, 0)
    for used in range(1, iterations + 1):
        expect_time()
        step = point.correction(point.residual)
        norm = scaled_norm(step, point.weight)
        if not norm <= NEAR:
            following = _moved(system, point, step, norm)
            if following is None:
                break
            point = following
            continue
        found = newton(residual, jacobian, point.x, scale, limits)
        count = found.iterations + used
        return NewtonResult(found.x, found.residual, found.outcome, count, found.condition)
    return NewtonResult(tuple(point.x), tuple(point.residual), Outcome.LIMIT, used, point.factor.condition())


def _moved(system: System, point: Point, step: list[float], norm: float) -> Point | None:
    """The point a full step on; nearer where that leaves the domain, None where every cut does."""
    share = min(1.0, LONGEST / norm) if norm > 0.0 else 0.0
    for _ in range(CUTS):
        following = system.point([v + share * d for v, d in zip(point.x, step, strict=True)])
        if following is not None:
            return following
        share /= 2
    return None
