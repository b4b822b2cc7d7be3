"""Derivatives of expressions: as numbers with error bounds in one pass, or as expressions.

Numbers come by reverse accumulation, over any arithmetic: the walk keeps the parts of an expression
with the slope of each in its own parts, and the gradient is summed from the top. In floats a bound
of the rounding error comes with it.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import combinations
from typing import Any, Generic, TypeVar, cast

from rulesheets.evaluate.number import Arithmetic, Floats, Undefined
from rulesheets.functions import TABLE
from rulesheets.functions.intervals import EPSILON
from rulesheets.functions.row import Function
from rulesheets.syntax.nodes import (
    ONE,
    ZERO,
    Call,
    Expression,
    Name,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    Values,
    add,
    call,
)

T = TypeVar("T")

CHOOSING = frozenset({"min", "max"})
TIED = 128.0
"""How many times the rounding of tied arguments counts: more than a check of rules admits of them,
for the slope may be that of the wrong one."""
SMALLEST = 2.0**-1022
"""Numbers below this have fewer digits than others."""
UNIT = 1.0
"""The slope of a sum by its terms: this very float is not multiplied by."""
BY_BASE = Product(Name("1"), Power(Name("0"), Sum((Name("1"), Number(-1.0)))))
BY_EXPONENT = Product(Power(Name("0"), Name("1")), Call("ln", (Name("0"),)))
BY_SIZE = Product(Power(Name("0"), Name("1")), Call("ln", (Call("abs", (Name("0"),)),)))
"""Slopes of the power ``0^1``; the last also has a value for a negative base, by a whole exponent:
how its size depends on that."""


@dataclass(slots=True)
class Part(Generic[T]):
    """A part of an expression at a point: its value, its name if it is a variable, and its slope by
    each of its own parts that varies.

    ``rounded``: the size of the numbers that its own operation has rounded; infinite if it has lost
    all digits. ``exact``: a number of the sheet, which neither varies nor is rounded.
    """

    value: T
    name: str = ""
    slopes: tuple[tuple[T, Part[T]], ...] = ()
    rounded: Any = 0.0
    exact: bool = False


class Traced(Arithmetic[Part[T]]):
    """The parts of an expression over another arithmetic.

    ``rounds``: its numbers are rounded by so much that it counts. ``by_exponent``: the slope of a
    power.
    """

    rounds = True
    by_exponent: Expression = BY_EXPONENT

    def __init__(self, numbers: Arithmetic[T]) -> None:
        self.numbers = numbers

    # --- slopes and rounding of an arithmetic ---

    def slope(self, template: Expression, arguments: Sequence[Part[T]], node: Expression) -> T:
        """A slope of ``node``: the template with the arguments put in at their places."""
        raise NotImplementedError

    def by_base(self, base: Part[T], exponent: Part[T], node: Power) -> Any:
        return self.slope(BY_BASE, (base, exponent), node) if exponent.value else 0.0

    def rounded(self, node: Expression, result: T, parts: Sequence[Part[T]]) -> Any:
        """The size of the rounded terms of an operation (for a sum, of its partial sums)."""
        return 0.0

    # --- the walk ---

    def number(self, node: Number) -> Part[T]:
        return Part(self.numbers.number(node), exact=True)

    def name(self, node: Name) -> Part[T]:
        return Part(self.numbers.name(node), node.name)

    def negative(self, node: Negative) -> Part[T]:
        part = self.of(node.operand)
        value: Any = -part.value  # type: ignore[operator]
        return Part(value, "", _varying((-1, part)), exact=part.exact)

    def sum(self, node: Sum) -> Part[T]:
        return self.added([self.operations[type(term)](self, term) for term in node.terms])

    def added(self, parts: Sequence[Part[T]]) -> Part[T]:
        """The sum of parts, and the size of all partial sums."""
        rounds, total, rounded = self.rounds, cast(Any, parts[0].value), cast(Any, 0.0)
        if rounds:
            total = 0.0 + total
        for part in parts[1:]:
            total = total + part.value
            if rounds:
                rounded = rounded + abs(total)
        slopes: Any = tuple([(UNIT, part) for part in parts if not part.exact])
        return Part(total, "", slopes, rounded, exact=not (slopes or rounds))

    def product(self, node: Product) -> Part[T]:
        parts = one, other = self.of(node.left), self.of(node.right)
        result = one.value * other.value  # type: ignore[operator]
        slopes = _varying((other.value, one), (one.value, other))
        rounded = self.rounded(node, result, parts)
        return Part(result, "", slopes, rounded, not (slopes or self.rounds))

    def divided(self, node: Quotient, above: Part[T], below: Part[T]) -> Part[T]:
        result: Any = self.numbers.divided(node, above.value, below.value)
        divisor: Any = below.value
        slopes = _varying((1.0 / divisor, above), (-result / divisor, below))
        rounded = self.rounded(node, result, (above, below))
        return Part(result, "", slopes, rounded, not (slopes or self.rounds))

    def raised(self, node: Power, base: Part[T], exponent: Part[T]) -> Part[T]:
        parts = base, exponent
        result = self.numbers.raised(node, base.value, exponent.value)
        slopes: list[tuple[Any, Part[T]]] = []
        if not base.exact:
            slopes.append((self.by_base(base, exponent, node), base))
        if not exponent.exact:
            slopes.append((self.slope(self.by_exponent, parts, node), exponent))
        rounded = self.rounded(node, result, parts)
        return Part(result, "", tuple(slopes), rounded, not (slopes or self.rounds))

    def applied(self, node: Call, arguments: list[Part[T]]) -> Part[T]:
        result = self.numbers.applied(node, [part.value for part in arguments])
        templates = partials(TABLE[node.function], len(arguments))
        slopes: list[tuple[Any, Part[T]]] = []
        for template, part in zip(templates, arguments, strict=True):
            if not part.exact:
                slopes.append((self.slope(template, arguments, node), part))
        rounded = self.rounded(node, result, arguments)
        return Part(result, "", tuple(slopes), rounded, not (slopes or self.rounds))

    # --- results ---

    def gradient(self, part: Part[T], zero: Any = 0.0) -> tuple[dict[str, Any], Any]:
        """The gradient, by variables in the order of the text, and the sum of the rounded sizes."""
        gradient: dict[str, Any] = {}
        noise: Any = 0.0
        pending: list[tuple[Any, Part[Any]]] = [(UNIT, part)]
        rounds = self.rounds
        while pending:
            slope, part = pending.pop()
            if part.name:
                gradient[part.name] = gradient.get(part.name, zero) + slope
                continue
            if rounds:
                noise = noise + abs(slope) * part.rounded
            for inner, below in part.slopes[::-1]:
                if inner is UNIT:
                    pending.append((slope, below))
                else:
                    pending.append((inner if slope is UNIT else slope * inner, below))
        return gradient, noise


def _varying(*slopes: tuple[Any, Part[Any]]) -> tuple[tuple[Any, Part[Any]], ...]:
    return tuple([pair for pair in slopes if not pair[1].exact])


@cache
def partials(row: Function, count: int) -> tuple[Expression, ...]:
    """The slopes of a function, by places of its arguments."""
    return row.partials(tuple(Name(str(place)) for place in range(count)))


# --- floats ---------------------------------------------------------------------


def derivatives(expression: Expression, values: Values) -> tuple[float, dict[str, float]]:
    """Value and partial derivatives by every variable in the expression.

    A derivative that does not exist at the point, or is unknown there (``sqrt`` at 0), is nan.
    Raises as ``value`` does.
    """
    return rounded_derivatives(expression, values)[:2]


def rounded_derivatives(
    expression: Expression, values: Values, by_exponent: Expression = BY_EXPONENT
) -> tuple[float, dict[str, float], float]:
    """As ``derivatives``, and a bound of the rounding error of the value, to first order.

    That is eps times the result of every operation times the slope by it (F. L. Bauer, SIAM Review
    16 (1974) 87–96): names and numbers are taken as exact. nan where a slope below an operation is.
    """
    traced = TracedFloats(Floats(values))
    traced.by_exponent = by_exponent
    part = traced.of(expression)
    if not math.isfinite(part.value):
        raise Undefined("overflow", (part.value,), expression)
    gradient, noise = traced.gradient(part)
    return part.value, gradient, EPSILON * noise


class TracedFloats(Traced[float]):
    """Parts in floats with the rounding of their operations. A slope without a value is nan."""

    def slope(
        self, template: Expression, arguments: Sequence[Part[float]], node: Expression
    ) -> float:
        values = {str(place): part.value for place, part in enumerate(arguments)}
        if template is self.by_exponent and values["0"] == 0.0 < values["1"]:
            return 0.0
        try:
            found = Floats(values).of(template)
        except Undefined:
            return math.nan
        return found if math.isfinite(found) else math.nan

    def rounded(self, node: Expression, result: float, parts: Sequence[Part[float]]) -> float:
        """Infinite for a result below SMALLEST that is not exactly 0: it has lost digits."""
        size = abs(result)
        if type(node) is Product:
            exact = parts[0].value == 0.0 or parts[1].value == 0.0
        elif result - result != 0.0:
            raise Undefined("overflow", (result,), node)
        elif isinstance(node, Call):
            row = TABLE[node.function]
            first = abs(parts[0].value) if parts else 0.0
            above = math.inf if row.direction else SMALLEST
            exact = not (row.nonzero or 0.0 < first < above)
            size *= row.ulps
            if node.function in CHOOSING and (tied := _tied(parts)):
                return size + TIED * tied
        else:
            exact = parts[0].value == 0.0
        return size if size >= SMALLEST or (exact and size == 0.0) else math.inf


def _tied(parts: Sequence[Part[float]]) -> float:
    """The rounding that decides which argument is the least or greatest (``max(x, pi)``), or 0."""
    pairs = ((one, other) for one, other in combinations(parts, 2) if one.value == other.value)
    return float(sum(one.rounded + other.rounded for one, other in pairs))


def differentiate(expression: Expression, name: str) -> Expression:
    """Partial derivative by the variable ``name``, with zeros and ones folded away.

    It is right wherever the expression is differentiable; at jumps and kinks it is that of one
    side.
    """
    return slopes_by_name(expression, (name,)).get(name, ZERO)


def slopes_by_name(expression: Expression, of: Collection[str]) -> dict[str, Expression]:
    """The partial derivatives by those of the names that occur, all in one pass."""
    match expression:
        case Name(name):
            return {name: ONE} if name in of else {}
        case Negative(operand):
            return {name: -slope for name, slope in slopes_by_name(operand, of).items()}
        case Quotient(left, right):
            above, below = slopes_by_name(left, of), slopes_by_name(right, of)
            return {
                name: (above.get(name, ZERO) - expression * below.get(name, ZERO)) / right
                for name in above | below
            }
        case Product(Call("sgn"), root) if (signed := signed_root(expression)) is not None:
            # the derivative of ``sqrt(abs(x))`` or ``abs(x)^p`` by ``abs(x)``
            by_size = _outer(root)[0] if isinstance(root, Power) else 1.0 / (2.0 * root)
            return {name: by_size * slope for name, slope in slopes_by_name(signed, of).items()}
    inner = [slopes_by_name(part, of) for part in expression.parts]
    found: dict[str, list[Expression]] = {}
    outer = _outer(expression) if any(inner) else ()
    for slopes, by in zip(inner, outer, strict=False):
        for name, slope in slopes.items():
            found.setdefault(name, []).append(by * slope)
    return {name: add(*terms) for name, terms in found.items()}


def _outer(expression: Any) -> tuple[Expression, ...]:
    """The slopes of a sum, a product, a power or a call by its own parts."""
    match expression:
        case Product(left, right):
            return right, left
        case Power(base, exponent):
            lower = Number(exponent.value - 1.0) if isinstance(exponent, Number) else exponent - 1.0
            return exponent * base**lower, expression * call("ln", base)
        case Call(function, arguments):
            return TABLE[function].partials(arguments)
        case _:
            return (ONE,) * len(expression.parts)


def signed_root(expression: Expression) -> Expression | None:
    """x in ``sgn(x)*sqrt(abs(x))`` or ``sgn(x)*abs(x)^p``, increasing in x and without jumps."""
    match expression:
        case Product(Call("sgn", (x,)), Call("sqrt", (Call("abs", (size,)),))) if size == x:
            return x
        case Product(Call("sgn", (x,)), Power(Call("abs", (size,)), exponent)) if size == x:
            parts = exponent.parts if isinstance(exponent, Quotient) else (exponent,)
            above = all(isinstance(part, Number) and part.value > 0.0 for part in parts)
            return x if above else None
        case _:
            return None
