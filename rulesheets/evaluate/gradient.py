"""The value of an expression, all its partial derivatives at a point and its rounding, in one sweep."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

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


_EPSILON = 2.0**-52
_ULPS = {
    **dict.fromkeys(("gamma", "lgamma", "erf", "erfc", "digamma"), 16.0),
    **dict.fromkeys(("beta", "j0", "j1", "jn", "y0", "y1", "yn", "i0", "k0"), 64.0),
}
"""Functions that floats compute to fewer digits than the last, and by how many units of it."""
_VANISHING = frozenset({"exp", "erfc", "gamma", "k0", "bessel_k1", "beta"})
"""Functions that are never 0 but where floats lose them."""
_DIRECTIONS, _DEGREES = frozenset({"atan2", "atan2d"}), frozenset({"sind", "tand"})
_CHOOSING = frozenset({"min", "max"})
_SMALLEST = 2.0**-1022
"""Numbers below this have fewer digits than others."""
_LEAST = 2.0**-1074


@dataclass(slots=True)
class _Trace:
    """A part of an expression at a point: its value, and the slope in each part below it that varies.

    ``rounded``: the size of the numbers that its own operation has rounded; infinite where it has lost all.
    """

    value: float
    name: str = ""
    slopes: tuple[tuple[float, _Trace], ...] = ()
    rounded: float = 0.0

    @property
    def constant(self) -> bool:
        return not (self.name or self.slopes)


def derivatives(expression: Expression, values: Values) -> tuple[float, dict[str, float]]:
    """Value and partial derivatives by every variable in the expression.

    Reverse accumulation over the tree. A derivative that does not exist at the point, or
    cannot be told there (``sqrt`` at 0), is nan. Raises as ``value`` does.
    """
    return rounded_derivatives(expression, values)[:2]


def rounded_derivatives(expression: Expression, values: Values) -> tuple[float, dict[str, float], float]:
    """As ``derivatives``, and a bound of the rounding error of the value, to first order.

    That is eps times the result of every operation times the slope by it (F. L. Bauer, SIAM Review 16
    (1974) 87–96): names and numbers are taken as exact. nan where a slope below an operation is.
    """
    trace = _trace(expression, values)
    if not math.isfinite(trace.value):
        raise Undefined("overflow", (trace.value,), expression)
    gradient: dict[str, float] = {}
    noise = 0.0
    pending = [(1.0, trace)]
    while pending:
        slope, part = pending.pop()
        if part.name:
            gradient[part.name] = gradient.get(part.name, 0.0) + slope
        elif part.rounded:
            noise += abs(slope) * part.rounded or (_SMALLEST if slope else 0.0)
        for inner, below in part.slopes[::-1]:
            pending.append((slope * inner, below))
    return trace.value, gradient, _EPSILON * noise or (_LEAST if noise else 0.0)


def _trace(expression: Expression, values: Values) -> _Trace:
    return _TRACERS[type(expression)](expression, values)


def _name(expression: Name, values: Values) -> _Trace:
    return _Trace(value(expression, values), expression.name)


def _constant(expression: Number | Symbol, values: Values) -> _Trace:
    return _Trace(value(expression, values))


def _negative(expression: Negative, values: Values) -> _Trace:
    part = _trace(expression.operand, values)
    return _Trace(-part.value, "", ((-1.0, part),))


def _sum(expression: Sum, values: Values) -> _Trace:
    total = rounded = 0.0
    slopes: list[tuple[float, _Trace]] = []
    for term in expression.terms:
        part = _TRACERS[type(term)](term, values)
        total += part.value
        if slopes:
            rounded += abs(total)
        slopes.append((1.0, part))
    return _Trace(total, "", tuple(slopes), rounded)


def _product(expression: Product, values: Values) -> _Trace:
    left, right = expression.left, expression.right
    if type(left) is Number:  # the usual case, a coefficient
        part = _trace(right, values)
        result = left.value * part.value
        return _Trace(result, "", ((left.value, part),), _rounded(result, left.value != 0.0 != part.value))
    first, second = _trace(left, values), _trace(right, values)
    result = first.value * second.value
    rounded = _rounded(result, first.value != 0.0 != second.value)
    if first.value == 0.0 == second.value and _lost(first) and _lost(second):
        rounded = _SMALLEST
    return _Trace(result, "", ((second.value, first), (first.value, second)), rounded)


def _rounded(result: float, some: bool) -> float:
    """The size of a result that has been rounded; ``some``: it would not be 0 in exact numbers."""
    size = abs(result)
    return size if size >= _SMALLEST else _SMALLEST if size else math.inf if some else 0.0


def _lost(part: _Trace) -> bool:
    """Whether a 0 is a number below floats, or made of such, which no slope of what is made of it tells."""
    if part.value != 0.0:
        return False
    below = 0.0 < part.rounded <= _SMALLEST * 64.0 or part.rounded == math.inf
    return below or (not part.rounded and any(_lost(inner) for _, inner in part.slopes))


def _applied(expression: Expression, template: Expression, parts: tuple[_Trace, ...]) -> float:
    """Value of an operation on parts already evaluated; Undefined blames ``expression``."""
    try:
        return value(template, {str(place): part.value for place, part in enumerate(parts)})
    except Undefined as error:
        raise Undefined(error.operation, error.arguments, expression, error.overflow) from None


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


def _quotient(expression: Quotient, values: Values) -> _Trace:
    first, second = parts = _trace(expression.left, values), _trace(expression.right, values)
    result = _applied(expression, _QUOTIENT, parts)
    slopes = (1.0 / second.value, first), (-result / second.value, second)
    return _Trace(result, "", slopes, _rounded(result, first.value != 0.0))


def _power(expression: Power, values: Values) -> _Trace:
    base, exponent = parts = _trace(expression.base, values), _trace(expression.exponent, values)
    result = _applied(expression, _POWER, parts)
    rounded = _rounded(result, base.value != 0.0)
    if result == 0.0 == base.value and _lost(base):
        rounded = _SMALLEST
    by_base = 0.0 if exponent.value == 0.0 else _slope(_POWER_BY_BASE, parts)
    if exponent.constant:
        return _Trace(result, "", ((by_base, base),), rounded)
    by_exponent = _slope(_POWER_BY_EXPONENT, parts)
    return _Trace(result, "", ((by_base, base), (by_exponent, exponent)), rounded)


def _call(expression: Call, values: Values) -> _Trace:
    parts = tuple(_trace(argument, values) for argument in expression.arguments)
    result = _applied(expression, Call(expression.function, _places(len(parts))), parts)
    slopes = _partials(expression.function, len(parts))
    below = tuple((_slope(slope, parts), part) for slope, part in zip(slopes, parts, strict=True))
    size = abs(result)
    if size < _SMALLEST and (size or _below_floats(expression.function, parts) or any(map(_lost, parts))):
        size = _SMALLEST
    if expression.function in _CHOOSING and _tied(parts):
        size = math.inf
    return _Trace(result, "", below, size * _ULPS.get(expression.function, 1.0))


def _below_floats(function: str, parts: tuple[_Trace, ...]) -> bool:
    """Whether the 0 that a function came out as is a number smaller than floats hold."""
    first = parts[0].value if parts else 0.0
    if function in _DIRECTIONS:
        return first != 0.0
    return function in _VANISHING or (function in _DEGREES and 0.0 < abs(first) < _SMALLEST)


def _tied(parts: tuple[_Trace, ...]) -> bool:
    """Whether rounding decides which of these is the least or the greatest (``max(x, pi)`` at 3.14159…)."""
    return any(
        one.value == other.value and (one.rounded or other.rounded)
        for place, one in enumerate(parts)
        for other in parts[:place]
    )


@cache
def _partials(function: str, count: int) -> tuple[Expression | None, ...]:
    return TABLE[function].partials(_places(count))


_TRACERS: dict[type, Callable[[Any, Values], _Trace]] = {
    Number: _constant,
    Symbol: _constant,
    Name: _name,
    Negative: _negative,
    Sum: _sum,
    Product: _product,
    Quotient: _quotient,
    Power: _power,
    Call: _call,
}
