"""Partial derivatives of the built-in functions, as trees of their arguments."""

from __future__ import annotations

import math
from collections.abc import Callable

from rulesheets.functions.row import Slopes
from rulesheets.syntax.nodes import (
    ONE,
    ZERO,
    Expression,
    Number,
    add,
    call,
    divide,
    multiply,
    negative,
    power,
    subtract,
)

_TWO = Number(2.0)
_RADIAN = Number(math.pi / 180.0)
_DEGREE = Number(180.0 / math.pi)
LOG10_E = 1.0 / math.log(10.0)
_BELL = 2.0 / math.sqrt(math.pi)

ROUNDED: dict[float, Expression] = {
    _RADIAN.value: divide(call("pi"), Number(180.0)),
    _DEGREE.value: divide(Number(180.0), call("pi")),
    _BELL: divide(_TWO, call("sqrt", call("pi"))),
    -_BELL: divide(Number(-2.0), call("sqrt", call("pi"))),
    LOG10_E: divide(ONE, call("ln", Number(10.0))),
}
"""Floats that derivatives have in place of numbers that no float holds, and those numbers."""


def one(slope: Callable[[Expression], Expression]) -> Slopes:
    """Partials of a function of one argument."""
    return lambda arguments: (slope(arguments[0]),)


def of(name: str) -> Slopes:
    """The slope is another function of the table."""
    return one(lambda x: call(name, x))


def minus(name: str) -> Slopes:
    return one(lambda x: negative(call(name, x)))


def flat(arguments: tuple[Expression, ...]) -> tuple[Expression | None, ...]:
    """Partials of a function that is constant between its jumps."""
    return (ZERO,) * len(arguments)


def per_degree(slope: Callable[[Expression], Expression]) -> Slopes:
    """Partials of a function of degrees from the slope that it has in radians."""
    return one(lambda x: multiply(_RADIAN, slope(x)))


def to_degrees(slope: Callable[[Expression], Expression]) -> Slopes:
    """Partials of an angle in degrees from the slope that it has in radians."""
    return one(lambda x: multiply(_DEGREE, slope(x)))


def square(x: Expression) -> Expression:
    return power(x, _TWO)


def _half(x: Expression) -> Expression:
    return divide(x, _TWO)


def sqrt(x: Expression) -> Expression:
    return divide(Number(0.5), call("sqrt", x))


def secant_squared(tangent: str) -> Callable[[Expression], Expression]:
    return lambda x: add(ONE, square(call(tangent, x)))


def arc_sine(x: Expression) -> Expression:
    """``1/sqrt((1 - x)*(1 + x))``, the form without cancellation near the ends."""
    return divide(ONE, call("sqrt", multiply(subtract(ONE, x), add(ONE, x))))


def arc_tangent(x: Expression) -> Expression:
    return divide(ONE, add(ONE, square(x)))


def area_cosine(x: Expression) -> Expression:
    return divide(ONE, call("sqrt", multiply(subtract(x, ONE), add(x, ONE))))


def area_sine(x: Expression) -> Expression:
    return divide(ONE, call("sqrt", add(square(x), ONE)))


def area_tangent(x: Expression) -> Expression:
    return divide(ONE, multiply(subtract(ONE, x), add(ONE, x)))


def over(factor: float) -> Callable[[Expression], Expression]:
    """Slope of a logarithm: ``factor / x``."""
    return lambda x: divide(Number(factor), x)


def direction(unit: Expression) -> Slopes:
    """Partials of atan2(y, x) where a radian is ``unit``."""

    def partials(arguments: tuple[Expression, ...]) -> tuple[Expression | None, ...]:
        y, x = arguments
        distance = add(square(x), square(y))
        return divide(multiply(unit, x), distance), negative(divide(multiply(unit, y), distance))

    return partials


radians = direction(ONE)
degrees = direction(_DEGREE)


def mod(arguments: tuple[Expression, ...]) -> tuple[Expression | None, ...]:
    x, y = arguments
    return ONE, negative(call("int", divide(x, y)))


def _extreme(name: str, beats: Callable[[Expression, Expression], Expression]) -> Slopes:
    """Partials of min or max: 1 for the argument that is it (the first of equals), 0 for the others."""

    def partials(arguments: tuple[Expression, ...]) -> tuple[Expression | None, ...]:
        slopes: list[Expression] = []
        for position, argument in enumerate(arguments):
            slope: Expression = ONE
            if later := arguments[position + 1 :]:
                slope = beats(argument, call(name, *later))
            if earlier := arguments[:position]:
                slope = multiply(slope, subtract(ONE, beats(call(name, *earlier), argument)))
            slopes.append(slope)
        return tuple(slopes)

    return partials


least = _extreme("min", lambda winner, loser: call("step", loser, winner))
greatest = _extreme("max", lambda winner, loser: call("step", winner, loser))


def error_function(factor: float) -> Callable[[Expression], Expression]:
    """Slope ``factor * 2/sqrt(pi) * exp(-x^2)``."""
    return lambda x: multiply(Number(factor * _BELL), call("exp", negative(square(x))))


def gamma(x: Expression) -> Expression:
    return multiply(call("gamma", x), call("digamma", x))


def beta(arguments: tuple[Expression, ...]) -> tuple[Expression | None, ...]:
    a, b = arguments
    whole, both = call("beta", a, b), call("digamma", add(a, b))
    return tuple(multiply(whole, subtract(call("digamma", part), both)) for part in (a, b))


def bessel_first(name: str) -> Callable[[Expression], Expression]:
    """Slope of j1 or y1 by the recurrence that has no division by x."""
    even = name[0]
    return lambda x: _half(subtract(call(f"{even}0", x), call(f"{even}n", _TWO, x)))


def bessel_order(name: str) -> Slopes:
    """Partials of jn or yn: unknown in the order, by recurrence in x."""

    def partials(arguments: tuple[Expression, ...]) -> tuple[Expression | None, ...]:
        order, x = arguments
        below, above = call(name, subtract(order, ONE), x), call(name, add(order, ONE), x)
        return None, _half(subtract(below, above))

    return partials


def bessel_i1(x: Expression) -> Expression:
    return subtract(call("i0", x), divide(call("bessel_i1", x), x))


def bessel_k1(x: Expression) -> Expression:
    return negative(add(call("k0", x), divide(call("bessel_k1", x), x)))
