"""Polynomials in several letters with exact rational coefficients: what elimination computes with.

A letter is a variable, the cosine or the sine of an angle, a root, or any other part of an
expression that stays as it is. Like terms are merged, so that what cancels by algebra is gone; the
square of a sine is written by that of the cosine."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TypeAlias

from rulesheets.syntax.nodes import (
    ONE,
    Call,
    Expression,
    Name,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    add,
    call,
    divide,
    multiply,
    names,
    negative,
    power,
)

Monomial: TypeAlias = tuple[tuple[str, int], ...]
"""Letters with their exponents, sorted."""

Polynomial: TypeAlias = dict[Monomial, Fraction]

UNIT: Monomial = ()
MAX_TERMS = 400


class NoForm(Exception):
    """The equations are no polynomials in letters, or of more terms than are worth a formula, or contradict
    one another."""


def constant(value: float | Fraction) -> Polynomial:
    return {UNIT: Fraction(value)} if value else {}


def letter(name: str) -> Polynomial:
    return {((name, 1),): Fraction(1)}


def _collected(terms: Iterable[tuple[Monomial, Fraction]]) -> Polynomial:
    """Like terms merged. Raises NoForm."""
    total: Polynomial = {}
    for monomial, coefficient in terms:
        before = total.get(monomial)
        total[monomial] = coefficient if before is None else before + coefficient
        if not total[monomial]:
            del total[monomial]
    if len(total) > MAX_TERMS:
        raise NoForm
    return total


def plus(*polynomials: Polynomial) -> Polynomial:
    return _collected(term for polynomial in polynomials for term in polynomial.items())


def times(left: Polynomial, right: Polynomial) -> Polynomial:
    terms = []
    for one, a in left.items():
        for other, b in right.items():
            joined = one or other
            if one and other:
                exponents = dict(one)
                for name, exponent in other:
                    exponents[name] = exponents.get(name, 0) + exponent
                joined = tuple(sorted(exponents.items()))
            terms.append((joined, a * b))
    return _collected(terms)


def scaled(polynomial: Polynomial, factor: Fraction) -> Polynomial:
    return {monomial: factor * coefficient for monomial, coefficient in polynomial.items()} if factor else {}


def minus(left: Polynomial, right: Polynomial) -> Polynomial:
    return plus(left, scaled(right, Fraction(-1)))


def letters(polynomial: Polynomial) -> set[str]:
    return {name for monomial in polynomial for name, _ in monomial}


def degree(polynomial: Polynomial, name: str) -> int:
    return max(
        (exponent for monomial in polynomial for other, exponent in monomial if other == name), default=0
    )


def coefficients(polynomial: Polynomial, name: str) -> dict[int, Polynomial]:
    """The polynomial by powers of one letter."""
    parts: dict[int, Polynomial] = {}
    for monomial, coefficient in polynomial.items():
        exponent = dict(monomial).get(name, 0)
        rest = tuple(item for item in monomial if item[0] != name)
        parts.setdefault(exponent, {})[rest] = coefficient
    return parts


def substituted(polynomial: Polynomial, name: str, value: Polynomial) -> Polynomial:
    """The polynomial with a letter replaced."""
    parts, raised = coefficients(polynomial, name), constant(1.0)
    total: Polynomial = {}
    for exponent in range(max(parts, default=0) + 1):
        raised = times(raised, value) if exponent else raised
        total = plus(total, times(parts.get(exponent, {}), raised))
    return total


def reduced(polynomial: Polynomial, pairs: Mapping[str, str]) -> Polynomial:
    """Every square of a sine replaced: sin² = 1 - cos². ``pairs`` gives the cosine of each sine."""
    for sine, cosine in pairs.items():
        while degree(polynomial, sine) >= 2:
            total: Polynomial = {}
            for exponent, part in coefficients(polynomial, sine).items():
                squares, rest = divmod(exponent, 2)
                for _ in range(squares):
                    part = minus(part, times(part, {((cosine, 2),): Fraction(1)}))
                total = plus(total, times(part, letter(sine)) if rest else part)
            polynomial = total
    return polynomial


def expression(polynomial: Polynomial, meaning: Mapping[str, Expression]) -> Expression:
    """The polynomial as an expression; ``meaning`` gives the expression of every letter."""
    terms: list[Expression] = []
    for monomial, coefficient in polynomial.items():
        product: Expression = ONE
        for name, exponent in monomial:
            product = multiply(product, power(meaning[name], Number(float(exponent))))
        if abs(coefficient) != 1:
            product = multiply(Number(float(abs(coefficient))), product)
        terms.append(product if coefficient > 0 else negative(product))
    return add(*terms)


_CIRCULAR = {"sind": "d", "cosd": "d", "sin": "", "cos": ""}
_QUARTER = {"d": 90.0, "": math.pi / 2}


@dataclass
class Letters:
    """What the letters stand for."""

    unknowns: frozenset[str]
    turning: Collection[str]
    meaning: dict[str, Expression] = field(default_factory=dict)
    pairs: dict[str, str] = field(default_factory=dict)
    angles: dict[str, tuple[str, str, str]] = field(default_factory=dict)
    open: set[str] = field(default_factory=set)
    roots: list[str] = field(default_factory=list)
    extra: list[Polynomial] = field(default_factory=list)

    def polynomial(self, node: Expression) -> Polynomial:
        """Of a part without unknowns: opened as far as it is a polynomial, a letter of its own beyond.

        Raises NoForm for a part with unknowns that is none.
        """
        known = not self.unknowns.intersection(names(node))
        match node:
            case Number(value):
                return constant(value)
            case Name(name):
                if name in self.angles:
                    raise NoForm
                self.meaning[name] = node
                if not known:
                    self.open.add(name)
                return letter(name)
            case Negative(operand):
                return scaled(self.polynomial(operand), Fraction(-1))
            case Sum(terms):
                return plus(*map(self.polynomial, terms))
            case Product(left, right):
                return reduced(times(self.polynomial(left), self.polynomial(right)), self.pairs)
            case Quotient(left, Number(value)) if value:
                return scaled(self.polynomial(left), 1 / Fraction(value))
            case Power(base, Number(value)) if value == 2.0 or (value in (3.0, 4.0) and not known):
                inner = raised = self.polynomial(base)
                for _ in range(int(value) - 1):
                    raised = reduced(times(raised, inner), self.pairs)
                return raised
            case Call(function, (argument,)) if function in _CIRCULAR:
                return self._circular(function, argument)
            case _ if known:
                return letter(self._named(node))
            case Quotient(left, right) if not self.unknowns.intersection(names(right)):
                dividend = self.polynomial(left)
                return times(dividend, letter(self._named(divide(Number(1.0), right))))
            case Quotient(left, right):  # one more unknown, and a product
                dividend, name = self.polynomial(left), self._auxiliary()
                product = reduced(times(letter(name), self.polynomial(right)), self.pairs)
                self.extra.append(minus(product, dividend))
                return letter(name)
            case Power(base, Number(0.5)) | Call("sqrt", (base,)):
                inside, name = self.polynomial(base), self._auxiliary()
                self.roots.append(name)
                self.extra.append(minus(times(letter(name), letter(name)), inside))
                return letter(name)
        raise NoForm

    def _named(self, node: Expression) -> str:
        """The letter of a known part that stays as it is."""
        for name, meaning in self.meaning.items():
            if meaning == node:
                return name
        name = f"#k{len(self.meaning)}"
        self.meaning[name] = node
        return name

    def _auxiliary(self) -> str:
        name = f"#u{len(self.meaning)}"
        self.meaning[name] = Name(name)
        self.open.add(name)
        return name

    # --- angles ---

    def _circular(self, function: str, argument: Expression) -> Polynomial:
        """Of ``±base + 90·quarters + rest``: at most one unknown, at most once."""
        unit, cosine = _CIRCULAR[function], function.startswith("cos")
        turns = _count(argument, _QUARTER[unit])
        if turns is not None and unit:
            whole = (1.0, 0.0, -1.0, 0.0)
            return constant(whole[(turns if cosine else turns - 1) % 4])
        terms = argument.terms if isinstance(argument, Sum) else (argument,)
        unknown = [term for term in terms if self.unknowns.intersection(names(term))]
        base = next((t for t in unknown or terms if _name_of(t)), None)
        if len(unknown) > 1 or (unknown and base is None):
            raise NoForm
        quarters, rest = 0, []
        for term in terms:
            count = _count(term, _QUARTER[unit])
            if count is not None:
                quarters += count
            elif term is not base:
                rest.append(term)
        if base is None or (rest and not unknown):
            c, s = map(letter, self._pair(argument, unit))
            return c if cosine else s
        name, sign = _name_of(base), -1 if isinstance(base, Negative) else 1
        pair = self._of_unknown(name, unit) if unknown else self._pair(Name(name), unit)
        c, s = letter(pair[0]), scaled(letter(pair[1]), Fraction(sign))
        for _ in range(quarters % 4):
            c, s = scaled(s, Fraction(-1)), c
        if rest:
            cos, sin = map(letter, self._pair(add(*rest), unit))
            c, s = minus(times(c, cos), times(s, sin)), plus(times(s, cos), times(c, sin))
        return reduced(c if cosine else s, self.pairs)

    def _of_unknown(self, name: str, unit: str) -> tuple[str, str]:
        if name in self.open or name not in self.turning:
            raise NoForm
        cosine, sine, known = self.angles.setdefault(name, (f"#c {name}", f"#s {name}", unit))
        if known != unit:
            raise NoForm
        self.pairs[sine] = cosine
        self.open.update((cosine, sine))
        self.meaning.update({cosine: Name(cosine), sine: Name(sine)})
        return cosine, sine

    def _pair(self, argument: Expression, unit: str) -> tuple[str, str]:
        cosine = self._named(call("cos" + unit, argument))
        sine = self._named(call("sin" + unit, argument))
        self.pairs[sine] = cosine
        return cosine, sine


def _name_of(term: Expression) -> str:
    """The name that a term is, with either sign; blank where it is none."""
    inner = term.operand if isinstance(term, Negative) else term
    return inner.name if isinstance(inner, Name) else ""


def _count(term: Expression, quarter: float) -> int | None:
    """How many right angles a term is."""
    inner, sign = (term.operand, -1) if isinstance(term, Negative) else (term, 1)
    count = sign * inner.value / quarter if isinstance(inner, Number) else 0.5
    return int(count) if count == int(count) and abs(count) < 1e6 else None
