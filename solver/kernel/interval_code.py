"""Expressions compiled to Python source for intervals of floats."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from math import inf, isfinite, log, log1p, nan, nextafter
from types import FunctionType
from typing import Any, TypeAlias

from rulesheets.evaluate.gradient import SMALLEST
from rulesheets.evaluate.number import INTERVALS
from rulesheets.functions import TABLE, intervals
from rulesheets.syntax.nodes import (
    ONE,
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
    add,
)
from solver.kernel.emitter import CodeLines, is_square

Pair: TypeAlias = tuple[str, str]

ARITHMETIC = {
    name: getattr(intervals, name)
    for name in ("add", "both", "divide", "multiply", "power", "ratio", "square", "scaled")
}
MEAN_ULPS = 8.0


def log_means(a: float, b: float, c: float, d: float) -> intervals.Interval:
    """The means ``(u - v)/ln(u/v)`` of numbers of one sign, u between a and b, v between c and d:
    that of positive numbers grows with both, and is 0/0 where they are equal."""
    signs = ((a, b, c, d), (-b, -a, -d, -c))
    bounds = [
        sign * end
        for sign, (low, high, least, most) in zip((1.0, -1.0), signs, strict=True)
        if high > 0.0 and most > 0.0
        for end in (_log_mean(low, least, 0), _log_mean(high, most, 1))
    ]
    return (min(bounds), max(bounds)) if bounds else intervals.EMPTY


def _log_mean(u: float, v: float, end: int) -> float:
    """A lower (0) or upper (1) bound: the mean lies between the geometric and the arithmetic one,
    and nothing is known of numbers from 0 down."""
    if not (u > 0.0 < v and isfinite(u + v)):
        return inf if end else 0.0
    ratio = u / v
    if 0.5 <= ratio <= 2.0:
        mean = v if u == v else (u - v) / log1p((u - v) / v)
    elif SMALLEST <= ratio < inf:
        mean = (u - v) / log(ratio)
    else:
        mean = u + v if end else 0.0
    return intervals.up(mean, MEAN_ULPS) if end else intervals.down(mean, MEAN_ULPS)


ARITHMETIC["log_means"] = log_means

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


def log_mean(node: Quotient) -> tuple[Expression, Expression, Expression] | None:
    """f, u and v of ``f*(u - v)/ln(u/v)``; None for other quotients."""
    match node.right:
        case Call("ln", (Quotient(u, v),)) | Sum((Call("ln", (u,)), Negative(Call("ln", (v,))))):
            parts = factors(node.left)
            for part in parts:
                rest = times(*without(parts, [part]))
                if Counter(_terms(part)) == Counter(_terms(u - v)):
                    return rest, u, v
                if Counter(_terms(part)) == Counter(_terms(v - u)):
                    return -rest, u, v
    return None


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
        if mean := log_mean(node):
            factor, *ends = map(self.of, mean)
            found = self.apply(
                "both", found, self.apply("multiply", factor, self.apply("log_means", *ends))
            )
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
