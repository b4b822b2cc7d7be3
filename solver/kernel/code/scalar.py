"""Expressions compiled to Python source: straight-line code, common parts computed once.

For floats by default; with the functions of ``rulesheets.functions.arrays`` for numpy arrays.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import inf, nan
from typing import Any

from rulesheets.evaluate.number import Arithmetic
from rulesheets.functions import TABLE
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
        exec(compile(f"def kernel({self._header}):\n    {body}\n", "<kernel>", "exec"), namespace)
        return namespace["kernel"]  # type: ignore[no-any-return]


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
