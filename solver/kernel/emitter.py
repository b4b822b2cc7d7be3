"""Expressions compiled to Python source: straight-line code, common parts computed once.

For floats, numpy arrays and intervals. Code for intervals works on one box of floats and on arrays of boxes:
what differs are the functions that it calls (``enclosure.py``).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from math import inf, nan
from types import CodeType
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from rulesheets.evaluate.number import Arithmetic
from rulesheets.functions import TABLE
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


def _power(base: float, exponent: float) -> float:
    """A real power; ValueError where it would be complex, as ``math.pow`` has it."""
    result = base**exponent
    if isinstance(result, complex):
        raise ValueError("power of a negative number")
    return float(result)


class Source:
    """Lines of a function in three-address code. Equal texts are computed once (hash-consing)."""

    def __init__(self, header: str, **globals: Any) -> None:
        self.lines: list[str] = []
        self.globals: dict[str, Any] = globals
        self._header = header
        self._tokens: dict[str, str] = {}

    def line(self, text: str) -> None:
        self.lines.append(text)

    def temporary(self, text: str, form: str = "t{0}") -> str:
        """The names, made by ``form`` from a number, of what the text computes."""
        token = self._tokens.get(text)
        if token is None:
            token = self._tokens[text] = form.format(len(self._tokens))
            self.line(f"{token} = {text}")
        return token

    def function(self, results: str) -> Callable[..., Any]:
        """A function of the arguments of the header that returns ``results`` (Python source)."""
        body = "\n    ".join([*self.lines, f"return {results}"])
        namespace = dict(self.globals)
        exec(_compiled(f"def kernel({self._header}):\n    {body}\n"), namespace)
        return namespace["kernel"]  # type: ignore[no-any-return]


@lru_cache(maxsize=1_000)
def _compiled(text: str) -> CodeType:
    """The code of a text: blocks of one shape have the same."""
    return compile(text, "<kernel>", "exec")


class Emitter(Arithmetic[str]):
    """Code for expressions of named numbers, which are arguments or were assigned before."""

    def __init__(
        self,
        arguments: Sequence[str],
        functions: Mapping[str, Callable[..., Any]] = VALUES,
        power: Callable[..., Any] = _power,
    ) -> None:
        self._functions, self._power = functions, power
        header = ", ".join(f"a{i}" for i in range(len(arguments)))
        self.source = Source(header, __builtins__={"ValueError": ValueError}, nan=nan)
        self._names = {name: f"a{i}" for i, name in enumerate(arguments)}

    def argument(self, name: str) -> str:
        return self._names[name]

    def assign(self, name: str, expression: Expression) -> None:
        """From here on ``name`` stands for the value of the expression."""
        self._names[name] = self.of(expression)

    def require(self, name: str, low: float, high: float, low_open: bool, high_open: bool) -> None:
        """Raise ValueError where the value called ``name`` lies outside the range."""
        token = self._names[name]
        tests = []
        if low > -inf:
            tests.append(f"{token} {'<=' if low_open else '<'} {low!r}")
        if high < inf:
            tests.append(f"{token} {'>=' if high_open else '>'} {high!r}")
        if tests:
            self.source.line(f"if {' or '.join(tests)}: raise ValueError")

    def clamp(self, name: str, low: float, high: float, clip: Callable[..., Any]) -> None:
        """Move the value called ``name`` into the range (on arrays)."""
        if low > -inf or high < inf:
            ends = repr(low) if low > -inf else None, repr(high) if high < inf else None
            self.source.globals["clip"] = clip
            self._names[name] = self.source.temporary(f"clip({self._names[name]}, {ends[0]}, {ends[1]})")

    def function(self, tokens: Sequence[str]) -> Callable[..., tuple[Any, ...]]:
        """A function of the arguments, in their order, that returns the values of the tokens."""
        return self.source.function("(" + "".join(f"{token}, " for token in tokens) + ")")

    # --- the arithmetic ---

    def number(self, node: Number) -> str:
        return repr(node.value) if node.value >= 0 else f"({node.value!r})"

    def name(self, node: Name) -> str:
        return self._names[node.name]

    def symbol(self, node: Symbol) -> str:
        """No number: what is computed with it is none either."""
        return "nan"

    def negative(self, node: Negative) -> str:
        return self.source.temporary(f"- {self.of(node.operand)}")

    def sum(self, node: Sum) -> str:
        token = self.of(node.terms[0])
        for term in node.terms[1:]:
            sign, part = ("-", term.operand) if isinstance(term, Negative) else ("+", term)
            token = self.source.temporary(f"{token} {sign} {self.of(part)}")
        return token

    def product(self, node: Product) -> str:
        return self.source.temporary(f"{self.of(node.left)} * {self.of(node.right)}")

    def divided(self, node: Quotient, above: str, below: str) -> str:
        return self.source.temporary(f"{above} / {below}")

    def power(self, node: Power) -> str:
        if node.exponent == Number(2.0):
            token = self.of(node.base)
            return self.source.temporary(f"{token} * {token}")
        return self._applied("power", self._power, [self.of(node.base), self.of(node.exponent)])

    def applied(self, node: Call, arguments: list[str]) -> str:
        return self._applied(node.function, self._functions[node.function], arguments)

    def _applied(self, name: str, function: Callable[..., Any], arguments: list[str]) -> str:
        self.source.globals[f"f_{name}"] = function
        return self.source.temporary(f"f_{name}({', '.join(arguments)})")


def compile_expressions(
    expressions: Sequence[Expression], arguments: Sequence[str]
) -> Callable[..., tuple[float, ...]]:
    """A function of floats, in the order of ``arguments``, that returns the values of all expressions.

    Raises what Python arithmetic raises outside the domain (ArithmeticError, ValueError).
    """
    emitter = Emitter(arguments)
    return emitter.function([emitter.of(expression) for expression in expressions])


def compile_arrays(expressions: Sequence[Expression], names: Sequence[str]) -> Callable[..., Sequence[Any]]:
    """A function of arrays, in the order of ``names``, that returns the values of all expressions."""
    emitter = Emitter(names, ARRAYS, np.power)
    return emitter.function([emitter.of(expression) for expression in expressions])


Pair: TypeAlias = tuple[str, str]

ROUNDED: Mapping[float, tuple[float, float]] = {
    number: (math.nextafter(number, -inf), math.nextafter(number, inf))
    for size in ROUNDED_SLOPES
    for number in (size, -size)
}
"""Floats that slopes have in place of numbers next to them that no float holds."""


class Operations(NamedTuple):
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
