"""Rules brought into forms easier to solve: quotients of polynomials; without roots and jumps."""

from __future__ import annotations

from functools import reduce
from typing import TYPE_CHECKING, NamedTuple

from rulesheets.functions import TABLE, named
from rulesheets.syntax.nodes import (
    ONE,
    ZERO,
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
    exchange,
    is_number,
    multiply,
    names,
    negative,
    power,
    subtract,
)
from rulesheets.syntax.program import walk

if TYPE_CHECKING:
    from typing import TypeAlias


Polynomial: TypeAlias = tuple[Expression, ...]
"""Coefficients, lowest degree first."""

_UNIT: Polynomial = (ONE,)


class Rational(NamedTuple):
    numerator: Polynomial
    denominator: Polynomial = _UNIT


class _NoForm(Exception):
    """No quotient of polynomials of degree 2 at most."""


def equation(left: Expression, right: Expression, unknown: str) -> tuple[Polynomial, bool] | None:
    """``left - right`` brought to one polynomial, and whether a denominator was multiplied away.

    None where it is none of degree 2 at most.
    """
    try:
        difference = _add(_rational(left, unknown), _negated(_rational(right, unknown)))
    except _NoForm:
        return None
    return difference.numerator, difference.denominator != _UNIT


def _rational(expression: Expression, unknown: str) -> Rational:
    """The expression as a quotient of polynomials in ``unknown``. Raises _NoForm."""
    if unknown not in names(expression):
        return Rational((expression,))
    match expression:
        case Name():
            return Rational((ZERO, ONE))
        case Negative(operand):
            return _negated(_rational(operand, unknown))
        case Sum(terms):
            return reduce(_add, (_rational(term, unknown) for term in terms), Rational((ZERO,)))
        case Product(left, right):
            return _multiply(_rational(left, unknown), _rational(right, unknown))
        case Quotient(left, right):
            numerator, denominator = _rational(right, unknown)
            return _multiply(_rational(left, unknown), Rational(denominator, numerator))
        case Power(base, Number(1.0)):
            return _rational(base, unknown)
        case Power(base, Number(2.0)):
            inner = _rational(base, unknown)
            return _multiply(inner, inner)
    raise _NoForm


def _negated(value: Rational) -> Rational:
    return Rational(tuple(negative(c) for c in value.numerator), value.denominator)


def _add(left: Rational, right: Rational) -> Rational:
    if left.denominator == right.denominator:
        return Rational(_plus(left.numerator, right.numerator), left.denominator)
    first, second = (
        _times(left.numerator, right.denominator),
        _times(right.numerator, left.denominator),
    )
    return Rational(_plus(first, second), _times(left.denominator, right.denominator))


def _multiply(left: Rational, right: Rational) -> Rational:
    if len(right.numerator) == 1 and len(right.denominator) == 1 and right.numerator == _UNIT:
        divided = tuple(divide(c, right.denominator[0]) for c in left.numerator)
        return Rational(divided, left.denominator)
    return Rational(_times(left.numerator, right.numerator), _times(left.denominator, right.denominator))


def _plus(left: Polynomial, right: Polynomial) -> Polynomial:
    size = max(len(left), len(right))
    padded = [(*p, *[ZERO] * (size - len(p))) for p in (left, right)]
    return _trim(tuple(add(a, b) for a, b in zip(*padded, strict=True)))


def _times(left: Polynomial, right: Polynomial) -> Polynomial:
    """Raises _NoForm."""
    if len(left) + len(right) - 2 > 2:
        raise _NoForm
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


_TWO = Number(2.0)
_TANGENTS = named(lambda row: row.half_turn)
_DIRECTIONS = named(lambda row: row.direction)
_ROUGH = frozenset({"sqrt", "abs", *_TANGENTS, *_DIRECTIONS})


_PART = "#part"
"""Stands for a rough part of a rule."""


def smooth(left: Expression, right: Expression) -> Expression:
    """An expression that vanishes wherever ``left = right`` does, smooth where that can be had."""
    form = subtract(left, right)
    parts = [part for part in walk(form) if isinstance(part, Call) and part.function in _ROUGH]
    found = [(part, split) for part in dict.fromkeys(parts) if (split := _split(form, part))]
    return _without(found[0][0], *found[0][1]) if len(found) == 1 else form


def _split(form: Expression, rough: Call) -> tuple[Expression, Expression] | None:
    """``(factor, rest)`` with ``form = factor*rough + rest``; None where it is not linear."""
    match equation(exchange(form, rough, Name(_PART)), ZERO, _PART):
        case (rest, factor), False:
            return factor, rest
        case _:
            return None


def _without(rough: Call, factor: Expression, rest: Expression) -> Expression:
    """``factor*rough + rest = 0`` with the rough operation undone."""
    form = add(multiply(factor, rough), rest)
    if rough.function == "sqrt":
        return subtract(multiply(power(factor, _TWO), rough.arguments[0]), power(rest, _TWO))
    if rough.function == "abs":
        return subtract(power(multiply(factor, rough.arguments[0]), _TWO), power(rest, _TWO))
    if rough.function in _TANGENTS:
        sine, cosine = (call(name, *rough.arguments) for name in TABLE[rough.function].sine_and_cosine)
        return add(multiply(factor, sine), multiply(rest, cosine))
    if not isinstance(factor, Number) or len(rough.arguments) != 2 or abs(factor.value) != 1.0:
        return form
    angle = negative(rest) if factor.value > 0 else rest
    sine, cosine = (call(name, angle) for name in TABLE[rough.function].sine_and_cosine)
    y, x = rough.arguments
    return subtract(multiply(y, cosine), multiply(x, sine))
