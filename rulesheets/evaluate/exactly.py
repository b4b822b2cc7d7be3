"""The value of an expression in rational numbers, where it has one that can be computed exactly."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from math import prod
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
    """What ball arithmetic gives without a radius (the sine of 30 degrees), and roots of squares."""
    from rulesheets.functions.balls import FUNCTIONS, exact_ball, exact_fraction

    if function == "sqrt":
        ends = [
            exact_fraction(FUNCTIONS["sqrt"](exact_ball(Fraction(n))))
            for n in arguments[0].as_integer_ratio()
        ]
        return _quotient(*(_known(end) for end in ends))
    if function == "abs":
        return abs(arguments[0])
    return _known(exact_fraction(FUNCTIONS[function](*map(exact_ball, arguments))))


def _known(number: Fraction | None) -> Fraction:
    if number is None:
        raise Inexact("call")
    return number
