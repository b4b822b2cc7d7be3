"""The value of an expression to many digits."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache
from typing import Any, TypeAlias, assert_never

from rulesheets.evaluate.number import Undefined
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

ExtendedValues: TypeAlias = Mapping[str, Any]
"""Floats or mpmath numbers (taken exactly) and symbols, by the full names of variables."""


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
            return _power(expression, extended(base, values, digits), extended(exponent, values, digits))
        case Call(_, arguments):
            return _call(expression, [extended(argument, values, digits) for argument in arguments], digits)
        case Symbol():
            raise Undefined("symbol", (), expression)
        case _:
            assert_never(expression)


@lru_cache(maxsize=4096)
def _exact(value: float, digits: int) -> Extended:
    """A number of a rule, which is met again and again."""
    return context(digits).mpf(value)


def _quotient(expression: Quotient, numerator: Extended, divisor: Extended) -> Extended:
    if divisor == 0:
        raise Undefined("/", (0.0,), expression)
    return numerator / divisor


def _power(expression: Power, base: Extended, exponent: Extended) -> Extended:
    negative_root = base < 0 and exponent != int(exponent)
    if negative_root or (base == 0 and exponent < 0):
        raise Undefined("^", (float(base), float(exponent)), expression)
    return base**exponent


def _call(expression: Call, arguments: list[Extended], digits: int) -> Extended:
    for argument in arguments:
        if argument and abs(argument.exp + argument.bc) > MOST_BITS:
            raise Undefined("overflow", (math.inf,), expression)
    try:
        return functions(digits)[expression.function](*arguments)
    except (ValueError, ZeroDivisionError, OverflowError):
        raise Undefined(expression.function, tuple(map(float, arguments)), expression) from None
