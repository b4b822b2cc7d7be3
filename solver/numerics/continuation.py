"""Follow a curve through its turning points: pseudo-arclength continuation with adaptive steps.

H. B. Keller (1977); steps, orientation and the test for bifurcations after E. L. Allgower & K.
Georg, *Introduction to Numerical Continuation Methods* (2003), chapters 6 to 8. The predictor is
the tangent, the corrector Newton's method in the plane across it. Steps are so short that
neighbouring tangents are nearly parallel. A change of orientation means that branches cross, or
that another branch is so close that only a shorter step separates them: the step is halved until it
does, and the curve ends if it never does.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple

import numpy as np

from rulesheets.deadline import expect_time
from solver.numerics.linear_algebra import Array, equilibrated
from solver.numerics.tolerances import EPS, FLAT_TANGENT, HOME, MEETING, ON_CURVE, TURNING


@dataclass(frozen=True)
class Problem:
    """``residual`` (n,) and ``jacobian`` (n, n + 1) of z; both may raise ArithmeticError or
    ValueError outside their domain. ``regime`` tells which equations hold at z, ``these`` that they
    are the ones of this problem: the curve is followed as long as both agree.

    ``scale`` (n + 1,) are the magnitudes in which lengths are measured, ``turn`` (n + 1,) the
    periods of angles (infinite for others), ``low`` and ``high`` (n + 1,) the ranges.
    """

    residual: Callable[[Array], Array]
    jacobian: Callable[[Array], Array]
    scale: Array
    turn: Array
    low: Array
    high: Array
    regime: Callable[[Array], Hashable] = field(default=lambda z: None)
    these: Hashable = None

    def passed(self, z: Array) -> list[tuple[int, float]]:
        """The coordinates that lie beyond an end of their range by more than rounding, each with
        that end."""
        slack = 1e-13 * (np.abs(z) + self.scale)
        below, above = z < self.low - slack, z > self.high + slack
        ends = np.where(below, self.low, self.high)
        return [(int(j), float(ends[j])) for j in np.flatnonzero(below | above)]

    def turned(self, there: Array, here: Array) -> Array:
        """``there`` with its angles moved by whole turns as near to ``here`` as possible."""
        finite = np.isfinite(self.turn)
        whole = np.where(finite, self.turn, 1.0)
        return np.where(finite, there - whole * np.round((there - here) / whole), there)

    def apart(self, there: Array, here: Array) -> Array:
        """The scaled difference, angles less their whole turns."""
        return np.asarray((self.turned(there, here) - here) / self.scale)

    def length(self, move: Array) -> float:
        return float(np.linalg.norm(move / self.scale))


class CurvePoint(NamedTuple):
    """A point of the curve: ``z`` (n + 1,), unit ``tangent`` in scaled coordinates, ``arc`` length
    from the start, the sign of ``orientation`` (it changes at a bifurcation). ``fold``: the
    parameter turns here."""

    z: Array
    tangent: Array
    arc: float
    orientation: int
    fold: bool = False


def point_at(problem: Problem, z: Array, along: Array, arc: float = 0.0) -> CurvePoint | None:
    """The point at ``z`` with its tangent to the side of ``along``; None where it has no single
    tangent.

    The orientation is the sign of the determinant of the Jacobian bordered by the tangent (E. L.
    Allgower & K. Georg, *Introduction to Numerical Continuation Methods*, 2003, chapters 2 and 8).
    """
    try:
        matrix, _ = equilibrated(problem.jacobian(z), problem.scale)
    except (ArithmeticError, ValueError):
        return None
    tangent = np.ones(1)
    if len(matrix):
        _, singular, right = np.linalg.svd(matrix)
        if singular[-1] <= FLAT_TANGENT * singular[0]:
            return None
        tangent = np.asarray(right[-1], dtype=np.float64)
    if tangent @ along < 0:
        tangent = -tangent
    sign, _ = np.linalg.slogdet(np.vstack([matrix, tangent]))
    return CurvePoint(z, tangent, arc, int(sign))


def start(problem: Problem, z: Array) -> CurvePoint | None:
    """The point of the curve at ``z``, directed so that the parameter grows."""
    point = point_at(problem, z, np.eye(len(z))[-1])
    return point and point._replace(fold=bool(abs(point.tangent[-1]) <= TURNING))


CORRECTIONS = 8
CONTRACTION = 0.3
"""Factor by which each correction has to shrink: a slower one may lead to another branch."""

ROUNDS = 60


class OutOfDomain(ArithmeticError):
    """The equations have no value where a step leads."""


def stepped(problem: Problem, here: CurvePoint, length: float) -> CurvePoint | None:
    """The point in the plane ``length`` ahead across the tangent, by Newton's method from the
    tangent's end.

    (H. B. Keller, "Numerical solution of bifurcation and nonlinear eigenvalue problems", 1977.)
    None where the method does not contract, or the point has no tangent. Raises OutOfDomain.
    """
    ahead = here.z + length * problem.scale * here.tangent
    z, before = ahead, np.inf
    for _ in range(CORRECTIONS):
        try:
            values, matrix = problem.residual(z), problem.jacobian(z) * problem.scale
        except (ArithmeticError, ValueError):
            raise OutOfDomain from None
        if not (np.isfinite(values).all() and np.isfinite(matrix).all()):
            raise OutOfDomain
        bordered = np.vstack([matrix, here.tangent])  # F, and the distance from the plane
        scaled, sizes = equilibrated(bordered, np.ones(len(z)))
        off = here.tangent @ ((z - ahead) / problem.scale)
        try:
            move = np.linalg.solve(scaled, -np.append(values, off) / sizes)
        except np.linalg.LinAlgError:
            return None
        size = float(np.linalg.norm(move))
        grain = ON_CURVE * (1.0 + float(np.abs(z / problem.scale).max()))
        if size > max(CONTRACTION * before, 100 * grain):
            return None
        z = z + problem.scale * move
        if size <= grain:
            return point_at(problem, z, here.tangent, here.arc + problem.length(z - here.z))
        before = size
    return None


def attempted(problem: Problem, here: CurvePoint, length: float) -> CurvePoint | None:
    """The same; also None out of the domain."""
    try:
        return stepped(problem, here, length)
    except OutOfDomain:
        return None


def where(
    problem: Problem, here: CurvePoint, length: float, level: Callable[[CurvePoint], float]
) -> CurvePoint | None:
    """The point within ``length`` at which ``level`` vanishes, by R. P. Brent's method; the nearest
    to it if the domain ends before. None if ``level`` has one sign at both ends, or there is no
    point."""
    from scipy.optimize import brentq  # takes longer to import than most curves

    points = {0.0: here}

    def at(distance: float) -> float:
        if distance not in points:
            point = attempted(problem, here, distance)
            if point is None:
                raise OutOfDomain
            points[distance] = point
        return level(points[distance])

    try:
        if at(length) * at(0.0) > 0.0 or at(length) == at(0.0):
            return None
        brentq(at, 0.0, length, xtol=1e-15 * length, rtol=4 * EPS, maxiter=ROUNDS, disp=False)
    except OutOfDomain:
        if len(points) == 1:
            return None
    return min(points.values(), key=lambda point: abs(level(point)))


def _beyond(place: int, bound: float) -> Callable[[CurvePoint], float]:
    return lambda point: float(point.z[place]) - bound


def crossing(problem: Problem, here: CurvePoint, length: float, value: float) -> CurvePoint | None:
    """The point whose parameter is exactly ``value``; the other coordinates are polished."""
    found = where(problem, here, length, _beyond(-1, value))
    if found is None:
        return None
    held, size = found.z.copy(), problem.scale[:-1]
    held[-1] = value
    try:
        for _ in range(2):
            move = np.linalg.solve(problem.jacobian(held)[:, :-1] * size, -problem.residual(held))
            if np.linalg.norm(move) > 1e-6:
                break
            held[:-1] += size * move
    except (ArithmeticError, ValueError, np.linalg.LinAlgError):
        pass
    return found._replace(z=held)


class End(Enum):
    """Why a curve ends; the value follows ``where``."""

    CLOSED = "the curve is closed"
    BOUNDARY = "a variable reaches the end of its range"
    SINGULAR = "branches meet or cross"
    DOMAIN = "the rules have no value beyond"
    CHANGED = "other rules hold beyond"
    STALLED = "the curve cannot be followed further"
    LIMIT = "its points are too many: a variable may grow without bound"


class Trace(NamedTuple):
    """The points in order, the start first; ``end`` is why there is no further one."""

    problem: Problem
    points: tuple[CurvePoint, ...]
    end: End


FIRST, LONGEST, SHORTEST = 0.02, 0.1, 1e-9
"""Lengths of steps in scaled coordinates."""
TURNING_COSINE = 0.985
"""The least cosine of the angle between tangents a step apart."""
ASIDE = 0.15
"""The largest share of a step by which the corrector may leave its prediction."""
MOST = 5_000
AIM = 0.3
"""Share of the largest turning that a step aims at."""

SHOWN = 40
"""Points that the rank of the Jacobian is measured at, where a curve ends."""


def follow(problem: Problem, first: CurvePoint, home: CurvePoint | None = None) -> Trace:
    """Follow the curve from ``first`` along its tangent. It closes at ``home`` (None: at
    ``first``)."""
    return _Walk(problem, first, home or first).run()


class _Walk:
    def __init__(self, problem: Problem, first: CurvePoint, home: CurvePoint) -> None:
        self.problem, self.home = problem, home
        self.points = [first]
        self.regime = problem.these
        self.obstacle = End.STALLED

    def run(self) -> Trace:
        if self.problem.regime(self._nudged(self.points[0])) != self.regime:
            return Trace(self.problem, tuple(self.points), End.CHANGED)
        length = FIRST
        while len(self.points) < MOST:
            expect_time()
            here = self.points[-1]
            there = self._accepted(here, length)
            if there is None:
                length /= 2
                if length < SHORTEST:
                    return Trace(self.problem, tuple(self.points), self._reason())
                continue
            end = self._take(here, there, length)
            if end is not None:
                return Trace(self.problem, tuple(self.points), end)
            # tangents turn by an angle that grows with the step: its square is 2 (1 - cosine)
            turned = max(1.0 - float(here.tangent @ there.tangent), 1e-12)
            factor = (AIM * (1.0 - TURNING_COSINE) / turned) ** 0.5
            length = min(LONGEST, length * min(1.6, max(0.5, factor)))
        return Trace(self.problem, tuple(self.points), End.LIMIT)

    def _reason(self) -> End:
        """Why the curve does not continue. Where branches meet, the Jacobian loses rank."""
        if self.obstacle is not End.STALLED:
            return self.obstacle
        shown = [*self.points[:: len(self.points) // SHOWN + 1], self.points[-1]]
        try:
            found = np.array(
                [self.problem.jacobian(point.z) * self.problem.scale for point in shown]
            )
        except (ArithmeticError, ValueError):
            return End.DOMAIN
        sizes = np.abs(found).max(axis=(0, 2))
        singular = np.linalg.svd(found[-1] / sizes[:, None], compute_uv=False)
        return End.SINGULAR if singular[-1] <= MEETING else End.STALLED

    def _accepted(self, here: CurvePoint, length: float) -> CurvePoint | None:
        """The next point, if it certainly lies on the same branch; else ``obstacle`` says why
        not."""
        try:
            there = stepped(self.problem, here, length)
        except OutOfDomain:
            self.obstacle = End.DOMAIN
            return None
        self.obstacle = End.STALLED
        if there is None or float(here.tangent @ there.tangent) < TURNING_COSINE:
            return None
        aside = there.z - here.z - length * self.problem.scale * here.tangent
        if self.problem.length(aside) > ASIDE * length:
            return None
        if there.orientation != here.orientation:
            self.obstacle = End.SINGULAR
            return None
        return there

    def _take(self, here: CurvePoint, there: CurvePoint, length: float) -> End | None:
        """Add the points up to ``there``; return why the curve ends before it, if it does."""
        last, end = there, None
        out = self._boundary(here, there, length)
        if out is not None:
            last, end = out, End.BOUNDARY
        # and beyond it too: not at one point alone
        changed = self.problem.regime(there.z) != self.regime
        if changed and self.problem.regime(self._nudged(there)) != self.regime:
            edge = attempted(self.problem, here, self._last_inside(here, length))
            if edge is None or end is None or edge.arc < last.arc:
                last, end = edge or here, End.CHANGED
        home = self._closing_point(here, length)
        if home is not None and (end is None or home.arc <= last.arc):
            last, end = home, End.CLOSED
        if last.arc > here.arc:
            self._append(here, last)
        return end

    def _append(self, here: CurvePoint, last: CurvePoint) -> None:
        """Add the fold between two neighbours, where the tangent has no component along the
        parameter, if there is one, and the second of them."""
        if not here.fold and here.tangent[-1] * last.tangent[-1] < 0.0:
            reach = float((last.z - here.z) / self.problem.scale @ here.tangent)
            turning = where(self.problem, here, reach, lambda point: float(point.tangent[-1]))
            if turning is not None:
                self.points.append(turning._replace(fold=True))
                last = last._replace(arc=turning.arc + self.problem.length(last.z - turning.z))
        self.points.append(last)

    def _boundary(self, here: CurvePoint, there: CurvePoint, length: float) -> CurvePoint | None:
        """Where the first coordinate reaches the end of its range; None if all stay inside."""
        found: list[CurvePoint] = []
        for place, bound in self.problem.passed(there.z):
            if place == len(there.z) - 1:
                point = crossing(self.problem, here, length, bound)
            else:
                point = where(self.problem, here, length, _beyond(place, bound))
            found.append(point or here)
        return min(found, key=lambda point: point.arc, default=None)

    def _last_inside(self, here: CurvePoint, length: float) -> float:
        """The longest step after which the same equations still hold, by bisection."""
        low, high = 0.0, length
        while high - low > 1e-15 * length:
            middle = 0.5 * (low + high)
            if middle in (low, high):
                break
            point = attempted(self.problem, here, middle)
            inside = point is not None and self.problem.regime(point.z) == self.regime
            low, high = (middle, high) if inside else (low, middle)
        return low

    def _nudged(self, point: CurvePoint) -> Array:
        return point.z + 1e-3 * FIRST * self.problem.scale * point.tangent

    def _closing_point(self, here: CurvePoint, length: float) -> CurvePoint | None:
        """The start, up to whole turns of angles, if the curve closes within this step."""
        if here.arc - self.home.arc < 3 * FIRST:
            return None
        home = self.problem.turned(self.home.z, here.z)
        ahead = float((home - here.z) / self.problem.scale @ here.tangent)
        if not 0.0 < ahead <= length or float(here.tangent @ self.home.tangent) < 0.9:
            return None
        point = attempted(self.problem, here, ahead)
        if point is None:
            return None
        size = 1.0 + float(np.abs(point.z / self.problem.scale).max())
        off = float(np.linalg.norm(self.problem.apart(point.z, self.home.z)))
        return None if off > HOME * size else point._replace(z=home)
