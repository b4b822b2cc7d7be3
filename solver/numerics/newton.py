"""Newton's method for F(x) = 0 with an exact Jacobian: damped, from one start.

The damping is the error-oriented one of P. Deuflhard, *Newton Methods for Nonlinear Problems*
(2004), section 3.3.3 (NLEQ-ERR): a step is accepted by the natural monotonicity test, which looks
at corrections and not at residuals, so that neither the units of the rules nor a linear mix of them
changes the iterates. Where the test fails at every length, or the Jacobian loses rank,
Levenberg–Marquardt steps (MINPACK's) lead away. Inside the region of fast contraction full steps
are taken until rounding ends the contraction, so that the last digits are right.

Two scale-free measures tell the end of an iteration. The *backward error* of equation i at x is
|F_i| / Σ_j |J_ij x_j|: the relative change of the unknowns that would explain the residual. The
*scaled step* of unknown j is |dx_j| / w_j with the weight w_j = max(|x_j|, scale_j).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from enum import Enum
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from rulesheets.deadline import expect_time
from solver.numerics.linear_algebra import Array, Factor, as_matrix, factorise, row_sizes
from solver.numerics.tolerances import (
    DEGENERATE,
    EPS,
    ESCAPED,
    FAST,
    RESIDUAL,
    STAGNATION,
    TIGHT,
    VANISHING,
)


class Outcome(Enum):
    """The end of a search. Only ``CONVERGED`` means an isolated answer correct to rounding."""

    CONVERGED = "The residual vanishes to rounding at an isolated point."
    SINGULAR_JACOBIAN = (
        "The residual vanishes to rounding, but the Jacobian loses rank there: "
        "the answer is not isolated, or it is a multiple one."
    )
    STALLED = "No step makes the residual smaller, and it does not vanish."
    LIMIT = "The limit on iterations was reached before the residual vanished."
    DOMAIN = "The residual or its Jacobian is undefined at the start or at the point approached."

    @property
    def found(self) -> bool:
        """Whether the residual vanishes to rounding at the point returned."""
        return self in (Outcome.CONVERGED, Outcome.SINGULAR_JACOBIAN)


def stagnates(step_norm: float, previous_norm: float) -> bool:
    """Quadratic contraction has ended at a step so small that only rounding explains it."""
    return step_norm <= STAGNATION and step_norm > 0.25 * previous_norm


Residual: TypeAlias = Callable[[list[float]], Sequence[float]]
Jacobian: TypeAlias = Callable[[list[float]], Any]
"""Rows of ∂F_i/∂x_j as a sequence of sequences, or a scipy sparse matrix."""


class Point(NamedTuple):
    """An iterate with its residual, Jacobian, weights, factored Jacobian and Newton step."""

    x: Array
    residual: Array
    jacobian: Any
    weight: Array
    factor: Factor
    step: Array

    def norm(self, step: Array) -> float:
        """The largest |dx_j| / w_j."""
        return float((np.abs(step) / self.weight).max(initial=0.0))

    def vanishes(self) -> bool:
        """Whether the backward error is at rounding level."""
        return bool((np.abs(self.residual) <= RESIDUAL * row_sizes(self.jacobian, self.x)).all())

    def explains(self) -> bool:
        """Whether the step accounts for the residual: F + J dx is small relative to F, or to the
        sizes of the rules. (If rank is lost at a minimum of |F| it does not.)"""
        left = np.abs(self.residual + self.jacobian @ self.step)
        sizes = row_sizes(self.jacobian, self.weight)
        return bool((left <= np.maximum(0.5 * np.abs(self.residual), VANISHING * sizes)).all())


SHORTEST = 1e-6
"""The least damping factor."""
POLISH = 12
"""Full steps to the end of fast contraction."""
SLOW = 6
"""So many full steps without fast contraction distinguish a multiple root from a simple one."""


class NewtonLimits(NamedTuple):
    """``escapes``: how often Levenberg–Marquardt may take over."""

    iterations: int = 100
    escapes: int = 6


STANDARD_LIMITS = NewtonLimits()


class NewtonResult(NamedTuple):
    """The best point of a search."""

    x: tuple[float, ...]
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

    ``scale`` (n,) gives typical magnitudes of the unknowns; without it |start|, or 1 for a start at
    0. The residual may raise ArithmeticError or ValueError, or return nan, outside its domain:
    steps are shortened back into it. Never raises for failing to converge: see the outcome.
    """
    x = np.array(start, dtype=float)
    search = Search(residual, jacobian, start if scale is None else scale, limits)
    with np.errstate(all="ignore"):
        first = search.at(x)
        if first is None:
            return NewtonResult(tuple(x.tolist()), Outcome.DOMAIN, 0)
        outcome = search.run(first)
    return NewtonResult(tuple(search.point.x.tolist()), outcome, search.iterations)


class Search:
    """One search: its functions, the present point, the damping, and the work spent."""

    point: Point

    def __init__(
        self,
        residual: Residual,
        jacobian: Jacobian,
        scale: Sequence[float],
        limits: NewtonLimits = STANDARD_LIMITS,
    ) -> None:
        self.functions, self.limits = (residual, jacobian), limits
        self.scale = np.array([abs(size) or 1.0 for size in scale])
        self.iterations = self.escapes = self.slow = 0
        self.damping = 1.0
        self.last: tuple[Array, Array, float] | None = None

    def residual_at(self, x: Array) -> Array | None:
        """The residual; None where it is undefined or infinite."""
        try:
            values = np.array(self.functions[0](x.tolist()), dtype=float)
        except (ArithmeticError, ValueError):
            return None
        return values if np.isfinite(values).all() else None

    def at(self, x: Array, residual: Array | None = None) -> Point | None:
        """The point x; None where residual or Jacobian is undefined or infinite."""
        values = self.residual_at(x) if residual is None else residual
        if values is None:
            return None
        weight = np.maximum(np.abs(x), self.scale)
        try:
            matrix = as_matrix(self.functions[1](x.tolist()), len(x))
        except (ArithmeticError, ValueError):
            return None
        if not np.isfinite(row_sizes(matrix, weight)).all():
            return None
        factor = factorise(matrix, weight)
        return Point(x, values, matrix, weight, factor, -factor.solution(values))

    def run(self, first: Point) -> Outcome:
        """Search from a point; ``point`` is then the best one."""
        self.point = first
        while self.iterations < self.limits.iterations:
            expect_time()
            p = self.point
            if p.vanishes():
                return self._polished()
            contraction = self._damped_step()
            if contraction is None:
                # if an unknown is 0 relative to its scale, neither its last bit nor the rows show
                # the end
                if p.norm(p.step) <= 4 * EPS and p.explains():
                    return self._polished()
                if not self._escape():
                    return self._stuck()
            elif contraction <= FAST and self.damping == 1.0:
                if (end := self._converge()) is not None:
                    return end
            elif contraction < 0.6 and self.damping == 1.0:
                self.slow += 1
        return self._stuck(Outcome.LIMIT)

    def _advance(self, following: Point) -> None:
        self.point = following
        self.iterations += 1

    def _damped_step(self) -> float | None:
        """Take one damped Newton step. The contraction factor, or None if no length is accepted."""
        p = self.point
        step, norm = p.step, p.norm(p.step)
        if norm == 0.0 or not math.isfinite(norm):
            return None
        damping = 1.0
        # the factor that the previous simplified correction predicts (eq. 3.48)
        if self.last is not None:
            simplified, weight, before = self.last
            change = float((np.abs(simplified - step) / weight).max())
            if change:
                length = float((np.abs(simplified) / weight).max())
                damping = min(
                    1.0, max((before / norm) * (length / change) * self.damping, 10 * SHORTEST)
                )
        while damping >= SHORTEST:
            x = p.x + damping * step
            values = self.residual_at(x)
            if values is None:
                damping /= 2
                continue
            simplified = -p.factor.solution(values)
            ahead = p.norm(simplified)
            if ahead <= (1 - damping / 4) * norm and (following := self.at(x, values)):
                self.last, self.damping = (simplified, p.weight, norm), damping
                self._advance(following)
                return ahead / norm
            deviation = p.norm(simplified - (1 - damping) * step)
            damping = min(0.5 * norm * damping**2 / deviation if deviation else 1.0, damping / 2)
        return None

    def _converge(self) -> Outcome | None:
        """Full steps from a point of fast contraction; None (and the best point kept) if it is
        lost."""
        previous = math.inf
        for _ in range(POLISH):
            p = self.point
            norm = p.norm(p.step)
            if p.vanishes():
                return self._polished()
            lost = bool((np.abs(p.step) <= EPS * np.abs(p.x)).all())  # in the last bits of x
            if lost or stagnates(norm, previous):
                return self._polished() if p.explains() else self._stuck()
            if norm <= FAST * previous < math.inf:
                self.slow = 0
            following = self.at(p.x + p.step)
            if following is None or norm > previous:
                break
            self._advance(following)
            previous = norm
        self.last, self.damping = None, 1.0
        return None

    def _polished(self) -> Outcome:
        """One or two more full steps while they still lower the simplified correction."""
        for _ in range(3):
            p = self.point
            following = self.at(p.x + p.step)
            if following is None or not p.norm(p.factor.solution(following.residual)) < p.norm(
                p.step
            ):
                break
            self._advance(following)
        regular = self.point.factor.rank == self.point.factor.columns and self.slow < SLOW
        return Outcome.CONVERGED if regular else Outcome.SINGULAR_JACOBIAN

    def _escape(self) -> bool:
        """Levenberg–Marquardt steps towards a smaller residual; False if there is none."""
        if self.escapes >= self.limits.escapes:
            return False
        self.escapes += 1
        self.iterations += 1
        x, weight = self.point.x, self.point.weight
        end = scipy_root(*self.functions, x.tolist(), "lm", weight.tolist(), ESCAPED).x
        lower = None if end == tuple(x.tolist()) else self.at(np.array(end))
        if lower is None:
            return False
        self.point, self.last, self.damping = lower, None, 1.0
        return True

    def _stuck(self, otherwise: Outcome = Outcome.STALLED) -> Outcome:
        if self.point.vanishes():
            return self._polished()
        return Outcome.SINGULAR_JACOBIAN if self._degenerate() else otherwise

    def _degenerate(self) -> bool:
        """Whether the rows themselves vanish with x at the end of a short step, as at a multiple
        root. At a minimum of |F| the step is long, or leaves the residual unchanged."""
        p = self.point
        if p.norm(p.step) > DEGENERATE or not p.explains():
            return False
        sizes = row_sizes(p.jacobian, p.weight)
        return bool((np.abs(p.residual) <= VANISHING * sizes).all())


TRUST_REGIONS = ("lm", "hybr")
METHODS = ("hybr", "lm", "least_squares")


class ScipyRoot(NamedTuple):
    """``success`` is scipy's own verdict; ``evaluations`` are those of the residual."""

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
    """``scipy.optimize.root`` (hybr, lm) or ``least_squares`` from ``start`` (n,), with the exact
    Jacobian.

    ``scale`` (n,): typical magnitudes of the unknowns, else scipy takes its own from the Jacobian.
    An undefined residual is nan, at which the methods give up. ``tolerance`` is relative.
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
                found = least_squares(
                    values, start, slopes, xtol=tolerance, ftol=tolerance, gtol=tolerance
                )
            else:
                diagonal = (
                    {} if scale is None else {"diag": [1.0 / abs(s) if s else 1.0 for s in scale]}
                )
                found = root(
                    values, start, jac=slopes, method=method, tol=tolerance, options=diagonal
                )
    except (ArithmeticError, ValueError, np.linalg.LinAlgError):
        return ScipyRoot(tuple(start), False, 0)
    x = tuple(float(v) for v in found.x)
    return ScipyRoot(x, bool(found.success) and bool(np.isfinite(found.x).all()), int(found.nfev))
