"""An expression as a quotient of two polynomials of low degree in one unknown.

Serves equations in which the unknown occurs more than once: linear and quadratic
ones are solved by formula. Coefficients are expressions free of the unknown.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rulesheets.syntax.nodes import (
    ONE,
    ZERO,
    Expression,
    Name,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    add,
    divide,
    is_number,
    multiply,
    names,
    negative,
)

if TYPE_CHECKING:
    from typing import TypeAlias

Polynomial: TypeAlias = tuple[Expression, ...]
"""Coefficients, lowest degree first."""

QUADRATIC = 2
_UNIT: Polynomial = (ONE,)


@dataclass(frozen=True, slots=True)
class Rational:
    numerator: Polynomial
    denominator: Polynomial = _UNIT


def rational(expression: Expression, unknown: str, degree: int = QUADRATIC) -> Rational | None:
    """The expression as a quotient of polynomials in ``unknown``; None where it is none up to ``degree``."""
    if unknown not in names(expression):
        return Rational((expression,))
    match expression:
        case Name():
            return Rational((ZERO, ONE))
        case Negative(operand):
            inner = rational(operand, unknown, degree)
            return inner and Rational(tuple(negative(c) for c in inner.numerator), inner.denominator)
        case Sum(terms):
            return _sum(terms, unknown, degree)
        case Product(left, right):
            return _multiply(rational(left, unknown, degree), rational(right, unknown, degree), degree)
        case Quotient(left, right):
            below = _reciprocal(rational(right, unknown, degree))
            return _multiply(rational(left, unknown, degree), below, degree)
        case Power(base, Number(exponent)) if exponent in range(1, degree + 1):
            inner = raised = rational(base, unknown, degree)
            for _ in range(int(exponent) - 1):
                raised = _multiply(raised, inner, degree)
            return raised
        case _:
            return None


def equation(
    left: Expression, right: Expression, unknown: str, degree: int = QUADRATIC
) -> tuple[Polynomial, bool] | None:
    """``left - right`` brought to one polynomial, and whether a denominator was multiplied away."""
    a, b = rational(left, unknown, degree), rational(right, unknown, degree)
    difference = _add(a, b and Rational(tuple(negative(c) for c in b.numerator), b.denominator), degree)
    if difference is None:
        return None
    return difference.numerator, difference.denominator != _UNIT


def _sum(terms: tuple[Expression, ...], unknown: str, degree: int) -> Rational | None:
    total: Rational | None = Rational((ZERO,))
    for term in terms:
        total = _add(total, rational(term, unknown, degree), degree)
    return total


def _add(left: Rational | None, right: Rational | None, degree: int) -> Rational | None:
    if left is None or right is None:
        return None
    if left.denominator == right.denominator:
        return Rational(_plus(left.numerator, right.numerator), left.denominator)
    first = _times(left.numerator, right.denominator, degree)
    second = _times(right.numerator, left.denominator, degree)
    denominator = _times(left.denominator, right.denominator, degree)
    if first is None or second is None or denominator is None:
        return None
    return Rational(_plus(first, second), denominator)


def _multiply(left: Rational | None, right: Rational | None, degree: int) -> Rational | None:
    if left is None or right is None:
        return None
    if len(right.numerator) == 1 and len(right.denominator) == 1 and right.numerator == _UNIT:
        divided = tuple(divide(c, right.denominator[0]) for c in left.numerator)
        return Rational(divided, left.denominator)
    numerator = _times(left.numerator, right.numerator, degree)
    denominator = _times(left.denominator, right.denominator, degree)
    return None if numerator is None or denominator is None else Rational(numerator, denominator)


def _reciprocal(value: Rational | None) -> Rational | None:
    return None if value is None else Rational(value.denominator, value.numerator)


def _plus(left: Polynomial, right: Polynomial) -> Polynomial:
    size = max(len(left), len(right))
    padded = [(*p, *[ZERO] * (size - len(p))) for p in (left, right)]
    return _trim(tuple(add(a, b) for a, b in zip(*padded, strict=True)))


def _times(left: Polynomial, right: Polynomial, degree: int) -> Polynomial | None:
    if len(left) + len(right) - 2 > degree:
        return None
    product: list[Expression] = [ZERO] * (len(left) + len(right) - 1)
    for i, a in enumerate(left):
        for j, b in enumerate(right):
            product[i + j] = add(product[i + j], multiply(a, b))
    return _trim(tuple(product))


def _trim(polynomial: Polynomial) -> Polynomial:
    size = len(polynomial)
    while size > 1 and is_number(polynomial[size - 1], 0.0):
        size -= 1
    return polynomial[:size]
