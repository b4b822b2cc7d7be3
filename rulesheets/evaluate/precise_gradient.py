"""The value of an expression and all its partial derivatives to many digits, in one sweep."""

from __future__ import annotations

from functools import cache
from typing import TypeAlias

from rulesheets.evaluate.number import Undefined
from rulesheets.evaluate.precise import ExtendedValues, extended
from rulesheets.functions import TABLE
from rulesheets.functions.extended import Extended, context
from rulesheets.functions.slopes import ROUNDED
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
    children,
    rebuilt,
)

_Part: TypeAlias = "tuple[Extended, str, tuple[tuple[Extended, _Part], ...]]"
"""A part of an expression at a point: its value, its name if it is a variable, and its slopes in the parts
below it that vary."""

_FIRST, _SECOND = Name("0"), Name("1")
_QUOTIENT, _POWER = Quotient(_FIRST, _SECOND), Power(_FIRST, _SECOND)
_POWER_BY_BASE = Product(_SECOND, Power(_FIRST, Sum((_SECOND, Number(-1.0)))))
_POWER_BY_EXPONENT = Product(_POWER, Call("ln", (_FIRST,)))


def extended_derivatives(
    expression: Expression, values: ExtendedValues, digits: int
) -> tuple[Extended, dict[str, Extended]]:
    """Value and partial derivatives by every variable in the expression, with ``digits`` decimal digits.

    Reverse accumulation over the tree. Raises Undefined where the expression or one of its slopes has no
    real value, KeyError for a variable without one.
    """
    part = _part(expression, values, digits)
    gradient = dict.fromkeys(_names(part), context(digits).zero)
    pending = [(context(digits).one, part)]
    while pending:
        slope, (_, name, below) = pending.pop()
        if name:
            gradient[name] += slope
        pending.extend((slope * inner, lower) for inner, lower in below)
    return part[0], gradient


def _names(part: _Part) -> list[str]:
    """The variables of a part, in the order in which they are written."""
    _, name, below = part
    return [name] if name else [found for _, lower in below for found in _names(lower)]


def _part(expression: Expression, values: ExtendedValues, digits: int) -> _Part:
    match expression:
        case Name(name):
            return extended(expression, values, digits), name, ()
        case Negative(operand):
            inner = _part(operand, values, digits)
            return -inner[0], "", _varying((-1, inner))
        case Sum(terms):
            added = [_part(term, values, digits) for term in terms]
            total = sum((part[0] for part in added[1:]), added[0][0])
            return total, "", _varying(*((1, part) for part in added))
        case Product(left, right):
            one, other = _part(left, values, digits), _part(right, values, digits)
            return one[0] * other[0], "", _varying((other[0], one), (one[0], other))
        case Quotient(left, right):
            one, other = _part(left, values, digits), _part(right, values, digits)
            result = _at(_QUOTIENT, (one, other), digits, expression)
            return result, "", _varying((1 / other[0], one), (-result / other[0], other))
        case Power(base, exponent):
            return _power(expression, _part(base, values, digits), _part(exponent, values, digits), digits)
        case Call(function, arguments):
            parts = tuple(_part(argument, values, digits) for argument in arguments)
            result = _at(Call(function, _places(len(parts))), parts, digits, expression)
            slopes = _partials(function, len(parts))
            below = [(slope, part) for slope, part in zip(slopes, parts, strict=True) if _varies(part)]
            return result, "", tuple((_at(slope, parts, digits, expression), part) for slope, part in below)
        case _:
            return extended(expression, values, digits), "", ()


def _power(expression: Power, base: _Part, exponent: _Part, digits: int) -> _Part:
    parts = base, exponent
    result = _at(_POWER, parts, digits, expression)
    below = []
    if _varies(base):
        below.append((_at(_POWER_BY_BASE, parts, digits, expression) if exponent[0] else 0, base))
    if _varies(exponent):
        below.append((_at(_POWER_BY_EXPONENT, parts, digits, expression), exponent))
    return result, "", tuple(below)


def _varies(part: _Part) -> bool:
    return bool(part[1] or part[2])


def _varying(*slopes: tuple[Extended, _Part]) -> tuple[tuple[Extended, _Part], ...]:
    return tuple((slope, part) for slope, part in slopes if _varies(part))


def _at(
    template: Expression | None, parts: tuple[_Part, ...], digits: int, expression: Expression
) -> Extended:
    """An operation, or its slope, on parts already evaluated; Undefined blames ``expression``."""
    if template is None:
        raise Undefined("derivative", (), expression)
    try:
        return extended(template, {str(place): part[0] for place, part in enumerate(parts)}, digits)
    except Undefined as error:
        raise Undefined(error.operation, error.arguments, expression) from None


@cache
def _places(count: int) -> tuple[Expression, ...]:
    """Stand-ins for the arguments of an operation."""
    return tuple(Name(str(place)) for place in range(count))


@cache
def _partials(function: str, count: int) -> tuple[Expression | None, ...]:
    """The slopes of a function, with exact numbers in place of the floats that stand for them."""
    slopes = TABLE[function].partials(_places(count))
    return tuple(None if slope is None else _unrounded(slope) for slope in slopes)


def _unrounded(expression: Expression) -> Expression:
    if isinstance(expression, Number):
        return ROUNDED.get(expression.value, expression)
    return rebuilt(expression, tuple(_unrounded(part) for part in children(expression)))  # type: ignore[arg-type]
