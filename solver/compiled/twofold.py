"""Polynomials of exact numbers to twice the digits of a float, as nodes of a graph.

A number is the sum of two floats, the second one what rounding took from the first. (T. J. Dekker, Numerische
Mathematik 18 (1971) 224–242; no fused operations are used, so that floats, arrays and machine code agree.)
For discriminants near zero, of which the difference of two rounded numbers leaves few digits.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from rulesheets.nodes import Expression, Name, Negative, Number, Power, Product, Sum
from solver.compiled.flow import NotCompilable

if TYPE_CHECKING:
    from collections.abc import Mapping
    from fractions import Fraction
    from typing import TypeAlias

    from solver.compiled.flow import Flow

    Pair: TypeAlias = tuple[int, int]

SPLITTER = 2.0**27 + 1.0


class Twofold:
    """Pairs of nodes. Constants are worked out exactly before they are parted in two."""

    def __init__(self, flow: Flow) -> None:
        self.flow = flow

    def pair(self, expression: Expression, values: Mapping[str, int]) -> Pair:
        """The value of an expression of variables that are inputs or given numbers.

        Raises NotCompilable for other variables, and for operations that are no polynomial's.
        """
        found = self._value(expression, values)
        return found if isinstance(found, tuple) else self._constant(found)

    def add(self, one: Pair, other: Pair) -> Pair:
        total, error = self._sum(one[0], other[0])
        return self._normal(total, self._node("add", error, self._node("add", one[1], other[1])))

    def negative(self, one: Pair) -> Pair:
        return self._node("neg", one[0]), self._node("neg", one[1])

    def multiply(self, one: Pair, other: Pair) -> Pair:
        product, error = self._product(one[0], other[0])
        across = self._node("add", self._node("mul", one[0], other[1]), self._node("mul", one[1], other[0]))
        return self._normal(product, self._node("add", error, across))

    def _value(self, expression: Expression, values: Mapping[str, int]) -> Pair | Fraction:
        from fractions import Fraction

        match expression:
            case Number(number):
                return Fraction(number)
            case Name(name):
                return self._variable(values[name])
            case Negative(operand):
                inside = self._value(operand, values)
                return self.negative(inside) if isinstance(inside, tuple) else -inside
            case Sum((first, *others)):
                total = self._value(first, values)
                for term in others:
                    total = self._joined("add", total, self._value(term, values))
                return total
            case Product(left, right):
                return self._joined("mul", self._value(left, values), self._value(right, values))
            case Power(base, Number(exponent)) if exponent in (2.0, 3.0):
                factor = self._value(base, values)
                square = self._joined("mul", factor, factor)
                return square if exponent == 2.0 else self._joined("mul", square, factor)
            case _:
                raise NotCompilable

    def _variable(self, node: int) -> Pair | Fraction:
        from fractions import Fraction

        flow = self.flow
        if flow.nodes[node][0] == "input":
            return node, flow.constant(0.0)
        number = flow.value_of(node)
        if not isinstance(number, float) or flow.off(node):
            raise NotCompilable
        try:
            return Fraction(number)
        except (OverflowError, ValueError):
            raise NotCompilable from None

    def _joined(self, operation: str, one: Pair | Fraction, other: Pair | Fraction) -> Pair | Fraction:
        if not isinstance(one, tuple) and not isinstance(other, tuple):
            return one + other if operation == "add" else one * other
        pairs = [part if isinstance(part, tuple) else self._constant(part) for part in (one, other)]
        return self.add(*pairs) if operation == "add" else self.multiply(*pairs)

    def _constant(self, number: Fraction) -> Pair:
        try:
            high = float(number)
            return self.flow.constant(high), self.flow.constant(float(number - type(number)(high)))
        except OverflowError:
            raise NotCompilable from None

    # Sums and products as they are, for whatever simplifies them takes the errors for zero.

    def _node(self, operation: str, *operands: int) -> int:
        flow = self.flow
        numbers = [flow.value_of(operand) for operand in operands]
        if operation == "mul" and 0.0 in numbers:
            return flow.constant(0.0)
        if operation == "add" and 0.0 in numbers:
            return operands[1 - numbers.index(0.0)]
        if operation == "sub" and numbers[1] == 0.0:
            return operands[0]
        if all(isinstance(number, float) for number in numbers):
            return flow.constant(_FOLD[operation](*numbers))
        return flow.node(operation, *operands)

    def _sum(self, a: int, b: int) -> Pair:
        """The rounded sum, and what it was rounded by."""
        node = self._node
        total = node("add", a, b)
        part = node("sub", total, a)
        return total, node("add", node("sub", a, node("sub", total, part)), node("sub", b, part))

    def _normal(self, a: int, b: int) -> Pair:
        """The same for a number and a smaller one."""
        total = self._node("add", a, b)
        return total, self._node("sub", b, self._node("sub", total, a))

    def _product(self, a: int, b: int) -> Pair:
        node = self._node
        product = node("mul", a, b)
        (ah, al), (bh, bl) = self._halves(a), self._halves(b)
        rest = node("sub", node("mul", ah, bh), product)
        rest = node("add", node("add", rest, node("mul", ah, bl)), node("mul", al, bh))
        return product, node("add", rest, node("mul", al, bl))

    def _halves(self, a: int) -> Pair:
        """The upper and the lower half of the digits."""
        node = self._node
        larger = node("mul", self.flow.constant(SPLITTER), a)
        upper = node("sub", larger, node("sub", larger, a))
        return upper, node("sub", a, upper)


_FOLD: dict[str, Callable[..., float]] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "neg": lambda a: -a,
}
