"""Letters that occur linearly: substituted one at a time, or two by Cramer's rule."""

from __future__ import annotations

from fractions import Fraction

from rulesheets.construct import multiply
from rulesheets.nodes import Name
from solver.path.closed_form import Let
from solver.path.elimination.system import System
from solver.path.polynomial import (
    UNIT,
    Polynomial,
    coefficients,
    letter,
    minus,
    scaled,
    substituted,
    times,
)


def substitute(system: System, by_number: bool) -> bool:
    """Replace a plain letter that an equation gives as a polynomial in the others.

    Equations free of angles come first: what they make zero is exactly zero then. ``by_number``: only where
    the coefficient of the letter is a number, so that no divisor is needed.
    """
    best = None
    for place, equation in enumerate(system.equations):
        unknown = system.unknown(equation)
        turning = sum(1 for name in unknown if not system.plain(name))
        for name in sorted(filter(system.plain, unknown)):
            parts = coefficients(equation, name)
            if set(parts) - {0, 1} or system.unknown(parts[1]):
                continue
            number = set(parts[1]) == {UNIT}
            cost = (not number, turning, len(equation), place, name)
            if (number or not by_number) and (best is None or cost < best):
                best = cost
    if best is None:
        return False
    *_, place, name = best
    _replace(system, system.equations.pop(place), name)
    return True


def _replace(system: System, equation: Polynomial, name: str) -> None:
    """Put what a linear equation says of a letter wherever the letter stands."""
    parts = coefficients(equation, name)
    value = scaled(parts.get(0, {}), Fraction(-1))
    if set(parts[1]) == {UNIT}:
        value = scaled(value, 1 / parts[1][UNIT])
    else:
        value = times(value, letter(system.reciprocal(parts[1])))
    size = system.size(value) if name in system.letters.roots else None
    system.backward.append([Let(name, system.expression(value), size=size)])
    system.found(name)
    system.equations = [substituted(e, name, value) for e in system.equations]


def cross(system: System) -> bool:
    """Two lines in two plain letters, by Cramer's rule: no pivot to choose before there are numbers."""
    for i, one in enumerate(system.equations):
        x, *others = sorted(system.unknown(one))
        if len(others) != 1 or not (system.linear(one) and system.plain(x) and system.plain(others[0])):
            continue
        for j, other in enumerate(system.equations):
            if i < j and system.unknown(other) == {x, *others} and system.linear(other):
                _meet(system, one, other, x, others[0])
                system.drop(i, j)
                return True
    return False


def _meet(system: System, one: Polynomial, other: Polynomial, x: str, y: str) -> None:
    (a, b, p), (c, d, q) = (system.sides(line, x, y) for line in (one, other))
    inverse = Name(system.reciprocal(minus(times(a, d), times(b, c))))
    by_x, by_y = minus(times(p, d), times(b, q)), minus(times(a, q), times(p, c))
    system.forward.append(Let(x, multiply(system.expression(by_x), inverse)))
    system.forward.append(Let(y, multiply(system.expression(by_y), inverse)))
    system.found(x, y)
