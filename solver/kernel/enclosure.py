"""The residual of a chain with one tear, and its slope, over boxes of the tear.

They are compiled when they are first asked for: to floats for a few boxes, to arrays for many. Quotients
whose dividend and divisor vanish together are bounded where they do: ``rate/(1 - (1 + rate)^(-term))`` is 0/0
at 0, and next to that interval arithmetic knows nothing of it. But if N and D both vanish at 0, then
N(x)/D(x) = N'(t)/D'(t) for some t between 0 and x (Cauchy's mean value theorem), so that the slopes over the
hull of 0 and the box bound the quotient over the box.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from itertools import product
from math import inf, isnan, nan
from typing import Any, TypeAlias

import numpy as np

from rulesheets.evaluate import NotDifferentiable, differentiate
from rulesheets.evaluate.exactly import Inexact, Rationals
from rulesheets.functions.intervals.arrays import Array
from rulesheets.functions.intervals.arrays import Interval as Intervals
from rulesheets.syntax import nodes
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
    add,
    divide,
    exchange,
    is_number,
    multiply,
    negative,
    substitute,
)
from rulesheets.syntax.program import walk
from solver.kernel.chain import Assignment, Chain, directions, jumps
from solver.kernel.emitter import IntervalEmitter, Operations, Pair
from solver.kernel.interval_forms import ARRAYS, FLOATS

_FROM_ZERO = "#from zero"


def by_slopes(emitter: IntervalEmitter, chain: Chain) -> Iterator[Pair]:
    """Other bounds of the residual, with one such quotient bounded by slopes; nan where they have none."""
    tear = chain.tears[0]
    assigned = {item.name for item in chain.assignments}
    residual = chain.assignments[-1].expression
    quotients = (part for part in walk(residual) if isinstance(part, Quotient))
    for number, quotient in enumerate(dict.fromkeys(quotients)):
        used = {*nodes.names(quotient)}
        if tear not in used or used & assigned:
            continue
        if not all(_vanishes_at_zero(side, tear) for side in (quotient.left, quotient.right)):
            continue
        try:
            slopes = [differentiate(part, tear) for part in (quotient.left, quotient.right)]
        except NotDifferentiable:
            continue
        emitter.assign(_FROM_ZERO, emitter.apply("from_zero", emitter.of(Name(tear))))
        pairs = [emitter.of(substitute(slope, {tear: Name(_FROM_ZERO)})) for slope in slopes]
        bounded = f"#quotient {number}"
        emitter.assign(bounded, emitter.apply("by_slopes", *pairs))
        yield emitter.of(exchange(residual, quotient, Name(bounded)))


class _AtZero(Rationals):
    """Exact values where the tear is 0, whatever the other numbers are."""

    def _is_number(self, expression: Expression) -> bool:
        return True

    def power(self, node: Power) -> Fraction:
        return Fraction(1) if self.of(node.base) == 1 else super().power(node)


def _vanishes_at_zero(expression: Expression, tear: str) -> bool:
    try:
        return _AtZero({tear: Fraction(0)}, {}).of(expression) == 0
    except Inexact:
        return False


# --- the residual with its denominators multiplied away ---

LONGEST = 300
"""Parts of an expression beyond which it is not brought to a common denominator."""


def cleared(chain: Chain) -> Chain | None:
    """The chain with the numerator of its residual in place of that, and with quotients of quotients as plain
    ones; None where it divides by nothing that moves, or is too long.

    Wherever the residual is 0 the numerator is, and at a pole it mostly is not. The divisor of a relational
    quotient has a name of its own, so that nothing cancels with it: where it is 0, there may be an answer.
    """
    moving, parts = {chain.tears[0]}, dict[str, tuple[Expression, Expression]]()
    items: list[Assignment] = []
    for item in chain.assignments:
        if moving.isdisjoint(nodes.names(item.expression)):
            items.append(item)
            continue
        moving.add(item.name)
        above, below = _fraction(item.expression, moving, parts, item.relational)
        if sum(1 for side in (above, below) for _ in walk(side)) > LONGEST:
            return None
        if item.relational and not moving.isdisjoint(nodes.names(below)):
            divisor = Assignment(f"{item.name} divisor", below)
            moving.add(divisor.name)
            items.append(divisor)
            below = Name(divisor.name)
        if not is_number(below, 1.0):
            parts[item.name] = above, below
        items.append(Assignment(item.name, divide(above, below)))
    *first, residual = items
    if residual.name not in parts:
        return None
    last = Assignment(residual.name, parts[residual.name][0])
    return Chain(chain.tears, (*first, last), chain.residuals)


def _fraction(
    node: Expression,
    moving: set[str],
    known: Mapping[str, tuple[Expression, Expression]],
    relational: bool = False,
) -> tuple[Expression, Expression]:
    """An expression as a numerator over what moves in its denominators.

    Of a ``relational`` quotient nothing is cancelled: where a common factor is 0 it may be anything.
    """
    if moving.isdisjoint(nodes.names(node)):
        return node, ONE
    match node:
        case Name(name) if name in known:
            return known[name]
        case Negative(operand):
            above, below = _fraction(operand, moving, known)
            return negative(above), below
        case Sum(terms):
            found = [_fraction(term, moving, known) for term in terms]
            divisors = [below for _, below in found if not is_number(below, 1.0)]
            common = tuple(dict.fromkeys(divisors))
            total = [_times(above, *(d for d in common if d != below)) for above, below in found]
            return add(*total), _times(*common)
        case Product(left, right):
            (above, below), (over, under) = (_fraction(part, moving, known) for part in (left, right))
            return _reduced((above, over), (below, under))
        case Quotient(left, right):
            (above, below), (under, over) = (_fraction(part, moving, known) for part in (left, right))
            if moving.isdisjoint(nodes.names(under)):
                return divide(multiply(above, over), under), below
            if relational:
                return _times(above, over), _times(below, under)
            return _reduced((above, over), (below, under))
        case Power(base, Number(exponent)) if exponent == exponent // 1 and exponent:
            above, below = _fraction(base, moving, known)
            if exponent < 0:
                above, below = below, above
            return _raised(above, abs(exponent)), _raised(below, abs(exponent))
        case Call("tand" | "tan" as function, arguments):
            sine, cosine = ("sind", "cosd") if function == "tand" else ("sin", "cos")
            return Call(sine, arguments), Call(cosine, arguments)
        case _:
            return node, ONE


def _reduced(above: Sequence[Expression], below: Sequence[Expression]) -> tuple[Expression, Expression]:
    """Two products without the factors that they have in common."""
    over = [factor for part in above for factor in _factors(part)]
    under = [factor for part in below for factor in _factors(part)]
    for factor in tuple(under):
        if factor in over:
            over.remove(factor)
            under.remove(factor)
    return _times(*over), _times(*under)


def _factors(node: Expression) -> list[Expression]:
    match node:
        case Product(left, right):
            return _factors(left) + _factors(right)
        case Negative(operand):
            return [Number(-1.0), *_factors(operand)]
        case Power(base, Number(2.0)):
            return 2 * _factors(base)
        case _:
            return [node]


def _times(*factors: Expression) -> Expression:
    product: Expression = ONE
    for factor in factors:
        product = multiply(product, factor)
    return product


def _raised(base: Expression, exponent: float) -> Expression:
    return base if exponent == 1.0 or is_number(base, 1.0) else Power(base, Number(exponent))


MOST = 2
"""Directions of a chain, of which every combination of sides is a chain of its own."""


def sides(chain: Chain) -> tuple[Chain, ...]:
    """One chain for every combination of sides; none where there is no direction, or too many.

    The residual is at every point that of one of the chains, if it has a value there.
    """
    calls = dict.fromkeys(call for item in chain.assignments for call in directions(item.expression))
    if not 0 < len(calls) <= MOST:
        return ()
    return tuple(
        _beside(chain, dict(zip(calls, upper, strict=True)))
        for upper in product((True, False), repeat=len(calls))
    )


def _beside(chain: Chain, upper: Mapping[Call, bool]) -> Chain:
    """The chain with directions on the upper side of their cut, or on the lower one."""
    assignments: list[Assignment] = []
    for item in chain.assignments:
        expression = item.expression
        for number, call in enumerate(upper):
            if call in directions(expression):
                y, x = call.arguments
                name = f"#side {number}"
                assignments.append(Assignment(name, y if upper[call] else negative(y), low=0.0))
                turned = Call(call.function, (Name(name), x))
                expression = exchange(expression, call, turned if upper[call] else negative(turned))
        assignments.append(item._replace(expression=expression))
    return Chain(chain.tears, tuple(assignments), chain.residuals)


Interval: TypeAlias = tuple[float, float]
Code: TypeAlias = tuple[Callable[..., Any], Callable[..., Any] | None]

FEW = 64
"""Up to so many boxes one after the other take no more time than arrays of them."""


class Enclosure:
    """Bounds over boxes of the tear, given the numbers ``known`` to the chain, in this order."""

    def __init__(self, chain: Chain, known: Sequence[str]) -> None:
        self._chain, self._known = chain, tuple(known)
        self.slopes = slopes_of(chain)
        self.cleared = cleared(chain)
        self.operations = 3 * len(chain.assignments) + len(self.slopes or ())
        """How many operations on all boxes one level of a search costs: range, sections and slope."""

    def ranges(self, boxes: Sequence[Interval], known: Sequence[float]) -> list[Interval]:
        """The residual over each box; nan, nan where it is undefined all over it, or jumps across 0 there and
        has no root."""
        if len(boxes) > FEW:
            found = _in_arrays(self.range_on, boxes, known)
        else:
            evaluated = self._floats[0]
            found = [_range(*evaluated(low, high, *known)) for low, high in boxes]
        if not self._sides:
            return found
        return [
            (nan, nan) if below <= 0.0 <= above and self._jumps_across(*box, known) else (below, above)
            for box, (below, above) in zip(boxes, found, strict=True)
        ]

    def _jumps_across(self, low: float, high: float, known: Sequence[float]) -> bool:
        """Whether the residual has no root on either side of the cuts of its directions."""
        for side in self._sides:
            below, above = _range(*side._floats[0](low, high, *known))
            if not (below > 0.0 or above < 0.0 or (isnan(below) and isnan(above))):
                return False
        return True

    def rises_or_falls(self, low: float, high: float, known: Sequence[float]) -> bool:
        """Whether the numerator of the residual is monotone on a box."""
        found = self._of_numerator
        if found is None or found.slopes is None:
            return False
        ((least, most),) = found.slopes_over([(low, high)], known)
        return least > 0.0 or most < 0.0

    @cached_property
    def _of_numerator(self) -> Enclosure | None:
        return None if self.cleared is None else Enclosure(self.cleared, self._known)

    def slopes_over(self, boxes: Sequence[Interval], known: Sequence[float]) -> list[Interval]:
        """The derivative of the residual by the tear; unbounded where it may be undefined somewhere."""
        if len(boxes) > FEW:
            return _in_arrays(self.slope_on, boxes, known)
        found, evaluated = [], self._floats[1]
        assert evaluated is not None
        for low, high in boxes:
            below, above, doubtful = evaluated(low, high, *known)
            unknown = doubtful or isnan(below) or isnan(above)
            found.append((-inf, inf) if unknown else (below, above))
        return found

    def range_on(self, low: Array, high: Array, known: Sequence[Any]) -> Intervals:
        """``ranges`` of arrays of boxes; the known numbers are numpy's, or arrays."""
        with np.errstate(all="ignore"):
            below, above, empty = self._arrays[0](low, high, *known)
            return np.where(empty, np.nan, below), np.where(empty, np.nan, above)

    def slope_on(self, low: Array, high: Array, known: Sequence[Any]) -> Intervals:
        """``slopes_over`` arrays of boxes."""
        assert self._arrays[1] is not None
        with np.errstate(all="ignore"):
            below, above, doubtful = self._arrays[1](low, high, *known)
            unknown = doubtful | np.isnan(below) | np.isnan(above)
            return np.where(unknown, -np.inf, below), np.where(unknown, np.inf, above)

    @cached_property
    def _sides(self) -> tuple[Enclosure, ...]:
        return tuple(Enclosure(side, self._known) for side in sides(self._chain))

    @cached_property
    def _floats(self) -> Code:
        return self._compiled(FLOATS)

    @cached_property
    def _arrays(self) -> Code:
        return self._compiled(ARRAYS)

    def _compiled(self, operations: Operations) -> Code:
        """Functions of the ends of the boxes and of the known numbers, for the range and for the slope."""
        emitter = _followed(self._chain, self._known, operations)
        residual = emitter.of(Name(self._chain.residuals[0]))
        for pair in by_slopes(emitter, self._chain):
            residual = emitter.apply("within", residual, pair)
        if self.cleared is not None:
            *items, numerator = self.cleared.assignments
            followed = {item.name for item in self._chain.assignments}
            for item in items:
                if item.name not in followed:
                    emitter.assign(item.name, emitter.of(item.expression))
            low, high = emitter.of(numerator.expression)
            open_ = f"({residual[0]} <= 0.0) & ({residual[1]} >= 0.0)"
            emitter.line(f"empty = empty | {open_} & (({low} > 0.0) | ({high} < 0.0))")
        ranges = emitter.function(f"{residual[0]}, {residual[1]}, empty")
        if self.slopes is None:
            return ranges, None
        emitter = _followed(self._chain, self._known, operations)
        for name, expression in self.slopes:
            emitter.assign(name, emitter.of(expression))
        slope = emitter.of(Name(_slope_name(self._chain.residuals[0])))
        return ranges, emitter.function(f"{slope[0]}, {slope[1]}, doubtful")


def _range(below: float, above: float, empty: bool) -> Interval:
    return (nan, nan) if empty else (below, above)


def _in_arrays(
    enclose: Callable[..., Intervals], boxes: Sequence[Interval], known: Sequence[float]
) -> list[Interval]:
    low, high = np.array(boxes).T
    below, above = enclose(low, high, [np.float64(number) for number in known])
    shape = low.shape
    return list(
        zip(np.broadcast_to(below, shape).tolist(), np.broadcast_to(above, shape).tolist(), strict=True)
    )


def slope_chain(chain: Chain) -> Chain | None:
    """The chain whose residual is the derivative of that of ``chain`` by its tear; None where it may jump."""
    slopes = slopes_of(chain)
    if slopes is None:
        return None
    added = (Assignment(name, expression) for name, expression in slopes)
    return Chain(chain.tears, (*chain.assignments, *added), (_slope_name(chain.residuals[0]),))


def _followed(chain: Chain, known: Sequence[str], operations: Operations) -> IntervalEmitter:
    """The boxes of every name of a chain, where some value may leave its domain, and where all must."""
    emitter = IntervalEmitter(chain.tears, known, operations)
    emitter.line("empty = isnan(l0)")
    emitter.line("doubtful = isnan(l0)")
    for item in chain.assignments:
        for direction in directions(item.expression):
            y, x = (emitter.of(argument) for argument in direction.arguments)
            emitter.line(f"doubtful = doubtful | cut({y[0]}, {y[1]}, {x[0]}, {x[1]})")
        low, high = _assigned(emitter, item)
        if item.low == -inf and item.high == inf:
            emitter.line(f"empty = empty | isnan({low})")
        else:
            ends = f"{low}, {high}, {_literal(emitter, item.low)}, {_literal(emitter, item.high)}"
            emitter.line(f"d{low}, e{low}, empty, doubtful = bounded({ends}, empty, doubtful)")
            low, high = f"d{low}", f"e{low}"
        emitter.assign(item.name, (low, high))
    return emitter


def _assigned(emitter: IntervalEmitter, item: Assignment) -> Pair:
    """A quotient that must not be negative has a divisor of its dividend's sign."""
    expression = item.expression
    if not isinstance(expression, Quotient) or not (item.relational or item.low >= 0.0):
        return emitter.of(expression)
    above, below = emitter.of(expression.left), emitter.of(expression.right)
    return emitter.apply("quotient", above, below, more=f", {item.low >= 0.0:d}, {item.relational:d}")


def _literal(emitter: IntervalEmitter, end: float) -> str:
    return emitter.of(Number(end))[0]


def _slope_name(name: str) -> str:
    return f"d {name}"


def slopes_of(chain: Chain) -> tuple[tuple[str, Expression], ...] | None:
    """Forward accumulation: the slope of every assignment by the tear; None where a step may jump."""
    moving: dict[str, Expression] = {chain.tears[0]: Number(1.0)}
    found: list[tuple[str, Expression]] = []
    try:
        for item in chain.assignments:
            used = [name for name in dict.fromkeys(nodes.names(item.expression)) if name in moving]
            if not used:
                continue
            if jumps(item.expression):
                return None
            terms = tuple(multiply(differentiate(item.expression, name), moving[name]) for name in used)
            slope = _slope_name(item.name)
            found.append((slope, terms[0] if len(terms) == 1 else nodes.Sum(terms)))
            moving[item.name] = Name(slope)
    except NotDifferentiable:
        return None
    if chain.residuals[0] not in moving:
        return None
    return tuple(found)
