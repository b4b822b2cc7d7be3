"""Elimination by lines: letters that occur linearly are substituted, one at a time or two by Cramer's rule.

Two equations that turn the cosine and sine of an unknown angle are squared and added, and the angle is gone.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import TypeAlias

from rulesheets.syntax.nodes import Name, call, divide, multiply
from solver.path.closed_form import Let
from solver.path.elimination.system import Line, System
from solver.path.polynomial import (
    UNIT,
    Polynomial,
    coefficients,
    letter,
    letters,
    minus,
    plus,
    reduced,
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


Turn: TypeAlias = tuple[Polynomial, Polynomial, Polynomial, Polynomial]
"""``a c + b s = p`` and ``-b c + a s = q`` as a, b, p and q."""


def rotate(system: System) -> bool:
    """Replace two equations that turn an angle, which occurs nowhere else, by ``a² + b² = p² + q²``."""
    for cosine, sine in _open_pairs(system):
        lines = [
            (place, line)
            for place, equation in enumerate(system.equations)
            if (line := _turned(equation, cosine, sine)) is not None
        ]
        for i, (one, first) in enumerate(lines):
            for other, second in lines[i + 1 :]:
                turn = _matched(first, second)
                if turn is not None and _only_in(system, cosine, sine, one, other):
                    system.drop(one, other)
                    _close(system, cosine, sine, turn)
                    return True
    return False


def direction(name: str, cosine: str, sine: str, unit: str) -> Let:
    """An angle from its cosine and sine; ``unit`` is "d" for degrees."""
    return Let(name, call("atan2" + unit, Name(sine), Name(cosine)))


def _open_pairs(system: System) -> Iterator[tuple[str, str]]:
    for cosine, sine, _ in system.letters.angles.values():
        if cosine in system.open and sine in system.open:
            yield cosine, sine


def _only_in(system: System, cosine: str, sine: str, *places: int) -> bool:
    elsewhere = (e for place, e in enumerate(system.equations) if place not in places)
    return not any(letters(equation) & {cosine, sine} for equation in elsewhere)


def _turned(equation: Polynomial, cosine: str, sine: str) -> Line | None:
    """``a c + b s = p`` with the rest free of the two."""
    found = letters(equation)
    if cosine not in found and sine not in found:
        return None
    by_cosine = coefficients(equation, cosine)
    a, rest = by_cosine.get(1, {}), by_cosine.get(0, {})
    by_sine = coefficients(rest, sine)
    b, p = by_sine.get(1, {}), scaled(by_sine.get(0, {}), Fraction(-1))
    if set(by_cosine) - {0, 1} or set(by_sine) - {0, 1} or sine in letters(a):
        return None
    return a, b, p


def _matched(first: Line, second: Line) -> Turn | None:
    """The turn that two lines are, up to a sign."""
    a, b, p = first
    c, d, q = second
    opposite = scaled(b, Fraction(-1))
    if c == opposite and d == a:
        return a, b, p, q
    if c == b and d == scaled(a, Fraction(-1)):
        return a, b, p, scaled(q, Fraction(-1))
    return None


def _close(system: System, cosine: str, sine: str, turn: Turn) -> None:
    a, b, p, q = turn
    pairs, meaning = system.letters.pairs, system.letters.meaning
    square = reduced(plus(times(a, a), times(b, b)), pairs)
    closing = minus(plus(times(p, p), times(q, q)), square)
    system.equations.append(reduced(closing, pairs))
    system.found(cosine, sine)
    name = f"#d{len(meaning)}"
    meaning[name] = Name(name)
    c, s = minus(times(a, p), times(b, q)), plus(times(b, p), times(a, q))
    system.backward.append(
        [
            Let(name, system.expression(square), divisor=True, size=system.size(square)),
            Let(cosine, divide(system.expression(c), Name(name))),
            Let(sine, divide(system.expression(s), Name(name))),
        ]
    )
