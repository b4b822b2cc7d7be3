"""Two equations that turn the cosine and sine of an unknown angle: squared and added, the angle is gone."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import TypeAlias

from rulesheets.construct import call, divide
from rulesheets.nodes import Name
from solver.path.closed_form import Let
from solver.path.elimination.system import Line, System
from solver.path.polynomial import Polynomial, coefficients, letters, minus, plus, reduced, scaled, times

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
