"""Exact rational values of expressions, and what is exactly a float put in for parts of π."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from fractions import Fraction
from math import isfinite, isqrt
from random import Random
from typing import Any, TypeAlias

from rulesheets.evaluate.number import Arithmetic, Undefined, value
from rulesheets.functions import TABLE
from rulesheets.syntax import nodes

LARGEST, LONGEST = 64, 20_000
"""Exponents beyond which numbers are not multiplied out, and binary digits of a power."""
BESIDE, LEAST = 2**128, Fraction(1, 2**1100)
"""Numbers of 64 bits are so many times the share by which one differs from a value; and the size of
a value that floats take for 0."""


class Inexact(Exception):
    """The value is not a rational number, or not known exactly."""


class Rationals(Arithmetic[Fraction]):
    """Rational numbers, floats being exact binary ones; ``pi`` stands for π.

    Raises Inexact if an operation leaves the rational numbers, and without a number.
    """

    def __init__(self, numbers: Mapping[str, Fraction], pi: Fraction | None) -> None:
        self.numbers, self.pi = numbers, pi

    def number(self, node: nodes.Number) -> Fraction:
        return Fraction(node.value)

    def name(self, node: nodes.Name) -> Fraction:
        if node.name not in self.numbers:
            raise Inexact(node.name)
        return self.numbers[node.name]

    def symbol(self, node: nodes.Symbol) -> Fraction:
        raise Inexact(node.name)

    def product(self, node: nodes.Product) -> Fraction:
        """The product; 0 if a factor is 0 and the other one a number, exactly known or not."""
        factors = []
        for one, other in ((node.left, node.right), (node.right, node.left)):
            with suppress(Inexact):
                factors.append(self.of(one))
                if not factors[-1] and self._is_number(other):
                    return Fraction(0)
        if len(factors) < 2:
            raise Inexact("*")
        return factors[0] * factors[1]

    def _is_number(self, expression: nodes.Expression) -> bool:
        """Whether a factor has a value, exactly known or not."""
        with suppress(Undefined, KeyError, OverflowError):
            near = {name: float(self.numbers[name]) for name in nodes.names(expression)}
            return isfinite(value(expression, near))
        return False

    def divided(self, node: nodes.Quotient, above: Fraction, below: Fraction) -> Fraction:
        if not below:
            raise Inexact("/")
        return above / below

    def raised(self, node: nodes.Power, base: Fraction, exponent: Fraction) -> Fraction:
        if base == 1 or exponent == 0:
            return Fraction(1)
        if base == 0 and exponent > 0:
            return base
        if exponent.denominator == 2:
            return self.raised(node, Fraction(*map(_root, base.as_integer_ratio())), 2 * exponent)
        if exponent.denominator != 1 or abs(exponent) > LARGEST or (exponent < 0 and not base):
            raise Inexact("^")
        if abs(exponent) * max(part.bit_length() for part in base.as_integer_ratio()) > LONGEST:
            raise Inexact("^")
        return base ** int(exponent)

    def applied(self, node: nodes.Call, arguments: list[Fraction]) -> Fraction:
        match node.function, arguments:
            case "pi", [] if self.pi is not None:
                return self.pi
            case "abs", [number]:
                return abs(number)
            case "min" | "max" as least_or_most, _:
                return (min if least_or_most == "min" else max)(arguments)
            case "sqrt", [number]:
                return Fraction(*map(_root, number.as_integer_ratio()))
            case function, [number]:
                return known(function, number)
            case _:
                raise Inexact(node.function)


class Decimals(Rationals):
    """Rational numbers, a float being the shortest decimal that leads to it: 0.1 is 1/10."""

    def number(self, node: nodes.Number) -> Fraction:
        return as_written(node.value)

    def applied(self, node: nodes.Call, arguments: list[Fraction]) -> Fraction:
        match node.function, arguments:
            case "int", [number]:
                return Fraction(int(number))
            case "sgn", [number]:
                return Fraction((number > 0) - (number < 0))
            case "step", [number, start]:
                return Fraction(number >= start)
        row = TABLE[node.function]
        if row.jumps and row.definition is not None:
            named = {f"a{k}": number for k, number in enumerate(arguments)}
            return Decimals(named, None).of(row.definition(*map(nodes.Name, named)))
        return super().applied(node, arguments)


def as_written(number: float | str) -> Fraction:
    """The decimal that a float was read from. Raises Inexact for a symbol, and what is infinite."""
    if isinstance(number, str) or not isfinite(number):
        raise Inexact(number)
    return Fraction(repr(float(number)))


Reader: TypeAlias = Callable[[str], Fraction]
"""The exact value of a variable. Raises Inexact or KeyError if it is not known."""


def value_as_written(expression: nodes.Expression, read: Reader) -> Fraction | None:
    """The exact value with the decimals of its numbers as written, 0 of ``0.1*3 - 0.3``; None if
    there is none, or it is not known."""
    with suppress(Inexact, KeyError):
        numbers = {name: read(name) for name in nodes.names(expression)}
        return Decimals(numbers, None).of(expression)
    return None


class Independent(Decimals):
    """Rational numbers, and one at random next to each irrational value: an expression that is 0
    with them is 0 whatever these values are, as ``exp(a) - exp(a)``, but for odds of some 2^-60 (J.
    T. Schwartz, 1980). Being next to the values they have their signs, and their order."""

    numbers: dict[str, Fraction]

    def __init__(self, numbers: dict[str, Fraction]) -> None:
        super().__init__(numbers, None)
        self._chosen, self._random = dict[Any, Fraction](), Random(0)

    def is_zero(self, expression: nodes.Expression) -> bool:
        with suppress(Inexact):
            return self.of(expression) == 0
        return False

    def raised(self, node: nodes.Power, base: Fraction, exponent: Fraction) -> Fraction:
        try:
            return super().raised(node, base, exponent)
        except Inexact:
            return self._instead(nodes.Name("b") ** nodes.Name("e"), b=base, e=exponent)

    def applied(self, node: nodes.Call, arguments: list[Fraction]) -> Fraction:
        try:
            return Rationals.applied(self, node, arguments)
        except Inexact:
            named = {f"a{k}": number for k, number in enumerate(arguments)}
            return self._instead(nodes.Call(node.function, tuple(map(nodes.Name, named))), **named)

    def _instead(self, operation: nodes.Expression, **numbers: Fraction) -> Fraction:
        """The number for a value, if there is one and it is finite."""
        try:
            near = value(operation, {name: float(v) for name, v in numbers.items()})
        except (Undefined, OverflowError):
            raise Inexact from None
        if not isfinite(near):
            raise Inexact
        share = Fraction(self._random.getrandbits(64), BESIDE)
        key = operation, *numbers.values()
        return self._chosen.setdefault(key, (Fraction(near) or LEAST) * (1 + share))


def known(function: str, number: Fraction) -> Fraction:
    """Values that are 0, 1 or -1 at 0 and 1, and those of the circular functions at whole degrees
    that are rational (I. Niven, *Irrational Numbers*, 1956). Raises Inexact for any other."""
    row = TABLE[function]
    degrees = function in ("sind", "cosd", "tand") and number.denominator == 1
    if row.source is not None or not row.smooth or not (degrees or number in (0, 1)):
        raise Inexact(function)
    try:
        value = row.value(float(number % 360))
    except (ArithmeticError, ValueError):
        raise Inexact(function) from None
    if abs(value) not in (0.0, 0.5, 1.0) or (abs(value) == 0.5 and not degrees):
        raise Inexact(function)
    return Fraction(value)


def _root(number: int) -> int:
    if number < 0 or isqrt(number) ** 2 != number:
        raise Inexact("sqrt")
    return isqrt(number)


# --- parts of π -------------------------------------------------------------------------
#
# Floats have no π, so that they make 1.2e-16 of sin(pi): a coefficient, where a rule has none. What
# is exactly a float is put in for it as a sheet is expanded. Poles stay as they are written.


def with_round_values(expression: Any) -> Any:
    """An expression or condition with sines, cosines and tangents of fractions of π replaced by 0,
    ±1/2 or ±1 if that is their value."""
    parts = expression.parts
    if not parts:
        return expression
    found = []
    for part in parts:  # a loop, for one frame a level: trees may be hundreds of levels deep
        found.append(with_round_values(part))
    if any(new is not old for new, old in zip(found, parts, strict=True)):
        expression = nodes.rebuilt(expression, tuple(found))
    if isinstance(expression, nodes.Call) and expression.function in ("sin", "cos", "tan"):
        try:
            # q where the angle is written as q·π: the same share of either stand-in for π
            shares = {Rationals({}, pi).of(expression.arguments[0]) / pi for pi in _STAND_INS}
            if len(shares) == 1:
                number = known(f"{expression.function}d", 180 * shares.pop())
                return nodes.Number(float(number), expression.span)
        except Inexact:
            pass
    return expression


_STAND_INS = Fraction(355, 113), Fraction(10**9 + 7, 17)
"""Numbers in place of π: a value proportional to both is proportional to π."""
