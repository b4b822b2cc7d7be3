"""The value of an expression, and its partial derivatives, to many digits."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any, TypeAlias

from rulesheets.evaluate.arithmetic import Arithmetic
from rulesheets.evaluate.gradient import Part, Traced, accumulated
from rulesheets.evaluate.undefined import Undefined
from rulesheets.functions import TABLE
from rulesheets.functions.extended import Extended, context, functions
from rulesheets.functions.slopes import ROUNDED
from rulesheets.syntax.nodes import Call, Expression, Name, Number, Power, Quotient
from rulesheets.syntax.program import walk

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
    return Digits(values, digits).of(expression)


def extended_derivatives(
    expression: Expression, values: ExtendedValues, digits: int
) -> tuple[Extended, dict[str, Extended]]:
    """Value and partial derivatives by every variable in the expression, with ``digits`` decimal digits.

    Raises Undefined where the expression or one of its slopes has no real value, KeyError for a variable
    without one.
    """
    part = TracedDigits(Digits(values, digits)).of(expression)
    return part.value, accumulated(part, context(digits).zero)[0]


def in_many_digits(expression: Expression) -> bool:
    """Whether every function in it is known to more digits than those of floats."""
    calls = (part for part in walk(expression) if isinstance(part, Call))
    return all(TABLE[call.function].digits is not None for call in calls)


class Digits(Arithmetic[Extended]):
    """Numbers of mpmath. ``slope``: floats of slopes stand for the exact numbers next to them."""

    def __init__(self, values: ExtendedValues, digits: int, slope: bool = False) -> None:
        self.values, self.digits, self.slope = values, digits, slope

    def number(self, node: Number) -> Extended:
        exact = ROUNDED.get(node.value) if self.slope else None
        return _exact(node.value, self.digits) if exact is None else self.of(exact)

    def name(self, node: Name) -> Extended:
        number = self.values[node.name]
        if isinstance(number, str):
            raise Undefined("symbol", (), node)
        return context(self.digits).mpf(number)

    def divided(self, node: Quotient, above: Extended, below: Extended) -> Extended:
        if below == 0:
            raise Undefined("/", (0.0,), node)
        return above / below

    def raised(self, node: Power, base: Extended, exponent: Extended) -> Extended:
        negative_root = base < 0 and exponent != int(exponent)
        if negative_root or (base == 0 and exponent < 0):
            raise Undefined("^", (float(base), float(exponent)), node)
        size = exponent.exp + exponent.bc if exponent else 0
        if size <= LARGE_BITS or not base:
            return base**exponent
        return self._large_power(node, base, exponent, size)

    def _large_power(self, node: Power, base: Extended, exponent: Extended, size: int) -> Extended:
        """By the logarithm, with as many digits more as the exponent has before its point: mpmath squares,
        and squares again, for whole exponents, and for others it takes no more digits."""
        if size > MOST_BITS:
            raise Undefined("overflow", (math.inf,), node)
        mp = context(self.digits + SPARE + size // 3)
        found = mp.exp(mp.mpf(exponent) * mp.ln(abs(mp.mpf(base))))
        odd = base < 0 and int(exponent) % 2 == 1
        return +context(self.digits).mpf(-found if odd else found)

    def applied(self, node: Call, arguments: list[Extended]) -> Extended:
        for argument in arguments:
            if argument and abs(argument.exp + argument.bc) > MOST_BITS:
                raise Undefined("overflow", (math.inf,), node)
        try:
            return functions(self.digits)[node.function](*arguments)
        except (ValueError, ZeroDivisionError, OverflowError):
            raise Undefined(node.function, tuple(map(float, arguments)), node) from None


class TracedDigits(Traced[Extended]):
    """Parts in many digits."""

    numbers: Digits

    def slope(self, template: Expression, arguments: Sequence[Part[Extended]], node: Expression) -> Extended:
        values = {str(place): part.value for place, part in enumerate(arguments)}
        try:
            return Digits(values, self.numbers.digits, slope=True).of(template)
        except Undefined as error:
            raise Undefined(error.operation, error.arguments, node) from None


@lru_cache(maxsize=4096)
def _exact(value: float, digits: int) -> Extended:
    """A number of a rule, which is met again and again."""
    return context(digits).mpf(value)
