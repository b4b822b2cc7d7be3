"""Damped Newton for F(x) = 0 with an exact Jacobian.

The damping is the error-oriented one of P. Deuflhard, *Newton Methods for Nonlinear Problems* (2004),
section 3.3.3 (NLEQ-ERR): a step is accepted by the natural monotonicity test, which looks at corrections
and not at residuals, so that neither the units of the rules nor a linear mix of them changes the
iterates. Where the test fails at every length, or the Jacobian loses rank, Levenberg–Marquardt steps
(MINPACK's) lead away. Inside the region of fast contraction full steps are taken until rounding
ends the contraction, so that the last digits are right.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from rulesheets.deadline import expect_time
from solver.numerics.linear_algebra import Factor, as_matrix, factorise, row_products, row_sizes
from solver.numerics.tolerances import (
    DEGENERATE,
    ESCAPED,
    FAST,
    STAGNATION,
    TIGHT,
    Outcome,
    explains,
    falls,
    residual_is_rounding,
    residual_vanishes,
    scaled_norm,
    stagnates,
    step_is_rounding,
    step_vanishes,
    weights,
)

Residual: TypeAlias = Callable[[list[float]], Sequence[float]]
Jacobian: TypeAlias = Callable[[list[float]], Any]
"""Rows of ∂F_i/∂x_j as a sequence of sequences, or a scipy sparse matrix."""


class Point(NamedTuple):
    """An iterate with its residual, Jacobian, weights and factored Jacobian."""

    x: list[float]
    residual: list[float]
    jacobian: Any
    weight: list[float]
    factor: Factor

    def correction(self, residual: Sequence[float]) -> list[float]:
        return [-d for d in self.factor.solve(residual)]


class System:
    """Residual and Jacobian with every way of being undefined turned into None."""

    def __init__(self, residual: Residual, jacobian: Jacobian, scale: Sequence[float]) -> None:
        self._residual, self._jacobian, self.scale = residual, jacobian, scale
        self.functions = residual, jacobian

    def residual_at(self, x: list[float]) -> list[float] | None:
        try:
            values = [float(v) for v in self._residual(x)]
        except (ArithmeticError, ValueError):
            return None
        return values if all(map(math.isfinite, values)) else None

    def point(self, x: list[float], residual: list[float] | None = None) -> Point | None:
        """The point x, or None where residual or Jacobian is undefined or infinite."""
        values = self.residual_at(x) if residual is None else residual
        if values is None:
            return None
        weight = weights(x, self.scale)
        try:
            matrix = as_matrix(self._jacobian(x), len(x))
        except (ArithmeticError, ValueError):
            return None
        if not all(map(math.isfinite, row_sizes(matrix, weight))):
            return None
        return Point(x, values, matrix, weight, factorise(matrix, weight))


SHORTEST = 1e-6
"""The least damping factor."""
POLISH, HALVINGS = 12, 60
"""Full steps to the end of fast contraction, and to show that a slow end is a multiple root."""
SLOW = 6
"""So many full steps without fast contraction tell a multiple root from a simple one."""


class NewtonLimits(NamedTuple):
    """``escapes`` is how often Levenberg–Marquardt may take over."""

    iterations: int = 100
    escapes: int = 6


STANDARD_LIMITS = NewtonLimits()


class NewtonResult(NamedTuple):
    """The best point met."""

    x: tuple[float, ...]
    residual: tuple[float, ...]
    outcome: Outcome
    iterations: int


def newton(
    residual: Residual,
    jacobian: Jacobian,
    start: Sequence[float],
    scale: Sequence[float] | None = None,
    limits: NewtonLimits = STANDARD_LIMITS,
) -> NewtonResult:
    """Search a root of F: Rⁿ → Rᵐ from ``start`` (n,).

    ``scale`` (n,) gives typical magnitudes of the unknowns; without it |start|, or 1 for a start at 0.
    The residual may raise ArithmeticError or ValueError, or return nan, outside its domain: steps are
    shortened back into it. Never raises for failing to converge: see the outcome.
    """
    x = [float(v) for v in start]
    system = System(residual, jacobian, _scales(x, scale))
    first = system.point(x)
    if first is None:
        return NewtonResult(tuple(x), tuple(system.residual_at(x) or ()), Outcome.DOMAIN, 0)
    return _Search(system, first, limits).run()


def _scales(x: Sequence[float], scale: Sequence[float] | None) -> list[float]:
    given = scale if scale is not None else x
    return [abs(s) if s else 1.0 for s in given]


class _Search:
    """The state of one search: the present point, the damping, and what has been spent."""

    def __init__(self, system: System, point: Point, limits: NewtonLimits) -> None:
        self.system, self.point, self.limits = system, point, limits
        self.iterations = 0
        self.escapes = 0
        self.slow = 0
        self.damping = 1.0
        self.last: tuple[list[float], list[float], float] | None = None

    def run(self) -> NewtonResult:
        while self.iterations < self.limits.iterations:
            expect_time()
            if self._vanishes():
                return self._polished()
            contraction = self._damped_step()
            if contraction is None:
                if self._at_rounding():
                    return self._polished()
                if not self._escape():
                    return self._stuck()
            elif contraction <= FAST and self.damping == 1.0:
                if (result := self._converge()) is not None:
                    return result
            elif contraction < 0.6 and self.damping == 1.0:
                self.slow += 1
        return self._stuck(Outcome.LIMIT)

    # -- tests, all of them asked of ``tolerances`` ------------------------------------------------------

    def _vanishes(self, point: Point | None = None) -> bool:
        p = point or self.point
        return residual_vanishes(p.residual, row_sizes(p.jacobian, p.x))

    def _explains(self, step: list[float]) -> bool:
        p = self.point
        sizes = row_sizes(p.jacobian, p.weight)
        return explains(p.residual, row_products(p.jacobian, step), sizes)

    def _at_rounding(self) -> bool:
        step = self.point.correction(self.point.residual)
        norm = scaled_norm(step, self.point.weight)
        return step_is_rounding(norm) and self._explains(step)

    def _degenerate(self) -> bool:
        """At a multiple root the Newton step is short although it contracts slowly, and full steps lower the
        residual until it is rounding; at a minimum of |F| the step is long, or leaves the residual as it was.
        At a root where rounding in F keeps the residual up, the Jacobian is the same at both ends.
        """
        for _ in range(HALVINGS):
            p = self.point
            step = p.correction(p.residual)
            if scaled_norm(step, p.weight) > DEGENERATE or not self._explains(step):
                return False
            if residual_is_rounding(p.residual, row_sizes(p.jacobian, p.weight)):
                return True
            following = self.system.point([v + d for v, d in zip(p.x, step, strict=True)])
            if following is None:
                return False
            if self._is_straight(following, step):
                return True
            if not falls(following.residual, p.residual):
                return False
            self.point = following
            self.iterations += 1
        return False

    def _is_straight(self, following: Point, step: list[float]) -> bool:
        """Whether F is so straight along a short full step that a simple root is near (Newton–Kantorovich):
        |J⁻¹ (J' - J) dx| is far below |dx|. It is |dx| / 2 at a double root, and more at a minimum of |F|."""
        p, norm = self.point, scaled_norm(step, self.point.weight)
        if norm > STAGNATION or p.factor.rank < p.factor.columns:
            return False
        ends = zip(row_products(following.jacobian, step), row_products(p.jacobian, step), strict=True)
        bend = p.correction([ahead - here for ahead, here in ends])
        return scaled_norm(bend, p.weight) <= FAST * norm

    # -- one damped step -------------------------------------------------------------------------------

    def _damped_step(self) -> float | None:
        """Take one damped Newton step. The contraction factor, or None where no length is accepted."""
        p = self.point
        step = p.correction(p.residual)
        norm = scaled_norm(step, p.weight)
        if norm == 0.0 or not math.isfinite(norm):
            return None
        damping = self._predicted(step, norm)
        while damping >= SHORTEST:
            x = [v + damping * d for v, d in zip(p.x, step, strict=True)]
            values = self.system.residual_at(x)
            if values is None:
                damping /= 2
                continue
            simplified = p.correction(values)
            ahead = scaled_norm(simplified, p.weight)
            deviation = scaled_norm(
                [b - (1 - damping) * d for b, d in zip(simplified, step, strict=True)], p.weight
            )
            if ahead <= (1 - damping / 4) * norm and (following := self.system.point(x, values)):
                self._accept(following, simplified, norm, damping)
                return ahead / norm
            longest = 0.5 * norm * damping**2 / deviation if deviation else 1.0
            damping = min(longest, damping / 2)
        return None

    def _predicted(self, step: list[float], norm: float) -> float:
        """A priori damping factor from the previous simplified correction (Deuflhard, eq. 3.48)."""
        if self.last is None:
            return 1.0
        simplified, weight, previous = self.last
        change = scaled_norm([b - d for b, d in zip(simplified, step, strict=True)], weight)
        if change == 0.0 or norm == 0.0:
            return 1.0
        predicted = (previous / norm) * (scaled_norm(simplified, weight) / change) * self.damping
        return min(1.0, max(predicted, 10 * SHORTEST))

    def _accept(self, point: Point, simplified: list[float], norm: float, damping: float) -> None:
        self.last = (simplified, self.point.weight, norm)
        self.point, self.damping = point, damping
        self.iterations += 1

    # -- the end: full steps until rounding stops them ---------------------------------------------------

    def _converge(self) -> NewtonResult | None:
        """Full steps from a point of fast contraction; None (and the best point kept) where it is lost."""
        previous = math.inf
        for _ in range(POLISH):
            p = self.point
            step = p.correction(p.residual)
            norm = scaled_norm(step, p.weight)
            if self._vanishes():
                return self._polished()
            if self._ended(step, norm, previous):
                return self._polished() if self._explains(step) else self._stuck()
            if norm <= FAST * previous < math.inf:
                self.slow = 0
            following = self.system.point([v + d for v, d in zip(p.x, step, strict=True)])
            if following is None or norm > previous:
                break
            self.point, previous = following, norm
            self.iterations += 1
        self.last, self.damping = None, 1.0
        return None

    def _ended(self, step: list[float], norm: float, previous: float) -> bool:
        return step_vanishes(step, self.point.x) or stagnates(norm, previous)

    def _polished(self) -> NewtonResult:
        """One more full step or two while they still lower the simplified correction."""
        for _ in range(3):
            p = self.point
            step = p.correction(p.residual)
            following = self.system.point([v + d for v, d in zip(p.x, step, strict=True)])
            if following is None or not _smaller(p.correction(following.residual), step, p.weight):
                break
            self.point = following
            self.iterations += 1
        regular = self.point.factor.rank == self.point.factor.columns and self.slow < SLOW
        return self._result(Outcome.CONVERGED if regular else Outcome.SINGULAR_JACOBIAN)

    # -- when Newton is stuck ----------------------------------------------------------------------------

    def _escape(self) -> bool:
        """Levenberg–Marquardt steps towards a smaller residual; False where there is none."""
        if self.escapes >= self.limits.escapes:
            return False
        self.escapes += 1
        p = self.point
        end = scipy_root(*self.system.functions, p.x, "lm", p.weight, ESCAPED)
        self.iterations += 1
        lower = self.system.point(list(end.x)) if end.x != tuple(p.x) else None
        if lower is None:
            return False
        self.point, self.last, self.damping = lower, None, 1.0
        return True

    def _stuck(self, otherwise: Outcome = Outcome.STALLED) -> NewtonResult:
        if self._vanishes():
            return self._polished()
        return self._result(Outcome.SINGULAR_JACOBIAN if self._degenerate() else otherwise)

    def _result(self, outcome: Outcome) -> NewtonResult:
        p = self.point
        return NewtonResult(tuple(p.x), tuple(p.residual), outcome, self.iterations)


def _smaller(simplified: list[float], step: list[float], weight: list[float]) -> bool:
    return scaled_norm(simplified, weight) < scaled_norm(step, weight)


TRUST_REGIONS = ("lm", "hybr")
METHODS = ("hybr", "lm", "least_squares")


class ScipyRoot(NamedTuple):
    """``success`` is what scipy says of itself; ``evaluations`` are those of the residual."""

    x: tuple[float, ...]
    success: bool
    evaluations: int


def scipy_root(
    residual: Residual,
    jacobian: Jacobian,
    start: Sequence[float],
    method: str,
    scale: Sequence[float] | None = None,
    tolerance: float = TIGHT,
) -> ScipyRoot:
    """``scipy.optimize.root`` (hybr, lm) or ``least_squares`` from ``start`` (n,), with the exact Jacobian.

    ``scale`` (n,): typical magnitudes of the unknowns, else scipy takes its own from the Jacobian. Where the
    residual is undefined it is taken as nan, at which the methods give up. ``tolerance`` is relative.
    """
    from scipy.optimize import least_squares, root  # takes longer to import than most solves

    def values(x: Any) -> Any:
        expect_time()
        try:
            return np.array(residual(x.tolist()), dtype=float)
        except (ArithmeticError, ValueError):
            return np.full(len(start), np.nan)

    def slopes(x: Any) -> Any:
        return np.array(jacobian(x.tolist()), dtype=float)

    try:
        with np.errstate(all="ignore"):
            if method == "least_squares":
                found = least_squares(values, start, slopes, xtol=tolerance, ftol=tolerance, gtol=tolerance)
            else:
                diagonal = {} if scale is None else {"diag": [1.0 / abs(s) if s else 1.0 for s in scale]}
                found = root(values, start, jac=slopes, method=method, tol=tolerance, options=diagonal)
    except (ArithmeticError, ValueError, np.linalg.LinAlgError):
        return ScipyRoot(tuple(start), False, 0)
    x = tuple(float(v) for v in found.x)
    return ScipyRoot(x, bool(found.success) and bool(np.isfinite(found.x).all()), int(found.nfev))
