"""Rules without roots, absolute values, poles and jumps: every zero of the rule is one of the form.

``s = sqrt(e)`` becomes ``e = s^2``, ``t = atan2d(y, x)`` becomes ``y*cosd(t) = x*sind(t)``. The form may
have further zeros (``s = -sqrt(e)``, the opposite direction), so it serves a search, and what is
found is tried in the rule as it was written.
"""

from __future__ import annotations

from rulesheets.functions import TABLE, named
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import (
    Call,
    Expression,
    Negative,
    Number,
    Product,
    Quotient,
    Sum,
    add,
    call,
    divide,
    multiply,
    negative,
    power,
    subtract,
)

_TWO = Number(2.0)
_TANGENTS = named(lambda row: row.half_turn)
_DIRECTIONS = named(lambda row: row.direction)
_ROUGH = frozenset({"sqrt", "abs", *_TANGENTS, *_DIRECTIONS})


def smooth(left: Expression, right: Expression) -> Expression:
    """An expression that vanishes wherever ``left = right`` does, smooth where that can be had."""
    form = subtract(left, right)
    rough = [part for part in _linear_parts(form) if isinstance(part, Call) and part.function in _ROUGH]
    if len(rough) != 1:
        return form
    split = _split(form, rough[0])
    return form if split is None else _without(rough[0], *split)


def _linear_parts(expression: Expression) -> list[Expression]:
    """The operands of sums, signs, products and dividends, all the way down."""
    match expression:
        case Sum(terms):
            return [part for term in terms for part in _linear_parts(term)]
        case Negative(operand):
            return _linear_parts(operand)
        case Product(left, right):
            return [*_linear_parts(left), *_linear_parts(right)]
        case Quotient(left, Number()):
            return _linear_parts(left)
        case _:
            return [expression]


def _split(form: Expression, rough: Call) -> tuple[Expression, Expression] | None:
    """``(factor, rest)`` with ``form = factor*rough + rest``; None where it is not linear."""
    match form:
        case Call() if form is rough:
            return Number(1.0), Number(0.0)
        case Sum(terms):
            holding = [term for term in terms if _holds(term, rough)]
            inner = _split(holding[0], rough) if len(holding) == 1 else None
            others = tuple(term for term in terms if term is not holding[0])
            return None if inner is None else (inner[0], add(inner[1], *others))
        case Negative(operand):
            inner = _split(operand, rough)
            return None if inner is None else (negative(inner[0]), negative(inner[1]))
        case Product(left, right):
            one, other = (left, right) if _holds(left, rough) else (right, left)
            inner = None if _holds(other, rough) else _split(one, rough)
            return None if inner is None else (multiply(inner[0], other), multiply(inner[1], other))
        case Quotient(left, Number() as divisor):
            inner = _split(left, rough)
            return None if inner is None else (divide(inner[0], divisor), divide(inner[1], divisor))
        case _:
            return None


def _holds(expression: Expression, part: Expression) -> bool:
    return expression is part or any(
        _holds(child, part)  # type: ignore[arg-type]
        for child in nodes.children(expression)
    )


def _without(rough: Call, factor: Expression, rest: Expression) -> Expression:
    """``factor*rough + rest = 0`` with the rough operation undone."""
    form = add(multiply(factor, rough), rest)
    if rough.function == "sqrt":
        return subtract(multiply(power(factor, _TWO), rough.arguments[0]), power(rest, _TWO))
    if rough.function == "abs":
        return subtract(power(multiply(factor, rough.arguments[0]), _TWO), power(rest, _TWO))
    if rough.function in _TANGENTS:
        sine, cosine = (call(name, *rough.arguments) for name in TABLE[rough.function].sine_and_cosine)
        return add(multiply(factor, sine), multiply(rest, cosine))
    if not isinstance(factor, Number) or len(rough.arguments) != 2 or abs(factor.value) != 1.0:
        return form
    angle = negative(rest) if factor.value > 0 else rest
    sine, cosine = (call(name, angle) for name in TABLE[rough.function].sine_and_cosine)
    y, x = rough.arguments
    return subtract(multiply(y, cosine), multiply(x, sine))
