"""What closes a chain of substitutions: a parabola in one letter, a line and a circle in two."""

from __future__ import annotations

from fractions import Fraction

from rulesheets.syntax.nodes import Name, add, multiply, negative
from solver.path.closed_form import Circle, Let, Parabola
from solver.path.elimination.system import System
from solver.path.polynomial import (
    Polynomial,
    coefficients,
    constant,
    degree,
    letter,
    minus,
    plus,
    scaled,
    substituted,
    times,
)


def close(system: System) -> bool:
    """Solve an equation in one letter, or a line in the cosine and sine of one angle."""
    for place, equation in enumerate(system.equations):
        unknown = sorted(system.unknown(equation))
        if len(unknown) == 1 and system.plain(unknown[0]) and degree(equation, unknown[0]) <= 2:
            _root(system, equation, unknown[0])
        elif len(unknown) == 2 and _is_pair(system, *unknown) and system.linear(equation):
            cosine, sine = unknown
            a, b, k = system.line(equation, cosine, sine)
            system.forward.append(Circle(cosine, sine, a, b, k, system.coefficient(constant(1.0))))
            system.found(cosine, sine)
        else:
            continue
        system.drop(place)
        return True
    return False


def _is_pair(system: System, cosine: str, sine: str) -> bool:
    return system.letters.pairs.get(sine) == cosine


def _root(system: System, equation: Polynomial, name: str) -> None:
    parts = coefficients(equation, name)
    c, b, a = (parts.get(power, {}) for power in range(3))
    if not a:
        inverse = system.reciprocal(b)
        value = negative(multiply(system.expression(c), Name(inverse)))
        system.forward.append(Let(name, value))
    else:
        system.forward.append(Parabola(name, *map(system.coefficient, (a, b, c))))
    system.found(name)


def subtract(system: System) -> bool:
    """Take one equation from another so that what is not linear in them goes."""
    curved = [(i, system.curved(e)) for i, e in enumerate(system.equations)]
    for i, one in curved:
        for j, other in curved:
            if i >= j or not one or set(one) != set(other):
                continue
            ratio = _ratio(one, other)
            if ratio is not None:
                system.equations[j] = minus(system.equations[j], scaled(system.equations[i], ratio))
                return True
    return False


def _ratio(one: Polynomial, other: Polynomial) -> Fraction | None:
    """The number that takes one polynomial to the other."""
    ratios = {other[m] / one[m] for m in one}
    return ratios.pop() if len(ratios) == 1 else None


def line_and_circle(system: System) -> bool:
    """``a x + b y = k`` and ``x² + y² + d x + e y + f = 0``, moved to the centre."""
    for i, line in enumerate(system.equations):
        unknown = sorted(system.unknown(line))
        if len(unknown) != 2 or not system.linear(line) or not all(map(system.plain, unknown)):
            continue
        for j, circle in enumerate(system.equations):
            if i != j and system.unknown(circle) == set(unknown) and _is_circle(system, circle, *unknown):
                _meet(system, line, circle, *unknown)
                system.drop(i, j)
                return True
    return False


def _is_circle(system: System, equation: Polynomial, x: str, y: str) -> bool:
    curved = system.curved(equation)
    square = {((x, 2),), ((y, 2),)}
    return set(curved) == square and len(set(curved.values())) == 1


def _meet(system: System, line: Polynomial, circle: Polynomial, x: str, y: str) -> None:
    circle = scaled(circle, 1 / circle[((x, 2),)])
    by_x = coefficients(circle, x)
    by_y = coefficients(by_x[0], y)
    d, e, f = by_x.get(1, {}), by_y.get(1, {}), by_y.get(0, {})
    centre = [scaled(part, Fraction(-1, 2)) for part in (d, e)]
    square = minus(plus(*(times(part, part) for part in centre)), f)
    meaning = system.letters.meaning
    moved = {name: f"#m{len(meaning)} {name}" for name in (x, y)}
    meaning.update({new: Name(new) for new in moved.values()})
    shifted = line
    for name, part in zip((x, y), centre, strict=True):
        shifted = substituted(shifted, name, plus(letter(moved[name]), part))
    a, b, k = system.line(shifted, moved[x], moved[y])
    system.forward.append(Circle(moved[x], moved[y], a, b, k, system.coefficient(square)))
    for name, part in zip((x, y), centre, strict=True):
        system.forward.append(Let(name, add(Name(moved[name]), system.expression(part))))
    system.found(x, y)
