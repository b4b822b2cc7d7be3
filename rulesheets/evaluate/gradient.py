"""The value of an expression and all its partial derivatives at a point, in one sweep."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import assert_never

from rulesheets.evaluate.number import Undefined, Values, value
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

# Operations on stand-ins for their two parts, and the slopes of a power.
_FIRST, _SECOND = Name("0"), Name("1")
_QUOTIENT, _POWER = Quotient(_FIRST, _SECOND), Power(_FIRST, _SECOND)
_POWER_BY_BASE = Product(_SECOND, Power(_FIRST, Sum((_SECOND, Number(-1.0)))))
_POWER_BY_EXPONENT = Product(_POWER, Call("ln", (_FIRST,)))


@dataclass(frozen=True, slots=True)
class _Trace:
    """A part of an expression at a point: its value, and the slope in each part below it."""

    value: float
    name: str = ""
    slopes: tuple[tuple[float, _Trace], ...] = ()


def derivatives(expression: Expression, values: Values) -> tuple[float, dict[str, float]]:
    """Value and partial derivatives by every variable in the expression.

    Reverse accumulation over the tree. A derivative that does not exist at the point, or
    cannot be told there (``sqrt`` at 0), is nan. Raises as ``value`` does.
    """
    trace = _trace(expression, values)
    if not math.isfinite(trace.value):
        raise Undefined("overflow", (trace.value,), expression)
    gradient: dict[str, float] = {}
    pending = [(1.0, trace)]
    while pending:
        slope, part = pending.pop()
        if part.name:
            gradient[part.name] = gradient.get(part.name, 0.0) + slope
        pending.extend((slope * inner, below) for inner, below in reversed(part.slopes))
    return trace.value, gradient


def _trace(expression: Expression, values: Values) -> _Trace:
    match expression:
        case Name(name):
            return _Trace(value(expression, values), name)
        case Number() | Symbol():
            return _Trace(value(expression, values))
        case Negative(operand):
            part = _trace(operand, values)
            return _Trace(-part.value, slopes=((-1.0, part),))
        case Sum(terms):
            parts = [_trace(term, values) for term in terms]
            total = 0.0
            for part in parts:
                total += part.value
            return _Trace(total, slopes=tuple((1.0, part) for part in parts))
        case Product(left, right):
            first, second = _trace(left, values), _trace(right, values)
            return _Trace(first.value * second.value, slopes=((second.value, first), (first.value, second)))
        case Quotient(left, right):
            return _quotient(expression, _trace(left, values), _trace(right, values))
        case Power(base, exponent):
            return _power(expression, _trace(base, values), _trace(exponent, values))
        case Call(_, arguments):
            return _call(expression, tuple(_trace(argument, values) for argument in arguments))
        case _:
            assert_never(expression)


def _applied(expression: Expression, template: Expression, parts: tuple[_Trace, ...]) -> float:
    """Value of an operation on parts already evaluated; Undefined blames ``expression``."""
    try:
        return value(template, {str(place): part.value for place, part in enumerate(parts)})
    except Undefined as error:
        raise Undefined(error.operation, error.arguments, expression) from None


def _slope(template: Expression | None, parts: tuple[_Trace, ...]) -> float:
    if template is None:
        return math.nan
    try:
        return value(template, {str(place): part.value for place, part in enumerate(parts)})
    except Undefined:
        return math.nan


@cache
def _places(count: int) -> tuple[Expression, ...]:
    """Stand-ins for the arguments of an operation."""
    return tuple(Name(str(place)) for place in range(count))


def _quotient(expression: Quotient, first: _Trace, second: _Trace) -> _Trace:
    result = _applied(expression, _QUOTIENT, (first, second))
    return _Trace(result, slopes=((1.0 / second.value, first), (-result / second.value, second)))


def _power(expression: Power, base: _Trace, exponent: _Trace) -> _Trace:
    parts = (base, exponent)
    result = _applied(expression, _POWER, parts)
    by_base = 0.0 if exponent.value == 0.0 else _slope(_POWER_BY_BASE, parts)
    slopes = [(by_base, base)]
    if exponent.name or exponent.slopes:
        slopes.append((_slope(_POWER_BY_EXPONENT, parts), exponent))
    return _Trace(result, slopes=tuple(slopes))


def _call(expression: Call, parts: tuple[_Trace, ...]) -> _Trace:
    places = _places(len(parts))
    result = _applied(expression, Call(expression.function, places), parts)
    slopes = _partials(expression.function, len(parts))
    return _Trace(
        result, slopes=tuple((_slope(slope, parts), part) for slope, part in zip(slopes, parts, strict=True))
    )


@cache
def _partials(function: str, count: int) -> tuple[Expression | None, ...]:
    return TABLE[function].derivatives(_places(count))
