"""The value of an expression in floats."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from rulesheets.functions import TABLE
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

Values: TypeAlias = Mapping[str, float | str]
"""Numbers and symbols by the full names of variables."""


def number_text(x: float) -> str:
    """Six digits of x, or all where six would pass it off as a whole number."""
    text = f"{x:.6g}"
    return repr(x) if float(text) != x and float(text).is_integer() else text


class Undefined(ArithmeticError):
    """An operation that has no value at its arguments; the text reads ``sqrt of -3.2``.

    ``operation`` is the name of a function, or ``/``, ``^``, ``overflow``, ``symbol``;
    ``expression`` is the part of the tree that it stands for. ``overflow``: there is a value, that no float
    holds.
    """

    def __init__(
        self, operation: str, arguments: tuple[float, ...], expression: Expression, overflow: bool = False
    ) -> None:
        super().__init__(_reading(operation, arguments))
        self.overflow = overflow or operation == "overflow"
        self.operation = operation
        self.arguments = arguments
        self.expression = expression

    @property
    def argument(self) -> float:
        """The argument to blame: the divisor, the base, the first of a function's."""
        return self.arguments[0]

    @property
    def hole(self) -> bool:
        """Whether it divides by 0, be it by a power, or asks for the direction of the origin: a point without
        a value among points that have one.
        """
        return (
            self.operation == "/"
            or (self.operation == "^" and self.arguments[0] == 0.0)
            or (self.operation in TABLE and TABLE[self.operation].direction)
        )


def _reading(operation: str, arguments: tuple[float, ...]) -> str:
    texts = [number_text(argument) for argument in arguments]
    match operation:
        case "/":
            return f"division by {texts[0]}"
        case "^":
            base = f"({texts[0]})" if arguments[0] < 0.0 and arguments[1] != int(arguments[1]) else texts[0]
            return f"{base}^{texts[1]}"
        case "overflow":
            return "a number too large to hold"
        case "symbol":
            return "arithmetic with a symbol"
        case _:
            return f"{operation} of {texts[0]}" if len(texts) == 1 else f"{operation} of ({', '.join(texts)})"


def value(expression: Expression, values: Values) -> float:
    """The value of ``expression``, terms added left to right.

    Raises Undefined where an operation has none, KeyError for a variable without a value.
    """
    result = _evaluate(expression, values)
    if result - result != 0.0:
        raise Undefined("overflow", (result,), expression)
    return result


def _evaluate(expression: Expression, values: Values) -> float:
    return _EVALUATORS[type(expression)](expression, values)


def _number(expression: Number, values: Values) -> float:
    return expression.value


def _name(expression: Name, values: Values) -> float:
    number = values[expression.name]
    if isinstance(number, str):
        raise Undefined("symbol", (), expression)
    return number


def _symbol(expression: Symbol, values: Values) -> float:
    raise Undefined("symbol", (), expression)


def _negative(expression: Negative, values: Values) -> float:
    return -_evaluate(expression.operand, values)


def _sum(expression: Sum, values: Values) -> float:
    total = 0.0
    for term in expression.terms:
        total += _EVALUATORS[type(term)](term, values)
    return total


def _product(expression: Product, values: Values) -> float:
    return _evaluate(expression.left, values) * _evaluate(expression.right, values)


def _quotient(expression: Quotient, values: Values) -> float:
    numerator = _evaluate(expression.left, values)
    divisor = _evaluate(expression.right, values)
    try:
        return numerator / divisor
    except ZeroDivisionError:
        raise Undefined("/", (divisor,), expression) from None


def _power(expression: Power, values: Values) -> float:
    base = _evaluate(expression.base, values)
    exponent = _evaluate(expression.exponent, values)
    try:
        return math.pow(base, exponent)
    except ValueError:
        raise Undefined("^", (base, exponent), expression) from None
    except OverflowError:
        raise Undefined("^", (base, exponent), expression, overflow=True) from None


def _call(expression: Call, values: Values) -> float:
    arguments = [_EVALUATORS[type(item)](item, values) for item in expression.arguments]
    try:
        return TABLE[expression.function].value(*arguments)
    except (ValueError, ZeroDivisionError):
        raise Undefined(expression.function, tuple(arguments), expression) from None
    except OverflowError:
        raise Undefined(expression.function, tuple(arguments), expression, overflow=True) from None


_EVALUATORS: dict[type, Callable[[Any, Values], float]] = {
    Number: _number,
    Name: _name,
    Symbol: _symbol,
    Negative: _negative,
    Sum: _sum,
    Product: _product,
    Quotient: _quotient,
    Power: _power,
    Call: _call,
}
