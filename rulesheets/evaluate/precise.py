"""The value of an expression to many digits."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache
from typing import Any, TypeAlias, assert_never

from rulesheets.evaluate.number import Undefined
from rulesheets.functions import TABLE
from rulesheets.functions.extended import Extended, context, functions
from rulesheets.nodes import (
    Call,
    Expression,
    Name,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    Symbol,
)
from rulesheets.program import walk

ExtendedValues: TypeAlias = Mapping[str, Any]
"""Floats or mpmath numbers (taken exactly) and symbols, by the full names of variables."""


LARGE_BITS = 40
"""Binary digits before the point from which on an exponent is large."""
SPARE = 5
MOST_BITS = 100_000
"""Binary exponents of arguments beyond which a function may take all memory (``sin`` of e^1e300)."""


def extended(expression: Expression, values: ExtendedValues, digits: int = 50) -> Extended:
    """The value of ``expression`` computed with ``digits`` decimal digits, an mpmath number.

    Floats, those of the expression included, are taken as the exact numbers that they are.
    Raises Undefined where an operation has no real value, KeyError for a variable without one.
    """
    match expression:
        case Number(value):
            return _exact(value, digits)
        case Name(name):
            if isinstance(values[name], str):
                raise Undefined("symbol", (), expression)
            return context(digits).mpf(values[name])
        case Negative(operand):
            return -extended(operand, values, digits)
        case Sum((one, other)):
            return extended(one, values, digits) + extended(other, values, digits)
        case Sum(terms):
            return context(digits).fsum(extended(term, values, digits) for term in terms)
        case Product(left, right):
            return extended(left, values, digits) * extended(right, values, digits)
        case Quotient(left, right):
            return _quotient(expression, extended(left, values, digits), extended(right, values, digits))
        case Power(base, exponent):
            return _power(
                expression, extended(base, values, digits), extended(exponent, values, digits), digits
            )
        case Call(_, arguments):
            return _call(expression, [extended(argument, values, digits) for argument in arguments], digits)
        case Symbol():
            raise Undefined("symbol", (), expression)
        case _:
            assert_never(expression)


def in_many_digits(expression: Expression) -> bool:
    """Whether every function in it is known to more digits than those of floats."""
    calls = (part for part in walk(expression) if isinstance(part, Call))
    return all(TABLE[call.function].digits is not None for call in calls)


@lru_cache(maxsize=4096)
def _exact(value: float, digits: int) -> Extended:
    """A number of a rule, which is met again and again."""
    return context(digits).mpf(value)


def _quotient(expression: Quotient, numerator: Extended, divisor: Extended) -> Extended:
    if divisor == 0:
        raise Undefined("/", (0.0,), expression)
    return numerator / divisor


def _power(expression: Power, base: Extended, exponent: Extended, digits: int) -> Extended:
    negative_root = base < 0 and exponent != int(exponent)
    if negative_root or (base == 0 and exponent < 0):
        raise Undefined("^", (float(base), float(exponent)), expression)
    size = exponent.exp + exponent.bc if exponent else 0
    if size <= LARGE_BITS or not base:
        return base**exponent
    return _large_power(expression, base, exponent, size, digits)


def _large_power(expression: Power, base: Extended, exponent: Extended, size: int, digits: int) -> Extended:
    """By the logarithm, with as many digits more as the exponent has before its point: mpmath squares, and
    squares again, for whole exponents, and for others it takes no more digits."""
    if size > MOST_BITS:
        raise Undefined("overflow", (math.inf,), expression)
    mp = context(digits + SPARE + size // 3)
    found = mp.exp(mp.mpf(exponent) * mp.ln(abs(mp.mpf(base))))
    odd = base < 0 and int(exponent) % 2 == 1
    return +context(digits).mpf(-found if odd else found)


def _call(expression: Call, arguments: list[Extended], digits: int) -> Extended:
    for argument in arguments:
        if argument and abs(argument.exp + argument.bc) > MOST_BITS:
            raise Undefined("overflow", (math.inf,), expression)
    try:
        return functions(digits)[expression.function](*arguments)
    except (ValueError, ZeroDivisionError, OverflowError):
        raise Undefined(expression.function, tuple(map(float, arguments)), expression) from None
