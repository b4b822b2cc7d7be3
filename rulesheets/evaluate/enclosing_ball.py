"""The value of an expression over balls: a rigorous enclosure to any precision."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import reduce
from typing import assert_never

from rulesheets.evaluate.number import Undefined
from rulesheets.functions.balls import FUNCTIONS, Ball, ball, whole_power
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
    Symbol,
)


def enclosing_ball(expression: Expression, balls: Mapping[str, Ball], derivative: bool = False) -> Ball:
    """A ball that holds every value of ``expression`` over the ``balls`` of its variables.

    ``derivative``: the expression is one, in which some floats stand for the exact numbers next to
    them; both are enclosed. Raises Undefined where it may not be defined everywhere, KeyError for a
    variable without a ball.
    """
    match expression:
        case Number(value):
            exact = ROUNDED.get(value) if derivative else None
            return ball(value) if exact is None else ball(value).union(enclosing_ball(exact, {}))
        case Name(name):
            return balls[name]
        case Negative(operand):
            return -enclosing_ball(operand, balls, derivative)
        case Sum(terms):
            return reduce(lambda a, b: a + b, (enclosing_ball(term, balls, derivative) for term in terms))
        case Product(left, right):
            return enclosing_ball(left, balls, derivative) * enclosing_ball(right, balls, derivative)
        case Quotient(left, right):
            above, below = (enclosing_ball(part, balls, derivative) for part in (left, right))
            return _defined(above / below, "/", expression)
        case Power(base, exponent):
            return _power(expression, *(enclosing_ball(part, balls, derivative) for part in (base, exponent)))
        case Call(function, arguments):
            inside = [enclosing_ball(argument, balls, derivative) for argument in arguments]
            return _defined(FUNCTIONS[function](*inside), function, expression)
        case Symbol():
            raise Undefined("symbol", (), expression)
        case _:
            assert_never(expression)


def _power(expression: Power, base: Ball, exponent: Ball) -> Ball:
    whole = exponent.unique_fmpz() if exponent.is_exact() and exponent.is_integer() else None
    power = base**exponent if whole is None else whole_power(base, int(whole))
    return _defined(power, "^", expression)


def _defined(result: Ball, operation: str, expression: Expression) -> Ball:
    if not result.is_finite():
        raise Undefined(operation, (math.nan, math.nan)[: 2 if operation == "^" else 1], expression)
    return result
