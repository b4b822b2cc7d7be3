"""Curves F(z) = 0 of n equations in n + 1 unknowns: the problem, a point with its tangent, distances.

The last coordinate of z is the parameter.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

FLAT = 1e-11
"""Smallest singular value, over the largest, of a Jacobian whose null space is still a line."""


LEVEL = 1e-9
"""Part of a unit tangent along the parameter at which a start counts as a turning point."""


@dataclass(frozen=True)
class Problem:
    """``residual`` (n,) and ``jacobian`` (n, n + 1) of z; both may raise ArithmeticError or ValueError
    outside their domain. ``regime`` tells which equations hold at z, ``these`` that they are the ones of this
    problem: the curve is followed as long as both agree.

    ``scale`` (n + 1,) are the magnitudes in which lengths are measured, ``turn`` (n + 1,) the periods of
    angles (infinite for others), ``low`` and ``high`` (n + 1,) the ranges.
    """

    residual: Callable[[Vector], Vector]
    jacobian: Callable[[Vector], NDArray[np.float64]]
    scale: Vector
    turn: Vector
    low: Vector
    high: Vector
    regime: Callable[[Vector], Hashable] = field(default=lambda z: None)
    these: Hashable = None

    def passed(self, z: Vector) -> list[tuple[int, float]]:
        """The coordinates that lie beyond an end of their range by more than rounding, each with that end."""
        slack = 1e-13 * (np.abs(z) + self.scale)
        below, above = z < self.low - slack, z > self.high + slack
        ends = np.where(below, self.low, self.high)
        return [(int(j), float(ends[j])) for j in np.flatnonzero(below | above)]

    def turned(self, there: Vector, here: Vector) -> Vector:
        """``there`` with its angles as near to ``here`` as whole turns bring them."""
        finite = np.isfinite(self.turn)
        whole = np.where(finite, self.turn, 1.0)
        return np.where(finite, there - whole * np.round((there - here) / whole), there)

    def apart(self, there: Vector, here: Vector) -> Vector:
        """The scaled difference, angles less their whole turns."""
        return np.asarray((self.turned(there, here) - here) / self.scale)

    def scaled_jacobian(self, z: Vector) -> NDArray[np.float64] | None:
        """The Jacobian by scaled coordinates, rows of unit size; None without a value, or with a row of 0."""
        try:
            matrix = self.jacobian(z) * self.scale
        except (ArithmeticError, ValueError):
            return None
        sizes = np.abs(matrix).max(axis=1, initial=0.0)
        if not (np.isfinite(sizes).all() and sizes.all()):
            return None
        return np.asarray(matrix / sizes[:, None])


@dataclass(frozen=True)
class CurvePoint:
    """A point of the curve: ``z`` (n + 1,), unit ``tangent`` in scaled coordinates, ``arc`` length from the
    start, the sign of ``orientation`` (it changes at a bifurcation). ``fold``: the parameter turns here."""

    z: Vector
    tangent: Vector
    arc: float
    orientation: int
    fold: bool = False


def point_at(problem: Problem, z: Vector, along: Vector, arc: float = 0.0) -> CurvePoint | None:
    """The point at ``z`` with its tangent to the side of ``along``; None where it has no single tangent.

    The orientation is the sign of the determinant of the Jacobian bordered by the tangent (E. L. Allgower &
    K. Georg, *Introduction to Numerical Continuation Methods*, 2003, chapters 2 and 8).
    """
    matrix = problem.scaled_jacobian(z)
    if matrix is None:
        return None
    tangent = np.ones(1)
    if len(matrix):
        _, singular, right = np.linalg.svd(matrix)
        if singular[-1] <= FLAT * singular[0]:
            return None
        tangent = np.asarray(right[-1], dtype=np.float64)
    if tangent @ along < 0:
        tangent = -tangent
    sign, _ = np.linalg.slogdet(np.vstack([matrix, tangent]))
    return CurvePoint(z, tangent, arc, int(sign))


def start(problem: Problem, z: Vector, way: int = 1) -> CurvePoint | None:
    """The point of the curve at ``z``, directed so that the parameter grows (``way`` 1) or falls (-1)."""
    along = np.zeros(len(z))
    along[-1] = way
    point = point_at(problem, z, along)
    turning = point is not None and abs(point.tangent[-1]) <= LEVEL
    return point if point is None or not turning else replace(point, fold=True)
