"""Expressions compiled to Python source for intervals: straight-line code, common parts once.

The same code works on arrays of boxes (``interval_arrays``) and on one box of floats (``interval_floats``):
what differs are the functions that it calls.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

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

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from typing import Any, TypeAlias

    Pair: TypeAlias = tuple[str, str]

ROUNDED: Mapping[float, tuple[float, float]] = {
    number: (math.nextafter(number, -math.inf), math.nextafter(number, math.inf))
    for size in (math.pi / 180.0, 180.0 / math.pi, 2.0 / math.sqrt(math.pi), 1.0 / math.log(10.0))
    for number in (size, -size)
}
"""Floats that derivatives have in place of numbers next to them that no float holds."""


@dataclass(frozen=True, slots=True)
class Operations:
    """What compiled code calls: ``number`` makes a constant of a float, ``calls`` are the interval forms of
    the functions of the language, ``forms`` those of arithmetic and of what callers of the emitter add."""

    number: Callable[[float], Any]
    calls: Mapping[str, Callable[..., Any]]
    forms: Mapping[str, Callable[..., Any]]


class IntervalEmitter:
    """Lines that compute pairs of ends. Names in ``points`` are single numbers: their two ends are one."""

    def __init__(self, boxes: Sequence[str], points: Sequence[str], operations: Operations) -> None:
        self.lines: list[str] = []
        self.globals: dict[str, Any] = {"__builtins__": {}, **operations.forms}
        self._operations = operations
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
                    total = self.apply("add", total, self.pair(term))
                return total
            case Product(left, right):
                return self._product(self.pair(left), self.pair(right))
            case Quotient(left, right):
                return self.apply("divide", self.pair(left), self.pair(right))
            case Power(base, Number(2.0)):
                return self.apply("square", self.pair(base))
            case Power(base, exponent):
                return self.apply("power", self.pair(base), self.pair(exponent))
            case Call(function, arguments):
                pairs = [self.pair(argument) for argument in arguments]
                self.globals[f"f_{function}"] = self._operations.calls[function]
                return self.apply(f"f_{function}", *pairs)
            case Symbol(name):
                raise ValueError(f"the symbol '{name} has no range")

    def name(self, name: str, pair: Pair) -> None:
        """From here on ``name`` stands for the pair."""
        self._names[name] = pair

    def apply(self, name: str, *operands: Pair, more: str = "") -> Pair:
        """The pair that the operation of that name returns for the ends of the operands."""
        ends = ", ".join(end for pair in operands for end in pair)
        return self._assigned(f"{name}({ends}{more})")

    def line(self, text: str) -> None:
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
            for side, end in enumerate(ROUNDED[value]):
                self.globals[f"{token}_{side}"] = self._operations.number(end)
            return f"{token}_0", f"{token}_1"
        self.globals[token] = self._operations.number(value)
        return token, token

    def _product(self, left: Pair, right: Pair) -> Pair:
        if left == right:
            return self.apply("square", left)
        for factor, other in ((left, right), (right, left)):
            if factor[0] == factor[1]:
                return self.apply("scaled", factor, other)
        return self.apply("multiply", left, right)

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
