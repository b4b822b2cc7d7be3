"""Searches from many starts: on arrays, onto curves of solutions, and one after another, in a fixed order."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.deadline import expect_time
from solver.numerics.newton import STANDARD_LIMITS, Jacobian, NewtonLimits, NewtonResult, Residual, newton
from solver.numerics.termination import Outcome
from solver.numerics.tolerances import ARRIVED, NULL, ON_LINE, SAME_ROOT, SAME_SINGULAR_ROOT

Array: TypeAlias = NDArray[np.float64]
BatchFunction: TypeAlias = Callable[[Array], Array]

LENGTHS = (1.0, 0.3)
"""Fractions of the Newton step that are tried."""


BATCH, PROJECTED = 80, 60
"""Steps of a search at most, for a point and onto a curve."""
PATIENCE = 12
"""Steps without a gain of a tenth after which a start is given up."""
LONGEST, LONGEST_PROJECTED = 10.0, 2.0
"""Sizes of the unknowns beyond which a step is cut."""


def batch_newton(
    residual: BatchFunction,
    jacobian: BatchFunction,
    starts: Array,
    scale: Array,
) -> Array:
    """The ends (m, n) of those ``starts`` (k, n) that arrive at a root of F: Rⁿ → Rⁿ, in their order.

    ``residual`` maps (k, n) to (k, n), ``jacobian`` to (k, n, n), both nan outside their domain. ``scale``
    (n,): typical sizes of the unknowns. Nothing is polished or made distinct.
    """
    with np.errstate(all="ignore"):
        return _Batch(residual, jacobian, starts, scale).run()


class _Batch:
    def __init__(
        self,
        residual: BatchFunction,
        jacobian: BatchFunction,
        starts: Array,
        scale: Array,
    ) -> None:
        self.residual, self.jacobian, self.scale = residual, jacobian, scale
        values = residual(starts)
        usable = np.isfinite(values).all(axis=1)
        self.x, self.f = starts[usable], values[usable]
        self.place = np.flatnonzero(usable)
        self.best = np.full(len(self.x), np.inf)
        self.idle = np.zeros(len(self.x), dtype=int)
        self.arrived: list[tuple[int, Array]] = []

    def run(self) -> Array:
        for _ in range(BATCH):
            expect_time()
            if not len(self.x):
                break
            self._step()
        ends = [x for _, x in sorted(self.arrived, key=lambda pair: pair[0])]
        return np.array(ends).reshape(len(ends), len(self.scale))

    def _step(self) -> None:
        weight = np.maximum(abs(self.x), self.scale)
        matrix = self.jacobian(self.x) * weight[:, None, :]
        rows = abs(matrix).sum(axis=2)
        usable = np.isfinite(rows).all(axis=1) & (rows > 0).all(axis=1)
        if not usable.all():
            self._keep(usable)
            weight, matrix, rows = weight[usable], matrix[usable], rows[usable]
        if not len(self.x):
            return
        scaled = self.f / rows
        step = _solved(matrix / rows[:, :, None], -scaled)
        length = abs(step).max(axis=1)
        near = length <= ARRIVED
        step *= np.minimum(1.0, LONGEST / np.maximum(length, 1e-300))[:, None]
        norm = self._follow(weight * step, rows)
        finite = np.isfinite(norm)
        done = near & finite
        self.arrived += list(zip(self.place[done].tolist(), self.x[done], strict=True))
        gained = norm < 0.9 * self.best
        self.idle = np.where(gained, 0, self.idle + 1)
        self.best = np.where(gained, norm, self.best)
        self._keep(~near & finite & (self.idle < PATIENCE))

    def _follow(self, step: Array, rows: Array) -> Array:
        """Take the best of the lengths; the scaled residuals (k,) there, infinite where none is defined."""
        trials = np.stack([self.x + length * step for length in LENGTHS])
        values = self.residual(trials.reshape(-1, step.shape[1])).reshape(trials.shape)
        norms = abs(values / rows).max(axis=2)
        norms = np.where(np.isfinite(norms), norms, np.inf)
        chosen = norms.argmin(axis=0)
        each = np.arange(len(self.x))
        self.x, self.f = trials[chosen, each], values[chosen, each]
        norm: Array = norms[chosen, each]
        return norm

    def _keep(self, chosen: NDArray[np.bool_]) -> None:
        self.x, self.f, self.place = self.x[chosen], self.f[chosen], self.place[chosen]
        self.best, self.idle = self.best[chosen], self.idle[chosen]


def _solved(matrices: Array, rhs: Array) -> Array:
    """Solutions of (k, n, n) systems; where one is singular, all are regularised by rounding."""
    try:
        return np.asarray(np.linalg.solve(matrices, rhs[:, :, None])[:, :, 0], dtype=float)
    except np.linalg.LinAlgError:
        n = matrices.shape[-1]
        normal = np.swapaxes(matrices, 1, 2) @ matrices + 1e-12 * np.eye(n)
        solved = np.linalg.solve(normal, np.swapaxes(matrices, 1, 2) @ rhs[:, :, None])[:, :, 0]
        return np.asarray(solved, dtype=float)


PROJECTED_LENGTHS = (1.0, 0.3, 0.05)
"""Fractions of a step that are tried."""
KEPT = 0.1
"""Share of the distance to the end of a range that a step beyond it leaves."""


def project(
    residual: BatchFunction,
    jacobian: BatchFunction,
    starts: Array,
    scale: Array,
    low: Array,
    high: Array,
) -> Array:
    """The ends (m, n) of those ``starts`` (k, n) that arrive at a zero of F: Rⁿ → Rᵐ, in no certain order.

    ``residual`` maps (k, n) to (k, m), ``jacobian`` to (k, m, n), both nan outside their domain. ``scale``
    (n,): typical sizes of the unknowns; ``low`` and ``high`` (n,): their ranges, in which the way stays.
    """
    with np.errstate(all="ignore"):
        x = starts[np.isfinite(residual(starts)).all(axis=1)]
        best, idle = np.full(len(x), np.inf), np.zeros(len(x), dtype=int)
        arrived: list[Array] = []
        for _ in range(PROJECTED):
            expect_time()
            if not len(x):
                break
            x, norm, length = _step(residual, jacobian, x, scale, low, high)
            finite = np.isfinite(norm) & np.isfinite(x).all(axis=1)
            done = finite & (length <= ON_LINE)
            arrived.extend(x[done])
            gained = norm < 0.9 * best
            idle, best = np.where(gained, 0, idle + 1), np.where(gained, norm, best)
            going = finite & ~done & (idle < PATIENCE)
            x, best, idle = x[going], best[going], idle[going]
    return np.array(arrived).reshape(len(arrived), len(scale))


def _step(
    residual: BatchFunction,
    jacobian: BatchFunction,
    x: Array,
    scale: Array,
    low: Array,
    high: Array,
) -> tuple[Array, Array, Array]:
    """The points after a step, the scaled residuals there, infinite where none is defined, and its length."""
    weight = np.maximum(abs(x), scale)
    matrix = jacobian(x) * weight[:, None, :]
    rows = abs(matrix).sum(axis=2)
    rows = np.where(np.isfinite(rows) & (rows > 0.0), rows, np.inf)
    step = _least_norm(np.nan_to_num(matrix / rows[:, :, None]), residual(x) / rows)
    length = abs(step).max(axis=1)
    step *= np.minimum(1.0, LONGEST_PROJECTED / np.maximum(length, 1e-300))[:, None]
    trials = np.stack([_within(x, x + share * weight * step, low, high) for share in PROJECTED_LENGTHS])
    values = residual(trials.reshape(-1, x.shape[1])).reshape(len(PROJECTED_LENGTHS), len(x), -1)
    norms = abs(values / rows).max(axis=2)
    norms = np.where(np.isfinite(norms), norms, np.inf)
    chosen, each = norms.argmin(axis=0), np.arange(len(x))
    return trials[chosen, each], norms[chosen, each], length


def _least_norm(matrices: Array, rhs: Array) -> Array:
    """-A⁺ b for each of (k, m, n) and (k, m); singular values up to a share ``NULL`` of the largest are 0."""
    u, s, v = np.linalg.svd(matrices, full_matrices=False)
    inverse = np.where(s > NULL * s[:, :1], 1.0 / s, 0.0)
    parts: Any = inverse * np.einsum("kmi,km->ki", u, rhs)
    found: Array = -np.einsum("kin,ki->kn", v, np.where(inverse > 0.0, parts, 0.0))
    return found


def _within(x: Array, moved: Array, low: Array, high: Array) -> Array:
    """Where a step beyond the end of a range stops: before it, for the end may not belong to the range."""
    moved = np.where((moved <= low) & (x > low), low + KEPT * (x - low), moved)
    return np.where((moved >= high) & (x < high), high - KEPT * (high - x), moved)


Range = tuple[float, float]

DECADES = 3.0
"""An unbounded unknown is sought from 10⁻³ to 10³ times its scale, on both sides."""
SINGULAR_LIMIT = 4
"""Singular ends that mostly lie on one curve of solutions, of which there is no end."""


class MultiStart(NamedTuple):
    """``roots`` in the order in which they were reached (that of the guess first), each inside the ranges.

    ``best`` is the end with the least residual among the failures, None where nothing failed.
    """

    roots: tuple[NewtonResult, ...]
    best: NewtonResult | None


def multistart(
    residual: Residual,
    jacobian: Jacobian,
    guess: Sequence[float],
    ranges: Sequence[Range] | None = None,
    scale: Sequence[float] | None = None,
    count: int = 32,
    limits: NewtonLimits = STANDARD_LIMITS,
) -> MultiStart:
    """Newton from ``guess`` (n,) and from ``count`` further points of ``ranges`` (n pairs, ± inf allowed).

    ``scale`` (n,): typical magnitudes, else |guess| or 1. Roots outside the ranges are dropped. ``limits``
    are those of every start but the guess, which is worth a longer search.
    """
    within = ranges if ranges is not None else [(-math.inf, math.inf)] * len(guess)
    size = [abs(s) or 1.0 for s in (scale if scale is not None else guess)]
    roots: list[NewtonResult] = []
    best: NewtonResult | None = None
    for number, start in enumerate(starting_points(guess, within, size, count)):
        expect_time()
        result = newton(residual, jacobian, start, size, limits if number else STANDARD_LIMITS)
        if not result.outcome.found:
            best = _lower(best, result)
        elif _inside(result.x, within, size) and not any(same_root(result, root, size) for root in roots):
            roots.append(result)
        if sum(root.outcome is Outcome.SINGULAR_JACOBIAN for root in roots) >= SINGULAR_LIMIT:
            break
    return MultiStart(tuple(roots), best)


def same_root(one: NewtonResult, other: NewtonResult, scale: Sequence[float]) -> bool:
    """Whether two ends are one root: equal to 9 digits, or to 4 where a multiple root blurs them."""
    singular = Outcome.SINGULAR_JACOBIAN in (one.outcome, other.outcome)
    tolerance = SAME_SINGULAR_ROOT if singular else SAME_ROOT
    return all(
        abs(a - b) <= tolerance * max(abs(a), abs(b), 1e-6 * s)
        for a, b, s in zip(one.x, other.x, scale, strict=True)
    )


def _lower(best: NewtonResult | None, result: NewtonResult) -> NewtonResult:
    return result if best is None or _size(result) < _size(best) else best


def _size(result: NewtonResult) -> float:
    return max(map(abs, result.residual), default=math.inf)


def _inside(x: Sequence[float], ranges: Sequence[Range], scale: Sequence[float]) -> bool:
    """Within every range, give or take the last bits."""
    slack = [1e-14 * max(abs(v), 1e-3 * s) for v, s in zip(x, scale, strict=True)]
    return all(low - d <= v <= high + d for v, (low, high), d in zip(x, ranges, slack, strict=True))


# -- where to start ---------------------------------------------------------------------------------------


def starting_points(
    guess: Sequence[float], ranges: Sequence[Range], scale: Sequence[float], count: int
) -> Iterator[list[float]]:
    """The guess, moved into the ranges, and ``count`` points that fill them."""
    yield [min(max(g, low), high) for g, (low, high) in zip(guess, ranges, strict=True)]
    for shares in low_discrepancy(len(guess), count):
        yield [place(u, *bounds, s) for u, bounds, s in zip(shares, ranges, scale, strict=True)]


def low_discrepancy(n: int, count: int, offset: int = 0) -> Iterator[list[float]]:
    """``count`` points of [0, 1)ⁿ that fill it evenly, after the first ``offset``."""
    ratios = _ratios(n)
    for k in range(offset + 1, offset + count + 1):
        yield [(0.5 + k * ratio) % 1.0 for ratio in ratios]


def _ratios(n: int) -> list[float]:
    """1/φ^j for j = 1 … n, with φ the positive root of φ^(n+1) = φ + 1."""
    phi = 2.0
    for _ in range(64):
        phi = (1.0 + phi) ** (1.0 / (n + 1))
    return [phi**-j for j in range(1, n + 1)]


def place(share: float, low: float, high: float, scale: float) -> float:
    """The point of a range at ``share`` in [0, 1): even over a finite range, or over its decades where it
    spans more than three; over the decades around ``scale`` from the finite end of an infinite one."""
    if math.isfinite(low) and math.isfinite(high):
        if low > 0 and high > 1e3 * low:
            return math.exp(math.log(low) + share * (math.log(high) - math.log(low)))
        if high < 0 and low < 1e3 * high:
            return -place(1.0 - share, -high, -low, scale)
        return low + share * (high - low)
    if math.isfinite(low):
        return low + _magnitude(share, scale)
    if math.isfinite(high):
        return high - _magnitude(share, scale)
    return _magnitude(2 * share - 1, scale) if share >= 0.5 else -_magnitude(1 - 2 * share, scale)


def _magnitude(share: float, scale: float) -> float:
    return float(scale * 10.0 ** (DECADES * (2.0 * share - 1.0)))
