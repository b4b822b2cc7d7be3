"""A straight-line program as a graph: every operation once, constants folded, angles simplified.

Nodes are numbered in the order in which they can be computed, and equal operations are one node. What
is simplified keeps the value to rounding: the tangent of the direction of a point is the quotient
of its coordinates, a cosine moved by right angles is a sine, and where an angle came out of a
closed form its cosine and sine are there already.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias

from rulesheets.functions import TABLE
from rulesheets.syntax.nodes import Call, Expression, Name, Negative, Number, Power, Product, Quotient, Sum
from solver.trace.folding import folded_error
from solver.trace.simplify import SIMPLIFY

Operand: TypeAlias = int | float | str
Node: TypeAlias = tuple[Operand, ...]

"""An operation and the numbers of its operands; of ``const`` the value (and, where it was computed, how
far it may be off), of ``call`` the function and of ``root`` the number of its finder first. ``sooner`` is its
second operand, which may be dear to compute: true where the first is true."""

TOLERANCE = 16.0 * 2.0**-52
NEAR = 1e-13
"""A direction nearer to the axis than this (as a quotient) is left to a full solve."""


class NotCompilable(Exception):
    """What has no straight-line form: a symbol in arithmetic, a constant without a value."""


FOLD: dict[str, Callable[..., float | bool]] = {
    "neg": lambda a: -a,
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "sqrt": math.sqrt,
    "abs": abs,
    "rint": lambda a: float(round(a)),
    "pow": math.pow,
    "expm1": math.expm1,
    "log1p": math.log1p,
    "lt": lambda a, b: a < b,
    "le": lambda a, b: a <= b,
    "eq": lambda a, b: a == b,
    "near": lambda a, b: abs(a - b) <= TOLERANCE * max(abs(a), abs(b)),
    "and": lambda a, b: a and b,
    "or": lambda a, b: a or b,
    "not": lambda a: not a,
    "xor": lambda a, b: a is not b,
    "where": lambda c, a, b: a if c else b,
    "max": max,
    "sooner": lambda sooner, whole: whole,
}


class Finder(Protocol):
    """Roots of a block as a function of known numbers: one, or (``several``) one for each unknown.

    ``scalar`` raises ValueError and ``array`` (n,), or (unknowns, n), has nan where there is none.
    """

    several: bool

    def scalar(self, *known: float) -> Any: ...

    def array(self, *known: Any) -> Any: ...


@dataclass(frozen=True, slots=True)
class Direction:
    """A node that is the direction of the point (x, y), in degrees or (unit "") in radians."""

    y: int
    x: int
    unit: str
    length: int | None
    """The node of the point's distance from the origin, or None for 1."""


class Flow:
    """The graph. ``plain``: as the rules are written, without what leaves special directions out or is more
    exact than the rules are in floats (``cosd(theta + 90)`` for a small ``theta``).
    """

    def __init__(self, plain: bool = False) -> None:
        self.plain = plain
        self.reported = False
        """Whether numbers are taken for what they are rounded to, not for what they were computed from."""
        self.nodes: list[Node] = []
        self.checks: list[int] = []
        self.finite: list[int] = []
        self.finders: list[Finder] = []
        self.always: set[int] = set()
        self.taken_away: list[tuple[int, int]] = []
        """What was left of a sum that another number was taken away from, and that number."""
        self._numbers: dict[Node, int] = {}
        self._directions: dict[int, Direction] = {}
        self.true = self.constant(True)
        self.false = self.constant(False)

    # --- nodes ---

    def constant(self, value: float | bool) -> int:
        return self.node("const", value if isinstance(value, bool) else float(value))

    def input(self, place: int) -> int:
        return self.node("input", place)

    def number(self, *node: Operand) -> int | None:
        """The number of an operation that is there already."""
        return self._numbers.get(node)

    def off(self, node: int) -> float:
        """How far a constant that was computed may be from the number that it stands for."""
        return float(self.nodes[node][2]) if len(self.nodes[node]) > 2 else 0.0

    def value_of(self, node: int) -> float | bool | None:
        """The value of a constant node."""
        kind = self.nodes[node]
        return kind[1] if kind[0] == "const" else None  # type: ignore[return-value]

    def add(self, operation: str, *operands: int) -> int:
        """The node of an operation, simplified."""
        folded = self._folded(operation, operands)
        if folded is not None:
            return folded
        simple = SIMPLIFY.get(operation)
        if simple is not None:
            found = simple(self, *operands)
            if found is not None:
                return found
        return self.node(operation, *operands)

    def node(self, *node: Operand) -> int:
        """The number of an operation as it is, unsimplified."""
        key = (node[0], type(node[1]).__name__, *map(repr, node[1:])) if node[0] == "const" else node
        number = self._numbers.get(key)
        if number is None:
            number = len(self.nodes)
            self.nodes.append(node)
            self._numbers[key] = number
        return number

    def _folded(self, operation: str, operands: tuple[int, ...]) -> int | None:
        values = [self.value_of(operand) for operand in operands]
        if any(value is None for value in values):
            return None
        try:
            result = FOLD[operation](*values)
        except (ArithmeticError, ValueError):
            raise NotCompilable from None
        return self._computed(FOLD[operation], result, operands, operation)

    def _computed(
        self, function: Callable[..., float | bool], result: float | bool, operands: Iterable[int], name: str
    ) -> int:
        """The constant that an operation on constants comes to, and how far it may be off."""
        if isinstance(result, bool):
            return self.constant(result)
        known = [(float(self.nodes[operand][1]), self.off(operand)) for operand in operands]
        off = folded_error(function, name, result, known)
        return self.node("const", float(result), off) if off else self.constant(result)

    def _alike(self, condition: int, one: Node, other: Node) -> int | None:
        """A selection between the same operation on operands of which only one differs: of that one."""
        if one[0] != other[0] or one[0] not in _SELECTABLE:
            return None
        differ = [place for place in range(1, len(one)) if one[place] != other[place]]
        if len(differ) != 1:
            return None
        (place,) = differ
        operands = [int(o) for o in one[1:]]
        operands[place - 1] = self.add("where", condition, int(one[place]), int(other[place]))
        return self.add(str(one[0]), *operands)

    def factor(self, node: int) -> tuple[float, int] | None:
        """The number and the other factor of a product with a number."""
        kind, *parts = self.nodes[node]
        if kind == "mul":
            for one, other in ((0, 1), (1, 0)):
                value = self.value_of(int(parts[one]))
                if isinstance(value, float):
                    return value, int(parts[other])
        return None

    def require(self, condition: int) -> None:
        """A condition that must hold for the results to count."""
        if condition != self.true and condition not in self.checks:
            self.checks.append(condition)

    def bound(self, number: int) -> None:
        """A number that must be finite, because what is computed from it could hide that it is not."""
        if self.value_of(number) is None and number not in self.finite:
            self.finite.append(number)

    def firm(self, number: int) -> None:
        """A number that must be finite, whether the results read it or not."""
        self.bound(number)
        self.always.add(number)

    @contextmanager
    def only_if(self, condition: int) -> Iterator[None]:
        """What is required inside is required where the condition holds."""
        outside, self.checks = self.checks, []
        yield
        inside, self.checks = self.checks, outside
        for check in inside:
            self.require(self.add("or", self.add("not", condition), check))

    @contextmanager
    def as_reported(self) -> Iterator[None]:
        """What is added inside reads the numbers that are reported."""
        self.reported = True
        yield
        self.reported = False

    # --- expressions ---

    def expression(self, node: Expression, values: Mapping[str, int]) -> int:
        """The node of an expression; ``values`` gives that of every variable."""
        match node:
            case Number(value):
                return self.constant(value)
            case Name(name):
                return values[name]
            case Negative(operand):
                return self.add("neg", self.expression(operand, values))
            case Sum(terms):
                return self._sum([(term, self.expression(term, values)) for term in terms])
            case Product(left, right):
                return self.add("mul", self.expression(left, values), self.expression(right, values))
            case Quotient(left, right):
                divided = self.expression(left, values)
                divisor = self.expression(right, values)
                self._divisor(divisor)
                return self.add("div", divided, divisor)
            case Power(base, exponent):
                return self._power(self.expression(base, values), exponent, values)
            case Call(function, arguments):
                return self.call(function, *(self.expression(item, values) for item in arguments))
            case _:
                raise NotCompilable

    def _sum(self, terms: list[tuple[Expression, int]]) -> int:
        total = terms[0][1]
        for _, term in terms[1:]:
            total = self.add("add", total, term)
        return total

    def _divisor(self, divisor: int) -> None:
        if self.value_of(divisor) is None:
            self.bound(divisor)
            self.require(self.add("not", self.add("eq", divisor, self.constant(0.0))))

    def _power(self, base: int, exponent: Expression, values: Mapping[str, int]) -> int:
        match exponent:
            case Number(2.0):
                return self.add("mul", base, base)
            case Number(3.0):
                return self.add("mul", self.add("mul", base, base), base)
            case Number(-1.0):
                self._divisor(base)
                return self.add("div", self.constant(1.0), base)
            case Number(0.5):
                return self.add("sqrt", base)
            case _:
                power = self.expression(exponent, values)
                known = self.value_of(power)
                if known is not None and known < 0.0:
                    self._divisor(base)
                return self.add("pow", base, power)

    def call(self, function: str, *arguments: int) -> int:
        """The node of a function; those of angles by what is known of the angle."""
        if function in ("sqrt", "abs"):
            return self.add(function, *arguments)
        if all(self.value_of(argument) is not None for argument in arguments):
            try:
                result = TABLE[function].value(*(self.value_of(a) for a in arguments))
            except (ArithmeticError, ValueError):
                raise NotCompilable from None
            return self._computed(TABLE[function].value, result, arguments, function)
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
                self._directions[node] = Direction(y, x, function.removeprefix("atan2"), self._length(y, x))
            at_zero = [self.add("eq", argument, self.constant(0.0)) for argument in arguments]
            self.require(self.add("not", self.add("and", *at_zero)))
            return node
        return self.node("call", function, *arguments)

    def beside_one(self, node: int) -> int | None:
        """What is added to 1, where a node is such a sum."""
        kind, *parts = self.nodes[node]
        if self.plain or kind not in ("add", "sub"):
            return None
        one, other = (int(part) for part in parts)
        if self.value_of(one) == 1.0:
            return other if kind == "add" else self.add("neg", other)
        return one if kind == "add" and self.value_of(other) == 1.0 else None

    def _length(self, y: int, x: int) -> int:
        return self.add("sqrt", self.add("add", self.add("mul", x, x), self.add("mul", y, y)))

    def circle(self, angle: int) -> tuple[int, ...]:
        """The sine and the cosine that an angle came out of."""
        known = self._directions.get(angle)
        return () if known is None or known.length is not None else (known.y, known.x)

    def direction(self, y: int, x: int, unit: str) -> int:
        """The direction of a point on the unit circle."""
        node = self.node("direction" + unit, y, x)
        self._directions[node] = Direction(y, x, unit, None)
        return node

    def selected(self, condition: int, one: int, other: int) -> int:
        """A selection; of two directions it is one, of the selected point."""
        alike = self._alike(condition, self.nodes[one], self.nodes[other])
        if alike is not None:
            return alike
        node = self.node("where", condition, one, other)
        first, second = self._directions.get(one), self._directions.get(other)
        if first and second and first.unit == second.unit and first.length is None is second.length:
            y, x = (
                self.add("where", condition, *pair) for pair in ((first.y, second.y), (first.x, second.x))
            )
            self._directions.setdefault(node, Direction(y, x, first.unit, None))
        return node

    # --- angles ---

    def _circular(self, function: str, angle: int) -> int:
        unit = "d" if function.endswith("d") else ""
        kind = function.removesuffix("d")
        known = self._directions.get(angle)
        if known is not None and known.unit == unit:
            return self._of_direction(kind, known)
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

    def _of_direction(self, kind: str, known: Direction) -> int:
        if kind == "tan":
            self._divisor(known.x)
            return self.add("div", known.y, known.x)
        part = known.x if kind == "cos" else known.y
        if known.length is None:
            return part
        return self.add("div", part, known.length)

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
            return self.add("neg", self.add("div", self.constant(1.0), tangent))
        names = ("cosd", "sind") if kind == "cos" else ("sind", "cosd")
        found = self._circular(names[quarters % 2], angle)
        minus = quarters in ((1, 2) if kind == "cos" else (2, 3))
        return self.add("neg", found) if minus else found

    # --- conditions ---

    def compare(self, operator: str, left: int, right: int) -> int:
        """The node of a comparison of two numbers."""
        match operator:
            case "=":
                return self._near(left, right)
            case "<>":
                return self.add("not", self._near(left, right))
            case "<":
                return self.add("lt", left, right)
            case "<=":
                return self.add("le", left, right)
            case ">":
                return self.add("lt", right, left)
            case _:
                return self.add("le", right, left)

    def _near(self, left: int, right: int) -> int:
        for angle, other in ((left, right), (right, left)):
            known, number = self._directions.get(angle), self.value_of(other)
            if known is None or known.unit != "d" or not isinstance(number, float):
                continue
            if abs(number) > 180.5 and not self.plain:
                return self.false
            if number in (0.0, 180.0):
                # Neither to the right nor to the left of the origin: away from the axis, for certain.
                away = self.add("lt", self._axis(known.x), self.add("abs", known.y))
                if not self.plain:
                    self.require(away)
                    return self.false
                self.require(self.add("or", away, self.add("eq", known.y, self.constant(0.0))))
        near = self.add("near", left, right)
        # Whether numbers that differ by a hair are the same is told by more digits than floats have.
        self.require(self.add("or", self.add("not", near), self.add("eq", left, right)))
        return near

    def _axis(self, x: int) -> int:
        return self.add("mul", self.constant(NEAR), self.add("abs", x))


_SELECTABLE = frozenset({"add", "sub", "mul", "div", "neg", "abs", "sqrt"})
_CIRCULAR = frozenset({"sind", "cosd", "tand", "sin", "cos", "tan"})
