"""Expressions compiled to Python source: straight-line code, common parts computed once.

For floats, numpy arrays and intervals of floats.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache
from math import inf, nan, nextafter
from types import CodeType
from typing import Any, TypeAlias, TypeVar

import numpy as np

from rulesheets.evaluate.number import INTERVALS, Arithmetic
from rulesheets.functions import TABLE, intervals
from rulesheets.functions.arrays import ARRAYS
from rulesheets.functions.row import ROUNDED as ROUNDED_SLOPES
from rulesheets.functions.row import Forms
from rulesheets.syntax.nodes import (
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

VALUES = Forms(TABLE, lambda row: row.value)
"""The functions of the language on floats."""


T = TypeVar("T")


def is_square(node: Power) -> bool:
    return node.exponent == Number(2.0)


def _power(base: float, exponent: float) -> float:
    """A real power; ValueError where it would be complex, as ``math.pow`` has it."""
    result = base**exponent
    if isinstance(result, complex):
        raise ValueError("power of a negative number")
    return float(result)


class _Source(Arithmetic[T]):
    """Lines of a function in three-address code. Equal texts are computed once (hash-consing)."""

    def __init__(self, arguments: Sequence[str], names: dict[str, T], **globals: Any) -> None:
        self.lines: list[str] = []
        self.globals: dict[str, Any] = globals
        self.names = names
        """What stands for the value of each name: an argument, or what was assigned before."""
        self._header = ", ".join(arguments)
        self._tokens: dict[str, str] = {}

    def line(self, text: str) -> None:
        self.lines.append(text)

    def temporary(self, text: str, form: str = "t{0}") -> str:
        """The names, made by ``form`` from a number, of what the text computes."""
        token = self._tokens.get(text)
        if token is None:
            token = self._tokens[text] = form.format(len(self._tokens))
            self.lines.append(f"{token} = {text}")
        return token

    def function(self, results: Iterable[str]) -> Callable[..., Any]:
        """A function of the arguments, in their order, that returns the values of these tokens."""
        return self._kernel([*self.lines, f"return ({''.join(f'{token}, ' for token in results)})"])

    def _kernel(self, lines: Iterable[str]) -> Callable[..., Any]:
        namespace, body = dict(self.globals), "\n    ".join(lines)
        exec(_compiled(f"def kernel({self._header}):\n    {body}\n"), namespace)
        return namespace["kernel"]  # type: ignore[no-any-return]

    def assign(self, name: str, value: T) -> None:
        """From here on ``name`` stands for the value."""
        self.names[name] = value

    def name(self, node: Name) -> T:
        return self.names[node.name]


@lru_cache(maxsize=1_000)
def _compiled(text: str) -> CodeType:
    """The code of a text: blocks of one shape have the same."""
    return compile(text, "<kernel>", "exec")


class Emitter(_Source[str]):
    """Code for expressions of named numbers."""

    def __init__(
        self,
        arguments: Sequence[str],
        functions: Mapping[str, Callable[..., Any]] = VALUES,
        power: Callable[..., Any] = _power,
    ) -> None:
        self._functions, self._power = functions, power
        names = {name: f"a{i}" for i, name in enumerate(arguments)}
        super().__init__([*names.values()], names, __builtins__={"ValueError": ValueError}, nan=nan)

    def require(self, name: str, low: float, high: float, low_open: bool, high_open: bool) -> None:
        """Raise ValueError where the value called ``name`` lies outside the range."""
        sides = ((low, "<=" if low_open else "<"), (high, ">=" if high_open else ">"))
        tests = [f"{self.names[name]} {sign} {end!r}" for end, sign in sides if math.isfinite(end)]
        if tests:
            self.line(f"if {' or '.join(tests)}: raise ValueError")

    def clamp(self, name: str, low: float, high: float) -> None:
        """Move the value called ``name`` into the range (on arrays)."""
        ends = [repr(end) if math.isfinite(end) else None for end in (low, high)]
        if ends != [None, None]:
            self.globals["clip"] = np.clip
            self.names[name] = self.temporary(f"clip({self.names[name]}, {ends[0]}, {ends[1]})")

    # --- the arithmetic ---

    def number(self, node: Number) -> str:
        return repr(node.value) if node.value >= 0 else f"({node.value!r})"

    def symbol(self, node: Symbol) -> str:
        return "nan"  # what is computed with it is no number either

    def negative(self, node: Negative) -> str:
        return self.temporary(f"- {self.of(node.operand)}")

    def sum(self, node: Sum) -> str:
        token = self.of(node.terms[0])
        for term in node.terms[1:]:
            sign, part = ("-", term.operand) if isinstance(term, Negative) else ("+", term)
            token = self.temporary(f"{token} {sign} {self.of(part)}")
        return token

    def product(self, node: Product) -> str:
        return self.temporary(f"{self.of(node.left)} * {self.of(node.right)}")

    def divided(self, node: Quotient, above: str, below: str) -> str:
        return self.temporary(f"{above} / {below}")

    def raised(self, node: Power, base: str, exponent: str) -> str:
        if is_square(node):
            return self.temporary(f"{base} * {base}")
        return self._called("POWER", self._power, [base, exponent])  # no function has capitals

    def applied(self, node: Call, arguments: list[str]) -> str:
        return self._called(node.function, self._functions[node.function], arguments)

    def _called(self, name: str, function: Callable[..., Any], arguments: list[str]) -> str:
        self.globals[f"f_{name}"] = function
        return self.temporary(f"f_{name}({', '.join(arguments)})")


def compile_expressions(
    expressions: Sequence[Expression], arguments: Sequence[str], arrays: bool = False
) -> Callable[..., Sequence[Any]]:
    """A function of floats, or of arrays, in the order of ``arguments``, that returns all values.

    With floats it raises what Python arithmetic raises outside the domain (ArithmeticError, ValueError).
    """
    emitter = Emitter(arguments, ARRAYS, np.power) if arrays else Emitter(arguments)
    return emitter.function([emitter.of(expression) for expression in expressions])


Pair: TypeAlias = tuple[str, str]

ROUNDED: Mapping[float, tuple[float, float]] = {
    number: (math.nextafter(number, -inf), math.nextafter(number, inf))
    for size in ROUNDED_SLOPES
    for number in (size, -size)
}
"""Floats that slopes have in place of numbers next to them that no float holds."""


ARITHMETIC = {
    name: getattr(intervals, name) for name in ("add", "divide", "multiply", "power", "square", "scaled")
}


class IntervalEmitter(_Source[Pair]):
    """Code for the two ends of expressions. Names in ``points`` are single numbers, with one end.

    ``forms`` are further operations that a caller of ``apply`` may name.
    """

    def __init__(self, boxes: Sequence[str], points: Sequence[str], **forms: Callable[..., Any]) -> None:
        pairs, single = [(f"l{i}", f"h{i}") for i in range(len(boxes))], [f"p{i}" for i in range(len(points))]
        names = dict(zip((*boxes, *points), (*pairs, *zip(single, single, strict=True)), strict=True))
        self._ends = ", ".join(end for pair in pairs for end in pair)
        self._fixed, self._once = set(single), list[str]()
        constants = {"__builtins__": {}, "inf": inf, "nan": nan, "nextafter": nextafter}
        super().__init__(single, names, **constants, **ARITHMETIC, **forms)

    def function(self, results: Iterable[str]) -> Callable[..., Any]:
        """A function of the points, in their order, that returns one of the ends of a box.

        What depends on points alone is computed once for all boxes.
        """
        body = (f"    {line}" for line in (*self.lines, f"return ({', '.join(results)})"))
        return self._kernel([*self._once, f"def on_box({self._ends}):", *body, "return on_box"])

    def apply(self, name: str, *operands: Pair, more: str = "") -> Pair:
        """The pair that the operation of that name returns for the ends of the operands."""
        ends = ", ".join(end for pair in operands for end in pair)
        return self._assigned(f"{name}({ends}{more})", *operands)

    # --- the arithmetic ---

    def number(self, node: Number) -> Pair:
        low, high = map(repr, ROUNDED.get(node.value, (node.value, node.value)))
        self._fixed |= {low, high}
        return low, high

    def symbol(self, node: Symbol) -> Pair:
        return self.number(Number(nan))

    def negative(self, node: Negative) -> Pair:
        low, high = self.of(node.operand)
        return self._assigned(f"-{high}, -{low}", (low, high))

    def sum(self, node: Sum) -> Pair:
        total = self.of(node.terms[0])
        for term in node.terms[1:]:
            part = self.of(term)
            if {total[0], part[0]} <= self._fixed:
                total = self.apply("add", total, part)
            else:
                total = self._assigned(f"{total[0]} + {part[0]}, {total[1]} + {part[1]}", total, part)
                low, high = total  # a sum that is 0 is exact
                rounded = f"{low} and nextafter({low}, -inf), {high} and nextafter({high}, inf)"
                total = self._assigned(rounded, total)
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

    def raised(self, node: Power, base: Pair, exponent: Pair) -> Pair:
        return self.apply("square", base) if is_square(node) else self.apply("power", base, exponent)

    def applied(self, node: Call, arguments: list[Pair]) -> Pair:
        self.globals[f"f_{node.function}"] = INTERVALS[node.function]
        return self.apply(f"f_{node.function}", *arguments)

    def _assigned(self, text: str, *operands: Pair) -> Pair:
        token = self._tokens.get(text)
        if token is None:
            token = self._tokens[text] = "a{0}, b{0}".format(len(self._tokens))
            fixed = all(pair[0] in self._fixed for pair in operands)
            (self._once if fixed else self.lines).append(f"{token} = {text}")
            self._fixed |= set(token.split(", ") if fixed else ())
        low, high = token.split(", ")
        return low, high
