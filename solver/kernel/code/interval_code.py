"""Expressions compiled to Python source for intervals: straight-line code, common parts once.

The same code works on one box of floats (``FLOATS``) and on arrays of boxes (``interval_arrays``): what
differs are the functions that it calls.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite, isnan, nan
from typing import Any, TypeAlias

from rulesheets.evaluate.number import FLOAT_INTERVALS, Arithmetic
from rulesheets.functions.intervals import (
    EMPTY,
    Interval,
    add,
    divide,
    greatest,
    multiply,
    power,
    scaled,
    square,
    within,
)
from rulesheets.functions.intervals import least as smaller
from rulesheets.functions.intervals.forms import cut
from rulesheets.functions.slopes import ROUNDED as ROUNDED_SLOPES
from rulesheets.syntax.nodes import Call, Name, Negative, Number, Power, Product, Quotient, Sum, Symbol
from solver.kernel.code.scalar import Source

Pair: TypeAlias = tuple[str, str]

ROUNDED: Mapping[float, tuple[float, float]] = {
    number: (math.nextafter(number, -inf), math.nextafter(number, inf))
    for size in ROUNDED_SLOPES
    for number in (size, -size)
}
"""Floats that slopes have in place of numbers next to them that no float holds."""


@dataclass(frozen=True, slots=True)
class Operations:
    """What compiled code calls: ``number`` makes a constant of a float, ``calls`` are the interval forms of
    the functions of the language, ``forms`` those of arithmetic and of what callers of the emitter add."""

    number: Callable[[float], Any]
    calls: Mapping[str, Callable[..., Any]]
    forms: Mapping[str, Callable[..., Any]]


class IntervalEmitter(Arithmetic[Pair]):
    """Code for the two ends of expressions. Names in ``points`` are single numbers, with one end."""

    def __init__(self, boxes: Sequence[str], points: Sequence[str], operations: Operations) -> None:
        self._operations = operations
        self._names: dict[str, Pair] = {name: (f"l{i}", f"h{i}") for i, name in enumerate(boxes)}
        self._names |= {name: (f"p{i}", f"p{i}") for i, name in enumerate(points)}
        ends = [end for i in range(len(boxes)) for end in (f"l{i}", f"h{i}")]
        header = ", ".join([*ends, *(f"p{i}" for i in range(len(points)))])
        self.source = Source(header, **{"__builtins__": {}, **operations.forms})
        self.line, self.function = self.source.line, self.source.function

    def assign(self, name: str, pair: Pair) -> None:
        """From here on ``name`` stands for the pair."""
        self._names[name] = pair

    def apply(self, name: str, *operands: Pair, more: str = "") -> Pair:
        """The pair that the operation of that name returns for the ends of the operands."""
        ends = ", ".join(end for pair in operands for end in pair)
        return self._assigned(f"{name}({ends}{more})")

    # --- the arithmetic ---

    def number(self, node: Number) -> Pair:
        token = f"c{node.value!r}".replace("-", "m").replace(".", "_").replace("+", "")
        ends = ROUNDED.get(node.value)
        if ends is None:
            self.source.globals[token] = self._operations.number(node.value)
            return token, token
        for side, end in enumerate(ends):
            self.source.globals[f"{token}_{side}"] = self._operations.number(end)
        return f"{token}_0", f"{token}_1"

    def name(self, node: Name) -> Pair:
        return self._names[node.name]

    def symbol(self, node: Symbol) -> Pair:
        return self.number(Number(nan))

    def negative(self, node: Negative) -> Pair:
        low, high = self.of(node.operand)
        return self._assigned(f"-{high}, -{low}")

    def sum(self, node: Sum) -> Pair:
        total = self.of(node.terms[0])
        for term in node.terms[1:]:
            total = self.apply("add", total, self.of(term))
        return total

    def product(self, node: Product) -> Pair:
        left, right = self.of(node.left), self.of(node.right)
        if left == right:
            return self.apply("square", left)
        for factor, other in ((left, right), (right, left)):
            if factor[0] == factor[1]:
                return self.apply("scaled", factor, other)
        return self.apply("multiply", left, right)

    def divided(self, node: Quotient, above: Pair, below: Pair) -> Pair:
        return self.apply("divide", above, below)

    def power(self, node: Power) -> Pair:
        if node.exponent == Number(2.0):
            return self.apply("square", self.of(node.base))
        return self.apply("power", self.of(node.base), self.of(node.exponent))

    def applied(self, node: Call, arguments: list[Pair]) -> Pair:
        self.source.globals[f"f_{node.function}"] = self._operations.calls[node.function]
        return self.apply(f"f_{node.function}", *arguments)

    def _assigned(self, text: str) -> Pair:
        low, high = self.source.temporary(text, "a{0}, b{0}").split(", ")
        return low, high


# --- what code on one box of floats calls ---------------------------------------


def bounded(
    low: float, high: float, least: float, most: float, empty: bool, doubtful: bool
) -> tuple[float, float, bool, bool]:
    """What lies between ``least`` and ``most``."""
    outside = high < least or low > most
    doubtful = doubtful or low < least or high > most
    low, high = greatest(low, least), smaller(high, most)
    if empty or outside or isnan(low) or isnan(high):
        return *EMPTY, True, doubtful
    return low, high, False, doubtful


def quotient(
    a_low: float, a_high: float, b_low: float, b_high: float, not_negative: int, relational: int
) -> Interval:
    """A product x*c = t says nothing about x where both c and t may be 0."""
    if not_negative:
        least, most = b_low, b_high
        if a_low > 0.0 and least < 0.0:
            b_low = smaller(0.0, most)
        if a_high < 0.0 and most > 0.0:
            b_high = greatest(0.0, least)
    if relational and a_low <= 0.0 <= a_high and b_low <= 0.0 <= b_high:
        return -inf, inf
    return divide(a_low, a_high, b_low, b_high)


def from_zero(low: float, high: float) -> Interval:
    """The hull of 0 and a box."""
    return smaller(low, 0.0), greatest(high, 0.0)


def by_slopes(a_low: float, a_high: float, b_low: float, b_high: float) -> Interval:
    """The quotient of two slopes where both are bounded: where they are not, they may not be defined."""
    known = isfinite(a_low) and isfinite(a_high) and isfinite(b_low) and isfinite(b_high)
    return divide(a_low, a_high, b_low, b_high) if known else EMPTY


FLOATS = Operations(
    float,
    FLOAT_INTERVALS,
    {
        "isnan": isnan,
        "add": add,
        "divide": divide,
        "multiply": multiply,
        "power": power,
        "square": square,
        "scaled": scaled,
        "cut": cut,
        "bounded": bounded,
        "quotient": quotient,
        "within": within,
        "from_zero": from_zero,
        "by_slopes": by_slopes,
    },
)
