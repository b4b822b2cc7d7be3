"""Expressions compiled to Python source: straight-line code, common parts computed once.

For floats by default; with the functions of ``rulesheets.functions.arrays`` for numpy arrays.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rulesheets.functions import TABLE
from rulesheets.functions.row import Forms
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

VALUES = Forms(TABLE, lambda row: row.value)
"""The functions of the language on floats."""


def _power(base: float, exponent: float) -> float:
    """A real power; ValueError where it would be complex, as ``math.pow`` has it."""
    result = base**exponent
    if isinstance(result, complex):
        raise ValueError("power of a negative number")
    return float(result)


class Emitter:
    """Lines of three-address code. Equal expressions get the same temporary (hash-consing)."""

    def __init__(
        self,
        arguments: Sequence[str],
        functions: Mapping[str, Callable[..., Any]] = VALUES,
        power: Callable[..., Any] = _power,
    ) -> None:
        self._functions, self._power = functions, power
        self.lines: list[str] = []
        self.globals: dict[str, Any] = {"__builtins__": {"ValueError": ValueError}}
        self._tokens: dict[tuple[str, ...], str] = {}
        self._header = ", ".join(f"a{i}" for i in range(len(arguments)))
        self._names = {name: f"a{i}" for i, name in enumerate(arguments)}
        self._count = 0

    def argument(self, name: str) -> str:
        return self._names[name]

    def assign(self, name: str, expression: Expression) -> str:
        """From here on ``name`` stands for the value of the expression."""
        self._names[name] = self.token(expression)
        return self._names[name]

    def require(self, name: str, low: float, high: float, low_open: bool, high_open: bool) -> None:
        """Raise ValueError where the value called ``name`` lies outside the range."""
        token = self._names[name]
        tests = []
        if low > float("-inf"):
            tests.append(f"{token} {'<=' if low_open else '<'} {low!r}")
        if high < float("inf"):
            tests.append(f"{token} {'>=' if high_open else '>'} {high!r}")
        if tests:
            self.lines.append(f"if {' or '.join(tests)}: raise ValueError")

    def clamp(self, name: str, low: float, high: float, clip: Callable[..., Any]) -> None:
        """Move the value called ``name`` into the range (on arrays)."""
        if low > float("-inf") or high < float("inf"):
            ends = (repr(low) if low > float("-inf") else None, repr(high) if high < float("inf") else None)
            self.globals["clip"] = clip
            self._names[name] = self._temporary(f"clip({self._names[name]}, {ends[0]}, {ends[1]})")

    def token(self, expression: Expression) -> str:
        match expression:
            case Number(value):
                return repr(value) if value >= 0 else f"({value!r})"
            case Name(name):
                return self._names[name]
            case Negative(operand):
                return self._temporary("-", self.token(operand))
            case Sum(terms):
                return self._sum(terms)
            case Product(left, right):
                return self._temporary(self.token(left), "*", self.token(right))
            case Quotient(left, right):
                return self._temporary(self.token(left), "/", self.token(right))
            case Power(base, Number(2.0)):
                token = self.token(base)
                return self._temporary(token, "*", token)
            case Power(base, exponent):
                return self._call("power", self._power, (base, exponent))
            case Call(function, arguments):
                return self._call(function, self._functions[function], arguments)
            case Symbol(name):
                raise ValueError(f"the symbol '{name} has no number")

    def _sum(self, terms: tuple[Expression, ...]) -> str:
        token = self.token(terms[0])
        for term in terms[1:]:
            if isinstance(term, Negative):
                token = self._temporary(token, "-", self.token(term.operand))
            else:
                token = self._temporary(token, "+", self.token(term))
        return token

    def _call(self, name: str, function: Callable[..., Any], arguments: tuple[Expression, ...]) -> str:
        self.globals[f"f_{name}"] = function
        tokens = ", ".join(self.token(argument) for argument in arguments)
        return self._temporary(f"f_{name}(", tokens, ")")

    def _temporary(self, *parts: str) -> str:
        token = self._tokens.get(parts)
        if token is None:
            token = f"t{self._count}"
            self._count += 1
            self._tokens[parts] = token
            self.lines.append(f"{token} = {' '.join(parts)}")
        return token

    def function(self, results: str) -> Callable[..., Any]:
        """A function of the arguments, in their order, that returns ``results`` (Python source)."""
        body = "\n    ".join([*self.lines, f"return {results}"])
        namespace = dict(self.globals)
        exec(compile(f"def kernel({self._header}):\n    {body}\n", "<kernel>", "exec"), namespace)
        return namespace["kernel"]  # type: ignore[no-any-return]


def compile_expressions(
    expressions: Sequence[Expression], arguments: Sequence[str]
) -> Callable[..., tuple[float, ...]]:
    """A function of floats, in the order of ``arguments``, that returns the values of all expressions.

    Raises what Python arithmetic raises outside the domain (ArithmeticError, ValueError).
    """
    emitter = Emitter(arguments)
    tokens = [emitter.token(expression) for expression in expressions]
    return emitter.function("(" + "".join(f"{token}, " for token in tokens) + ")")
