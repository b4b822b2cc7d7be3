"""One walk over an expression, whatever its numbers are.

An :class:`Arithmetic` says what a number is: how constants and variables enter, and the operations that
Python has no sign for, or that may have no value. All else is written once here, for any numbers with the
signs ``+ - *``. (As in ``core/calculus.hpp`` of CasADi: J. Andersson et al., Math. Programming Computation 11
(2019) 1–36.)
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, Generic, TypeVar

from rulesheets.evaluate.undefined import Undefined
from rulesheets.syntax.nodes import (
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

T = TypeVar("T")


class Arithmetic(Generic[T]):
    """The value of an expression in numbers of the type T; ``of`` raises Undefined where it has none."""

    __slots__ = ()
    operations: ClassVar[dict[type, Callable[..., Any]]] = {}

    def __init_subclass__(cls) -> None:
        cls.operations = {
            Number: cls.number,
            Name: cls.name,
            Symbol: cls.symbol,
            Negative: cls.negative,
            Sum: cls.sum,
            Product: cls.product,
            Quotient: cls.quotient,
            Power: cls.power,
            Call: cls.call,
        }

    def of(self, node: Expression) -> T:
        value: T = self.operations[type(node)](self, node)
        return value

    # --- what an arithmetic says of its numbers ---

    def number(self, node: Number) -> T:
        """A number of the sheet, which is taken exactly."""
        raise NotImplementedError

    def name(self, node: Name) -> T:
        """A variable. Raises KeyError for one without a value."""
        raise NotImplementedError

    def divided(self, node: Quotient, above: T, below: T) -> T:
        raise NotImplementedError

    def raised(self, node: Power, base: T, exponent: T) -> T:
        raise NotImplementedError

    def applied(self, node: Call, arguments: list[T]) -> T:
        """The function of a call."""
        raise NotImplementedError

    # --- the walk ---

    def symbol(self, node: Symbol) -> T:
        raise Undefined("symbol", (), node)

    def negative(self, node: Negative) -> T:
        value: T = -self.operations[type(node.operand)](self, node.operand)
        return value

    def sum(self, node: Sum) -> T:
        """The terms added left to right."""
        operations, terms = self.operations, node.terms
        total: T = operations[type(terms[0])](self, terms[0])
        for term in terms[1:]:
            total = total + operations[type(term)](self, term)
        return total

    def product(self, node: Product) -> T:
        operations, left, right = self.operations, node.left, node.right
        value: T = operations[type(left)](self, left) * operations[type(right)](self, right)
        return value

    def quotient(self, node: Quotient) -> T:
        operations, left, right = self.operations, node.left, node.right
        above = operations[type(left)](self, left)
        return self.divided(node, above, operations[type(right)](self, right))

    def power(self, node: Power) -> T:
        operations, base, exponent = self.operations, node.base, node.exponent
        return self.raised(
            node, operations[type(base)](self, base), operations[type(exponent)](self, exponent)
        )

    def call(self, node: Call) -> T:
        operations = self.operations
        return self.applied(node, [operations[type(item)](self, item) for item in node.arguments])
