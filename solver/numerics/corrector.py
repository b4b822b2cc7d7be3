"""One step along a curve, and the points on it where something happens."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from solver.numerics.curve import CurvePoint, Problem, Vector, point_at

CORRECTIONS = 8
CONVERGED = 1e-12
CONTRACTION = 0.3
"""Factor by which each correction has to shrink: a slower one may lead to another branch."""

ROUNDS = 60


class OutOfDomain(ArithmeticError):
    """The equations have no value where a step leads."""


def stepped(problem: Problem, here: CurvePoint, length: float) -> CurvePoint | None:
    """The point in the plane ``length`` ahead across the tangent, by Newton's method from the tangent's end.

    (H. B. Keller, "Numerical solution of bifurcation and nonlinear eigenvalue problems", 1977.) None where
    the method does not contract, or the point has no tangent. Raises OutOfDomain.
    """
    ahead = here.z + length * problem.scale * here.tangent
    z, before = ahead, np.inf
    for _ in range(CORRECTIONS):
        move = _correction(problem, z, here.tangent, (z - ahead) / problem.scale)
        if move is None:
            return None
        size, grain = float(np.linalg.norm(move)), CONVERGED * _size(problem, z)
        if size > max(CONTRACTION * before, 100 * grain):
            return None
        z = z + problem.scale * move
        if size <= grain:
            chord = float(np.linalg.norm((z - here.z) / problem.scale))
            return point_at(problem, z, here.tangent, here.arc + chord)
        before = size
    return None


def _correction(problem: Problem, z: Vector, tangent: Vector, off: Vector) -> Vector | None:
    """One Newton move, scaled, of F and of the distance from the plane."""
    try:
        values, matrix = problem.residual(z), problem.jacobian(z) * problem.scale
    except (ArithmeticError, ValueError):
        raise OutOfDomain from None
    if not (np.isfinite(values).all() and np.isfinite(matrix).all()):
        raise OutOfDomain
    bordered = np.vstack([matrix, tangent])
    sizes = np.abs(bordered).max(axis=1)
    if not sizes.all():
        return None
    try:
        return np.linalg.solve(bordered / sizes[:, None], -np.append(values, tangent @ off) / sizes)
    except np.linalg.LinAlgError:
        return None


def _size(problem: Problem, z: Vector) -> float:
    return 1.0 + float(np.abs(z / problem.scale).max())


def attempted(problem: Problem, here: CurvePoint, length: float) -> CurvePoint | None:
    """The same, None out of the domain too."""
    try:
        return stepped(problem, here, length)
    except OutOfDomain:
        return None


def last_inside(
    problem: Problem, here: CurvePoint, length: float, inside: Callable[[CurvePoint], bool]
) -> float:
    """The longest step up to ``length`` at whose end the curve is still ``inside``, by bisection."""
    low, high = 0.0, length
    while high - low > 1e-15 * length:
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        point = attempted(problem, here, middle)
        low, high = (middle, high) if point is not None and inside(point) else (low, middle)
    return low


def where(
    problem: Problem,
    here: CurvePoint,
    length: float,
    level: Callable[[CurvePoint], float],
    grain: float,
) -> CurvePoint | None:
    """The point within ``length`` at which ``level`` vanishes, to ``grain``: regula falsi (Illinois).

    None where ``level`` has one sign at both ends, or no point is found.
    """
    end = attempted(problem, here, length)
    if end is None:
        return None
    low, first, high, second = 0.0, level(here), length, level(end)
    if first * second > 0.0 or first == second:
        return None
    best = here if abs(first) < abs(second) else end
    for _ in range(ROUNDS):
        middle = high - second * (high - low) / (second - first)
        point = attempted(problem, here, middle)
        if point is None:
            return best
        now = level(point)
        if abs(now) < abs(level(best)):
            best = point
        if abs(now) <= grain or abs(high - low) <= 1e-15 * length:
            return best
        if now * second < 0.0:
            low, first = high, second
        else:
            first /= 2
        high, second = middle, now
    return best


def fold(problem: Problem, here: CurvePoint, length: float) -> CurvePoint | None:
    """Where the parameter turns: the tangent has no part along it."""
    found = where(problem, here, length, lambda point: float(point.tangent[-1]), 1e-13)
    return None if found is None else replace(found, fold=True)


def crossing(problem: Problem, here: CurvePoint, length: float, value: float) -> CurvePoint | None:
    """Where the parameter is ``value``, exactly, the other coordinates polished with it held."""
    grain = 4e-16 * abs(value)
    found = where(problem, here, length, lambda point: float(point.z[-1]) - value, grain)
    return None if found is None else replace(found, z=_held(problem, found.z, value))


def _held(problem: Problem, z: Vector, value: float) -> Vector:
    held = z.copy()
    held[-1] = value
    size = problem.scale[:-1]
    try:
        for _ in range(2):
            move = np.linalg.solve(problem.jacobian(held)[:, :-1] * size, -problem.residual(held))
            if np.linalg.norm(move) > 1e-6:
                break
            held[:-1] += size * move
    except (ArithmeticError, ValueError, np.linalg.LinAlgError):
        pass
    return held
