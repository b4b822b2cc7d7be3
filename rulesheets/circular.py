"""Sines, cosines and tangents of numbers written as parts of π: ``sin(pi)`` is 0, ``cos(2*pi/3)`` is -0.5.

Floats have no π, so that they make 1.2e-16 of ``sin(pi)``: a coefficient, where a rule has none. What is
exactly a float is put in for it as a sheet is expanded. Poles stay as they are written.
"""

from __future__ import annotations

from fractions import Fraction

from rulesheets.functions.degrees import cosd, sind, tand
from rulesheets.syntax.nodes import (
    Call,
    Expression,
    Negative,
    Number,
    Product,
    Quotient,
    Sum,
    children,
    rebuilt,
)

_DEGREES = {"sin": sind, "cos": cosd, "tan": tand}
_ROUND = frozenset({0.0, 0.5, -0.5, 1.0, -1.0})


def with_round_values(expression: Expression) -> Expression:
    """The expression with every sine, cosine and tangent of a part of π that is 0, ±1/2 or ±1 put in."""
    parts = children(expression)
    if not parts:
        return expression
    found: list[Expression] = []
    for part in parts:  # a loop, for one frame a level: trees may be hundreds of levels deep
        found.append(with_round_values(part))  # type: ignore[arg-type]
    if any(new is not old for new, old in zip(found, parts, strict=True)):
        expression = rebuilt(expression, tuple(found))
    if isinstance(expression, Call) and expression.function in _DEGREES:
        number = _round_value(expression.function, expression.arguments[0])
        return expression if number is None else Number(number, expression.span)
    return expression


def _round_value(function: str, angle: Expression) -> float | None:
    share = _share_of_pi(angle)
    if share is None:
        return None
    degrees = 180 * share % 360
    if degrees.denominator != 1:
        return None
    try:
        value = _DEGREES[function](float(degrees))
    except ZeroDivisionError:
        return None
    return value if value in _ROUND else None


def _share_of_pi(angle: Expression) -> Fraction | None:
    """q where the angle is written as q·π, q a rational number other than 0; else None."""
    match angle:
        case Call("pi"):
            return _rational(Number(1.0))
        case Negative(operand):
            share = _share_of_pi(operand)
            return None if share is None else -share
        case Sum(terms):
            shares = [_share_of_pi(term) for term in terms]
            known = [share for share in shares if share is not None]
            return sum(known[1:], known[0]) if known and len(known) == len(shares) else None
        case Product(left, right):
            for one, other in ((left, right), (right, left)):
                share, factor = _share_of_pi(one), _rational(other)
                if share is not None and factor is not None:
                    return share * factor
        case Quotient(left, right):
            share, divisor = _share_of_pi(left), _rational(right)
            return share / divisor if share is not None and divisor else None
    return None


def _rational(expression: Expression) -> Fraction | None:
    match expression:
        case Number(value):
            return Fraction(value)
        case Negative(operand):
            number = _rational(operand)
            return None if number is None else -number
        case Quotient(left, right):
            above, below = _rational(left), _rational(right)
            return above / below if above is not None and below else None
    return None
