"""Follow the curve F(x) = (1 - t) F(x₀) from the start at t = 0 to a root at t = 1.

The Newton homotopy of H. B. Keller (*Global homotopies and Newton methods*, 1978): any start solves the
easy system F(x) - F(x₀) = 0, and the curve leads from it to F(x) = 0, over folds where t turns back. It is
followed by arc length (E. Allgower and K. Georg, *Introduction to Numerical Continuation Methods*, 2003,
chapters 3 and 6): a step along the tangent of (x, t), corrected by Gauss–Newton steps of least length. A
local minimum of |F|, where every method of descent ends, is an ordinary point of the curve.

Where t passes 1, damped Newton takes over, and decides.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from rulesheets.deadline import expect_time
from solver.numerics.factor import row_sizes
from solver.numerics.newton import STANDARD_LIMITS, NewtonLimits, NewtonResult, newton
from solver.numerics.outcome import Outcome
from solver.numerics.system import Jacobian, Point, Residual, System

if TYPE_CHECKING:
    from numpy.typing import NDArray

CORRECTIONS = 4
CLOSE = 1e-6
"""A point is on the curve when its correction is as short as this beside the step."""


@dataclass(frozen=True, slots=True)
class HomotopyLimits:
    """``steps`` tried, lengths relative to the size of the unknowns; the curve is left beyond ``reach``."""

    steps: int = 240
    first: float = 0.1
    longest: float = 2.0
    shortest: float = 1e-7
    reach: float = 1e9
    newton: NewtonLimits = STANDARD_LIMITS


STANDARD_HOMOTOPY = HomotopyLimits()


def follow_homotopy(
    residual: Residual,
    jacobian: Jacobian,
    start: Sequence[float],
    scale: Sequence[float],
    limits: HomotopyLimits = STANDARD_HOMOTOPY,
    forward: bool = True,
) -> NewtonResult:
    """Search a root of F: Rⁿ → Rⁿ along the curve through ``start`` (n,).

    ``scale`` (n,) gives typical magnitudes of the unknowns. ``forward``: t grows at first; else the curve is
    taken the other way, where a fold may turn it to t = 1 all the same. Never raises for failing to arrive:
    the outcome says how it ended, and the iterations count the steps along the curve too.
    """
    system = System(residual, jacobian, [abs(s) or 1.0 for s in scale])
    first = system.point([float(v) for v in start])
    if first is None:
        return NewtonResult(tuple(start), tuple(system.residual_at(list(start)) or ()), Outcome.DOMAIN, 0)
    import numpy as np

    with np.errstate(all="ignore"):  # what overflows is refused as not finite
        return _Curve(system, first, limits, forward).run(residual, jacobian)


class _Curve:
    """Points (x, t) of the curve; directions are in unknowns over their weights, and t."""

    def __init__(self, system: System, start: Point, limits: HomotopyLimits, forward: bool) -> None:
        import numpy as np

        self.system, self.limits = system, limits
        self.point, self.t = start, 0.0
        self.rows = np.array([size or 1.0 for size in row_sizes(start.jacobian, start.weight)])
        self.target = np.asarray(start.residual) / self.rows
        self.direction = np.zeros(len(start.x) + 1)
        self.direction[-1] = 1.0 if forward else -1.0

    def run(self, residual: Residual, jacobian: Jacobian) -> NewtonResult:
        length, used = self.limits.first, 0
        while used < self.limits.steps and length >= self.limits.shortest:
            expect_time()
            used += 1
            following = self._step(length)
            if following is None:
                length /= 4
                continue
            point, t, quick = following
            if self.t < 1.0 <= t:
                found = self._arrive(point, t, residual, jacobian)
                if found.outcome.found:
                    return _counting(found, used)
            if self._astray(point, t):
                break
            self.point, self.t = point, t
            length = min(2 * length, self.limits.longest) if quick else length
        x = self.point
        return NewtonResult(tuple(x.x), tuple(x.residual), Outcome.LIMIT, used, x.factor.condition())

    def _step(self, length: float) -> tuple[Point, float, bool] | None:
        """The point of the curve a length ahead, and whether few corrections led to it."""
        import numpy as np

        tangent = self._tangent()
        if tangent is None:
            return None
        weight = np.asarray(self.point.weight)
        x = np.asarray(self.point.x) + length * weight * tangent[:-1]
        t = self.t + length * float(tangent[-1])
        previous = math.inf
        for turn in range(CORRECTIONS):
            point = self.system.point(x.tolist())
            if point is None:
                return None
            change = self._correction(point, t, weight)
            size = math.inf if change is None else float(np.abs(change).max())
            if change is None or not size <= 0.5 * previous or size > length:
                return None
            x, t = x + weight * change[:-1], t + float(change[-1])
            if size <= CLOSE * max(length, 1e-3):
                landed = self.system.point(x.tolist())
                if landed is None:
                    return None
                self.direction = tangent
                return landed, t, turn < 3
            previous = size
        return None

    def _matrix(self, point: Point, weight: NDArray[Any]) -> NDArray[Any]:
        """Derivatives (n, n + 1) of the scaled equations by the scaled unknowns and t."""
        import numpy as np

        jacobian = point.jacobian.toarray() if hasattr(point.jacobian, "toarray") else point.jacobian
        scaled = np.asarray(jacobian, dtype=float) * weight / self.rows[:, None]
        return np.column_stack([scaled, self.target])

    def _tangent(self) -> NDArray[Any] | None:
        """The unit tangent, on in the direction of the last one."""
        import numpy as np

        matrix = self._matrix(self.point, np.asarray(self.point.weight))
        if not np.isfinite(matrix).all():
            return None
        _, singular, right = np.linalg.svd(matrix)
        if not singular[-1] > 1e-13 * singular[0]:
            return None
        ahead: NDArray[Any] = right[-1]
        return ahead if float(ahead @ self.direction) >= 0.0 else -ahead

    def _correction(self, point: Point, t: float, weight: NDArray[Any]) -> NDArray[Any] | None:
        """The shortest change of (x, t) that leads back to the curve, to first order."""
        import numpy as np

        matrix = self._matrix(point, weight)
        miss = np.asarray(point.residual) / self.rows - (1.0 - t) * self.target
        if not (np.isfinite(matrix).all() and np.isfinite(miss).all()):
            return None
        change: NDArray[Any] = -np.linalg.lstsq(matrix, miss, rcond=None)[0]
        return change if np.isfinite(change).all() else None

    def _astray(self, point: Point, t: float) -> bool:
        far = any(abs(v) > self.limits.reach * s for v, s in zip(point.x, self.system.scale, strict=True))
        return far or abs(t) > 1e3

    def _arrive(self, point: Point, t: float, residual: Residual, jacobian: Jacobian) -> NewtonResult:
        """Newton from where the chord between the last two points meets t = 1."""
        share = (1.0 - self.t) / (t - self.t)
        x = [a + share * (b - a) for a, b in zip(self.point.x, point.x, strict=True)]
        return newton(residual, jacobian, x, self.system.scale, self.limits.newton)


def _counting(found: NewtonResult, steps: int) -> NewtonResult:
    iterations = found.iterations + steps
    return NewtonResult(found.x, found.residual, found.outcome, iterations, found.condition)
