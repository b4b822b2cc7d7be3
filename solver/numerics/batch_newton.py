"""Damped Newton on many starts at once: which of them end at a root, and where.

One step solves all the linear systems together and tries a few lengths of each step; the one of least
scaled residual is taken. That is cruder than ``newton.py`` and some ten times faster a start: it
serves to find where roots are, not to polish them. Starts that no longer come nearer are dropped.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.deadline import expect_time

Array: TypeAlias = NDArray[np.float64]
BatchFunction: TypeAlias = Callable[[Array], Array]

LENGTHS = (1.0, 0.3)
"""Fractions of the Newton step that are tried."""


@dataclass(frozen=True, slots=True)
class BatchLimits:
    """``near``: scaled step that counts as having arrived. ``patience``: steps without a gain of a tenth."""

    iterations: int = 80
    near: float = 1e-9
    patience: int = 12
    longest: float = 10.0


STANDARD_LIMITS = BatchLimits()


def batch_newton(
    residual: BatchFunction,
    jacobian: BatchFunction,
    starts: Array,
    scale: Array,
    limits: BatchLimits = STANDARD_LIMITS,
) -> Array:
    """The ends (m, n) of those ``starts`` (k, n) that arrive at a root of F: Rⁿ → Rⁿ, in their order.

    ``residual`` maps (k, n) to (k, n), ``jacobian`` to (k, n, n), both nan outside their domain. ``scale``
    (n,): typical sizes of the unknowns. Nothing is polished or made distinct.
    """
    with np.errstate(all="ignore"):
        return _Batch(residual, jacobian, starts, scale, limits).run()


class _Batch:
    def __init__(
        self,
        residual: BatchFunction,
        jacobian: BatchFunction,
        starts: Array,
        scale: Array,
        limits: BatchLimits,
    ) -> None:
        self.residual, self.jacobian, self.scale, self.limits = residual, jacobian, scale, limits
        values = residual(starts)
        usable = np.isfinite(values).all(axis=1)
        self.x, self.f = starts[usable], values[usable]
        self.place = np.flatnonzero(usable)
        self.best = np.full(len(self.x), np.inf)
        self.idle = np.zeros(len(self.x), dtype=int)
        self.arrived: list[tuple[int, Array]] = []

    def run(self) -> Array:
        for _ in range(self.limits.iterations):
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
        near = length <= self.limits.near
        step *= np.minimum(1.0, self.limits.longest / np.maximum(length, 1e-300))[:, None]
        norm = self._follow(weight * step, rows)
        finite = np.isfinite(norm)
        done = near & finite
        self.arrived += list(zip(self.place[done].tolist(), self.x[done], strict=True))
        gained = norm < 0.9 * self.best
        self.idle = np.where(gained, 0, self.idle + 1)
        self.best = np.where(gained, norm, self.best)
        self._keep(~near & finite & (self.idle < self.limits.patience))

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
