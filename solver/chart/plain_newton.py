"""Newton's method as a user would write it, to a tolerance of one's own: what speed costs in accuracy.

Nothing that is presented as an answer comes from here; it is measured beside what is.
"""

from __future__ import annotations

from collections.abc import Sequence

from rulesheets.deadline import expect_time
from solver.numerics.newton import Jacobian, Residual, ScipyRoot, System
from solver.numerics.termination import scaled_norm

MOST = 60
CUTS = 12


def plain_newton(
    residual: Residual,
    jacobian: Jacobian,
    start: Sequence[float],
    scale: Sequence[float],
    tolerance: float,
) -> ScipyRoot:
    """Full steps from ``start`` (n,), halved only to stay in the domain, until one is short."""
    system = System(residual, jacobian, [abs(s) or 1.0 for s in scale])
    point = system.point([float(v) for v in start])
    for used in range(1, MOST + 1):
        expect_time()
        if point is None:
            return ScipyRoot(tuple(start), False, used)
        step = point.correction(point.residual)
        norm, share = scaled_norm(step, point.weight), 1.0
        following = None
        for _ in range(CUTS):
            following = system.point([v + share * d for v, d in zip(point.x, step, strict=True)])
            if following is not None:
                break
            share /= 2
        if following is not None and norm <= tolerance and share == 1.0:
            return ScipyRoot(tuple(following.x), True, used)
        if following is None:
            return ScipyRoot(tuple(point.x), False, used)
        point = following
    return ScipyRoot(tuple(point.x) if point else tuple(start), False, MOST)
