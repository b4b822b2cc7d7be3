"""The value of an expression in rational numbers, where it has one that can be computed exactly."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from fractions import Fraction
from math import isfinite, isqrt

from rulesheets.evaluate.number import Arithmetic, Undefined, value
from rulesheets.functions import TABLE
from rulesheets.syntax.nodes import Call, Expression, Name, Number, Power, Product, Quotient, Symbol

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

    def product(self, node: Product) -> Fraction:
        """The product; 0 if a factor is 0 and the other one a number, exactly known or not."""
        for one, other in ((node.left, node.right), (node.right, node.left)):
            with suppress(Inexact):
                if not self.of(one) and self._is_number(other):
                    return Fraction(0)
        return self.of(node.left) * self.of(node.right)

    def _is_number(self, expression: Expression) -> bool:
        try:
            return isfinite(value(expression, {name: float(v) for name, v in self.numbers.items()}))
        except (Undefined, KeyError, OverflowError):
            return False

    def divided(self, node: Quotient, above: Fraction, below: Fraction) -> Fraction:
        if not below:
            raise Inexact("/")
        return above / below

    def raised(self, node: Power, base: Fraction, exponent: Fraction) -> Fraction:
        if base == 1 or exponent == 0:
            return Fraction(1)
        if base == 0 and exponent > 0:
            return base
        if exponent.denominator != 1 or abs(exponent) > LARGEST or (exponent < 0 and not base):
            raise Inexact("^")
        return base ** int(exponent)

    def applied(self, node: Call, arguments: list[Fraction]) -> Fraction:
        match node.function, arguments:
            case "abs", [number]:
                return abs(number)
            case "sqrt", [number]:
                return Fraction(*map(_root, number.as_integer_ratio()))
            case function, [number] if (known := _special(function, number)) is not None:
                return known
            case _:
                return _in_balls(node.function, arguments)


def _special(function: str, number: Fraction) -> Fraction | None:
    """Values that need no extra: at 0 where they are 0 or 1, and at quarter turns in degrees."""
    row = TABLE[function]
    quarter = function in ("sind", "cosd") and number % 90 == 0
    if row.source is not None or not row.smooth or (number and not quarter):
        return None
    try:
        value = row.value(float(number % 360) if quarter else 0.0)
    except (ArithmeticError, ValueError):
        return None
    return Fraction(value) if value in (0.0, 1.0, -1.0) else None


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
