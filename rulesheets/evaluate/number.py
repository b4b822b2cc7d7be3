"""The value of an expression in floats."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TypeAlias

from rulesheets.evaluate.arithmetic import Arithmetic
from rulesheets.evaluate.undefined import Undefined, number_text
from rulesheets.functions import TABLE
from rulesheets.syntax.nodes import Call, Expression, Name, Number, Power, Quotient, Sum

__all__ = ["Floats", "Undefined", "Values", "number_text", "value"]

Values: TypeAlias = Mapping[str, float | str]
"""Numbers and symbols by the full names of variables."""


class Floats(Arithmetic[float]):
    """Floats; a variable with a symbol has no number."""

    __slots__ = ("values",)

    def __init__(self, values: Values) -> None:
        self.values = values

    def number(self, node: Number) -> float:
        return node.value

    def name(self, node: Name) -> float:
        number = self.values[node.name]
        if isinstance(number, str):
            raise Undefined("symbol", (), node)
        return number

    def sum(self, node: Sum) -> float:
        total, operations = 0.0, self.operations
        for term in node.terms:
            total += operations[type(term)](self, term)
        return total

    def divided(self, node: Quotient, above: float, below: float) -> float:
        try:
            return above / below
        except ZeroDivisionError:
            raise Undefined("/", (below,), node) from None

    def raised(self, node: Power, base: float, exponent: float) -> float:
        try:
            return math.pow(base, exponent)
        except ValueError:
            raise Undefined("^", (base, exponent), node) from None
        except OverflowError:
            raise Undefined("^", (base, exponent), node, overflow=True) from None

    def applied(self, node: Call, arguments: list[float]) -> float:
        try:
            return TABLE[node.function].value(*arguments)
        except (ValueError, ZeroDivisionError):
            raise Undefined(node.function, tuple(arguments), node) from None
        except OverflowError:
            raise Undefined(node.function, tuple(arguments), node, overflow=True) from None


def value(expression: Expression, values: Values) -> float:
    """The value of ``expression``, terms added left to right.

    Raises Undefined where an operation has none, KeyError for a variable without a value.
    """
    result = Floats(values).of(expression)
    if result - result != 0.0:
        raise Undefined("overflow", (result,), expression)
    return result
