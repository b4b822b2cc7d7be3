"""Polynomials over the rationals, by sympy, and those that algebraic equations lead to.

The roots of the *eliminants* of an equation with quotients, roots and absolute values include every
solution. Quotients are multiplied away; a root s of degree q of an expression e is one more unknown
with s^q = e. Those are eliminated one by one by resultants (J. J. Sylvester). An absolute value is
its argument or the opposite: there is an eliminant for each choice of signs. The polynomials may
have further roots, such as those of another sign, or poles. Where an explicit form is 0/0 its
unknown is free, and a solution there may be none of their roots.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import partial, reduce
from typing import Any, NamedTuple, TypeAlias

from sympy import QQ, Poly, resultant
from sympy.polys.fields import field
from sympy.polys.rings import ring

from rulesheets.deadline import expect_time
from rulesheets.evaluate import Undefined, value
from rulesheets.evaluate.number import Arithmetic
from rulesheets.syntax.nodes import (
    Call,
    Expression,
    Name,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    Symbol,
    rebuilt,
)

MAX_RADICALS = 3
MAX_ROOT = 4
MAX_DEGREE = 24
MAX_CHOICES = 64
"""Of the signs of absolute values."""
CLEAR = Fraction(1, 10**9)
"""Share of two numbers by which they differ clearly."""

Coefficients: TypeAlias = list[Fraction]
"""Of a polynomial, lowest degree first."""


def exact(number: float | Fraction) -> Any:
    return QQ(*number.as_integer_ratio())


def resultant_of(*polynomials: Mapping[tuple[int, ...], Fraction]) -> Coefficients:
    """The resultant of polynomials in y and x, by exponents of these, in x; none of 0."""
    made, *_ = ring(["y", "x"], QQ)
    p, q = (made.from_dict({m: exact(c) for m, c in p.items()}) for p in polynomials)
    dense = p.resultant(q).to_dense()
    return [Fraction(int(c.numerator), int(c.denominator)) for c in reversed(dense)]


# --- the eliminant --------------------------------------------------------------


class Eliminant(NamedTuple):
    """``polynomial``: its roots, and those of ``indeterminate``, at which forms may be 0/0, include
    every solution at which the polynomials ``positive`` are not negative; empty if there is no
    solution."""

    polynomial: Coefficients
    indeterminate: tuple[Coefficients, ...]
    positive: tuple[Coefficients, ...]


class NotAlgebraic(Exception):
    """The equation is not an algebraic function of low degree of the unknown."""


def eliminants(
    left: Expression,
    right: Expression,
    unknown: str,
    forms: Sequence[tuple[str, Expression]],
    known: Mapping[str, float],
) -> list[Eliminant] | None:
    """The eliminants, one for each choice of signs; None if the equation is not algebraic.

    ``forms`` are further unknowns by those before them; ``known`` numbers are exact.
    """
    found, waiting = list[Eliminant](), [tuple[int, ...]()]
    try:
        while waiting:
            one = _Eliminator(unknown, known, waiting.pop())
            found.append(one.run(left, right, forms))
            waiting += one.others
            if len(found) + len(waiting) > MAX_CHOICES:
                return None
    except (NotAlgebraic, OverflowError):
        return None
    return found


class _Eliminator(Arithmetic[Any]):
    """Quotients of polynomials (sympy's ``FracElement``) in the unknown and the radicals.

    ``signs`` are those of the first absolute values; ``others`` wait for eliminations.
    """

    def __init__(self, unknown: str, known: Mapping[str, float], signs: tuple[int, ...]) -> None:
        self.signs, self.others = signs, list[tuple[int, ...]]()
        self.chosen: dict[Any, int] = {}
        symbols = ["x", *(f"s{k}" for k in range(MAX_RADICALS))]
        self.field, first, *self.radicals = field(symbols, QQ)
        self.values = {name: self._exact(number) for name, number in known.items()}
        self.values[unknown] = first
        self.relations: dict[tuple[Any, int], Any] = {}
        self.common: list[Any] = []

    def run(
        self, left: Expression, right: Expression, forms: Sequence[tuple[str, Expression]]
    ) -> Eliminant:
        for name, form in forms:
            self.values[name] = self.of(form)
        factors = map(self._bare, self.common)
        common = (factor for factor in factors if not factor or not factor.is_ground)
        indeterminate = tuple(map(self._coefficients, common))
        sides = self.of(left), self.of(right)
        found = self._bare(self._bounded(sides[0] - sides[1]).numer)
        chosen = [(a.numer * a.denom, sign) for a, sign in [*self.chosen.items()][::2]]
        within = tuple(self._coefficients(sign * a) for a, sign in chosen if not _has_radicals(a))
        if within and found and found.is_ground and all(map(self._is_constant, sides)):
            # a case without a solution, unless that is by rounding
            one, other = map(self._constant, sides)
            if abs(one - other) > CLEAR * max(abs(one), abs(other)):
                return Eliminant([], indeterminate, within)
        return Eliminant(self._coefficients(found), indeterminate, within)

    def _bare(self, found: Any) -> Any:
        """A polynomial without radicals, whose roots include those of ``found``."""
        for (inside, degree), radical in reversed(self.relations.items()):
            expect_time()
            relation = radical.numer**degree * inside.denom - inside.numer
            if max(found.degrees()) > MAX_DEGREE:
                raise NotAlgebraic
            symbol = radical.as_expr()
            if symbol in found.as_expr().free_symbols:
                eliminated = resultant(found.as_expr(), relation.as_expr(), symbol)
                found = self.field.ring.from_expr(eliminated.expand())
        return found

    def _coefficients(self, found: Any) -> Coefficients:
        polynomial = Poly(found.as_expr(), self.field.gens[0].as_expr(), domain=QQ)
        if polynomial.degree() > MAX_DEGREE or polynomial.degree() < 1:
            raise NotAlgebraic
        return [Fraction(int(c.p), int(c.q)) for c in reversed(polynomial.all_coeffs())]

    # --- expressions ---

    def _exact(self, number: float) -> Any:
        if not math.isfinite(number):
            raise NotAlgebraic
        return self.field(exact(number))

    def number(self, node: Number) -> Any:
        return self._exact(node.value)

    def name(self, node: Name) -> Any:
        if node.name not in self.values:
            raise NotAlgebraic
        return self.values[node.name]

    def sum(self, node: Sum) -> Any:
        total = self.field.zero
        for term in node.terms:
            total = self._bounded(total + self.of(term))
        return total

    def product(self, node: Product) -> Any:
        return self._bounded(super().product(node))

    def divided(self, node: Quotient, above: Any, below: Any) -> Any:
        """The quotient; where both may be 0 is noted: roots may be 0 without a common factor."""
        if not below:
            raise NotAlgebraic
        one, other = above.numer, below.numer
        if not other.is_ground and not (one and one.is_ground):
            bare = not (_has_radicals(one) or _has_radicals(other))
            factor = one.gcd(other) if bare else other
            if not factor.is_ground:
                self.common.append(factor)
        return self._bounded(above / below)

    def raised(self, node: Power, base: Any, exponent: Any) -> Any:
        number = self._constant(exponent)
        near = number.limit_denominator(MAX_ROOT)
        if float(near) != float(number):
            return self._evaluated(node, base, exponent)
        return self._power(base, near)

    def applied(self, node: Call, arguments: list[Any]) -> Any:
        match node.function:
            case "pi":
                return self._exact(math.pi)
            case "sqrt":
                return self._power(arguments[0], Fraction(1, 2))
            case "abs":
                return self._absolute(arguments[0])
            case "min" | "max":  # of two: half of the sum, less or more half of the distance
                return reduce(partial(self._end, 1 if node.function == "max" else -1), arguments)
            case _:
                return self._evaluated(node, *arguments)

    def _absolute(self, argument: Any) -> Any:
        if self._is_constant(argument):
            return argument if self._constant(argument) >= 0 else -argument
        if argument not in self.chosen:
            place = len(self.chosen) // 2
            if place == len(self.signs):
                self.others.append((*self.signs, -1))
                self.signs = (*self.signs, 1)
            self.chosen |= {argument: self.signs[place], -argument: -self.signs[place]}
        return self.chosen[argument] * argument

    def _end(self, sign: int, one: Any, other: Any) -> Any:
        return self._bounded(one + other + sign * self._absolute(one - other)) / 2

    def _evaluated(self, node: Expression, *parts: Any) -> Any:
        """A function of numbers, rounded as one of the inputs is."""
        numbers = (Number(float(self._constant(part))) for part in parts)
        try:
            return self._exact(value(rebuilt(node, tuple(numbers)), {}))
        except Undefined:
            raise NotAlgebraic from None

    def _is_constant(self, element: Any) -> bool:
        return bool(element.numer.is_ground and element.denom.is_ground)

    def _constant(self, element: Any) -> Fraction:
        if not self._is_constant(element):
            raise NotAlgebraic
        number = element.numer.coeff(1) / element.denom.coeff(1)
        return Fraction(int(number.numerator), int(number.denominator))

    def symbol(self, node: Symbol) -> Any:
        raise NotAlgebraic

    def _power(self, base: Any, exponent: Fraction) -> Any:
        if exponent.denominator > 1:
            key = base, exponent.denominator
            if key not in self.relations:
                if len(self.relations) == MAX_RADICALS:
                    raise NotAlgebraic
                self.relations[key] = self.radicals[len(self.relations)]
            base = self.relations[key]
        if abs(exponent.numerator) > MAX_DEGREE or (exponent <= 0 and not base):
            raise NotAlgebraic
        return self._bounded(base**exponent.numerator)

    def _bounded(self, found: Any) -> Any:
        expect_time()
        degree = max(*found.numer.degrees(), *found.denom.degrees())
        if len(found.numer) + len(found.denom) > 400 or degree > 2 * MAX_DEGREE:
            raise NotAlgebraic
        return found


def _has_radicals(polynomial: Any) -> bool:
    return any(any(powers[1:]) for powers in polynomial.monoms())
