"""The value of an expression in rational numbers, where it has one that can be computed exactly."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from math import isqrt

from rulesheets.evaluate.number import Arithmetic
from rulesheets.syntax.nodes import Call, Expression, Name, Number, Power, Quotient, Symbol

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
    return Rationals(numbers, constants).of(expression)


class Rationals(Arithmetic[Fraction]):
    def __init__(self, numbers: Mapping[str, Fraction], constants: Mapping[float, Fraction]) -> None:
        self.numbers, self.constants = numbers, constants

    def number(self, node: Number) -> Fraction:
        return self.constants[node.value] if node.value in self.constants else Fraction(node.value)

    def name(self, node: Name) -> Fraction:
        if node.name not in self.numbers:
            raise Inexact(node.name)
        return self.numbers[node.name]

    def symbol(self, node: Symbol) -> Fraction:
        raise Inexact(node.name)

    def divided(self, node: Quotient, above: Fraction, below: Fraction) -> Fraction:
        if not below:
            raise Inexact("/")
        return above / below

    def raised(self, node: Power, base: Fraction, exponent: Fraction) -> Fraction:
        if exponent.denominator != 1 or abs(exponent) > LARGEST or (exponent < 0 and not base):
            raise Inexact("^")
        return base ** int(exponent)

    def applied(self, node: Call, arguments: list[Fraction]) -> Fraction:
        match node.function, arguments:
            case "abs", [number]:
                return abs(number)
            case "sqrt", [number]:
                return Fraction(*map(_root, number.as_integer_ratio()))
            case _:
                return _in_balls(node.function, arguments)


def _root(number: int) -> int:
    if number < 0 or isqrt(number) ** 2 != number:
        raise Inexact("sqrt")
    return isqrt(number)


def _in_balls(function: str, arguments: list[Fraction]) -> Fraction:
    """What ball arithmetic gives without a radius (the sine of 30 degrees); nothing without the extra."""
    try:
        from rulesheets.evaluate.balls import FUNCTIONS, exact_ball, exact_fraction
    except ImportError:
        raise Inexact(function) from None
    number = exact_fraction(FUNCTIONS[function](*map(exact_ball, arguments)))
    if number is None:
        raise Inexact(function)
    return number
