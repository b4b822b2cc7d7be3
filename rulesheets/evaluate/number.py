"""Expressions and conditions in floats: values, or why there is none."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from contextlib import suppress
from operator import ge, gt, le, lt
from sys import float_info
from typing import Any, ClassVar, Generic, TypeAlias, TypeVar

from rulesheets.functions import TABLE
from rulesheets.syntax.nodes import (
    And,
    Call,
    Comparison,
    Condition,
    Expression,
    Given,
    Name,
    Negative,
    Not,
    Number,
    Or,
    Power,
    Product,
    Quotient,
    Sum,
    Symbol,
    Values,
    walk,
)


def number_text(x: float) -> str:
    """Six digits of x, or the fewest more with which it does not look like another whole number;
    numbers beyond a billion always do."""
    for digits in range(6, 18):
        text = f"{x:.{digits}g}"
        if float(text) == x or not float(text).is_integer() or abs(x) >= 1e9:
            break
    return text


def rounded(x: float, digits: int = 6) -> float:
    """The number with so many digits; with 12 the decimal for which a float may stand."""
    return float(f"{x:.{digits}g}")


class Undefined(ArithmeticError):
    """An operation has no value at its arguments; the text reads ``sqrt of -3.2``.

    ``operation`` is the name of a function, or ``/``, ``^``, ``overflow``, ``symbol``;
    ``expression`` is the part of the tree that it stands for. ``overflow``: the value is outside
    the range of floats.
    """

    def __init__(
        self,
        operation: str,
        arguments: tuple[float, ...],
        expression: Expression,
        overflow: bool = False,
    ) -> None:
        super().__init__(operation, arguments, expression)
        self.overflow = overflow or operation == "overflow"
        self.operation = operation
        self.arguments = arguments
        self.expression = expression

    def __str__(self) -> str:
        """The text, which few of them need: searches meet thousands."""
        arguments, texts = self.arguments, [number_text(argument) for argument in self.arguments]
        match self.operation:
            case "/":
                return f"division by {texts[0]}"
            case "^":
                rooted = arguments[0] < 0.0 and arguments[1] != int(arguments[1])
                return f"({texts[0]})^{texts[1]}" if rooted else f"{texts[0]}^{texts[1]}"
            case "overflow":
                return "a number too large to hold"
            case "symbol":
                return "arithmetic with a symbol"
            case function:
                inside = ", ".join(texts)
                return f"{function} of {inside if len(texts) == 1 else f'({inside})'}"

    @property
    def hole(self) -> bool:
        """Whether it is undefined at isolated points: a division by 0, or atan2 at the origin."""
        return (
            self.operation == "/"
            or (self.operation == "^" and self.arguments[0] == 0.0)
            or (self.operation in TABLE and TABLE[self.operation].direction)
        )


T = TypeVar("T")


class Arithmetic(Generic[T]):
    """The value of an expression in numbers of the type T; ``of`` raises Undefined if it has none.

    A subclass defines constants, variables, and the operations that have no Python operator or may
    have no value. Everything else is written once here, for any numbers with ``+ - *``. (As in
    ``core/calculus.hpp`` of CasADi: J. Andersson et al., Math. Programming Computation 11 (2019)
    1–36.)
    """

    __slots__ = ()
    operations: ClassVar[dict[type, Callable[..., Any]]] = {}

    def __init_subclass__(cls) -> None:
        kinds = Number, Name, Symbol, Negative, Sum, Product, Quotient, Power, Call
        cls.operations = {kind: getattr(cls, kind.__name__.lower()) for kind in kinds}

    def of(self, node: Expression) -> T:
        value: T = self.operations[type(node)](self, node)
        return value

    # --- operations of an arithmetic ---

    def number(self, node: Number) -> T:
        """A number of the sheet, taken as exact."""
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
        """The terms added from left to right."""
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
        below = operations[type(base)](self, base)
        return self.raised(node, below, operations[type(exponent)](self, exponent))

    def call(self, node: Call) -> T:
        operations = self.operations
        return self.applied(node, [operations[type(item)](self, item) for item in node.arguments])


class Floats(Arithmetic[float]):
    """Floats; a variable whose value is a symbol has no number."""

    __slots__ = ("values",)

    def __init__(self, values: Values) -> None:
        self.values = values

    def number(self, node: Number) -> float:
        return node.value

    def name(self, node: Name) -> float:
        number = self.values[node.name]
        if isinstance(number, str):
            raise Undefined("symbol", (), node)
        return number

    def divided(self, node: Quotient, above: float, below: float) -> float:
        try:
            return above / below
        except ZeroDivisionError:
            raise Undefined("/", (below,), node) from None

    def raised(self, node: Power, base: float, exponent: float) -> float:
        try:
            return math.pow(base, exponent)
        except ValueError:
            raise Undefined("^", (base, exponent), node) from None
        except OverflowError:
            raise Undefined("^", (base, exponent), node, overflow=True) from None

    def applied(self, node: Call, arguments: list[float]) -> float:
        try:
            return TABLE[node.function].value(*arguments)
        except (ValueError, ZeroDivisionError):
            raise Undefined(node.function, tuple(arguments), node) from None
        except OverflowError:
            raise Undefined(node.function, tuple(arguments), node, overflow=True) from None


def value(expression: Expression, values: Values) -> float:
    """The value of ``expression``, terms added left to right.

    Raises Undefined where an operation has none, KeyError for a variable without a value.
    """
    result = Floats(values).of(expression)
    if result - result != 0.0:
        raise Undefined("overflow", (result,), expression)
    return result


class _Close(Floats):
    """Floats; ``found`` are sums of which no more than a share of their terms is left, divisors as
    small, arguments that close to the end of a domain, and functions that jump as near."""

    __slots__ = ("found", "share")

    def __init__(self, values: Values, share: float) -> None:
        super().__init__(values)
        self.share, self.found = share, list[Expression]()

    def sum(self, node: Sum) -> float:
        total = size = 0.0
        for term in node.terms:
            number = self.of(term)
            total, size = total + number, size + abs(number)
        if abs(total) <= self.share * size != 0.0:
            self.found.append(node)
        return total

    def divided(self, node: Quotient, above: float, below: float) -> float:
        if isinstance(node.right, Call) and abs(below) <= self.share:
            self.found.append(node.right)
        return super().divided(node, above, below)

    def applied(self, node: Call, arguments: list[float]) -> float:
        row = TABLE[node.function]
        for end in row.domain:
            if 0.0 != abs(end) < math.inf and abs(arguments[0] - end) <= self.share * abs(end):
                self.found.append(node.arguments[0])
        if row.jumps:
            moved = (arguments[0] * (1.0 + share) for share in (self.share, -self.share))
            above, below = (super(_Close, self).applied(node, [x, *arguments[1:]]) for x in moved)
            if abs(above - below) > STEEP * self.share * abs(arguments[0]):
                self.found.append(node)
        return super().applied(node, arguments)


STEEP = 1e3
"""Slope from which on a function jumps."""


def _may_be_close(part: object) -> bool:
    """Whether a part of an expression may be one that ``undecided`` finds."""
    match part:
        case Quotient(_, Call()):
            return True
        case Call(function):
            row = TABLE[function]
            return row.jumps or any(0.0 != abs(end) < math.inf for end in row.domain)
    return isinstance(part, Sum)


def undecided(expression: Expression, values: Values, share: float) -> list[Expression]:
    """The parts of an expression that rounding decides about: sums of which no more than a
    ``share`` of their terms is left, tiny divisors, arguments next to the end of a domain,
    functions next to a jump. As far as the expression has a value."""
    if (any_may := expression.__dict__.get("_any_may")) is None:
        any_may = expression.__dict__["_any_may"] = any(map(_may_be_close, walk(expression)))
    if not any_may:
        return []
    tried = _Close(values, share)
    with suppress(Undefined):
        tried.of(expression)
    return tried.found


TOLERANCE = 16.0 * float_info.epsilon


def equal(left: float, right: float) -> bool:
    """Equality of floats within the comparison tolerance, 16 eps of the larger."""
    return abs(left - right) <= TOLERANCE * max(abs(left), abs(right))


Same: TypeAlias = Callable[[Comparison, float, float], bool]
"""Whether the two sides of a comparison, of these values, are equal."""


def holds(
    condition: Condition, values: Values, given: Collection[str] = (), same: Same | None = None
) -> bool:
    """Whether ``condition`` is true; ``given`` are the names of the inputs.

    ``=`` and ``<>`` of numbers use the comparison tolerance; the other comparisons are exact;
    ``same`` decides in place of both. A symbol is equal only to itself; compared with anything else
    every relation but ``<>`` is false. Terms of ``and`` and ``or`` that cannot be evaluated do not
    matter if another term decides. Raises KeyError (a variable without a value) or Undefined if the
    condition is undecided.
    """
    match condition:
        case Comparison():
            return _compare(condition, values, same)
        case And(terms):
            return not _any(terms, False, values, given, same)
        case Or(terms):
            return _any(terms, True, values, given, same)
        case Not(term):
            return not holds(term, values, given, same)
        case Given():
            return condition.name in given


def meets(comparison: Comparison, values: Values) -> bool:
    """Whether numbers satisfy a requirement, with the comparison tolerance in every relation.

    Numbers that are equal within it satisfy ``<=`` and ``>=``, but neither ``<`` nor ``>``. Raises
    KeyError and Undefined as :func:`holds` does.
    """
    operator, left, right = comparison.operator, comparison.left, comparison.right
    if operator not in ("=", "<>") and _compare(Comparison("=", left, right), values):
        return operator in ("<=", ">=")
    return _compare(comparison, values)


def _any(
    terms: tuple[Condition, ...],
    wanted: bool,
    values: Values,
    given: Collection[str],
    same: Same | None,
) -> bool:
    """Whether some term evaluates to ``wanted``."""
    obstacle: KeyError | Undefined | None = None
    for term in terms:
        try:
            if holds(term, values, given, same) is wanted:
                return True
        except (KeyError, Undefined) as error:
            obstacle = obstacle or error
    if obstacle is not None:
        raise obstacle
    return False


def _compare(comparison: Comparison, values: Values, same: Same | None = None) -> bool:
    sides: list[float | str] = []
    for side in (comparison.left, comparison.right):
        if isinstance(side, Name):
            sides.append(values[side.name])
        else:
            sides.append(side.name if isinstance(side, Symbol) else value(side, values))
    left, right = sides
    operator, asked = comparison.operator, comparison.operator in ("=", "<>")
    if isinstance(left, str) or isinstance(right, str):
        return asked and (left == right) is (operator == "=")
    alike = equal(left, right) if asked else left == right
    if same is not None and (asked or left != right):
        alike = same(comparison, left, right)
    if asked:
        return alike == (operator == "=")
    order: bool = _ORDERS[operator](left, right if not alike else left)
    return order


_ORDERS = {"<": lt, "<=": le, ">": gt, ">=": ge}
