"""Searches from many starts at once: where to start, Newton's method on arrays, and steps onto a curve."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.deadline import expect_time
from solver.numerics.tolerances import ARRIVED, NULL, ON_LINE

Array: TypeAlias = NDArray[np.float64]
BatchFunction: TypeAlias = Callable[[Array], Array]

PATIENCE = 12
"""Steps without a gain of a tenth after which a start is given up."""
KEPT = 0.1
"""Share of the distance to the end of a range that a step beyond it leaves."""


def _solved(matrices: Array, rhs: Array) -> Array:
    """-A⁻¹ b for each of (k, n, n) and (k, n), nan where a row is 0; where a matrix is singular, all are
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
    """``solved`` gives a step; of its ``lengths`` the best is taken, none ``longest`` sizes of the unknowns
    or more. A step as short as ``arrived`` is the last one; there are ``most`` at the most."""

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
    """The ends (m, n) of those ``starts`` (k, n) that arrive at a zero of F: Rⁿ → Rᵐ, in their order.

    ``residual`` maps (k, n) to (k, m), ``jacobian`` to (k, m, n), both nan outside their domain. ``scale``
    (n,): typical sizes of the unknowns; ``ranges``: their lower and upper ends (n,), between which the way
    stays. Nothing is polished or made distinct.
    """
    with np.errstate(all="ignore"):
        return _Batch(residual, jacobian, starts, scale, by, ranges).run()


class _Batch:
    """The starts that are still under way: points ``x`` and residuals ``f``, (k, n) and (k, m)."""

    def __init__(
        self,
        residual: BatchFunction,
        jacobian: BatchFunction,
        starts: Array,
        scale: Array,
        by: Iteration,
        ranges: tuple[Array, Array] | None,
    ) -> None:
        self.residual, self.jacobian, self.scale = residual, jacobian, scale
        self.by, self.ranges = by, ranges
        values = residual(starts)
        self.place = np.flatnonzero(np.isfinite(values).all(axis=1))
        self.x, self.f = starts[self.place], values[self.place]
        self.best = np.full(len(self.x), np.inf)
        self.idle = np.zeros(len(self.x), dtype=int)
        self.arrived: list[tuple[int, Array]] = []

    def run(self) -> Array:
        for _ in range(self.by.most):
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
        rows = np.where(np.isfinite(rows) & (rows > 0.0), rows, np.inf)
        step = self.by.solved(np.nan_to_num(matrix / rows[:, :, None]), self.f / rows)
        length = abs(step).max(axis=1)
        step *= np.minimum(1.0, self.by.longest / np.maximum(length, 1e-300))[:, None]
        norm = self._follow(weight * step, rows)
        near, finite = length <= self.by.arrived, np.isfinite(norm)
        done = near & finite
        self.arrived += list(zip(self.place[done].tolist(), self.x[done], strict=True))
        gained = norm < 0.9 * self.best
        self.idle = np.where(gained, 0, self.idle + 1)
        self.best = np.where(gained, norm, self.best)
        going = ~near & finite & (self.idle < PATIENCE)
        self.x, self.f, self.place = self.x[going], self.f[going], self.place[going]
        self.best, self.idle = self.best[going], self.idle[going]

    def _follow(self, step: Array, rows: Array) -> Array:
        """Take the best of the lengths; the scaled residuals (k,) there, infinite where none is defined."""
        trials = np.stack([self._inside(self.x + length * step) for length in self.by.lengths])
        values = self.residual(trials.reshape(-1, step.shape[1])).reshape(*trials.shape[:2], -1)
        norms = abs(values / rows).max(axis=2)
        norms = np.where(np.isfinite(norms), norms, np.inf)
        chosen, each = norms.argmin(axis=0), np.arange(len(self.x))
        self.x, self.f = trials[chosen, each], values[chosen, each]
        norm: Array = norms[chosen, each]
        return norm

    def _inside(self, moved: Array) -> Array:
        """Where a step beyond the end of a range stops: before it, as the end may not belong to it."""
        if self.ranges is None:
            return moved
        low, high = self.ranges
        moved = np.where((moved <= low) & (self.x > low), low + KEPT * (self.x - low), moved)
        return np.where((moved >= high) & (self.x < high), high - KEPT * (high - self.x), moved)


# -- where to start ---------------------------------------------------------------------------------------

Range = tuple[float, float]

DECADES = 3.0
"""An unbounded unknown is sought from 10⁻³ to 10³ times its size, on both sides."""


def starting_points(
    guess: Sequence[float], ranges: Sequence[Range], sizes: Sequence[float], count: int
) -> Iterator[list[float]]:
    """The guess, moved into the ranges, and ``count`` points that fill them."""
    yield [min(max(g, low), high) for g, (low, high) in zip(guess, ranges, strict=True)]
    yield from spread(ranges, sizes, count)


def spread(
    ranges: Sequence[Range], sizes: Sequence[float], count: int, offset: int = 0
) -> Iterator[list[float]]:
    """``count`` points that fill the ranges evenly, after the first ``offset``."""
    for shares in low_discrepancy(len(ranges), count, offset):
        yield [place(u, *ends, size) for u, ends, size in zip(shares, ranges, sizes, strict=True)]


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
