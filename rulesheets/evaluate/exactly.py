"""The value of an expression in rational numbers, where it has one that can be computed exactly."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from math import isqrt, prod
from typing import assert_never

from rulesheets.nodes import Call, Expression, Name, Negative, Number, Power, Product, Quotient, Sum, Symbol

LARGEST = 64
"""Exponents beyond which numbers are not multiplied out."""


class Inexact(Exception):
    """The value is no rational number, or none that is known exactly."""


NOTHING: Mapping[float, Fraction] = {}


def exactly(
    expression: Expression, numbers: Mapping[str, Fraction], constants: Mapping[float, Fraction] = NOTHING
) -> Fraction:
    """The exact value; floats in the expression are the numbers that they are, or what ``constants`` say.

    Raises Inexact where an operation leaves the rational numbers or is undefined, and for a variable without
    a number.
    """
    match expression:
        case Number(value):
            return constants[value] if value in constants else Fraction(value)
        case Name(name):
            if name not in numbers:
                raise Inexact(name)
            return numbers[name]
        case Negative(operand):
            return -exactly(operand, numbers, constants)
        case Sum(terms):
            return sum((exactly(term, numbers, constants) for term in terms), Fraction(0))
        case Product(left, right):
            return prod(
                (exactly(left, numbers, constants), exactly(right, numbers, constants)), start=Fraction(1)
            )
        case Quotient(left, right):
            return _quotient(exactly(left, numbers, constants), exactly(right, numbers, constants))
        case Power(base, exponent):
            return _power(exactly(base, numbers, constants), exactly(exponent, numbers, constants))
        case Call(function, arguments):
            return _call(function, [exactly(argument, numbers, constants) for argument in arguments])
        case Symbol(name):
            raise Inexact(name)
        case _:
            assert_never(expression)


def _quotient(above: Fraction, below: Fraction) -> Fraction:
    if not below:
        raise Inexact("/")
    return above / below


def _power(base: Fraction, exponent: Fraction) -> Fraction:
    if exponent.denominator != 1 or abs(exponent) > LARGEST or (exponent < 0 and not base):
        raise Inexact("^")
    return base ** int(exponent)


def _call(function: str, arguments: list[Fraction]) -> Fraction:
    match function, arguments:
        case "abs", [number]:
            return abs(number)
        case "sqrt", [number]:
            return Fraction(*map(_root, number.as_integer_ratio()))
        case _:
            return _in_balls(function, arguments)


def _root(number: int) -> int:
    if number < 0 or isqrt(number) ** 2 != number:
        raise Inexact("sqrt")
    return isqrt(number)


def _in_balls(function: str, arguments: list[Fraction]) -> Fraction:
    """What ball arithmetic gives without a radius (the sine of 30 degrees); nothing without the extra."""
    try:
        from rulesheets.functions.balls import FUNCTIONS, exact_ball, exact_fraction
    except ImportError:
        raise Inexact(function) from None
    number = exact_fraction(FUNCTIONS[function](*map(exact_ball, arguments)))
    if number is None:
        raise Inexact(function)
    return number
