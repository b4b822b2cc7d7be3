"""Follow a curve through its turning points: pseudo-arclength continuation with adaptive steps.

H. B. Keller (1977); steps, orientation and the test for bifurcations after E. L. Allgower & K. Georg,
*Introduction to Numerical Continuation Methods* (2003), chapters 6 to 8. The predictor is the tangent, the
corrector Newton's method in the plane across it. Steps are so short that neighbouring tangents are nearly
parallel; where the orientation changes, branches cross, or another branch runs so near that only a shorter
step tells them apart: the step is halved until it does, and the curve ends where it never does.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from rulesheets.deadline import expect_time
from solver.numerics.corrector import OutOfDomain, attempted, crossing, fold, last_inside, stepped, where
from solver.numerics.curve import CurvePoint, Problem


class End(Enum):
    """Why a curve ends; the value says it after ``where``."""

    CLOSED = "the curve is closed"
    BOUNDARY = "a variable reaches the end of its range"
    SINGULAR = "branches meet or cross"
    DOMAIN = "the rules have no value beyond"
    CHANGED = "other rules hold beyond"
    STALLED = "the curve cannot be followed further"
    LIMIT = "its points are too many: a variable may grow without bound"


@dataclass(frozen=True)
class Trace:
    """The points in order, the start first; ``end`` is why there is no further one."""

    points: tuple[CurvePoint, ...]
    end: End


@dataclass(frozen=True, slots=True)
class Steps:
    """Lengths in scaled coordinates. ``turning``: the least cosine of the angle between tangents a step
    apart; ``away``: the largest share of a step by which the corrector may leave its prediction."""

    first: float = 0.02
    longest: float = 0.1
    shortest: float = 1e-9
    turning: float = 0.985
    away: float = 0.15
    most: int = 5_000


STEPS = Steps()
AIM = 0.3
"""Share of the largest turning that a step aims at."""

MEETING, SHOWN = 1e-5, 40
"""Smallest singular value this near to a point where branches meet, rows having the unit size that they reach
along the curve; points that it is measured at."""

HOME = 1e-7
"""Scaled distance from its start at which a curve is closed."""


def follow(
    problem: Problem, first: CurvePoint, home: CurvePoint | None = None, steps: Steps = STEPS
) -> Trace:
    """Follow the curve from ``first`` along its tangent. It closes at ``home`` (None: at ``first``)."""
    return _Walk(problem, first, home or first, steps).run()


class _Walk:
    def __init__(self, problem: Problem, first: CurvePoint, home: CurvePoint, steps: Steps) -> None:
        self.problem, self.home, self.steps = problem, home, steps
        self.points = [first]
        self.regime = problem.these
        self.obstacle = End.STALLED

    def run(self) -> Trace:
        if self.problem.regime(self._nudged(self.points[0])) != self.regime:
            return Trace(tuple(self.points), End.CHANGED)
        length = self.steps.first
        while len(self.points) < self.steps.most:
            expect_time()
            here = self.points[-1]
            there = self._accepted(here, length)
            if there is None:
                length /= 2
                if length < self.steps.shortest:
                    return Trace(tuple(self.points), self._reason())
                continue
            end = self._take(here, there, length)
            if end is not None:
                return Trace(tuple(self.points), end)
            length = self._next(length, here, there)
        return Trace(tuple(self.points), End.LIMIT)

    def _reason(self) -> End:
        """What is in the way. Where branches meet, the Jacobian loses the rank that it has elsewhere."""
        if self.obstacle is not End.STALLED:
            return self.obstacle
        shown = [*self.points[:: len(self.points) // SHOWN + 1], self.points[-1]]
        try:
            found = np.array([self.problem.jacobian(point.z) * self.problem.scale for point in shown])
        except (ArithmeticError, ValueError):
            return End.DOMAIN
        sizes = np.abs(found).max(axis=(0, 2))
        singular = np.linalg.svd(found[-1] / sizes[:, None], compute_uv=False)
        return End.SINGULAR if singular[-1] <= MEETING else End.STALLED

    def _next(self, length: float, here: CurvePoint, there: CurvePoint) -> float:
        """Tangents turn by an angle that grows with the step: its square is 2 (1 - cosine)."""
        turned = max(1.0 - float(here.tangent @ there.tangent), 1e-12)
        factor: float = (AIM * (1.0 - self.steps.turning) / turned) ** 0.5
        return min(self.steps.longest, length * min(1.6, max(0.5, factor)))

    def _accepted(self, here: CurvePoint, length: float) -> CurvePoint | None:
        """The next point, where it is certain to lie on the same branch; else ``obstacle`` says why not."""
        try:
            there = stepped(self.problem, here, length)
        except OutOfDomain:
            self.obstacle = End.DOMAIN
            return None
        self.obstacle = End.STALLED
        if there is None:
            return None
        if float(here.tangent @ there.tangent) < self.steps.turning:
            return None
        moved = (there.z - here.z) / self.problem.scale
        if float(np.linalg.norm(moved - length * here.tangent)) > self.steps.away * length:
            return None
        if there.orientation != here.orientation:
            self.obstacle = End.SINGULAR
            return None
        return there

    def _take(self, here: CurvePoint, there: CurvePoint, length: float) -> End | None:
        """Take in the points up to ``there``; why the curve ends before it, if it does."""
        last, end = there, None
        out = self._boundary(here, there, length)
        if out is not None:
            last, end = out, End.BOUNDARY
        if self._changes(there):
            same = last_inside(self.problem, here, length, lambda p: self.problem.regime(p.z) == self.regime)
            edge = attempted(self.problem, here, same)
            if edge is None or end is None or edge.arc < last.arc:
                last, end = edge or here, End.CHANGED
        home = self._homecoming(here, length)
        if home is not None and (end is None or home.arc <= last.arc):
            last, end = home, End.CLOSED
        if last.arc > here.arc:
            self._append(here, last)
        return end

    def _append(self, here: CurvePoint, last: CurvePoint) -> None:
        """The fold between two neighbours, if there is one, and the second of them."""
        if not here.fold and here.tangent[-1] * last.tangent[-1] < 0.0:
            turning = fold(self.problem, here, self._reach(here, last))
            if turning is not None:
                self.points.append(turning)
                chord = float(np.linalg.norm((last.z - turning.z) / self.problem.scale))
                last = replace(last, arc=turning.arc + chord)
        self.points.append(last)

    def _reach(self, here: CurvePoint, there: CurvePoint) -> float:
        return float((there.z - here.z) / self.problem.scale @ here.tangent)

    def _boundary(self, here: CurvePoint, there: CurvePoint, length: float) -> CurvePoint | None:
        """Where the first coordinate reaches the end of its range; None where all stay inside."""
        found: list[CurvePoint] = []
        for place, bound in self.problem.passed(there.z):
            if place == len(there.z) - 1:
                point = crossing(self.problem, here, length, bound)
            else:
                point = where(self.problem, here, length, _beyond(place, bound), 4e-16 * abs(bound))
            found.append(point or here)
        return min(found, key=lambda point: point.arc, default=None)

    def _changes(self, point: CurvePoint) -> bool:
        """Whether other equations hold at the point, and beyond it too: not at one point alone."""
        if self.problem.regime(point.z) == self.regime:
            return False
        return self.problem.regime(self._nudged(point)) != self.regime

    def _nudged(self, point: CurvePoint) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
        return point.z + 1e-3 * self.steps.first * self.problem.scale * point.tangent

    def _homecoming(self, here: CurvePoint, length: float) -> CurvePoint | None:
        """The start, whole turns of angles later, where the curve closes within this step."""
        if here.arc - self.home.arc < 3 * self.steps.first:
            return None
        apart = self.problem.apart(self.home.z, here.z)
        ahead = float(apart @ here.tangent)
        if not 0.0 < ahead <= length or float(here.tangent @ self.home.tangent) < 0.9:
            return None
        point = attempted(self.problem, here, ahead)
        if point is None:
            return None
        size = 1.0 + float(np.abs(point.z / self.problem.scale).max())
        if float(np.linalg.norm(self.problem.apart(point.z, self.home.z))) > HOME * size:
            return None
        return replace(point, z=self.problem.turned(self.home.z, here.z))


def _beyond(place: int, bound: float) -> Callable[[CurvePoint], float]:
    return lambda point: float(point.z[place]) - bound
