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

    def close(self, found: Collection[str], *places: int) -> None:
        """From here on these letters are known, and the equations at these places used up."""
        self.open.difference_update(found)
        self.equations = [e for place, e in enumerate(self.equations) if place not in places]

    # --- what a polynomial is in the open letters ---

    def unknown(self, polynomial: Polynomial) -> list[str]:
        return sorted(letters(polynomial) & self.open)

    def plain(self, *names: str) -> bool:
        """None of them the cosine or the sine of an unknown angle."""
        return not any(name.startswith(("#c ", "#s ")) for name in names)

    def curved(self, equation: Polynomial) -> Polynomial:
        """What is not linear of it."""
        return {
            monomial: c
            for monomial, c in equation.items()
            if sum(exponent for name, exponent in monomial if name in self.open) > 1
        }

    # --- the same as formulas ---

    def expression(self, polynomial: Polynomial) -> Expression:
        return expression(polynomial, self.letters.meaning)

    def coefficient(self, polynomial: Polynomial) -> Coefficient:
        terms = [self.expression({monomial: c}) for monomial, c in polynomial.items()]
        return Coefficient(self.expression(polynomial), add(*(call("abs", term) for term in terms)))

    def divisor(self, divisor: Polynomial) -> Let:
        """A letter for something known, which must not vanish."""
        name = f"#d{len(self.letters.meaning)}"
        self.letters.meaning[name] = Name(name)
        value, size = self.coefficient(divisor)
        return Let(name, value, divisor=True, size=size)

    def reciprocal(self, divisor: Polynomial) -> str:
        """A letter for the reciprocal of something known."""
        let = self.divisor(divisor)
        inverse = f"#i{let.name[2:]}"
        self.forward += [let, Let(inverse, divide(Number(1.0), Name(let.name)))]
        self.letters.meaning[inverse] = Name(inverse)
        return inverse


def line(equation: Polynomial, x: str, y: str) -> Line | None:
    """``a x + b y = k`` with a, b and k free of the two; None where it is no such line."""
    by_x = coefficients(equation, x)
    by_y = coefficients(by_x.get(0, {}), y)
    a, b, k = by_x.get(1, {}), by_y.get(1, {}), scaled(by_y.get(0, {}), Fraction(-1))
    if {*by_x, *by_y} - {0, 1} or y in letters(a):
        return None
    return a, b, k


def close(system: System) -> bool:
    """Solve an equation in one letter, or a line in the cosine and sine of one angle."""
    for place, equation in enumerate(system.equations):
        match system.unknown(equation):
            case [name] if system.plain(name) and degree(equation, name) <= 2:
                parts = coefficients(equation, name)
                c, b, a = (parts.get(power, {}) for power in range(3))
                if a:
                    system.forward.append(Parabola(name, *map(system.coefficient, (a, b, c))))
                else:
                    inverse = Name(system.reciprocal(b))
                    system.forward.append(Let(name, negative(multiply(system.expression(c), inverse))))
            case [cosine, sine] if system.letters.pairs.get(sine) == cosine and (
                found := line(equation, cosine, sine)
            ):
                numbers = map(system.coefficient, (*found, constant(1.0)))
                system.forward.append(Circle(cosine, sine, *numbers))
            case _:
                continue
        system.close(system.unknown(equation), place)
        return True
    return False


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
        straight, circle = system.equations[i], system.equations[j]
        unknown, curved = system.unknown(straight), system.curved(circle)
        if len(unknown) != 2 or not system.plain(*unknown) or line(straight, *unknown) is None:
            continue
        if system.unknown(circle) != unknown or set(curved) != {((name, 2),) for name in unknown}:
            continue
        if len(set(curved.values())) > 1:
            continue
        x, y = unknown
        circle = scaled(circle, 1 / circle[((x, 2),)])
        by_x = coefficients(circle, x)
        by_y = coefficients(by_x[0], y)
        centre = [scaled(part.get(1, {}), Fraction(-1, 2)) for part in (by_x, by_y)]
        square = minus(plus(*(times(part, part) for part in centre)), by_y.get(0, {}))
        meaning = system.letters.meaning
        moved = [f"#m{len(meaning)} {name}" for name in unknown]
        meaning.update({new: Name(new) for new in moved})
        for name, new, part in zip(unknown, moved, centre, strict=True):
            straight = substituted(straight, name, plus(letter(new), part))
        found = line(straight, *moved)
        assert found is not None
        system.forward.append(Circle(moved[0], moved[1], *map(system.coefficient, (*found, square))))
        for name, new, part in zip(unknown, moved, centre, strict=True):
            system.forward.append(Let(name, add(Name(new), system.expression(part))))
        system.close(unknown, i, j)
        return True
    return False


def substitute(system: System, by_number: bool) -> bool:
    """Replace a plain letter that an equation gives as a polynomial in the others, wherever it stands.

    Equations free of angles come first: what they make zero is exactly zero then. ``by_number``: only where
    the coefficient of the letter is a number, so that no divisor is needed.
    """
    best = None
    for place, equation in enumerate(system.equations):
        unknown = system.unknown(equation)
        plain = list(filter(system.plain, unknown))
        for name in plain:
            parts = coefficients(equation, name)
            if set(parts) - {0, 1} or system.unknown(parts[1]):
                continue
            number = set(parts[1]) == {UNIT}
            cost = (not number, len(unknown) - len(plain), len(equation), place, name)
            if (number or not by_number) and (best is None or cost < best):
                best = cost
    if best is None:
        return False
    *_, place, name = best
    parts = coefficients(system.equations[place], name)
    value = scaled(parts.get(0, {}), Fraction(-1))
    if set(parts[1]) == {UNIT}:
        value = scaled(value, 1 / parts[1][UNIT])
    else:
        value = times(value, letter(system.reciprocal(parts[1])))
    size = system.coefficient(value).size if name in system.letters.roots else None
    system.backward.append([Let(name, system.expression(value), size=size)])
    system.close((name,), place)
    system.equations = [substituted(e, name, value) for e in system.equations]
    return True


def cross(system: System) -> bool:
    """Two lines in two plain letters, by Cramer's rule: no pivot to choose before there are numbers."""
    for (i, one), (j, other) in combinations(enumerate(system.equations), 2):
        unknown = system.unknown(one)
        if len(unknown) != 2 or not system.plain(*unknown) or system.unknown(other) != unknown:
            continue
        first, second = line(one, *unknown), line(other, *unknown)
        if first is None or second is None:
            continue
        (a, b, p), (c, d, q) = first, second
        inverse = Name(system.reciprocal(minus(times(a, d), times(b, c))))
        by_x, by_y = minus(times(p, d), times(b, q)), minus(times(a, q), times(p, c))
        for name, value in zip(unknown, (by_x, by_y), strict=True):
            system.forward.append(Let(name, multiply(system.expression(value), inverse)))
        system.close(unknown, i, j)
        return True
    return False


def rotate(system: System) -> bool:
    """Replace two equations that turn an angle, which occurs nowhere else, by ``a² + b² = p² + q²``.

    They are ``a c + b s = p`` and ``-b c + a s = q``, or that with the signs of the second changed.
    """
    for cosine, sine, _ in system.letters.angles.values():
        if cosine not in system.open or sine not in system.open:
            continue
        holders = [i for i, e in enumerate(system.equations) if letters(e) & {cosine, sine}]
        turned = (line(system.equations[place], cosine, sine) for place in holders)
        lines = [one for one in turned if one is not None]
        if not len(lines) == len(holders) == 2:
            continue
        (a, b, p), (c, d, q) = lines
        opposite = partial(scaled, factor=Fraction(-1))
        if (c, d) == (b, opposite(a)):
            c, d, q = opposite(c), opposite(d), opposite(q)
        if (c, d) != (opposite(b), a):
            continue
        pairs = system.letters.pairs
        square = reduced(plus(times(a, a), times(b, b)), pairs)
        closing = minus(plus(times(p, p), times(q, q)), square)
        system.close((cosine, sine), *holders)
        system.equations.append(reduced(closing, pairs))
        divisor = system.divisor(square)
        found: list[Formula] = [divisor]
        for name, above in (
            (cosine, minus(times(a, p), times(b, q))),
            (sine, plus(times(b, p), times(a, q))),
        ):
            found.append(Let(name, divide(system.expression(above), Name(divisor.name))))
        system.backward.append(found)
        return True
    return False


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
        system = System(equations, Letters(frozenset(unknowns), turning))
        angles = system.letters.angles
        if any(name not in system.open and name not in angles for name in unknowns):
            return None
        while system.open:
            system.tidy()
            if not any(move(system) for move in MOVES):
                return None
        system.tidy()
    except (NoForm, OverflowError):
        return None
    if system.equations:
        return None
    backward = (formula for group in reversed(system.backward) for formula in group)
    turned = (
        Let(name, call("atan2" + unit, Name(sine), Name(cosine)))
        for name, (cosine, sine, unit) in angles.items()
    )
    return (*system.forward, *backward, *turned)
