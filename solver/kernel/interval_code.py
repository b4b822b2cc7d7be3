"""Expressions compiled to Python source for arrays of intervals: straight-line code, common parts once.

The operations are those of ``rulesheets.functions.intervals`` without their guards against warnings (callers
silence those once), and cheaper ones where a factor is a number that is known, or both factors are one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

from rulesheets.functions.intervals import INTERVALS, add, divide, multiply, power
from rulesheets.functions.intervals.bounds import Array, Interval, Mask, magnitudes, where_not
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

Pair: TypeAlias = tuple[str, str]

ROUNDED: Mapping[float, tuple[float, float]] = {
    number: (math.nextafter(number, -math.inf), math.nextafter(number, math.inf))
    for size in (math.pi / 180.0, 180.0 / math.pi, 2.0 / math.sqrt(math.pi), 1.0 / math.log(10.0))
    for number in (size, -size)
}
"""Floats that derivatives have in place of numbers next to them that no float holds."""


class IntervalEmitter:
    """Lines that compute pairs of ends. Names in ``points`` are single numbers: their two ends are one."""

    def __init__(self, boxes: Sequence[str], points: Sequence[str]) -> None:
        self.lines: list[str] = []
        self.globals: dict[str, Any] = {"__builtins__": {}, "isnan": np.isnan}
        self._pairs: dict[tuple[str, ...], Pair] = {}
        self._names: dict[str, Pair] = {name: (f"l{i}", f"h{i}") for i, name in enumerate(boxes)}
        self._names |= {name: (f"p{i}", f"p{i}") for i, name in enumerate(points)}
        ends = [end for i in range(len(boxes)) for end in (f"l{i}", f"h{i}")]
        self._header = ", ".join([*ends, *(f"p{i}" for i in range(len(points)))])
        self._count = 0

    def pair(self, expression: Expression) -> Pair:
        """The tokens of the two ends of an expression."""
        match expression:
            case Number(value):
                return self._number(value)
            case Name(name):
                return self._names[name]
            case Negative(operand):
                low, high = self.pair(operand)
                return self._assigned(f"-{high}, -{low}") if low != high else self._point(f"-{low}")
            case Sum(terms):
                total = self.pair(terms[0])
                for term in terms[1:]:
                    total = self.apply("add", plain(add), total, self.pair(term))
                return total
            case Product(left, right):
                return self._product(self.pair(left), self.pair(right))
            case Quotient(left, right):
                return self.apply("divide", plain(divide), self.pair(left), self.pair(right))
            case Power(base, Number(2.0)):
                return self.apply("square", square, self.pair(base))
            case Power(base, exponent):
                return self.apply("power", plain(power), self.pair(base), self.pair(exponent))
            case Call(function, arguments):
                pairs = [self.pair(argument) for argument in arguments]
                return self.apply(f"f_{function}", plain(INTERVALS[function]), *pairs)
            case Symbol(name):
                raise ValueError(f"the symbol '{name} has no range")

    def name(self, name: str, pair: Pair) -> None:
        """From here on ``name`` stands for the pair."""
        self._names[name] = pair

    def apply(self, name: str, function: Callable[..., Any], *operands: Pair, more: str = "") -> Pair:
        """The pair that a function of the ends of the operands returns."""
        self.globals[name] = function
        ends = ", ".join(end for pair in operands for end in pair)
        return self._assigned(f"{name}({ends}{more})")

    def line(self, text: str, **functions: Callable[..., Any]) -> None:
        self.globals |= functions
        self.lines.append(text)

    def function(self, results: str) -> Callable[..., Any]:
        """A function of the ends of every box and of the points, that returns ``results``."""
        body = "\n    ".join([*self.lines, f"return {results}"])
        namespace = dict(self.globals)
        exec(compile(f"def kernel({self._header}):\n    {body}\n", "<intervals>", "exec"), namespace)
        return namespace["kernel"]  # type: ignore[no-any-return]

    def _number(self, value: float) -> Pair:
        token = f"c{value!r}".replace("-", "m").replace(".", "_").replace("+", "")
        if value in ROUNDED:
            self.globals |= {f"{token}_{side}": np.float64(end) for side, end in enumerate(ROUNDED[value])}
            return f"{token}_0", f"{token}_1"
        self.globals[token] = np.float64(value)
        return token, token

    def _product(self, left: Pair, right: Pair) -> Pair:
        if left == right:
            return self.apply("square", square, left)
        for factor, other in ((left, right), (right, left)):
            if factor[0] == factor[1]:
                return self.apply("scaled", scaled, factor, other)
        return self.apply("multiply", plain(multiply), left, right)

    def _point(self, text: str) -> Pair:
        return self._assigned(f"{text}, {text}")

    def _assigned(self, text: str) -> Pair:
        pair = self._pairs.get((text,))
        if pair is None:
            pair = f"a{self._count}", f"b{self._count}"
            self._count += 1
            self._pairs[text,] = pair
            self.lines.append(f"{pair[0]}, {pair[1]} = {text}")
        return pair


def plain(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function itself, where it is wrapped in a guard against warnings."""
    plain: Callable[..., Any] = getattr(function, "__wrapped__", function)
    return plain


def scaled(factor: Array, _: Array, low: Array, high: Array) -> Interval:
    """A number times an interval, rounded outward but not across 0."""
    if factor == 0.0:
        return where_not(np.isnan(low), np.zeros_like(low), np.zeros_like(high))
    first, last = (low, high) if factor > 0.0 else (-high, -low)
    size = abs(factor)
    below, above = np.nextafter(size * first, -np.inf), np.nextafter(size * last, np.inf)
    return np.where(first >= 0.0, np.maximum(below, 0.0), below), np.where(
        last <= 0.0, np.minimum(above, 0.0), above
    )


def square(low: Array, high: Array) -> Interval:
    least, greatest = magnitudes(low, high)
    below = np.maximum(np.nextafter(least * least, -np.inf), 0.0)
    above = np.nextafter(greatest * greatest, np.inf)
    return below, np.where(greatest == 0.0, 0.0, above)


def cut(y_low: Array, y_high: Array, x_low: Array, _: Array) -> Mask:
    """Where the direction of (x, y) may jump from one half turn to the other, or is undefined."""
    return ~((y_low > 0.0) | (y_high < 0.0) | (x_low > 0.0))
