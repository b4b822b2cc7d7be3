"""The residual of a chain with one tear, and its slope, over boxes of the tear.

They are compiled when they are first asked for: to floats for a few boxes, to arrays for many. Callers of
operations on arrays silence numpy's warnings once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from fractions import Fraction
from functools import cached_property
from math import inf, isfinite, isnan, nan
from typing import Any, TypeAlias

import numpy as np

from rulesheets.evaluate import NotDifferentiable, differentiate
from rulesheets.evaluate.number import FLOAT_INTERVALS, Inexact, Rationals
from rulesheets.functions import arrays, intervals
from rulesheets.functions.arrays import INTERVALS, Array, Mask
from rulesheets.functions.intervals import EMPTY, Interval, cut, divide, greatest
from rulesheets.functions.intervals import least as smaller
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Expression, Name, Number, Power, Quotient, exchange, substitute
from rulesheets.syntax.program import walk
from solver.kernel.chain import Assignment, Chain, cleared, directions, sides, slope_name, slopes_of
from solver.kernel.emitter import IntervalEmitter, Operations, Pair

# --- interval operations that compiled code calls, on one box of floats and on arrays of boxes ---

ARITHMETIC = ("add", "divide", "multiply", "power", "square", "scaled")


def bounded(
    low: float, high: float, least: float, most: float, empty: bool, doubtful: bool
) -> tuple[float, float, bool, bool]:
    """What lies between ``least`` and ``most``."""
    outside = high < least or low > most
    doubtful = doubtful or low < least or high > most
    low, high = greatest(low, least), smaller(high, most)
    if empty or outside or isnan(low) or isnan(high):
        return *EMPTY, True, doubtful
    return low, high, False, doubtful


def quotient(
    a_low: float, a_high: float, b_low: float, b_high: float, not_negative: int, relational: int
) -> Interval:
    """A product x*c = t says nothing about x where both c and t may be 0."""
    if not_negative:
        least, most = b_low, b_high
        if a_low > 0.0 and least < 0.0:
            b_low = smaller(0.0, most)
        if a_high < 0.0 and most > 0.0:
            b_high = greatest(0.0, least)
    if relational and a_low <= 0.0 <= a_high and b_low <= 0.0 <= b_high:
        return -inf, inf
    return divide(a_low, a_high, b_low, b_high)


def by_slopes(a_low: float, a_high: float, b_low: float, b_high: float) -> Interval:
    """The quotient of two slopes where both are bounded: where they are not, they may not be defined."""
    known = isfinite(a_low) and isfinite(a_high) and isfinite(b_low) and isfinite(b_high)
    return divide(a_low, a_high, b_low, b_high) if known else EMPTY


def cuts(y_low: Array, y_high: Array, x_low: Array, _: Array) -> Mask:
    """Where the direction of (x, y) may jump from one half turn to the other, or is undefined."""
    return ~((y_low > 0.0) | (y_high < 0.0) | (x_low > 0.0))


def all_bounded(
    low: Array, high: Array, least: float, most: float, empty: Mask, doubtful: Mask
) -> tuple[Array, Array, Mask, Mask]:
    """What lies between ``least`` and ``most``."""
    outside = (high < least) | (low > most)
    doubtful = doubtful | (low < least) | (high > most)
    low, high = np.maximum(low, least), np.minimum(high, most)
    empty = empty | outside | np.isnan(low) | np.isnan(high)
    return np.where(empty, np.nan, low), np.where(empty, np.nan, high), empty, doubtful


def all_quotients(
    a_low: Array, a_high: Array, b_low: Array, b_high: Array, not_negative: int, relational: int
) -> tuple[Array, Array]:
    """A product x*c = t says nothing about x where both c and t may be 0."""
    if not_negative:
        least, most = b_low, b_high
        b_low = np.where((a_low > 0.0) & (least < 0.0), np.fmin(0.0, most), least)
        b_high = np.where((a_high < 0.0) & (most > 0.0), np.fmax(0.0, least), most)
    low, high = arrays.divide(a_low, a_high, b_low, b_high)
    if relational:
        free = (a_low <= 0.0) & (a_high >= 0.0) & (b_low <= 0.0) & (b_high >= 0.0)
        low, high = np.where(free, -inf, low), np.where(free, inf, high)
    return low, high


def all_by_slopes(a_low: Array, a_high: Array, b_low: Array, b_high: Array) -> tuple[Array, Array]:
    """The quotients of two slopes where both are bounded."""
    known = np.isfinite(a_low) & np.isfinite(a_high) & np.isfinite(b_low) & np.isfinite(b_high)
    low, high = arrays.divide(a_low, a_high, b_low, b_high)
    return np.where(known, low, nan), np.where(known, high, nan)


FLOATS = Operations(
    float,
    FLOAT_INTERVALS,
    {
        **{name: getattr(intervals, name) for name in ARITHMETIC},
        "isnan": isnan,
        "cut": cut,
        "bounded": bounded,
        "quotient": quotient,
        "within": intervals.within,
        "from_zero": lambda low, high: (smaller(low, 0.0), greatest(high, 0.0)),
        "by_slopes": by_slopes,
    },
)

ARRAYS = Operations(
    np.float64,
    INTERVALS,
    {
        **{name: getattr(arrays, name) for name in ARITHMETIC},
        "isnan": np.isnan,
        "cut": cuts,
        "bounded": all_bounded,
        "quotient": all_quotients,
        "within": lambda low, high, below, above: (np.fmax(low, below), np.fmin(high, above)),
        "from_zero": lambda low, high: (np.minimum(low, 0.0) + 0.0, np.maximum(high, 0.0) + 0.0),
        "by_slopes": all_by_slopes,
    },
)


# --- quotients whose dividend and divisor vanish together ---
#
# ``rate/(1 - (1 + rate)^(-term))`` is 0/0 at 0, and next to that interval arithmetic knows nothing of it. But
# if N and D both vanish at 0, then N(x)/D(x) = N'(t)/D'(t) for some t between 0 and x (Cauchy's mean value
# theorem), so that the slopes over the hull of 0 and the box bound the quotient over the box.

_FROM_ZERO = "#from zero"


def _by_slopes(emitter: IntervalEmitter, chain: Chain) -> Iterator[Pair]:
    """Other bounds of the residual, with one such quotient bounded by slopes; nan where they have none."""
    tear = chain.tears[0]
    assigned = {item.name for item in chain.assignments}
    residual = chain.assignments[-1].expression
    quotients = (part for part in walk(residual) if isinstance(part, Quotient))
    for number, quotient in enumerate(dict.fromkeys(quotients)):
        used = {*nodes.names(quotient)}
        if tear not in used or used & assigned:
            continue
        at_zero = AtZero({tear: Fraction(0)}, {})
        try:
            if at_zero.of(quotient.left) or at_zero.of(quotient.right):
                continue
            slopes = [differentiate(part, tear) for part in (quotient.left, quotient.right)]
        except (Inexact, NotDifferentiable):
            continue
        emitter.assign(_FROM_ZERO, emitter.apply("from_zero", emitter.of(Name(tear))))
        pairs = [emitter.of(substitute(slope, {tear: Name(_FROM_ZERO)})) for slope in slopes]
        bounded = f"#quotient {number}"
        emitter.assign(bounded, emitter.apply("by_slopes", *pairs))
        yield emitter.of(exchange(residual, quotient, Name(bounded)))


class AtZero(Rationals):
    """Exact values where the tear is 0, whatever the other numbers are."""

    def is_number(self, expression: Expression) -> bool:
        return True

    def power(self, node: Power) -> Fraction:
        return Fraction(1) if self.of(node.base) == 1 else super().power(node)


# --- a chain over boxes ---

Code: TypeAlias = Sequence[Callable[..., Any]]

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
        found = [_range(*ends) for ends in self._evaluated(0, boxes, known)]
        if not self._sides:
            return found
        for place, (box, (below, above)) in enumerate(zip(boxes, found, strict=True)):
            if below <= 0.0 <= above:
                ranges = (_range(*side._floats[0](*box, *known)) for side in self._sides)
                if all(low > 0.0 or high < 0.0 or (isnan(low) and isnan(high)) for low, high in ranges):
                    found[place] = nan, nan  # no root on either side of the cuts of its directions
        return found

    def rises_or_falls(self, low: float, high: float, known: Sequence[float]) -> bool:
        """Whether the numerator of the residual is monotone on a box."""
        if self._of_numerator is None or self._of_numerator.slopes is None:
            return False
        ((least, most),) = self._of_numerator.slopes_over([(low, high)], known)
        return least > 0.0 or most < 0.0

    @cached_property
    def _of_numerator(self) -> Enclosure | None:
        return None if self.cleared is None else Enclosure(self.cleared, self._known)

    def slopes_over(self, boxes: Sequence[Interval], known: Sequence[float]) -> list[Interval]:
        """The derivative of the residual by the tear; unbounded where it may be undefined somewhere."""
        return [
            (-inf, inf) if doubtful or isnan(below) or isnan(above) else (below, above)
            for below, above, doubtful in self._evaluated(1, boxes, known)
        ]

    def _evaluated(
        self, which: int, boxes: Sequence[Interval], known: Sequence[float]
    ) -> Iterable[tuple[float, float, bool]]:
        """What the function for the range (0) or for the slope (1) gives for each box."""
        if len(boxes) <= FEW:
            on_floats = self._floats[which]
            return (on_floats(*box, *known) for box in boxes)
        low, high = np.array(boxes).T
        with np.errstate(all="ignore"):
            found = self._arrays[which](low, high, *map(np.float64, known))
        return zip(*(np.broadcast_to(each, low.shape).tolist() for each in found), strict=True)

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
        for pair in _by_slopes(emitter, self._chain):
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
        ranges = emitter.function([*residual, "empty"])
        if self.slopes is None:
            return (ranges,)
        emitter = _followed(self._chain, self._known, operations)
        for name, expression in self.slopes:
            emitter.assign(name, emitter.of(expression))
        slope = emitter.of(Name(slope_name(self._chain.residuals[0])))
        return ranges, emitter.function([*slope, "doubtful"])


def _range(below: float, above: float, empty: bool) -> Interval:
    return (nan, nan) if empty else (below, above)


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
            least, most = (emitter.number(Number(end))[0] for end in (item.low, item.high))
            ends = f"{low}, {high}, {least}, {most}"
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
