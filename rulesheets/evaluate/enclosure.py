"""The range of an expression over boxes, enclosed by interval arithmetic."""

from __future__ import annotations

from collections.abc import Mapping
from functools import reduce
from typing import TypeAlias, assert_never

import numpy as np
from numpy.typing import NDArray

from rulesheets.evaluate.number import Undefined
from rulesheets.functions.intervals import INTERVALS, Interval, add, divide, multiply, negate, power
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

Boxes: TypeAlias = Mapping[str, tuple[NDArray[np.float64] | float, NDArray[np.float64] | float]]
"""Low and high ends of variables, arrays that broadcast to one shape, or floats."""


def enclose(expression: Expression, boxes: Boxes) -> Interval:
    """Bounds of ``expression`` on every box: arrays ``(low, high)`` of the shape of the boxes.

    They contain every value that the expression has, in exact arithmetic, where all its
    operations are defined; nan where it is defined nowhere on the box. Raises KeyError for a
    variable without a box and Undefined for arithmetic with a symbol.
    """
    shape = np.broadcast_shapes(*(np.shape(end) for box in boxes.values() for end in box))
    low, high = _enclose(expression, boxes)
    return np.broadcast_to(low, shape), np.broadcast_to(high, shape)


def _enclose(expression: Expression, boxes: Boxes) -> Interval:
    match expression:
        case Number(value):
            return np.asarray(value), np.asarray(value)
        case Name(name):
            low, high = boxes[name]
            return np.asarray(low, dtype=float), np.asarray(high, dtype=float)
        case Negative(operand):
            return negate(*_enclose(operand, boxes))
        case Sum(terms):
            return reduce(lambda total, part: add(*total, *part), (_enclose(term, boxes) for term in terms))
        case Product(left, right):
            return _product(left, right, boxes)
        case Quotient(left, right):
            return divide(*_enclose(left, boxes), *_enclose(right, boxes))
        case Power(base, exponent):
            return power(*_enclose(base, boxes), *_enclose(exponent, boxes))
        case Call(function, arguments):
            ends = [end for argument in arguments for end in _enclose(argument, boxes)]
            return INTERVALS[function](*ends)
        case Symbol():
            raise Undefined("symbol", (), expression)
        case _:
            assert_never(expression)


def _product(left: Expression, right: Expression, boxes: Boxes) -> Interval:
    """A product; that of equal factors is a square, which is never negative."""
    factor = _enclose(left, boxes)
    if left == right:
        two = np.asarray(2.0)
        return power(*factor, two, two)
    return multiply(*factor, *_enclose(right, boxes))
