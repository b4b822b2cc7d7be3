"""Expressions, angles and conditions as operations of a graph.

Simplifications keep the value to rounding: the tangent of the direction of a point is the quotient
of its coordinates, a cosine shifted by right angles is a sine, and for an angle from a closed form
the cosine and sine are there already.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import partial, reduce
from typing import Any, NamedTuple

from rulesheets.functions import TABLE
from rulesheets.syntax import nodes
from solver.numerics.tolerances import BACKWARD, EPS
from solver.trace.graph import (
    LEAVES,
    LOGICAL,
    OPERATIONS,
    Graph,
    Node,
    NotCompilable,
    Operand,
    computed_from,
    not_negative,
)

LIBRARY = 4.0
"""Units in the last place that an operation, or a function of the library, may be off by."""
WIDE = 2.0**16
_EXACT = frozenset({"neg", "abs", "rint", "where", "max"})
_BOUNDED = frozenset({"sin", "cos", "sind", "cosd"})
_ODD = frozenset({"tan", "tand", "sinh", "tanh", "asin", "asind", "atan", "atand", "asinh"})
NEAR = 1e-13
"""A direction nearer to the axis than this (as a quotient) is left to a full solve."""


class Direction(NamedTuple):
    """A node that is the direction of the point (x, y), in degrees or (unit "") in radians."""

    y: int
    x: int
    unit: str
    length: int | None
    """The node of the point's distance from the origin, or None for 1."""


class Flow(Graph):
    """The graph of a record."""

    def __init__(self, plain: bool = False) -> None:
        super().__init__(plain)
        self._directions: dict[int, Direction] = {}

    def expression(self, node: nodes.Expression, values: Mapping[str, int]) -> int:
        """The node of an expression; ``values`` gives that of every variable."""
        match node:
            case nodes.Number(value):
                return self.constant(value)
            case nodes.Name(name):
                return values[name]
            case nodes.Negative(operand):
                return self.add("neg", self.expression(operand, values))
            case nodes.Sum(terms):
                return reduce(
                    partial(self.add, "add"), [self.expression(term, values) for term in terms]
                )
            case nodes.Product(left, right):
                return self.add(
                    "mul", self.expression(left, values), self.expression(right, values)
                )
            case nodes.Quotient(left, right):
                divided = self.expression(left, values)
                divisor = self.expression(right, values)
                self._divisor(divisor)
                return self.add("div", divided, divisor)
            case nodes.Power(base, exponent):
                return self._power(self.expression(base, values), exponent, values)
            case nodes.Call(function, arguments):
                return self.call(function, *(self.expression(item, values) for item in arguments))
            case _:
                raise NotCompilable

    def _divisor(self, divisor: int) -> None:
        if self.value_of(divisor) is None:
            self.bound(divisor)
            self.apart_from_zero(divisor)

    def apart_from_zero(self, divisor: int) -> None:
        """Require that a divisor, and each sum in it, is more than its rounding error."""
        sums = [
            (factor, terms)
            for factor in self._factors(divisor)
            if (terms := self._cancelling(factor))
        ]
        for factor, terms in sums:
            self.require(self.beyond(factor, BACKWARD, self.over("add", map(self._reach, terms))))
        if [divisor] != [factor for factor, _ in sums]:
            self.require(self.add("not", self.is_zero(divisor)))

    def _reach(self, term: int) -> int:
        """An upper bound of the size of a term; a number for a sine, which saves operations."""
        number, node = self.factor(term) or (1.0, term)
        return (
            self.constant(abs(number)) if self.nodes[node][0] in _BOUNDED else self.add("abs", term)
        )

    def _factors(self, node: int) -> list[int]:
        """The factors at whose zeros a product, a quotient, or an odd function vanishes."""
        kind, *parts = self.nodes[node]
        if kind == "call" and parts[0] in _ODD:
            return self._factors(int(parts[1]))
        if kind not in ("mul", "div", "neg", "abs", "sin", "sind"):
            return [node]
        read = parts[:1] if kind == "div" else dict.fromkeys(parts)
        return [factor for part in read for factor in self._factors(int(part))]

    def _cancelling(self, node: int) -> list[int]:
        """The terms of a sum that may cancel, and 1 of a logarithm; none for another number."""
        if self.nodes[node][:2] == ("call", "ln"):
            return [self.constant(1.0)]
        if self.nodes[node][0] not in ("add", "sub") or not_negative(self, node):
            return []
        terms, waiting = list[int](), [node]
        while waiting:
            kind, *parts = self.nodes[one := waiting.pop()]
            if kind in ("add", "sub", "neg"):
                waiting.extend(map(int, parts))
            else:
                terms.append(one)
        return terms

    def _power(self, base: int, exponent: nodes.Expression, values: Mapping[str, int]) -> int:
        match exponent:
            case nodes.Number(2.0):
                return self.add("mul", base, base)
            case nodes.Number(3.0):
                return self.add("mul", self.add("mul", base, base), base)
            case nodes.Number(-1.0):
                self._divisor(base)
                return self.add("div", 1.0, base)
            case nodes.Number(0.5):
                return self.add("sqrt", base)
            case _:
                power = self.expression(exponent, values)
                known = self.value_of(power)
                if known is not None and known < 0.0:
                    self._divisor(base)
                return self.add("pow", base, power)

    def call(self, function: str, *arguments: int) -> int:
        """The node of a function; for a function of an angle, simplified for known directions."""
        if function in ("sqrt", "abs"):
            return self.add(function, *arguments)
        if all(self.value_of(argument) is not None for argument in arguments):
            try:
                result = TABLE[function].value(*(self.value_of(a) for a in arguments))
            except (ArithmeticError, ValueError):
                raise NotCompilable from None
            return self.constant(result)
        if function in _CIRCULAR:
            return self._circular(function, arguments[0])
        for argument in arguments:
            self.bound(argument)
        if function == "ln" and (beside := self.beside_one(arguments[0])) is not None:
            return self.add("log1p", beside)
        if function in ("atan2", "atan2d"):
            node = self.node("call", function, *arguments)
            if node not in self._directions:
                y, x = arguments
                unit = function.removeprefix("atan2")
                self._directions[node] = Direction(y, x, unit, self.length(y, x))
            self.require(self.add("not", self.over("and", map(self.is_zero, arguments))))
            return node
        return self.node("call", function, *arguments)

    def direction(self, y: int, x: int, unit: str, on_circle: bool) -> int:
        """The direction of a point on the unit circle, exactly or up to what formulas lose."""
        node = self.node("direction" + unit, y, x)
        length = None if on_circle else self.length(y, x)
        self._directions[node] = Direction(y, x, unit, length)
        return node

    def length(self, y: int, x: int) -> int:
        """The distance of a point from the origin."""
        return self.add("sqrt", self.add("add", self.add("mul", x, x), self.add("mul", y, y)))

    def selected(self, condition: int, one: int, other: int) -> int:
        """A selection; of two directions it is the direction of the selected point."""
        node = super().selected(condition, one, other)
        first, second = self._directions.get(one), self._directions.get(other)
        if first and second and first.unit == second.unit:
            pairs = (first.y, second.y), (first.x, second.x)
            y, x = (self.add("where", condition, *pair) for pair in pairs)
            length = None if first.length is None is second.length else self.length(y, x)
            self._directions.setdefault(node, Direction(y, x, first.unit, length))
        return node

    # --- angles ---

    def _circular(self, function: str, angle: int) -> int:
        unit = "d" if function.endswith("d") else ""
        kind = function.removesuffix("d")
        known = self._directions.get(angle)
        if known is not None and known.unit == unit:
            if kind == "tan":
                self._divisor(known.x)
                return self.add("div", known.y, known.x)
            part = known.x if kind == "cos" else known.y
            return part if known.length is None else self.add("div", part, known.length)
        operation = self.nodes[angle]
        if operation[0] == "neg":
            inside = self._circular(function, int(operation[1]))
            return inside if kind == "cos" else self.add("neg", inside)
        if unit == "d" and operation[0] in ("add", "sub") and not self.plain:
            moved = self._moved(kind, operation)
            if moved is not None:
                return moved
        if kind == "tan":
            return self.node("call", function, angle)
        return self.node(function, angle)

    def _moved(self, kind: str, operation: Node) -> int | None:
        """An angle plus or minus a number of right angles."""
        left, right = int(operation[1]), int(operation[2])
        subtracted = operation[0] == "sub"
        shift, angle = self.value_of(right), left
        if isinstance(shift, float) and subtracted:
            shift = -shift
        if shift is None:
            shift, angle = self.value_of(left), self.add("neg", right) if subtracted else right
        if not isinstance(shift, float) or shift % 90.0 != 0.0 or abs(shift) > 1e9:
            return None
        return self._turned(kind, angle, int(shift / 90.0) % 4)

    def _turned(self, kind: str, angle: int, quarters: int) -> int:
        if kind == "tan":
            tangent = self._circular("tand", angle)
            if quarters % 2 == 0:
                return tangent
            self._divisor(tangent)
            return self.add("neg", self.add("div", 1.0, tangent))
        names = ("cosd", "sind") if kind == "cos" else ("sind", "cosd")
        found = self._circular(names[quarters % 2], angle)
        minus = quarters in ((1, 2) if kind == "cos" else (2, 3))
        return self.add("neg", found) if minus else found

    # --- conditions ---

    def compare(self, operator: str, left: int, right: int, error: float | None = None) -> int:
        """The node of a comparison of two numbers; with an ``error`` none that this may decide."""
        if operator in ("=", "<>"):
            same = self._same(left, right, error or 0.0)
            return same if operator == "=" else self.add("not", same)
        if error is not None:
            self.decide(left, right, error)
        pair = (left, right) if operator[0] == "<" else (right, left)
        return self.add("le" if operator.endswith("=") else "lt", *pair)

    def _same(self, left: int, right: int, error: float) -> int:
        for angle, other in ((left, right), (right, left)):
            known, number = self._directions.get(angle), self.value_of(other)
            if known is None or known.unit != "d" or not isinstance(number, float):
                continue
            if abs(number) > 180.5:
                return self.false
            if number in (0.0, 180.0):
                # Neither to the right nor to the left of the origin: away from the axis, for
                # certain.
                self.require(self.beyond(known.y, NEAR, self.add("abs", known.x)))
                return self.false
        return self.decide(left, right, error)

    def decide(self, left: int, right: int, error: float) -> int:
        """Whether numbers are equal: where they are nearly so, or no further apart than an error,
        more digits than floats have decide."""
        add = self.add
        same = add("eq", left, right)
        size = add("add", add("abs", left), add("abs", right))
        off = add("add", add("mul", BACKWARD, size), error)
        apart = add("lt", off, add("abs", add("sub", left, right)))
        self.require(add("or", apart, same))
        return same


_CIRCULAR = frozenset({"sind", "cosd", "tand", "sin", "cos", "tan"})


class Numbers:
    """Evaluates nodes at one set of inputs, each once. ``found`` has nodes whose values are
    given."""

    def __init__(self, flow: Flow, inputs: Mapping[int, float]) -> None:
        self.flow, self.inputs = flow, inputs
        self.found: dict[int, float | bool] = {}
        self._errors: dict[int, float] = {}

    def error(self, node: int) -> float:
        """A first-order bound of the rounding error of a node: running error analysis (Higham,
        Accuracy and Stability of Numerical Algorithms, 2002, section 3.3)."""
        for one in sorted(computed_from(self.flow, [node], self._errors)):
            self._errors[one] = self._error(one)
        return self._errors[node]

    def _error(self, node: int) -> float:
        operation, *rest = self.flow.nodes[node]
        if operation in LOGICAL | LEAVES or operation == "root":
            return 0.0
        result, parts = self(node), self.flow.operands[node]
        total = 0.0 if operation in _EXACT else LIBRARY * EPS * abs(result)
        numbers = [self(part) for part in parts] if operation != "item" else []
        for place, number in enumerate(numbers):
            off = WIDE * self._errors[parts[place]]  # what is moved farther is not rounded away
            with suppress(ArithmeticError, ValueError):
                moved = [*numbers[:place], number + off, *numbers[place + 1 :]] if off else numbers
                total += abs(self._result(operation, rest, moved) - result) / WIDE
        return total

    def __call__(self, node: int) -> float | bool:
        """The number of a node; nan if an operation has none."""
        if node not in self.found:
            for one in sorted(computed_from(self.flow, [node], self.found)):
                self.found[one] = self._value(one)
        return self.found[node]

    def _value(self, node: int) -> float | bool:
        operation, *rest = self.flow.nodes[node]
        if operation in LEAVES:
            number: Any = rest[0]
            return self.inputs[int(number)] if operation == "input" else number
        try:
            return self._result(
                operation, rest, [self.found[one] for one in self.flow.operands[node]]
            )
        except (ArithmeticError, ValueError):
            return math.nan

    def _result(
        self, operation: Operand, rest: Sequence[Operand], numbers: list[float | bool]
    ) -> float | bool:
        row = TABLE[str(rest[0])] if operation == "call" else OPERATIONS[str(operation)]
        return row.value(*numbers)
