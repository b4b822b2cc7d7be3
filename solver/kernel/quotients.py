"""Expressions as quotients of polynomials in a few unknowns, over exact numbers.

The known numbers are the exact fractions of their floats. Divisors are kept: where one is 0, a part
of the expression has no value. A root s of degree q of an expression e is one more unknown with s^q
= e. An absolute value is its argument or the opposite, by a choice of signs.

The roots of the *eliminants* of an equation in one unknown, one for each choice, include every
solution. Quotients are multiplied away, and roots eliminated one by one by resultants (J. J.
Sylvester). The polynomials may have further roots, such as those of another sign. Where an explicit
form is 0/0 its unknown is free, and a solution there may be none of their roots.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import reduce
from operator import mul
from typing import NamedTuple, TypeAlias

from rulesheets.deadline import expect_time
from rulesheets.evaluate import value
from rulesheets.evaluate.number import Arithmetic
from rulesheets.model import Equation
from rulesheets.syntax.nodes import Call, Expression, Name, Number, Power, Product, Sum, rebuilt
from solver.numerics.one_unknown import common_divisor, without_roots
from solver.numerics.tolerances import TOUCHING
from solver.path.polynomial import UNIT, Monomial, NoForm, Polynomial, constant, generator

NOT_RATIONAL = NoForm, KeyError, ArithmeticError
"""What is raised of an expression that is no quotient of polynomials."""

HIGHEST_DEGREE = 24
MAX_ROOT = 4
MAX_CHOICES = 64
"""Of the signs of absolute values."""

Divisor: TypeAlias = tuple[tuple[Monomial, Fraction], ...]
"""The sorted terms of a polynomial of which the last coefficient is 1."""

Coefficients: TypeAlias = list[Fraction]
"""Of a polynomial in one unknown, lowest degree first."""
Signs: TypeAlias = tuple[int, ...]
Exact: TypeAlias = Callable[[float], Fraction]
"""The exact value of a float: its binary fraction, or the decimal as written."""


@dataclass(frozen=True, slots=True)
class Ratio:
    """A polynomial, what it would be if nothing cancelled in it, and its divisors with their
    exponents."""

    top: Polynomial
    gross: Polynomial
    divisors: Counter[Divisor] = field(default_factory=Counter)

    def __neg__(self) -> Ratio:
        return self.scaled(Fraction(-1))

    def __add__(self, other: Ratio) -> Ratio:
        """Over the least common divisors."""
        common = self.divisors | other.divisors
        one, two = self._over(common), other._over(common)
        return Ratio(one.top + two.top, one.gross + two.gross, common)

    def __mul__(self, other: Ratio) -> Ratio:
        divisors = self.divisors + other.divisors
        return Ratio(self.top * other.top, self.gross * other.gross, divisors)

    def _over(self, divisors: Counter[Divisor]) -> Ratio:
        return self.times(divisors - self.divisors) if divisors != self.divisors else self

    def times(self, factors: Counter[Divisor]) -> Ratio:
        return reduce(mul, (plain(Polynomial(one)) for one in factors.elements()), self)

    def scaled(self, factor: Fraction) -> Ratio:
        return replace(self, top=self.top * factor, gross=self.gross * abs(factor))

    def power(self, exponent: int) -> Ratio:
        return reduce(mul, [self] * exponent, plain(constant(1.0)))

    @property
    def number(self) -> Fraction | None:
        """The value of one without unknowns."""
        if self.divisors or self.top.generators:
            return None
        return self.top.get(UNIT, Fraction(0))


def plain(polynomial: Polynomial) -> Ratio:
    return Ratio(polynomial, Polynomial({monomial: abs(c) for monomial, c in polynomial.items()}))


def dense(polynomial: Polynomial) -> Coefficients:
    """The coefficients of a polynomial in one unknown, lowest degree first."""
    by_degree = {sum(exponent for _, exponent in monomial): c for monomial, c in polynomial.items()}
    return [by_degree.get(k, Fraction(0)) for k in range(max(by_degree, default=-1) + 1)]


class Quotients(Arithmetic[Ratio]):
    """Quotients of polynomials in the ``unknowns`` and in so many ``radicals`` at most. An
    expression that is none of low degree raises NOT_RATIONAL.

    ``poles`` are the divisors: where one is 0, some part has no value. ``common`` are polynomials
    that are 0 wherever a divisor and its dividend are, but for the roots of ``sure`` ones, divisors
    that are 0 where their dividend is not. ``signs`` are those of the first absolute values;
    ``others`` are further choices.
    """

    def __init__(
        self,
        unknowns: Iterable[str],
        known: Mapping[str, float],
        exact: Exact = Fraction,
        radicals: int = 0,
        signs: Signs = (),
    ) -> None:
        self.exact, self.most = exact, radicals
        self.signs, self.others = signs, list[Signs]()
        self.values = {name: self.constant(number) for name, number in known.items()}
        self.values |= {name: plain(generator(name)) for name in unknowns}
        self.poles = dict[Divisor, None]()
        self.common, self.sure = list[Polynomial](), dict[str, list[list[Fraction]]]()
        self.chosen, self.radicals = list[tuple[Ratio, int]](), list[tuple[Ratio, int, str]]()

    def follow(self, forms: Iterable[tuple[str, Expression]], free: bool = False) -> None:
        """Add explicit forms of further unknowns by those before them; unknowns without one are
        left free if ``free``."""
        for name, form in forms:
            try:
                self.values[name] = self.of(form)
            except NOT_RATIONAL:
                if not free:
                    raise
                self.values[name] = plain(generator(name))

    def bare(self, found: Polynomial) -> Polynomial:
        """A polynomial without radicals, whose roots include those of ``found``."""
        for inside, degree, radical in reversed(self.radicals):
            if radical in found.generators:
                from rulesheets.algebra import resultant  # brings sympy

                relation = plain(generator(radical)).power(degree) + -inside
                found = Polynomial(resultant(found, relation.top, radical))
            if found.highest > HIGHEST_DEGREE:
                raise NoForm
        return found

    def constant(self, number: float) -> Ratio:
        if not math.isfinite(number):
            raise NoForm
        return plain(constant(self.exact(number)))

    def number(self, node: Number) -> Ratio:
        return self.constant(node.value)

    def name(self, node: Name) -> Ratio:
        return self.values[node.name]

    def sum(self, node: Sum) -> Ratio:
        return _bounded(super().sum(node))

    def product(self, node: Product) -> Ratio:
        return _bounded(super().product(node))

    def divided(self, node: Expression, above: Ratio, below: Ratio) -> Ratio:
        """The quotient, unless rounding may have left of the divisor what is not 0."""
        above = _bounded(above.times(below.divisors))
        *terms, (lead, by) = sorted(below.top.items()) or [(UNIT, Fraction(0))]
        if abs(by) <= TOUCHING * below.gross.get(lead, 0):
            raise NoForm
        quotient = above.scaled(1 / by)
        if not below.top.generators:
            return quotient
        factor = *((monomial, c / by) for monomial, c in terms), (lead, Fraction(1))
        self.poles[factor] = None
        self._note_common(above.top, below.top)
        return replace(quotient, divisors=above.divisors + Counter([factor]))

    def _note_common(self, one: Polynomial, other: Polynomial) -> None:
        names = one.generators | other.generators
        if len(names) == 1:
            (name,) = names
            sure, divisor = self.sure.setdefault(name, []), dense(other)
            shared = reduce(without_roots, sure, common_divisor(dense(one), divisor))
            sure.append(without_roots(divisor, shared))
            powers = (((name, k),) if k else UNIT for k in range(len(shared)))
            other = Polynomial.of(zip(powers, shared, strict=True))
        if other.generators and (one.generators or not one):
            self.common.append(other)

    def raised(self, node: Power, base: Ratio, exponent: Ratio) -> Ratio:
        number = exponent.number
        if number is None:
            raise NoForm
        if base.number is not None and (number.denominator > 1 or abs(number) > HIGHEST_DEGREE):
            return self._evaluated(node, base, exponent)
        return self._power(node, base, number)

    def _power(self, node: Expression, base: Ratio, number: Fraction) -> Ratio:
        exponent = number.limit_denominator(MAX_ROOT)
        if float(exponent) != float(number) or abs(exponent) > HIGHEST_DEGREE:
            raise NoForm
        if exponent.denominator > 1:
            base = self._root(base, exponent.denominator)
        found = _bounded(base.power(abs(exponent.numerator)))
        return found if number >= 0 else self.divided(node, self.constant(1.0), found)

    def _root(self, base: Ratio, degree: int) -> Ratio:
        known = (name for inside, of, name in self.radicals if (inside, of) == (base, degree))
        if (radical := next(known, None)) is None:
            if len(self.radicals) == self.most:
                raise NoForm
            radical = f"#r{len(self.radicals)}"
            self.radicals.append((base, degree, radical))
        return plain(generator(radical))

    def applied(self, node: Call, arguments: list[Ratio]) -> Ratio:
        match node.function:
            case "sqrt" if arguments[0].number is None:
                return self._power(node, arguments[0], Fraction(1, 2))
            case "abs":
                return self._absolute(arguments[0])
            case "min" | "max":  # of two: half of the sum, less or more half of the distance
                sign = Fraction(1 if node.function == "max" else -1)
                return reduce(lambda one, other: self._end(sign, one, other), arguments)
            case _:
                return self._evaluated(node, *arguments)

    def _absolute(self, argument: Ratio) -> Ratio:
        if argument.number is not None:
            return argument if argument.number >= 0 else -argument
        for one, sign in self.chosen:
            if argument in (one, -one):
                return one.scaled(Fraction(sign))
        if len(self.chosen) == len(self.signs):
            self.others.append((*self.signs, -1))
            self.signs = (*self.signs, 1)
        self.chosen.append((argument, self.signs[len(self.chosen)]))
        return argument.scaled(Fraction(self.chosen[-1][1]))

    def _end(self, sign: Fraction, one: Ratio, other: Ratio) -> Ratio:
        distance = self._absolute(_bounded(one + -other))
        return _bounded(one + other + distance.scaled(sign)).scaled(Fraction(1, 2))

    def _evaluated(self, node: Expression, *parts: Ratio) -> Ratio:
        """A function of known numbers, rounded as one of them is."""
        numbers = [float(part.number) for part in parts if part.number is not None]
        if len(numbers) < len(parts):
            raise NoForm
        return self.constant(value(rebuilt(node, tuple(map(Number, numbers))), {}))


def _bounded(found: Ratio) -> Ratio:
    expect_time()
    if found.top.highest > HIGHEST_DEGREE:
        raise NoForm
    return found


class Eliminant(NamedTuple):
    """``polynomial``: its roots, and those of ``indeterminate``, at which forms may be 0/0, include
    every solution at which the polynomials ``positive`` are not negative. ``clear``: the residual
    is 0/0 nowhere, there are no radicals and signs, and rounding left no coefficient."""

    polynomial: Coefficients
    indeterminate: tuple[Coefficients, ...]
    positive: tuple[Coefficients, ...]
    clear: bool = False


def eliminants(
    equation: Equation,
    unknown: str,
    forms: Sequence[tuple[str, Expression]],
    known: Mapping[str, float],
    exact: Exact = Fraction,
    radicals: int = 0,
) -> list[Eliminant]:
    """The eliminants, one for each choice of signs; none if the equation is not algebraic.

    ``forms`` are further unknowns by those before them, with so many ``radicals`` in all; ``known``
    numbers are exact.
    """
    found, waiting = list[Eliminant](), [Signs()]
    try:
        while waiting:
            quotients = Quotients([unknown], known, exact, radicals, waiting.pop())
            quotients.follow(forms)
            found.append(_eliminant(quotients, equation, unknown))
            waiting += quotients.others
            if len(found) + len(waiting) > MAX_CHOICES:
                return []
    except NOT_RATIONAL:
        return []
    return found


def _eliminant(quotients: Quotients, equation: Equation, unknown: str) -> Eliminant:
    free = (dense(quotients.bare(factor)) for factor in quotients.common)
    indeterminate = tuple(factor for factor in free if len(factor) != 1)
    of_forms = len(quotients.common)
    left, right = map(quotients.of, equation.sides)
    difference = _bounded(left + -right)
    sizes = ((abs(c), difference.gross.get(powers, 0)) for powers, c in difference.top.items())
    significant = [size > TOUCHING * gross for size, gross in sizes]
    if not any(significant):
        raise NoForm  # it is 0 = 0, but for rounding
    polynomial = dense(quotients.bare(difference.top))
    for pole in map(Polynomial, quotients.poles):
        if polynomial and pole.generators == {unknown}:
            polynomial = without_roots(polynomial, dense(pole))
    if not polynomial or (len(polynomial) == 1 and quotients.radicals):
        raise NoForm
    chosen = [part.times(part.divisors).top * Fraction(sign) for part, sign in quotients.chosen]
    within = tuple(dense(part) for part in chosen if part.generators == {unknown})
    exact = not (quotients.common[of_forms:] or quotients.radicals or quotients.chosen)
    return Eliminant(polynomial, indeterminate, within, exact and all(significant))
