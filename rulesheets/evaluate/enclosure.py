"""The range of an expression over a box, enclosed by interval arithmetic."""

from __future__ import annotations

from collections.abc import Mapping
from functools import reduce

from rulesheets.evaluate.number import Undefined
from rulesheets.functions.intervals.arithmetic import add, divide, multiply, power, square
from rulesheets.functions.intervals.bounds import Interval
from rulesheets.functions.intervals.floats import FLOAT_INTERVALS
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


def enclose(expression: Expression, box: Mapping[str, Interval]) -> Interval:
    """Bounds of ``expression`` where every variable lies between its two ends in ``box``.

    They contain every value that the expression has, in exact arithmetic, where all its
    operations are defined; nan where it is defined nowhere on the box. Raises KeyError for a
    variable that is not in the box and Undefined for arithmetic with a symbol.
    """
    match expression:
        case Number(value):
            return value, value
        case Name(name):
            return box[name]
        case Negative(operand):
            low, high = enclose(operand, box)
            return -high, -low
        case Sum(terms):
            return reduce(lambda total, part: add(*total, *part), (enclose(term, box) for term in terms))
        case Product(left, right):
            factor = enclose(left, box)
            return square(*factor) if left == right else multiply(*factor, *enclose(right, box))
        case Quotient(left, right):
            return divide(*enclose(left, box), *enclose(right, box))
        case Power(base, exponent):
            return power(*enclose(base, box), *enclose(exponent, box))
        case Call(function, arguments):
            ends = [end for argument in arguments for end in enclose(argument, box)]
            bounds: Interval = FLOAT_INTERVALS[function](*ends)
            return bounds
        case Symbol():
            raise Undefined("symbol", (), expression)
