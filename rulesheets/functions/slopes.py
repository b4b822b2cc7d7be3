"""Partial derivatives of built-in functions, as trees of their arguments, that are more than a formula."""

from __future__ import annotations

import math
from collections.abc import Callable

from rulesheets.functions.row import Slopes
from rulesheets.syntax.nodes import ONE, ZERO, Expression, Number, call, multiply

RADIAN = Number(math.pi / 180.0)
DEGREE = Number(180.0 / math.pi)
LOG10_E = 1.0 / math.log(10.0)
BELL = 2.0 / math.sqrt(math.pi)

ROUNDED: dict[float, Expression] = {
    RADIAN.value: call("pi") / 180.0,
    DEGREE.value: 180.0 / call("pi"),
    BELL: 2.0 / call("sqrt", call("pi")),
    -BELL: -2.0 / call("sqrt", call("pi")),
    LOG10_E: 1.0 / call("ln", Number(10.0)),
}
"""Floats that derivatives have in place of numbers that no float holds, and those numbers."""


def of(name: str) -> Callable[[Expression], Expression]:
    """The slope is another function of the table."""
    return lambda x: call(name, x)


def flat(*arguments: Expression) -> tuple[Expression, ...]:
    """Partials of a function that is constant between its jumps."""
    return (ZERO,) * len(arguments)


def arc_sine(x: Expression) -> Expression:
    """``1/sqrt((1 - x)*(1 + x))``, the form without cancellation near the ends."""
    return 1.0 / call("sqrt", (1.0 - x) * (1.0 + x))


def direction(radian: Expression) -> Slopes:
    """Partials of atan2(y, x) where a radian is so much."""

    def partials(y: Expression, x: Expression) -> tuple[Expression, ...]:
        distance = x**2.0 + y**2.0
        return radian * x / distance, -(radian * y / distance)

    return partials


def _extreme(name: str, beats: Callable[[Expression, Expression], Expression]) -> Slopes:
    """Partials of min or max: 1 for the argument that is it (the first of equals), 0 for the others."""

    def partials(*arguments: Expression) -> tuple[Expression, ...]:
        slopes: list[Expression] = []
        for position, argument in enumerate(arguments):
            slope: Expression = ONE
            if later := arguments[position + 1 :]:
                slope = beats(argument, call(name, *later))
            if earlier := arguments[:position]:
                slope = multiply(slope, 1.0 - beats(call(name, *earlier), argument))
            slopes.append(slope)
        return tuple(slopes)

    return partials


least = _extreme("min", lambda winner, loser: call("step", loser, winner))
greatest = _extreme("max", lambda winner, loser: call("step", winner, loser))


def beta(a: Expression, b: Expression) -> tuple[Expression, ...]:
    whole, both = call("beta", a, b), call("digamma", a + b)
    return tuple(whole * (call("digamma", part) - both) for part in (a, b))


def first_order(name: str) -> Callable[[Expression], Expression]:
    """Slope of j1 or y1 by the recurrence that has no division by x."""
    return lambda x: (call(f"{name}0", x) - call(f"{name}n", Number(2.0), x)) / 2.0


def any_order(name: str) -> Slopes:
    """Partials of jn or yn: unknown in the order, by recurrence in x."""
    return lambda order, x: (None, (call(name, order - 1.0, x) - call(name, order + 1.0, x)) / 2.0)
