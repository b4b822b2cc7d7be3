"""One polynomial whose roots include every solution of an equation with quotients, roots and absolute values.

Quotients are multiplied away; a root s of degree q of an expression e is one more unknown with s^q = e, and
so is an absolute value, with s^2 = e^2. Those are eliminated one by one by resultants (J. J. Sylvester).
The polynomial may have further roots, such as those of the other sign of a square root, or poles. Where an
explicit form is 0/0 its unknown is free, and a solution there may be none of its roots.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

from sympy import QQ, Poly, resultant
from sympy.polys.rings import ring

from rulesheets.deadline import expect_time
from rulesheets.syntax.nodes import Call, Expression, Name, Negative, Number, Power, Product, Quotient, Sum

MAX_RADICALS = 3
MAX_ROOT = 4
MAX_DEGREE = 24

Ratio: TypeAlias = "tuple[Any, Any]"
"""Numerator and denominator in the ring of the unknown and the radicals."""


Coefficients: TypeAlias = "list[Fraction]"
"""Of a polynomial, lowest degree first."""


@dataclass(frozen=True, slots=True)
class Eliminant:
    """``polynomial``: its roots, and those of ``indeterminate``, at which forms may be 0/0, include every
    solution."""

    polynomial: Coefficients
    indeterminate: tuple[Coefficients, ...] = ()


class NotAlgebraic(Exception):
    """Something that is no algebraic function of low degree of the unknown."""


def eliminant(
    left: Expression,
    right: Expression,
    unknown: str,
    forms: Sequence[tuple[str, Expression]],
    known: Mapping[str, float],
) -> Eliminant | None:
    """The eliminant; None where the equation is not algebraic in the unknown.

    ``forms`` are further unknowns as expressions of those before them; ``known`` numbers are exact fractions.
    """
    try:
        return _Elimination(unknown, known).run(left, right, forms)
    except (NotAlgebraic, OverflowError):
        return None


class _Elimination:
    def __init__(self, unknown: str, known: Mapping[str, float]) -> None:
        self.ring, first, *self.radicals = ring(["x", *(f"s{k}" for k in range(MAX_RADICALS))], QQ)
        self.one = self.ring.one
        self.values: dict[str, Ratio] = {name: self._number(number) for name, number in known.items()}
        self.values[unknown] = first, self.one
        self.relations: dict[tuple[Any, Any, int], Any] = {}
        self.common: list[Any] = []

    def run(self, left: Expression, right: Expression, forms: Sequence[tuple[str, Expression]]) -> Eliminant:
        for name, form in forms:
            self.values[name] = self._ratio(form)
        common = map(self._bare, self.common)
        indeterminate = tuple(
            self._coefficients(factor) for factor in common if not factor or not factor.is_ground
        )
        found = self._plus(self._ratio(left), self._scaled(self._ratio(right), -1))[0]
        return Eliminant(self._coefficients(self._bare(found)), indeterminate)

    def _bare(self, found: Any) -> Any:
        """A polynomial without radicals, whose roots include those of ``found``."""
        for (numerator, denominator, degree), radical in reversed(self.relations.items()):
            expect_time()
            relation = radical**degree * denominator - numerator
            if max(found.degrees()) > MAX_DEGREE:
                raise NotAlgebraic
            symbol = radical.as_expr()
            if symbol in found.as_expr().free_symbols:
                eliminated = resultant(found.as_expr(), relation.as_expr(), symbol)
                found = self.ring.from_expr(eliminated.expand())
        return found

    def _coefficients(self, found: Any) -> Coefficients:
        polynomial = Poly(found.as_expr(), self.ring.gens[0].as_expr(), domain=QQ)
        if polynomial.degree() > MAX_DEGREE or polynomial.degree() < 1:
            raise NotAlgebraic
        return [Fraction(int(c.p), int(c.q)) for c in reversed(polynomial.all_coeffs())]

    # --- expressions ---

    def _ratio(self, node: Expression) -> Ratio:
        expect_time()
        match node:
            case Number(number):
                return self._number(number)
            case Name(name):
                if name not in self.values:
                    raise NotAlgebraic
                return self.values[name]
            case Negative(operand):
                return self._scaled(self._ratio(operand), -1)
            case Sum(terms):
                total = self._ratio(terms[0])
                for term in terms[1:]:
                    total = self._plus(total, self._ratio(term))
                return total
            case Product(left, right):
                return self._times(self._ratio(left), self._ratio(right))
            case Quotient(left, right):
                return self._quotient(self._ratio(left), self._ratio(right))
            case Power(base, exponent):
                return self._power(self._ratio(base), self._constant(exponent))
            case Call("pi", ()):
                return self._number(math.pi)
            case Call("sqrt", (inside,)):
                return self._power(self._ratio(inside), Fraction(1, 2))
            case Call("abs", (inside,)):
                return self._power(self._power(self._ratio(inside), Fraction(2)), Fraction(1, 2))
            case _:
                raise NotAlgebraic

    def _constant(self, exponent: Expression) -> Fraction:
        numerator, denominator = self._ratio(exponent)
        if not (numerator.is_ground and denominator.is_ground):
            raise NotAlgebraic
        number = numerator.coeff(1) / denominator.coeff(1)
        near = Fraction(int(number.numerator), int(number.denominator)).limit_denominator(MAX_ROOT)
        if float(near) != float(Fraction(int(number.numerator), int(number.denominator))):
            raise NotAlgebraic
        return near

    def _power(self, base: Ratio, exponent: Fraction) -> Ratio:
        if exponent.denominator > 1:
            base = self._radical(base, exponent.denominator)
        if abs(exponent.numerator) > MAX_DEGREE:
            raise NotAlgebraic
        numerator, denominator = base if exponent > 0 else self._inverse(base)
        count = abs(exponent.numerator)
        return self._bounded(numerator**count, denominator**count)

    def _radical(self, inside: Ratio, degree: int) -> Ratio:
        key = (*inside, degree)
        if key not in self.relations:
            if len(self.relations) == MAX_RADICALS:
                raise NotAlgebraic
            self.relations[key] = self.radicals[len(self.relations)]
        return self.relations[key], self.one

    def _number(self, number: float) -> Ratio:
        if not math.isfinite(number):
            raise NotAlgebraic
        exact = Fraction(number)
        return self.ring(QQ(exact.numerator, exact.denominator)), self.one

    def _scaled(self, value: Ratio, factor: int) -> Ratio:
        return value[0] * factor, value[1]

    def _inverse(self, value: Ratio) -> Ratio:
        if not value[0]:
            raise NotAlgebraic
        return value[1], value[0]

    def _quotient(self, one: Ratio, other: Ratio) -> Ratio:
        """The quotient, with a note of where both may be 0. Radicals may be so without a common factor."""
        above, below = one[0], other[0]
        if not below.is_ground and not (above and above.is_ground):
            bare = not any(any(powers[1:]) for part in (above, below) for powers in part.monoms())
            factor = above.gcd(below) if bare else below
            if not factor.is_ground:
                self.common.append(factor)
        return self._times(one, self._inverse(other))

    def _times(self, one: Ratio, other: Ratio) -> Ratio:
        return self._bounded(one[0] * other[0], one[1] * other[1])

    def _plus(self, one: Ratio, other: Ratio) -> Ratio:
        if one[1] == other[1]:
            return self._bounded(one[0] + other[0], one[1])
        return self._bounded(one[0] * other[1] + other[0] * one[1], one[1] * other[1])

    def _bounded(self, numerator: Any, denominator: Any) -> Ratio:
        if not denominator.is_ground and numerator:
            numerator, denominator = numerator.cancel(denominator)
        if sum(map(len, (numerator, denominator))) > 400:
            raise NotAlgebraic
        return numerator, denominator
