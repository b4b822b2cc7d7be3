"""The range of an expression over a box, enclosed by interval arithmetic."""

from __future__ import annotations

from collections.abc import Mapping
from functools import reduce

from rulesheets.evaluate.arithmetic import Arithmetic
from rulesheets.functions.intervals.arithmetic import add, divide, multiply, power, square
from rulesheets.functions.intervals.bounds import Interval
from rulesheets.functions.intervals.floats import FLOAT_INTERVALS
from rulesheets.syntax.nodes import Call, Expression, Name, Negative, Number, Power, Product, Quotient, Sum


def enclose(expression: Expression, box: Mapping[str, Interval]) -> Interval:
    """Bounds of ``expression`` where every variable lies between its two ends in ``box``.

    They contain every value that the expression has, in exact arithmetic, where all its
    operations are defined; nan where it is defined nowhere on the box. Raises KeyError for a
    variable that is not in the box and Undefined for arithmetic with a symbol.
    """
    return Intervals(box).of(expression)


class Intervals(Arithmetic[Interval]):
    """Pairs of floats, which Python has no signs for."""

    def __init__(self, box: Mapping[str, Interval]) -> None:
        self.box = box

    def number(self, node: Number) -> Interval:
        return node.value, node.value

    def name(self, node: Name) -> Interval:
        return self.box[node.name]

    def negative(self, node: Negative) -> Interval:
        low, high = self.of(node.operand)
        return -high, -low

    def sum(self, node: Sum) -> Interval:
        return reduce(lambda total, part: add(*total, *part), map(self.of, node.terms))

    def product(self, node: Product) -> Interval:
        factor = self.of(node.left)
        return square(*factor) if node.left == node.right else multiply(*factor, *self.of(node.right))

    def divided(self, node: Quotient, above: Interval, below: Interval) -> Interval:
        return divide(*above, *below)

    def raised(self, node: Power, base: Interval, exponent: Interval) -> Interval:
        return power(*base, *exponent)

    def applied(self, node: Call, arguments: list[Interval]) -> Interval:
        bounds: Interval = FLOAT_INTERVALS[node.function](*(end for pair in arguments for end in pair))
        return bounds
