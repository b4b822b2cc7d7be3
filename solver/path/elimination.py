"""Simultaneous equations solved by formula: elimination until one line, circle or parabola is left.

Every angle stands for two letters, its cosine and its sine, every root for one; the equations
are polynomials in them. What occurs linearly is substituted; two equations that turn a cosine and a sine
(``a c + b s = p``, ``-b c + a s = q``) give ``a² + b² = p² + q²``; circles are subtracted from one another.
That closes the loops of planar linkages (the half-angle formulas of the textbooks, e.g. Norton, Design
of Machinery, chapter 4), slider-driven ones included, and meets of circles and lines.

Each step is valid for every solution as long as its divisor does not vanish: the solutions of the
block are among the candidates then, and there are no others. Roots can bring in strangers, which the
equations themselves have to refuse.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from fractions import Fraction
from functools import partial
from itertools import combinations, permutations
from typing import NamedTuple, TypeAlias

from rulesheets.model import Equation
from rulesheets.syntax.nodes import Expression, Name, Number, add, call, divide, multiply, negative
from solver.path.polynomial import (
    UNIT,
    Letters,
    NoForm,
    Polynomial,
    TooLarge,
    coefficients,
    constant,
    degree,
    expression,
    letter,
    letters,
    minus,
    plus,
    reduced,
    scaled,
    substituted,
    times,
)


class Let(NamedTuple):
    """``name := expression``. A ``divisor`` must not vanish, and a root (any other with a ``size``, which is
    the sum of its terms' sizes) must not be negative."""

    name: str
    expression: Expression
    divisor: bool = False
    size: Expression | None = None


class Coefficient(NamedTuple):
    """A known number; ``size`` is the sum of its terms' sizes, which its rounding goes by."""

    expression: Expression
    size: Expression


class Parabola(NamedTuple):
    """``name`` is a root of ``a x² + b x + c``: two values, one, or none."""

    name: str
    a: Coefficient
    b: Coefficient
    c: Coefficient


class Circle(NamedTuple):
    """The meets of the line ``a x + b y = k`` with the circle ``x² + y² = square``: two values, or none."""

    x: str
    y: str
    a: Coefficient
    b: Coefficient
    k: Coefficient
    square: Coefficient


Formula = Let | Parabola | Circle


ClosedForm: TypeAlias = tuple[Formula, ...]
"""Formulas in order; they end with every unknown."""


Line: TypeAlias = tuple[Polynomial, Polynomial, Polynomial]
"""``a x + b y = k`` as a, b and k."""


class System:
    """Equations in the ``open`` letters.

    ``forward`` are formulas in the order in which they are followed; each group of ``backward`` needs
    letters that are found later, so that the groups are followed last, in reverse.
    """

    def __init__(self, equations: Sequence[Equation], letters: Letters) -> None:
        self.letters = letters
        forms = [minus(letters.polynomial(e.left), letters.polynomial(e.right)) for e in equations]
        self.equations = [reduced(form, letters.pairs) for form in (*forms, *letters.extra)]
        self.open = letters.open
        self.forward: list[Formula] = []
        self.backward: list[list[Formula]] = []

    def tidy(self) -> None:
        """Drop the equations that have come to 0 = 0. Raises NoForm where one holds no unknown."""
        self.equations = [e for e in (reduced(p, self.letters.pairs) for p in self.equations) if e]
        if any(not self.unknown(e) for e in self.equations):
            raise NoForm

    def drop(self, *places: int) -> None:
        self.equations = [e for place, e in enumerate(self.equations) if place not in places]

    def found(self, *names: str) -> None:
        """From here on these letters are known. What stood before them stays before them."""
        self.open.difference_update(names)

    # --- what a polynomial is in the open letters ---

    def unknown(self, polynomial: Polynomial) -> set[str]:
        return letters(polynomial) & self.open

    def plain(self, name: str) -> bool:
        """Neither a cosine nor a sine of an unknown angle."""
        return not name.startswith(("#c ", "#s "))

    def linear(self, equation: Polynomial) -> bool:
        return not self.curved(equation)

    def curved(self, equation: Polynomial) -> Polynomial:
        """What is not linear of it."""
        return {
            monomial: c
            for monomial, c in equation.items()
            if sum(exponent for name, exponent in monomial if name in self.open) > 1
        }

    def sides(self, equation: Polynomial, x: str, y: str) -> Line:
        """``a x + b y = k``."""
        by_x = coefficients(equation, x)
        by_y = coefficients(by_x.get(0, {}), y)
        return by_x.get(1, {}), by_y.get(1, {}), scaled(by_y.get(0, {}), Fraction(-1))

    # --- the same as formulas ---

    def expression(self, polynomial: Polynomial) -> Expression:
        return expression(polynomial, self.letters.meaning)

    def size(self, polynomial: Polynomial) -> Expression:
        """The sum of the sizes of the terms."""
        terms = [expression({m: c}, self.letters.meaning) for m, c in polynomial.items()]
        return add(*(call("abs", term) for term in terms))

    def coefficient(self, polynomial: Polynomial) -> Coefficient:
        return Coefficient(self.expression(polynomial), self.size(polynomial))

    def line(self, equation: Polynomial, x: str, y: str) -> tuple[Coefficient, Coefficient, Coefficient]:
        a, b, k = self.sides(equation, x, y)
        return self.coefficient(a), self.coefficient(b), self.coefficient(k)

    def reciprocal(self, divisor: Polynomial) -> str:
        """A letter for the reciprocal of something known, which must not vanish."""
        count = len(self.letters.meaning)
        name, inverse = f"#d{count}", f"#i{count}"
        self.forward.append(Let(name, self.expression(divisor), divisor=True, size=self.size(divisor)))
        self.forward.append(Let(inverse, divide(Number(1.0), Name(name))))
        self.letters.meaning.update({name: Name(name), inverse: Name(inverse)})
        return inverse


def close(system: System) -> bool:
    """Solve an equation in one letter, or a line in the cosine and sine of one angle."""
    for place, equation in enumerate(system.equations):
        unknown = sorted(system.unknown(equation))
        if len(unknown) == 1 and system.plain(unknown[0]) and degree(equation, unknown[0]) <= 2:
            _root(system, equation, unknown[0])
        elif system.linear(equation) and [system.letters.pairs.get(n) for n in unknown[1:]] == unknown[:1]:
            cosine, sine = unknown
            a, b, k = system.line(equation, cosine, sine)
            system.forward.append(Circle(cosine, sine, a, b, k, system.coefficient(constant(1.0))))
            system.found(cosine, sine)
        else:
            continue
        system.drop(place)
        return True
    return False


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
    curved = [system.curved(equation) for equation in system.equations]
    for (i, one), (j, other) in combinations(enumerate(curved), 2):
        if one and set(one) == set(other) and len(ratios := {other[m] / one[m] for m in one}) == 1:
            system.equations[j] = minus(system.equations[j], scaled(system.equations[i], ratios.pop()))
            return True
    return False


def line_and_circle(system: System) -> bool:
    """``a x + b y = k`` and ``x² + y² + d x + e y + f = 0``, moved to the centre."""
    for i, j in permutations(range(len(system.equations)), 2):
        line, circle = system.equations[i], system.equations[j]
        unknown = sorted(system.unknown(line))
        if len(unknown) != 2 or not system.linear(line) or not all(map(system.plain, unknown)):
            continue
        curved = system.curved(circle)
        if system.unknown(circle) != set(unknown) or set(curved) != {((name, 2),) for name in unknown}:
            continue
        if len(set(curved.values())) == 1:
            _meet_circle(system, line, circle, *unknown)
            system.drop(i, j)
            return True
    return False


def _meet_circle(system: System, line: Polynomial, circle: Polynomial, x: str, y: str) -> None:
    circle = scaled(circle, 1 / circle[((x, 2),)])
    by_x = coefficients(circle, x)
    by_y = coefficients(by_x[0], y)
    d, e, f = by_x.get(1, {}), by_y.get(1, {}), by_y.get(0, {})
    centre = [scaled(part, Fraction(-1, 2)) for part in (d, e)]
    square = minus(plus(*(times(part, part) for part in centre)), f)
    meaning = system.letters.meaning
    moved = [f"#m{len(meaning)} {name}" for name in (x, y)]
    meaning.update({new: Name(new) for new in moved})
    for name, new, part in zip((x, y), moved, centre, strict=True):
        line = substituted(line, name, plus(letter(new), part))
    a, b, k = system.line(line, *moved)
    system.forward.append(Circle(moved[0], moved[1], a, b, k, system.coefficient(square)))
    for name, new, part in zip((x, y), moved, centre, strict=True):
        system.forward.append(Let(name, add(Name(new), system.expression(part))))
    system.found(x, y)


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
    for (i, one), (j, other) in combinations(enumerate(system.equations), 2):
        unknown = sorted(system.unknown(one))
        if len(unknown) != 2 or not all(map(system.plain, unknown)):
            continue
        if not (system.unknown(other) == {*unknown} and system.linear(one) and system.linear(other)):
            continue
        x, y = unknown
        (a, b, p), (c, d, q) = (system.sides(line, x, y) for line in (one, other))
        inverse = Name(system.reciprocal(minus(times(a, d), times(b, c))))
        by_x, by_y = minus(times(p, d), times(b, q)), minus(times(a, q), times(p, c))
        system.forward.append(Let(x, multiply(system.expression(by_x), inverse)))
        system.forward.append(Let(y, multiply(system.expression(by_y), inverse)))
        system.found(x, y)
        system.drop(i, j)
        return True
    return False


def rotate(system: System) -> bool:
    """Replace two equations that turn an angle, which occurs nowhere else, by ``a² + b² = p² + q²``."""
    for cosine, sine, _ in system.letters.angles.values():
        if cosine not in system.open or sine not in system.open:
            continue
        holders = [i for i, e in enumerate(system.equations) if letters(e) & {cosine, sine}]
        turned = (_turned(system.equations[place], cosine, sine) for place in holders)
        lines = [line for line in turned if line is not None]
        if not len(lines) == len(holders) == 2:
            continue
        (a, b, p), (c, d, q) = lines
        opposite = partial(scaled, factor=Fraction(-1))
        if (c, d) == (b, opposite(a)):
            c, d, q = opposite(c), opposite(d), opposite(q)
        if (c, d) == (opposite(b), a):
            system.drop(*holders)
            _close(system, cosine, sine, (a, b, p, q))
            return True
    return False


def direction(name: str, cosine: str, sine: str, unit: str) -> Let:
    """An angle from its cosine and sine; ``unit`` is "d" for degrees."""
    return Let(name, call("atan2" + unit, Name(sine), Name(cosine)))


def _turned(equation: Polynomial, cosine: str, sine: str) -> Line | None:
    """``a c + b s = p`` with the rest free of the two."""
    by_cosine = coefficients(equation, cosine)
    a, rest = by_cosine.get(1, {}), by_cosine.get(0, {})
    by_sine = coefficients(rest, sine)
    b, p = by_sine.get(1, {}), scaled(by_sine.get(0, {}), Fraction(-1))
    if set(by_cosine) - {0, 1} or set(by_sine) - {0, 1} or sine in letters(a):
        return None
    return a, b, p


def _close(
    system: System, cosine: str, sine: str, turn: tuple[Polynomial, Polynomial, Polynomial, Polynomial]
) -> None:
    """``a c + b s = p`` and ``-b c + a s = q``, for a, b, p and q."""
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


MAX_EQUATIONS = 16

MOVES: tuple[Callable[[System], bool], ...] = (
    partial(substitute, by_number=True),
    close,
    rotate,
    subtract,
    line_and_circle,
    cross,
    partial(substitute, by_number=False),
)
"""In the order in which they are tried: the first that can be made is made, then all are tried again.
Each tells whether there is one of its kind."""


def closed_form(
    equations: Sequence[Equation], unknowns: Collection[str], turning: Collection[str] = ()
) -> ClosedForm | None:
    """A closed form of as many equations as unknowns; None where elimination does not lead to one.

    ``turning`` are the unknowns that whole turns make no difference to.
    """
    if len(equations) > MAX_EQUATIONS:
        return None
    try:
        system = System(equations, Letters(unknowns, turning))
        angles = system.letters.angles
        if any(name not in system.open and name not in angles for name in unknowns):
            return None
        while system.open:
            system.tidy()
            if not any(move(system) for move in MOVES):
                return None
        system.tidy()
    except (NoForm, TooLarge, OverflowError):
        return None
    if system.equations:
        return None
    backward = (formula for group in reversed(system.backward) for formula in group)
    return (*system.forward, *backward, *(direction(name, *angle) for name, angle in angles.items()))
