"""Polynomials in many letters with exact rational coefficients: what elimination computes with.

A letter is a variable, the cosine or the sine of an angle, a root, or any other part of an
expression that stays as it is. Like terms are merged, so that what cancels by algebra is gone; the
square of a sine is written by that of the cosine.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import TypeAlias

from rulesheets.syntax.nodes import ONE, ZERO, Expression, Number, add, multiply, negative, power

Monomial: TypeAlias = tuple[tuple[str, int], ...]
"""Letters with their exponents, sorted."""

Polynomial: TypeAlias = dict[Monomial, Fraction]

UNIT: Monomial = ()
MAX_TERMS = 400


class TooLarge(Exception):
    """More terms than are worth a formula."""


def constant(value: float | Fraction) -> Polynomial:
    return {UNIT: Fraction(value)} if value else {}


def letter(name: str) -> Polynomial:
    return {((name, 1),): Fraction(1)}


def plus(*polynomials: Polynomial) -> Polynomial:
    total: Polynomial = {}
    for polynomial in polynomials:
        for monomial, coefficient in polynomial.items():
            _accumulate(total, monomial, coefficient)
    return _bounded(total)


def times(left: Polynomial, right: Polynomial) -> Polynomial:
    product: Polynomial = {}
    for one, a in left.items():
        for other, b in right.items():
            _accumulate(product, _joined(one, other), a * b)
    return _bounded(product)


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
    parts = coefficients(polynomial, name)
    if set(parts) <= {0}:
        return polynomial
    total: Polynomial = dict(parts.get(0, {}))
    raised, reached = constant(1.0), 0
    for exponent in sorted(parts):
        if exponent:
            for _ in range(exponent - reached):
                raised = times(raised, value)
            reached = exponent
            total = plus(total, times(parts[exponent], raised))
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
    return add(*(_term(coefficient, monomial, meaning) for monomial, coefficient in polynomial.items()))


def _term(coefficient: Fraction, monomial: Monomial, meaning: Mapping[str, Expression]) -> Expression:
    if not coefficient:
        return ZERO
    product: Expression = ONE
    for name, exponent in monomial:
        product = multiply(product, power(meaning[name], Number(float(exponent))))
    if abs(coefficient) != 1:
        product = multiply(Number(float(abs(coefficient))), product)
    return product if coefficient > 0 else negative(product)


def _accumulate(total: Polynomial, monomial: Monomial, coefficient: Fraction) -> None:
    before = total.get(monomial)
    found = coefficient if before is None else before + coefficient
    if found:
        total[monomial] = found
    else:
        total.pop(monomial, None)


def _joined(one: Monomial, other: Monomial) -> Monomial:
    if not one:
        return other
    if not other:
        return one
    exponents = dict(one)
    for name, exponent in other:
        exponents[name] = exponents.get(name, 0) + exponent
    return tuple(sorted(exponents.items()))


def _bounded(polynomial: Polynomial) -> Polynomial:
    if len(polynomial) > MAX_TERMS:
        raise TooLarge
    return polynomial
