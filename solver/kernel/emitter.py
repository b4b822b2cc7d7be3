"""Expressions as straight-line Python code for floats or numpy arrays, common parts computed
once."""

from __future__ import annotations

import marshal
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import lru_cache
from math import inf, nan
from types import CodeType, FunctionType
from typing import Any, TypeVar

import numpy as np

from rulesheets.evaluate.number import Arithmetic
from rulesheets.functions import ARRAYS, TABLE
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
    children,
    names,
)

CALLED, POWER = "f_", "POWER"
"""The prefix of tokens of functions, and a power: no function of the language has capitals."""


T = TypeVar("T")


def is_square(node: Power) -> bool:
    return node.exponent == Number(2.0)


def _power(base: float, exponent: float) -> float:
    """A real power; raises ValueError if it would be complex, as ``math.pow``."""
    result = base**exponent
    if isinstance(result, complex):
        raise ValueError("power of a negative number")
    return float(result)


class CodeLines(Arithmetic[T]):
    """Lines of a function in three-address code. Equal texts are computed once (hash-consing)."""

    def __init__(self, arguments: Sequence[str], names: dict[str, T]) -> None:
        self.lines: list[str] = []
        self.names = names
        """The value of each name: an argument, or an earlier assignment."""
        self._header = ", ".join(arguments)
        self._tokens: dict[str, str] = {}

    def line(self, text: str) -> None:
        self.lines.append(text)

    def temporary(self, text: str) -> str:
        """A name for the value of the text."""
        token = self._tokens.get(text)
        if token is None:
            token = self._tokens[text] = f"t{len(self._tokens)}"
            self.lines.append(f"{token} = {text}")
        return token

    def code(self, lines: Iterable[str]) -> CodeType:
        """The code of a function of the arguments with these lines."""
        body = "\n    ".join(lines)
        return _compiled(f"def kernel({self._header}):\n    {body}\n")

    def assign(self, name: str, value: T) -> None:
        """Let ``name`` stand for the value from here on."""
        self.names[name] = value

    def name(self, node: Name) -> T:
        return self.names[node.name]


@lru_cache(maxsize=1_000)
def _compiled(text: str) -> CodeType:
    """The code of a function; blocks of one shape share it."""
    return next(c for c in compile(text, "<kernel>", "exec").co_consts if isinstance(c, CodeType))


class Emitter(CodeLines[str]):
    """Code for expressions of named numbers, or of ``arrays`` of them."""

    def __init__(self, arguments: Sequence[str], arrays: bool) -> None:
        self._arrays = arrays
        names = {name: f"a{i}" for i, name in enumerate(arguments)}
        super().__init__([*names.values()], names)

    def function(self, results: Iterable[str]) -> Callable[..., Any]:
        """A function of the arguments, in their order, that returns the values of these tokens."""
        lines = [*self.lines, f"return ({''.join(f'{token}, ' for token in results)})"]
        return function_of(self.code(lines), self._arrays)

    def bound(self, name: str, low: float, high: float, low_open: bool, high_open: bool) -> None:
        """Raise ValueError if the value called ``name`` lies outside the range, or move arrays into
        it."""
        sides = ((low, "<=" if low_open else "<"), (high, ">=" if high_open else ">"))
        tests = [f"{self.names[name]} {sign} {end!r}" for end, sign in sides if math.isfinite(end)]
        if tests and self._arrays:
            self.names[name] = self.temporary(f"clip({self.names[name]}, {low!r}, {high!r})")
        elif tests:
            self.line(f"if {' or '.join(tests)}: raise ValueError")

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
        return self.temporary(f"{CALLED}{POWER}({base}, {exponent})")

    def applied(self, node: Call, arguments: list[str]) -> str:
        if not arguments:
            return repr(TABLE[node.function].value())
        return self.temporary(f"{CALLED}{node.function}({', '.join(arguments)})")


def function_of(code: CodeType, arrays: bool = False) -> Callable[..., Any]:
    """The function of code for floats, or for arrays, which calls those of the language by their
    tokens."""
    own = {POWER: np.power if arrays else _power}
    known: dict[str, Any] = {
        "__builtins__": {"ValueError": ValueError},
        "nan": nan,
        "inf": inf,
        "clip": np.clip,
    }
    for token in code.co_names:
        if token.startswith(CALLED):
            name = token.removeprefix(CALLED)
            known[token] = own.get(name) or (ARRAYS[name] if arrays else TABLE[name].value)
    made = FunctionType(code, known)
    if not arrays:
        made.__dict__["again"] = made_again  # what ``rulesheets.loading`` keeps it by
    return made


def made_again(code: bytes) -> Callable[..., Any]:
    """A function of floats from cached code."""
    return function_of(marshal.loads(code))


def compile_expressions(
    expressions: Sequence[Expression], arguments: Sequence[str], arrays: bool = False
) -> Callable[..., Sequence[Any]]:
    """A function of floats, or of arrays, in the order of ``arguments``, that returns all values.

    With floats it raises what Python arithmetic raises outside the domain (ArithmeticError,
    ValueError).
    """
    emitter = Emitter(arguments, arrays)
    return emitter.function([emitter.of(expression) for expression in expressions])


def divisors(expression: Expression) -> Iterator[Expression]:
    """The divisors of a rule with variables in them (or in a power, or in the cosine of a
    tangent)."""
    stack: list[Any] = [expression]
    while stack:
        node = stack.pop()
        match node:
            case Quotient(_, divisor) if any(names(divisor)):
                yield divisor
            case Power(_, Number(exponent)) if exponent > 0.0:
                pass
            case Power(base, _) if any(names(base)):
                yield base
            case Call("tan" | "tand" as function, arguments):
                yield Call(function.replace("tan", "cos"), arguments)
        stack.extend(children(node))
