"""Newton's method for F(x) = 0 with an exact Jacobian: damped, from one start, and on arrays, from many.

The damping is the error-oriented one of P. Deuflhard, *Newton Methods for Nonlinear Problems* (2004),
section 3.3.3 (NLEQ-ERR): a step is accepted by the natural monotonicity test, which looks at corrections
and not at residuals, so that neither the units of the rules nor a linear mix of them changes the
iterates. Where the test fails at every length, or the Jacobian loses rank, Levenberg–Marquardt steps
(MINPACK's) lead away. Inside the region of fast contraction full steps are taken until rounding
ends the contraction, so that the last digits are right.

Two scale-free measures tell the end of an iteration. The *backward error* of equation i at x is
|F_i| / Σ_j |J_ij x_j|: the relative change of the unknowns that would explain the residual. The *scaled
step* of unknown j is |dx_j| / w_j with the weight w_j = max(|x_j|, scale_j).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from enum import Enum
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from rulesheets.deadline import expect_time
from solver.numerics.linear_algebra import Array, Factor, as_matrix, factorise, row_sizes
from solver.numerics.tolerances import (
    ARRIVED,
    DEGENERATE,
    EPS,
    ESCAPED,
    FAST,
    NULL,
    ON_LINE,
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
        """Whether the step accounts for the residual: F + J dx is small relative to F, or to the sizes of
        the rules. (If rank is lost at a minimum of |F| it does not.)"""
        left, sizes = np.abs(self.residual + self.jacobian @ self.step), row_sizes(self.jacobian, self.weight)
        return bool((left <= np.maximum(0.5 * np.abs(self.residual), VANISHING * sizes)).all())


SHORTEST = 1e-6
"""The least damping factor."""
POLISH, HALVINGS = 12, 60
"""Full steps to the end of fast contraction, and to show that a slow end is a multiple root."""
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

    ``scale`` (n,) gives typical magnitudes of the unknowns; without it |start|, or 1 for a start at 0.
    The residual may raise ArithmeticError or ValueError, or return nan, outside its domain: steps are
    shortened back into it. Never raises for failing to converge: see the outcome.
    """
    x = np.array(start, dtype=float)
    search = Search(residual, jacobian, start if scale is None else scale, limits)
    with np.errstate(all="ignore"):
        first = search.at(x)
        return NewtonResult(tuple(x.tolist()), Outcome.DOMAIN, 0) if first is None else search.run(first)


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

    def run(self, first: Point) -> NewtonResult:
        self.point = first
        while self.iterations < self.limits.iterations:
            expect_time()
            p = self.point
            if p.vanishes():
                return self._polished()
            contraction = self._damped_step()
            if contraction is None:
                # if an unknown is 0 relative to its scale, neither its last bit nor the rows show the end
                if p.norm(p.step) <= 4 * EPS and p.explains():
                    return self._polished()
                if not self._escape():
                    return self._stuck()
            elif contraction <= FAST and self.damping == 1.0:
                if (result := self._converge()) is not None:
                    return result
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
        if self.last is not None:  # the factor that the previous simplified correction predicts (eq. 3.48)
            simplified, weight, before = self.last
            change = float((np.abs(simplified - step) / weight).max())
            if change:
                length = float((np.abs(simplified) / weight).max())
                damping = min(1.0, max((before / norm) * (length / change) * self.damping, 10 * SHORTEST))
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

    def _converge(self) -> NewtonResult | None:
        """Full steps from a point of fast contraction; None (and the best point kept) if it is lost."""
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

    def _polished(self) -> NewtonResult:
        """One or two more full steps while they still lower the simplified correction."""
        for _ in range(3):
            p = self.point
            following = self.at(p.x + p.step)
            if following is None or not p.norm(p.factor.solution(following.residual)) < p.norm(p.step):
                break
            self._advance(following)
        regular = self.point.factor.rank == self.point.factor.columns and self.slow < SLOW
        return self._result(Outcome.CONVERGED if regular else Outcome.SINGULAR_JACOBIAN)

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

    def _stuck(self, otherwise: Outcome = Outcome.STALLED) -> NewtonResult:
        if self.point.vanishes():
            return self._polished()
        return self._result(Outcome.SINGULAR_JACOBIAN if self._degenerate() else otherwise)

    def _degenerate(self) -> bool:
        """At a multiple root the Newton step is short although it contracts slowly, and full steps lower the
        residual down to rounding: to a quarter at a double one, (1 - 1/m)^m at one of multiplicity m. At a
        minimum of |F| the step is long, or leaves the residual unchanged. At a root at which rounding in F
        keeps the residual up, the Jacobian is the same at both ends."""
        for _ in range(HALVINGS):
            p = self.point
            if p.norm(p.step) > DEGENERATE or not p.explains():
                return False
            sizes = row_sizes(p.jacobian, p.weight)
            if (np.abs(p.residual) <= VANISHING * sizes).all():  # the rows themselves vanish with x
                return True
            following = self.at(p.x + p.step)
            if following is None:
                return False
            if _is_straight(p, following):
                return True
            if not np.abs(following.residual).max() <= 0.5 * np.abs(p.residual).max():
                return False
            self._advance(following)
        return False

    def _result(self, outcome: Outcome) -> NewtonResult:
        return NewtonResult(tuple(self.point.x.tolist()), outcome, self.iterations)


def _is_straight(p: Point, following: Point) -> bool:
    """Whether F is so straight along a short full step that a simple root is near (Newton–Kantorovich):
    |J⁻¹ (J' - J) dx| is far below |dx|. It is |dx| / 2 at a double root, and more at a minimum of
    |F|."""
    norm = p.norm(p.step)
    if norm > STAGNATION or p.factor.rank < p.factor.columns:
        return False
    return p.norm(p.factor.solution(following.jacobian @ p.step - p.jacobian @ p.step)) <= FAST * norm


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
    """``scipy.optimize.root`` (hybr, lm) or ``least_squares`` from ``start`` (n,), with the exact Jacobian.

    ``scale`` (n,): typical magnitudes of the unknowns, else scipy takes its own from the Jacobian. An
    undefined residual is nan, at which the methods give up. ``tolerance`` is relative.
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


# --- many starts at once ---

BatchFunction: TypeAlias = Callable[[Array], Array]

PATIENCE = 12
"""Steps without a gain of a tenth after which a start is abandoned."""
KEPT = 0.1
"""Share of the distance to the end of a range that a step beyond it leaves."""


def _solved(matrices: Array, rhs: Array) -> Array:
    """-A⁻¹ b for each of (k, n, n) and (k, n), nan if a row is 0; if a matrix is singular, all are
    regularised by rounding."""
    usable = (abs(matrices).max(axis=2) > 0.0).all(axis=1)
    matrices = np.where(usable[:, None, None], matrices, np.eye(matrices.shape[1]))
    try:
        found = np.linalg.solve(matrices, -rhs[:, :, None])[:, :, 0]
    except np.linalg.LinAlgError:
        turned = np.swapaxes(matrices, 1, 2)
        normal = turned @ matrices + 1e-12 * np.eye(matrices.shape[1])
        found = np.linalg.solve(normal, turned @ -rhs[:, :, None])[:, :, 0]
    return np.where(usable[:, None], found, np.nan)


def _least_norm(matrices: Array, rhs: Array) -> Array:
    """-A⁺ b for each of (k, m, n) and (k, m); singular values up to a share ``NULL`` of the largest are 0."""
    u, s, v = np.linalg.svd(matrices, full_matrices=False)
    inverse = np.where(s > NULL * s[:, :1], 1.0 / s, 0.0)
    parts: Any = inverse * np.einsum("kmi,km->ki", u, rhs)
    found: Array = -np.einsum("kin,ki->kn", v, np.where(inverse > 0.0, parts, 0.0))
    return found


class Iteration(NamedTuple):
    """``solved`` gives a step; the best of its ``lengths`` is taken, none of ``longest`` sizes of the
    unknowns or more. A step as short as ``arrived`` is the last one; there are at most ``most``."""

    solved: Callable[[Array, Array], Array]
    lengths: tuple[float, ...]
    longest: float
    arrived: float
    most: int


NEWTON = Iteration(_solved, (1.0, 0.3), 10.0, ARRIVED, 80)
GAUSS_NEWTON = Iteration(_least_norm, (1.0, 0.3, 0.05), 2.0, ON_LINE, 60)
"""Steps of least norm: they keep to the point of a curve that is nearest."""


def arrivals(
    residual: BatchFunction,
    jacobian: BatchFunction,
    starts: Array,
    scale: Array,
    by: Iteration = NEWTON,
    ranges: tuple[Array, Array] | None = None,
) -> Array:
    """The ends (m, n) of those ``starts`` (k, n) that reach a zero of F: Rⁿ → Rᵐ, in their order.

    ``residual`` maps (k, n) to (k, m), ``jacobian`` to (k, m, n), both nan outside their domain. ``scale``
    (n,): typical sizes of the unknowns; ``ranges``: their lower and upper ends (n,), which iterates do not
    leave. The ends are neither polished nor made distinct.
    """
    with np.errstate(all="ignore"):
        f = residual(starts)
        place = np.flatnonzero(np.isfinite(f).all(axis=1))
        x, f = starts[place], f[place]
        best, idle = np.full(len(x), np.inf), np.zeros(len(x), dtype=int)
        arrived: list[tuple[int, Array]] = []
        for _ in range(by.most):
            expect_time()
            if not len(x):
                break
            weight = np.maximum(abs(x), scale)
            matrix = jacobian(x) * weight[:, None, :]
            rows = abs(matrix).sum(axis=2)
            rows = np.where(np.isfinite(rows) & (rows > 0.0), rows, np.inf)
            step = by.solved(np.nan_to_num(matrix / rows[:, :, None]), f / rows)
            length = abs(step).max(axis=1)
            step *= np.minimum(1.0, by.longest / np.maximum(length, 1e-300))[:, None]
            trials = np.stack([_inside(x, x + share * (weight * step), ranges) for share in by.lengths])
            values = residual(trials.reshape(-1, x.shape[1])).reshape(*trials.shape[:2], -1)
            norms = abs(values / rows).max(axis=2)
            norms = np.where(np.isfinite(norms), norms, np.inf)
            chosen, each = norms.argmin(axis=0), np.arange(len(x))
            x, f, norm = trials[chosen, each], values[chosen, each], norms[chosen, each]
            near, finite = length <= by.arrived, np.isfinite(norm)
            arrived += zip(place[near & finite].tolist(), x[near & finite], strict=True)
            gained = norm < 0.9 * best
            best, idle = np.where(gained, norm, best), np.where(gained, 0, idle + 1)
            going = ~near & finite & (idle < PATIENCE)
            x, f, place, best, idle = x[going], f[going], place[going], best[going], idle[going]
    ends = [end for _, end in sorted(arrived, key=lambda pair: pair[0])]
    return np.array(ends).reshape(len(ends), len(scale))


def _inside(x: Array, moved: Array, ranges: tuple[Array, Array] | None) -> Array:
    """Where a step beyond the end of a range stops: before it, as the end may not belong to it."""
    if ranges is None:
        return moved
    low, high = ranges
    moved = np.where((moved <= low) & (x > low), low + KEPT * (x - low), moved)
    return np.where((moved >= high) & (x < high), high - KEPT * (high - x), moved)


# -- where to start ---------------------------------------------------------------------------------------

Range = tuple[float, float]

DECADES = 3.0
"""An unbounded unknown is searched from 10⁻³ to 10³ times its size, on both sides."""


def spread(
    ranges: Sequence[Range], sizes: Sequence[float], count: int, offset: int = 0
) -> Iterator[list[float]]:
    """``count`` points that fill the ranges evenly, after the first ``offset``: the k-th at the shares
    k/φ^j, modulo 1, for j = 1 … n, with φ the positive root of φ^(n+1) = φ + 1."""
    n, phi = len(ranges), 2.0
    for _ in range(64):
        phi = (1.0 + phi) ** (1.0 / (n + 1))
    for k in range(offset + 1, offset + count + 1):
        yield [
            place((0.5 + k * phi**-j) % 1.0, *ends, size)
            for j, (ends, size) in enumerate(zip(ranges, sizes, strict=True), 1)
        ]


def place(share: float, low: float, high: float, size: float) -> float:
    """The point of a range at ``share`` in [0, 1): even over a finite range, else over some decades around
    ``size`` from its finite end, or on both sides of 0."""
    if math.isfinite(low) and math.isfinite(high):
        return low + share * (high - low)
    if math.isfinite(low):
        return low + _magnitude(share, size)
    if math.isfinite(high):
        return high - _magnitude(share, size)
    return _magnitude(2 * share - 1, size) if share >= 0.5 else -_magnitude(1 - 2 * share, size)


def _magnitude(share: float, size: float) -> float:
    """From 10⁻³ to 10³ times the size, most of them near it."""
    centred = 2.0 * share - 1.0
    return size * math.pow(10.0, DECADES * centred * abs(centred))
