"""Two roots that floats cannot tell apart: a fold of the equations, resolved in extended precision.

Near a fold the Jacobian has one small singular value, with null vectors v and u. The bordered system
F(x) + μ u = 0, v·(x − x₀) = t stays regular there and leaves a scalar equation μ(t) = 0 (Lyapunov–Schmidt
reduction; W. Govaerts, *Numerical Methods for Bifurcations of Dynamical Equilibria*, 2000, chapter 3). Its
extreme value says whether there are two roots, one double root, or none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rulesheets.evaluate import Undefined, derivatives
from solver.accuracy.digits import ManyDigits
from solver.accuracy.last_places import half_unit
from solver.accuracy.rule_check import gross
from solver.numerics.elimination import eliminate

MAX_ITERATIONS = 60
NEAR = 1e-2
"""How far from the start a fold may lie, relative to the size of the unknowns."""
SUSPECT = 1e-3
"""Least singular value of the Jacobian, beside the terms of the equations, of a root with a sibling."""


@dataclass(frozen=True, slots=True)
class Fold:
    """``roots``: two, or none. ``double``: the point where the two coincide, as far as the precision tells,
    or as far as the known values can: to half a unit of the last place of each that is no short number."""

    roots: tuple[list[Any], ...] = ()
    double: list[Any] | None = None


def resolve_fold(system: ManyDigits, start: Sequence[float], scale: Sequence[float]) -> Fold | None:
    """The fold near ``start``; None where there is none, or where it cannot be followed.

    Near is measured by the unknowns themselves; failing that by their typical sizes ``scale``: a fold at 0
    is not near to either of its roots beside their own size.
    """
    own = _sizes(start)
    typical = [max(size, s) for size, s in zip(own, scale, strict=True)]
    for sizes in (own, typical) if typical != own else (own,):
        vectors = null_vectors(system, start, sizes)
        if vectors is None:
            continue
        try:
            fold = _Reduction(system, start, *vectors, sizes).resolve()
        except (Undefined, OverflowError, ZeroDivisionError):
            continue
        if fold is not None:
            return fold
    return None


def _sizes(x: Sequence[float]) -> list[float]:
    """Those of the unknowns; that of the largest for one that is next to nothing beside it."""
    largest = max(abs(v) for v in x) or 1.0
    return [abs(v) if abs(v) > 1e-3 * largest else largest for v in x]


def null_vectors(
    system: ManyDigits, x: Sequence[float], sizes: Sequence[float] | None = None
) -> tuple[list[float], list[float]] | None:
    """Null vectors (v, u) of the Jacobian, scaled by the ``sizes`` of the unknowns; None if it is regular."""
    x = [float(v) for v in x]
    sizes = sizes or _sizes(x)
    try:
        jacobian = np.array(system.linearised(x)[0], dtype=float)
        values = {name: float(v) for name, v in {**system.known, **system.point(x)}.items()}
    except (Undefined, OverflowError):
        return None
    with np.errstate(all="ignore"):  # what overflows is refused
        scaled = jacobian * sizes
    rows = np.maximum(np.abs(scaled).max(axis=1), [gross(equation, values) for equation in system.equations])
    if not (np.isfinite(scaled).all() and np.isfinite(rows).all() and rows.all()):
        return None
    left, singular, right = np.linalg.svd(scaled / rows[:, None])
    if singular[-1] > SUSPECT or (len(singular) > 1 and singular[-2] <= SUSPECT * SUSPECT):
        return None
    return right[-1].tolist(), (left[:, -1] * rows).tolist()


class _Reduction:
    """μ(t) along the null direction, by Newton on the bordered system."""

    def __init__(
        self,
        system: ManyDigits,
        start: Sequence[float],
        right: Sequence[float],
        left: Sequence[float],
        sizes: Sequence[float],
    ) -> None:
        mp = system.mp
        self.system, self.mp, self.tiny = system, mp, system.tiny
        self.start = [mp.mpf(v) for v in start]
        self.along = [mp.mpf(v / s) for v, s in zip(right, sizes, strict=True)]
        self.across = [mp.mpf(u) for u in left]
        self.sizes = sizes
        self.x, self.mu = list(self.start), mp.zero

    def resolve(self) -> Fold | None:
        t, curvature = self._extreme()
        if t is None or not curvature or abs(t) > NEAR:
            return None
        height, _ = self.at(t)
        if abs(height) <= self.tiny * abs(curvature) + self._fuzz():
            return Fold(double=list(self.x))
        if height / curvature > 0:
            return Fold()
        reach = self.mp.sqrt(-2 * height / curvature)
        if reach > NEAR:
            return None
        found = [root for side in (-1, 1) if (root := self._root(t + side * reach)) is not None]
        return Fold(tuple(found)) if len(found) == 2 and self._apart(*found) else None

    def at(self, t: Any) -> tuple[Any, Any]:
        """μ and its slope at t; leaves the point on the curve in ``x``."""
        n = len(self.start)
        for _ in range(MAX_ITERATIONS):
            jacobian, residual = self.system.linearised(self.x)
            matrix = [[*row, u] for row, u in zip(jacobian, self.across, strict=True)]
            matrix.append([*self.along, self.mp.zero])
            offset = sum(v * (x - s) for v, x, s in zip(self.along, self.x, self.start, strict=True))
            miss = [f + self.mu * u for f, u in zip(residual, self.across, strict=True)]
            step = eliminate(matrix, [*miss, offset - t], self.tiny)
            if step is None:
                raise ZeroDivisionError
            self.x = [x - d for x, d in zip(self.x, step[:n], strict=True)]
            self.mu -= step[n]
            if all(abs(d) <= self.tiny * s for d, s in zip(step[:n], self.sizes, strict=True)):
                slope = eliminate(matrix, [self.mp.zero] * n + [self.mp.one], self.tiny)
                if slope is None:
                    raise ZeroDivisionError
                return self.mu, slope[n]
        raise ZeroDivisionError

    def _fuzz(self) -> Any:
        """How far μ moves as the known values move by half a unit of their last places."""
        values = {name: float(v) for name, v in self._everything().items()}
        total = self.mp.zero
        jacobian = self.system.linearised(self.x)[0]
        matrix = [[*row, u] for row, u in zip(jacobian, self.across, strict=True)]
        matrix.append([*self.along, self.mp.zero])
        slopes = [derivatives(form, values)[1] for form in self.system.forms]
        for name in self.system.known:
            unit = half_unit(values[name])
            column = [self.mp.mpf(slope.get(name, 0.0)) for slope in slopes]
            if unit and any(column):
                moved = eliminate(matrix, [*column, self.mp.zero], self.tiny)
                total += unit * abs(moved[-1]) if moved else self.mp.zero
        return total

    def _everything(self) -> dict[str, Any]:
        return {**self.system.known, **self.system.point(self.x)}

    def _extreme(self) -> tuple[Any, Any]:
        """Where the slope of μ vanishes, and the curvature there, by the secant method."""
        a, b = self.mp.zero, self.mp.mpf(1e-9)
        at_a, at_b = self.at(a)[1], self.at(b)[1]
        curvature = self.mp.zero
        for _ in range(MAX_ITERATIONS):
            if at_b == at_a:
                return b, curvature
            curvature = (at_b - at_a) / (b - a)
            a, at_a, b = b, at_b, b - at_b / curvature
            if abs(b) > NEAR:
                return None, None
            if abs(b - a) <= self.tiny:
                return b, curvature
            at_b = self.at(b)[1]
        return None, None

    def _root(self, t: Any) -> list[Any] | None:
        """From the estimate of μ(t) = 0 by Newton on the block itself, which is regular there."""
        self.at(t)
        return self.system.newton(self.x)

    def _apart(self, one: list[Any], other: list[Any]) -> bool:
        return any(abs(a - b) > self.tiny * 1000 * s for a, b, s in zip(one, other, self.sizes, strict=True))
