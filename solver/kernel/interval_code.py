"""Expressions compiled to Python source for intervals of floats."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from math import inf, isfinite, nan, nextafter
from types import FunctionType
from typing import Any, NamedTuple, TypeAlias

from rulesheets.evaluate import NotDifferentiable, differentiate
from rulesheets.evaluate.number import INTERVALS
from rulesheets.functions import TABLE, intervals
from rulesheets.syntax.nodes import (
    ONE,
    Call,
    Condition,
    Expression,
    Name,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    Symbol,
    add,
    children,
    names,
    rebuilt,
)
from rulesheets.syntax.program import walk
from solver.kernel.emitter import CodeLines, is_square

Pair: TypeAlias = tuple[str, str]

ARITHMETIC = {
    name: getattr(intervals, name)
    for name in (
        "add",
        "both",
        "divide",
        "greatest",
        "least",
        "multiply",
        "power",
        "ratio",
        "square",
        "scaled",
    )
}


def bounded_slopes(a_low: float, a_high: float, b_low: float, b_high: float) -> intervals.Interval:
    """The quotient of two slopes if both are bounded: where they are not, there may be a pole."""
    known = all(map(isfinite, (a_low, a_high, b_low, b_high)))
    return intervals.divide(a_low, a_high, b_low, b_high) if known else intervals.LINE


ARITHMETIC["bounded_slopes"] = bounded_slopes
POWERS = tuple(Number(float(k)) for k in range(2, 7))
"""Exponents of powers that are defined for every base."""

Side: TypeAlias = tuple[Expression, Expression]
"""The operands of a factor x: b and c of ``b*x + c``."""


def shared_factors(node: Quotient) -> Iterator[tuple[Expression, Side, Side]]:
    """Factors shared by some terms of the dividend and of the divisor, with these terms: a quotient
    ``(a*x + d)/(b*x + c)`` is ``(a + d/x)/(b + c/x)``."""
    above, below = ([factors(term) for term in _terms(side)] for side in (node.left, node.right))
    if len(below) == 1:
        return
    inside = [part for term in below for part in term]
    for part in dict.fromkeys(part for term in above for part in term if part in inside):
        if not isinstance(part, Number):
            yield part, _split(part, above), _split(part, below)


# --- quotients of differences ---
#
# ``(u - v)/ln(u/v)`` is 0/0 where u = v, and intervals tell nothing of it near there. But (φ(u) -
# φ(v)) over (ψ(u) - ψ(v)) is φ'(ξ)/ψ'(ξ) for some ξ between u and v (Cauchy's mean value theorem),
# so that slopes over the hull of u and v bound it, if φ and ψ have no gap there.

BETWEEN = Name("#between")
"""ξ"""
Pairs: TypeAlias = dict[tuple[Expression, Expression], None]


class MeanValue(NamedTuple):
    """A ``factor`` times such a quotient; φ'(ξ) and ψ'(ξ). ``poles``: where one is unbounded there
    may be a pole."""

    factor: Expression
    u: Expression
    v: Expression
    above: Expression
    below: Expression
    poles: bool


def mean_value(node: Quotient) -> MeanValue | None:
    """A quotient of differences; None if it is none."""
    parts = factors(node.left)
    for part in parts:
        for _, u, v in filter(None, (_difference(node.right), _difference(part))):
            forms = [_form(side, u, v) for side in (part, node.right)]
            if (above := forms[0]) is None or (below := forms[1]) is None:
                continue
            with suppress(NotDifferentiable):
                over, under = (differentiate(form, BETWEEN.name) for form in (above, below))
                poles = any(_may_have_pole(node) for node in (*walk(above), *walk(below)))
                return MeanValue(times(*without(parts, [part])), u, v, over, under, poles)
    return None


def _difference(side: Expression) -> tuple[Expression, Expression, Expression] | None:
    """φ(ξ), u and v, if an expression is φ(u) - φ(v)."""
    match side:
        case Call("ln" | "log" | "log10" as function, (Quotient(u, v),)):
            return Call(function, (BETWEEN,)), u, v
        case Sum((one, Negative(other))):
            pairs: Pairs = {}
            form = _common(one, other, pairs)
            if len(pairs) == 1:
                ((u, v),) = pairs
                return form, u, v
    return None


def _common(one: Expression, other: Expression, pairs: Pairs) -> Expression:
    """What two trees have in common, with ξ in place of the ``pairs`` of parts in which they
    differ."""
    if one == other:
        return one
    inside, beside = children(one), children(other)
    alike = type(one) is type(other) and len(inside) == len(beside) > 0
    if alike and getattr(one, "function", None) == getattr(other, "function", None):
        return rebuilt(
            one, tuple(_common(a, b, pairs) for a, b in zip(inside, beside, strict=True))
        )
    pairs[one, other] = None
    return BETWEEN


def _form(side: Expression, u: Expression, v: Expression) -> Expression | None:
    """φ(ξ), if an expression is φ(u) - φ(v) and φ has no gap in which slopes are bounded."""
    if Counter(_terms(side)) == Counter(_terms(u - v)):
        return BETWEEN
    match _difference(side):
        case form, *pair if pair == [u, v] and not any(map(_has_gap, walk(form))):
            return form
    return None


def _has_gap(node: Expression | Condition) -> bool:
    """Whether an operation may be undefined, or jump, between two ξ, though its slope is
    bounded."""
    match node:
        case Call(function, arguments):
            row = TABLE[function]
            whole = row.domain == (-inf, inf) and len(arguments) == 1
            return row.jumps or not (whole or arguments == (BETWEEN,))
        case Power(base, exponent):
            return base != BETWEEN and BETWEEN.name in names(base) and exponent not in POWERS
    return False


def _may_have_pole(node: Expression | Condition) -> bool:
    match node:
        case Call(function):
            return TABLE[function].domain == (-inf, inf)
        case Power(_, exponent):
            return not (isinstance(exponent, Number) and exponent.value > 0.0)
        case Quotient(_, divisor):
            return BETWEEN.name in names(divisor)
    return False


def _terms(side: Expression) -> Sequence[Expression]:
    return side.terms if isinstance(side, Sum) else (side,)


def factors(node: Expression) -> list[Expression]:
    """The factors of a product, squares as two equal ones."""
    match node:
        case Product(left, right):
            return factors(left) + factors(right)
        case Negative(operand):
            return [Number(-1.0), *factors(operand)]
        case Power(base, Number(2.0)):
            return 2 * factors(base)
        case _:
            return [node]


def without(some: Sequence[Expression], others: Sequence[Expression]) -> list[Expression]:
    """Factors that others do not have, or less often."""
    return list((Counter(some) - Counter(others)).elements())


def times(*some: Expression) -> Expression:
    product: Expression = ONE
    for factor in some:
        product = product * factor
    return product


def _split(part: Expression, terms: Sequence[list[Expression]]) -> Side:
    """The terms that have a factor, without it, and the others."""
    having = [times(*without(some, [part])) for some in terms if part in some]
    return add(*having), add(*(times(*some) for some in terms if part not in some))


class IntervalEmitter(CodeLines[Pair]):
    """Code for the two ends of expressions. Names in ``points`` are single numbers, with one end.

    ``forms`` are further operations for ``apply``.
    """

    def __init__(
        self, boxes: Sequence[str], points: Sequence[str], **forms: Callable[..., Any]
    ) -> None:
        pairs, single = (
            [(f"l{i}", f"h{i}") for i in range(len(boxes))],
            [f"p{i}" for i in range(len(points))],
        )
        names = dict(
            zip((*boxes, *points), (*pairs, *zip(single, single, strict=True)), strict=True)
        )
        self._ends = ", ".join(end for pair in pairs for end in pair)
        self._fixed, self._once = set(single), list[str]()
        self._points: dict[str, tuple[float, Pair, Pair]] = {}
        """Of names that are directions of points: a full turn, and the coordinates y and x."""
        constants = {"__builtins__": {}, "inf": inf, "nan": nan, "nextafter": nextafter}
        self.globals: dict[str, Any] = {**constants, **ARITHMETIC, **forms}
        super().__init__(single, names)

    def function(self, results: Iterable[str]) -> Callable[..., Any]:
        """A function of the points, in their order, that returns one of the ends of a box.

        Values that depend on points only are computed once for all boxes.
        """
        body = (f"    {line}" for line in (*self.lines, f"return ({', '.join(results)})"))
        code = self.code([*self._once, f"def on_box({self._ends}):", *body, "return on_box"])
        return FunctionType(code, dict(self.globals))

    def apply(self, name: str, *operands: Pair, more: str = "") -> Pair:
        """The pair that the named operation returns for the ends of the operands."""
        ends = ", ".join(end for pair in operands for end in pair)
        return self._assigned(f"{name}({ends}{more})", *operands)

    # --- the arithmetic ---

    def number(self, node: Number) -> Pair:
        token = self._constant(node.value)
        return token, token

    def _constant(self, value: float) -> str:
        """The token of a number: blocks that differ only in numbers share their code."""
        token = self._tokens.setdefault(repr(value), f"n{len(self._tokens)}")
        self.globals[token] = value
        self._fixed.add(token)
        return token

    def symbol(self, node: Symbol) -> Pair:
        return self.number(Number(nan))

    def negative(self, node: Negative) -> Pair:
        low, high = self.of(node.operand)
        return self._assigned(f"-{high}, -{low}", (low, high))

    def sum(self, node: Sum) -> Pair:
        total = self.of(node.terms[0])
        for term in node.terms[1:]:
            part = self.of(term)
            if {total[0], part[0]} <= self._fixed:
                total = self.apply("add", total, part)
            else:
                total = self._assigned(
                    f"{total[0]} + {part[0]}, {total[1]} + {part[1]}", total, part
                )
                low, high = total  # a sum that is 0 is exact
                rounded = f"{low} and nextafter({low}, -inf), {high} and nextafter({high}, inf)"
                total = self._assigned(rounded, total)
        return total

    def product(self, node: Product) -> Pair:
        left, right = self.of(node.left), self.of(node.right)
        if left == right:
            return self.apply("square", left)
        for factor, other in ((left, right), (right, left)):
            if factor[0] == factor[1]:
                return self.apply("scaled", factor, other)
        return self.apply("multiply", left, right)

    def divided(self, node: Quotient, above: Pair, below: Pair) -> Pair:
        """A quotient, also divided by a factor on both sides, which then occurs once less."""
        found = self.apply("divide", above, below)
        for part, *sides in shared_factors(node):
            x = self.of(part)
            if x[0] not in self._fixed:
                over = [
                    self.apply("add", self.of(having), self.apply("divide", self.of(others), x))
                    for having, others in sides
                ]
                found = self.apply("both", found, self.apply("divide", *over))
        if mean := mean_value(node):
            (a, b), (c, d) = self.of(mean.u), self.of(mean.v)
            self.assign(
                BETWEEN.name, self._assigned(f"least({a}, {c}), greatest({b}, {d})", (a, b), (c, d))
            )
            if mean.poles or not isinstance(mean.below, Quotient):
                slopes = self.apply("bounded_slopes", self.of(mean.above), self.of(mean.below))
            else:
                slopes = self.of(mean.above * mean.below.right / mean.below.left)
            found = self.apply("both", found, self.apply("multiply", self.of(mean.factor), slopes))
        return found

    def raised(self, node: Power, base: Pair, exponent: Pair) -> Pair:
        return (
            self.apply("square", base) if is_square(node) else self.apply("power", base, exponent)
        )

    def let_direct(self, name: str, expression: Expression) -> None:
        """Let a name stand for the direction of a point, if the expression is one: its sine, cosine
        and tangent are ratios of the coordinates, which lose nothing next to a right angle."""
        if isinstance(expression, Call) and (row := TABLE[expression.function]).direction:
            y, x = map(self.of, expression.arguments)
            self._points[name] = row.angle or nan, y, x

    def applied(self, node: Call, arguments: list[Pair]) -> Pair:
        turn = TABLE[node.function].turn
        match node.arguments:
            case (Name(name),) if turn and self._points.get(name, (nan,))[0] == turn:
                _, y, x = self._points[name]
                match node.function[:3]:
                    case "sin":
                        return self.apply("ratio", y, x)
                    case "cos":
                        return self.apply("ratio", x, y)
                    case "tan":
                        return self.apply("divide", y, x)
        self.globals[f"f_{node.function}"] = INTERVALS[node.function]
        return self.apply(f"f_{node.function}", *arguments)

    def _assigned(self, text: str, *operands: Pair) -> Pair:
        token = self._tokens.get(text)
        if token is None:
            number = len(self._tokens)
            token = self._tokens[text] = f"a{number}, b{number}"
            fixed = all(pair[0] in self._fixed for pair in operands)
            (self._once if fixed else self.lines).append(f"{token} = {text}")
            self._fixed |= set(token.split(", ") if fixed else ())
        low, high = token.split(", ")
        return low, high
