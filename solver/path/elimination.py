"""Simultaneous equations solved by formula: elimination until one line, circle or parabola is left.

Every angle stands for two generators, its cosine and its sine, every root for one; the equations
are polynomials in them. A generator that occurs linearly is substituted; two equations that rotate
a cosine and a sine (``a c + b s = p``, ``-b c + a s = q``) give ``a² + b² = p² + q²``; circles are
subtracted from one another. This solves the loops of planar linkages (the half-angle formulas of
the textbooks, e.g. Norton, Design of Machinery, chapter 4), slider-driven ones included, and
intersections of circles and lines.

Each step is valid for every solution as long as its divisor does not vanish: the solutions of the
block are then among the candidates. Roots can introduce extraneous candidates, which the equations
themselves have to refuse.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from fractions import Fraction
from itertools import combinations, permutations
from typing import TypeAlias

from rulesheets.model import Equation
from rulesheets.syntax.nodes import Expression, Name, add, call
from solver.path import Circle, ClosedForm, Coefficient, Formula, Let, Parabola
from solver.path.polynomial import UNIT, Generators, NoForm, Polynomial, constant, generator

Line: TypeAlias = tuple[Polynomial, Polynomial, Polynomial]
"""``a x + b y = k`` as a, b and k."""

MAX_EQUATIONS = 16


def closed_form(
    equations: Sequence[Equation],
    unknowns: Collection[str],
    turning: Collection[str] = (),
    by: str = "",
) -> ClosedForm | None:
    """A closed form of as many equations as unknowns; None if elimination does not lead to one.

    ``turning`` are the unknowns for which whole turns make no difference; terms are collected
    ``by`` a known name.
    """
    if len(equations) > MAX_EQUATIONS:
        return None
    try:
        system = _System(equations, Generators(frozenset(unknowns), turning), by)
        angles = system.generators.angles
        if any(name not in system.open and name not in angles for name in unknowns):
            return None
        while system.open:
            system.tidy()
            if not system.move():
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


class _System:
    """Equations in the ``open`` generators.

    ``forward`` are formulas in order of evaluation; each group of ``backward`` needs generators
    that are found later, so the groups are evaluated last, in reverse.
    """

    def __init__(self, equations: Sequence[Equation], generators: Generators, by: str) -> None:
        self.by = by
        self.generators, self.open, self.pairs = generators, generators.open, generators.pairs
        forms = [generators.polynomial(e.left) - generators.polynomial(e.right) for e in equations]
        self.equations = [form.reduced(self.pairs) for form in (*forms, *generators.extra)]
        self.forward: list[Formula] = []
        self.backward: list[list[Formula]] = []

    def tidy(self) -> None:
        """Drop the equations that have become 0 = 0. Raises NoForm if one holds no unknown."""
        self.equations = [e for e in (p.reduced(self.pairs) for p in self.equations) if e]
        if any(not self.unknown(e) for e in self.equations):
            raise NoForm

    def move(self) -> bool:
        """Make the first possible step of elimination; False if there is none."""
        return (
            self._substitute(by_number=True)
            or self._solve_one()
            or self._rotate()
            or self._subtract()
            or self._line_and_circle()
            or self._cross()
            or self._substitute(by_number=False)
        )

    def _close(self, found: Collection[str], *places: int) -> bool:
        """Mark these generators as known, and the equations at these places as used."""
        self.open.difference_update(found)
        self.equations = [e for place, e in enumerate(self.equations) if place not in places]
        return True

    # --- polynomials in the open generators ---

    def unknown(self, polynomial: Polynomial) -> list[str]:
        return sorted(polynomial.generators & self.open)

    def _curved(self, equation: Polynomial) -> Polynomial:
        """Its nonlinear part."""
        return Polynomial(
            (monomial, c)
            for monomial, c in equation.items()
            if sum(exponent for name, exponent in monomial if name in self.open) > 1
        )

    # --- the same as formulas ---

    def _expression(self, polynomial: Polynomial) -> Expression:
        return polynomial.expression(self.generators.meaning, self.by)

    def _coefficient(self, polynomial: Polynomial) -> Coefficient:
        terms = [self._expression(Polynomial({monomial: c})) for monomial, c in polynomial.items()]
        return Coefficient(
            self._expression(polynomial), add(*(call("abs", term) for term in terms))
        )

    def _divisor(self, divisor: Polynomial) -> Let:
        """A generator for a known expression that must not vanish."""
        name = f"#d{len(self.generators.meaning)}"
        self.generators.meaning[name] = Name(name)
        value, size = self._coefficient(divisor)
        return Let(name, value, divisor=True, size=size)

    def _reciprocal(self, divisor: Polynomial) -> str:
        """A generator for the reciprocal of a known expression."""
        let = self._divisor(divisor)
        inverse = f"#i{let.name[2:]}"
        self.forward += [let, Let(inverse, 1.0 / Name(let.name))]
        self.generators.meaning[inverse] = Name(inverse)
        return inverse

    # --- steps of elimination: each returns whether it was made ---

    def _solve_one(self) -> bool:
        """Solve an equation in one generator, or a line in the cosine and sine of one angle."""
        pairs = [[cosine, sine] for cosine, sine, _ in self.generators.angles.values()]
        for place, equation in enumerate(self.equations):
            closed = self.unknown(equation)
            angle = next((pair for pair in pairs if closed and {*closed} <= {*pair}), None)
            match closed:
                case [name] if _plain(name) and equation.degree(name) <= 2:
                    c, b, a = (
                        equation.coefficients(name).get(power, Polynomial()) for power in range(3)
                    )
                    if a:
                        self.forward.append(Parabola(name, *map(self._coefficient, (a, b, c))))
                    else:
                        inverse = Name(self._reciprocal(b))
                        self.forward.append(Let(name, -(self._expression(c) * inverse)))
                case _ if angle and (found := _line(equation, *angle)):
                    numbers = map(self._coefficient, (*found, constant(1.0)))
                    self.forward.append(Circle(angle[0], angle[1], *numbers))
                    closed = angle
                case _:
                    continue
            return self._close(closed, place)
        return False

    def _subtract(self) -> bool:
        """Subtract one equation from another so that their nonlinear parts cancel."""
        curved = [self._curved(equation) for equation in self.equations]
        for (i, one), (j, other) in combinations(enumerate(curved), 2):
            if (
                one
                and set(one) == set(other)
                and len(ratios := {other[m] / one[m] for m in one}) == 1
            ):
                self.equations[j] -= self.equations[i] * ratios.pop()
                return True
        return False

    def _line_and_circle(self) -> bool:
        """``a x + b y = k`` and ``x² + y² + d x + e y + f = 0``, moved to the centre."""
        for i, j in permutations(range(len(self.equations)), 2):
            straight, circle = self.equations[i], self.equations[j]
            unknown, curved = self.unknown(straight), self._curved(circle)
            if len(unknown) != 2 or not _plain(*unknown) or _line(straight, *unknown) is None:
                continue
            if self.unknown(circle) != unknown or set(curved) != {((name, 2),) for name in unknown}:
                continue
            if len(set(curved.values())) > 1:
                continue
            x, y = unknown
            by_x = (circle * (1 / circle[((x, 2),)])).coefficients(x)
            by_y = by_x[0].coefficients(y)
            centre = [part.get(1, Polynomial()) * Fraction(-1, 2) for part in (by_x, by_y)]
            square = centre[0] * centre[0] + centre[1] * centre[1] - by_y.get(0, Polynomial())
            meaning = self.generators.meaning
            moved = [f"#m{len(meaning)} {name}" for name in unknown]
            meaning.update({new: Name(new) for new in moved})
            for name, new, part in zip(unknown, moved, centre, strict=True):
                straight = straight.substituted(name, generator(new) + part)
            found = _line(straight, *moved)
            assert found is not None
            self.forward.append(
                Circle(moved[0], moved[1], *map(self._coefficient, (*found, square)))
            )
            for name, new, part in zip(unknown, moved, centre, strict=True):
                self.forward.append(Let(name, Name(new) + self._expression(part)))
            return self._close(unknown, i, j)
        return False

    def _substitute(self, by_number: bool) -> bool:
        """Replace a plain generator that an equation gives as a polynomial in the others.

        Equations free of angles come first: what they make zero is then exactly zero.
        ``by_number``: only if the coefficient of the generator is a number, so that no divisor is
        needed.
        """
        costs = []
        for place, equation in enumerate(self.equations):
            unknown = self.unknown(equation)
            plain = list(filter(_plain, unknown))
            for name in plain:
                parts = equation.coefficients(name)
                number = set(parts[1]) == {UNIT} if 1 in parts else False
                if (
                    not set(parts) - {0, 1}
                    and not self.unknown(parts[1])
                    and (number or not by_number)
                ):
                    costs.append(
                        (not number, len(unknown) - len(plain), len(equation), place, name)
                    )
        if not costs:
            return False
        *_, place, name = min(costs)
        parts = self.equations[place].coefficients(name)
        value = -parts.get(0, Polynomial())
        if set(parts[1]) == {UNIT}:
            value *= 1 / parts[1][UNIT]
        else:
            value *= generator(self._reciprocal(parts[1]))
        size = self._coefficient(value).size if name in self.generators.roots else None
        self.backward.append([Let(name, self._expression(value), size=size)])
        self._close((name,), place)
        self.equations = [e.substituted(name, value) for e in self.equations]
        return True

    def _cross(self) -> bool:
        """Two lines in two plain generators, by Cramer's rule, which needs no pivot."""
        for (i, one), (j, other) in combinations(enumerate(self.equations), 2):
            unknown = self.unknown(one)
            if len(unknown) != 2 or not _plain(*unknown) or self.unknown(other) != unknown:
                continue
            first, second = _line(one, *unknown), _line(other, *unknown)
            if first is None or second is None:
                continue
            (a, b, p), (c, d, q) = first, second
            inverse = Name(self._reciprocal(a * d - b * c))
            for name, value in zip(unknown, (p * d - b * q, a * q - p * c), strict=True):
                self.forward.append(Let(name, self._expression(value) * inverse))
            return self._close(unknown, i, j)
        return False

    def _rotate(self) -> bool:
        """Replace two equations that rotate an angle, which occurs nowhere else, by ``a² + b² = p²
        + q²``.

        They are ``a c + b s = p`` and ``-b c + a s = q``, or that with the signs of the second
        changed.
        """
        for cosine, sine, _ in self.generators.angles.values():
            if cosine not in self.open or sine not in self.open:
                continue
            holders = [i for i, e in enumerate(self.equations) if e.generators & {cosine, sine}]
            turned = (_line(self.equations[place], cosine, sine) for place in holders)
            lines = [one for one in turned if one is not None]
            if not len(lines) == len(holders) == 2:
                continue
            (a, b, p), (c, d, q) = lines
            if (c, d) == (b, -a):
                c, d, q = -c, -d, -q
            if (c, d) != (-b, a):
                continue
            square = (a * a + b * b).reduced(self.pairs)
            self._close((cosine, sine), *holders)
            self.equations.append((p * p + q * q - square).reduced(self.pairs))
            divisor = self._divisor(square)
            found: list[Formula] = [divisor]
            for name, above in ((cosine, a * p - b * q), (sine, b * p + a * q)):
                found.append(Let(name, self._expression(above) / Name(divisor.name)))
            self.backward.append(found)
            return True
        return False


def _plain(*names: str) -> bool:
    """None of them the cosine or the sine of an unknown angle."""
    return not any(name.startswith(("#c ", "#s ")) for name in names)


def _line(equation: Polynomial, x: str, y: str) -> Line | None:
    """``a x + b y = k`` with a, b and k free of the two; None if it is not such a line."""
    none, by_x = Polynomial(), equation.coefficients(x)
    by_y = by_x.get(0, none).coefficients(y)
    a, b, k = by_x.get(1, none), by_y.get(1, none), -by_y.get(0, none)
    return None if {*by_x, *by_y} - {0, 1} or y in a.generators else (a, b, k)
