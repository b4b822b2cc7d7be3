"""The residual of a chain with one tear, and its slope, on arrays of boxes of the tear; compiled once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import inf

import numpy as np

from rulesheets import nodes
from rulesheets.construct import add, is_number, multiply
from rulesheets.evaluate import NotDifferentiable, differentiate
from rulesheets.functions.intervals import divide
from rulesheets.functions.intervals.bounds import Array, Interval, Mask
from rulesheets.nodes import Expression, Name, Number, Quotient
from solver.kernel.chain import Assignment, Chain, directions, jumps
from solver.kernel.interval_code import IntervalEmitter, Pair, cut
from solver.kernel.quotients import by_slopes
from solver.path import rational

HORNER_DEGREE = 12


class Enclosure:
    """Bounds over boxes of the tear, given the numbers ``known`` to the chain."""

    def __init__(self, chain: Chain, known: Sequence[str]) -> None:
        self.slopes = slopes_of(chain)
        nested = tuple(_nested(chain))
        self.operations = 3 * len(chain.assignments) + len(nested) + len(self.slopes or ())
        """How many operations on all boxes one level of a search costs: range, sections and slope."""
        emitter = _followed(chain, known)
        residual = emitter.pair(Name(chain.residuals[0]))
        for form in nested:
            pair = emitter.pair(form)
            residual = emitter.apply("within", _within, residual, pair)
        for pair in by_slopes(emitter, chain):
            residual = emitter.apply("within", _within, residual, pair)
        self._range = emitter.function(f"{residual[0]}, {residual[1]}, empty")
        if self.slopes is None:
            return
        emitter = _followed(chain, known)
        for name, expression in self.slopes:
            emitter.name(name, emitter.pair(expression))
        slope = emitter.pair(Name(_slope_name(chain.residuals[0])))
        self._slope = emitter.function(f"{slope[0]}, {slope[1]}, doubtful")

    def range_on(self, low: Array, high: Array, known: Sequence[np.float64]) -> Interval:
        """The residual over each box; nan where it is undefined all over it."""
        with np.errstate(all="ignore"):
            below, above, empty = self._range(low, high, *known)
            return np.where(empty, np.nan, below), np.where(empty, np.nan, above)

    def slope_on(self, low: Array, high: Array, known: Sequence[np.float64]) -> Interval:
        """The derivative of the residual by the tear; unbounded where it may be undefined somewhere."""
        with np.errstate(all="ignore"):
            below, above, doubtful = self._slope(low, high, *known)
            unknown = doubtful | np.isnan(below) | np.isnan(above)
            return np.where(unknown, -np.inf, below), np.where(unknown, np.inf, above)


def slope_chain(chain: Chain) -> Chain | None:
    """The chain whose residual is the derivative of that of ``chain`` by its tear; None where it may jump."""
    slopes = slopes_of(chain)
    if slopes is None:
        return None
    added = (Assignment(name, expression) for name, expression in slopes)
    return Chain(chain.tears, (*chain.assignments, *added), (_slope_name(chain.residuals[0]),))


def _followed(chain: Chain, known: Sequence[str]) -> IntervalEmitter:
    """The boxes of every name of a chain, where some value may leave its domain, and where all must."""
    emitter = IntervalEmitter(chain.tears, known)
    emitter.line("empty = isnan(l0)")
    emitter.line("doubtful = isnan(l0)")
    for item in chain.assignments:
        for direction in directions(item.expression):
            y, x = (emitter.pair(argument) for argument in direction.arguments)
            emitter.line(f"doubtful = doubtful | cut({y[0]}, {y[1]}, {x[0]}, {x[1]})", cut=cut)
        low, high = _assigned(emitter, item)
        if item.low == -inf and item.high == inf:
            emitter.line(f"empty = empty | isnan({low})")
        else:
            ends = f"{low}, {high}, {_literal(emitter, item.low)}, {_literal(emitter, item.high)}"
            emitter.line(
                f"d{low}, e{low}, empty, doubtful = bounded({ends}, empty, doubtful)", bounded=_bounded
            )
            low, high = f"d{low}", f"e{low}"
        emitter.name(item.name, (low, high))
    return emitter


def _assigned(emitter: IntervalEmitter, item: Assignment) -> Pair:
    """A quotient that must not be negative has a divisor of its dividend's sign."""
    expression = item.expression
    if not isinstance(expression, Quotient) or not (item.relational or item.low >= 0.0):
        return emitter.pair(expression)
    above, below = emitter.pair(expression.left), emitter.pair(expression.right)
    return emitter.apply(
        "quotient", _quotient, above, below, more=f", {item.low >= 0.0:d}, {item.relational:d}"
    )


def _literal(emitter: IntervalEmitter, end: float) -> str:
    return emitter.pair(Number(end))[0]


def _bounded(
    low: Array, high: Array, least: float, most: float, empty: Mask, doubtful: Mask
) -> tuple[Array, Array, Mask, Mask]:
    """What lies between ``least`` and ``most``."""
    outside = (high < least) | (low > most)
    doubtful = doubtful | (low < least) | (high > most)
    low, high = np.maximum(low, least), np.minimum(high, most)
    empty = empty | outside | np.isnan(low) | np.isnan(high)
    return np.where(empty, np.nan, low), np.where(empty, np.nan, high), empty, doubtful


def _quotient(
    a_low: Array, a_high: Array, b_low: Array, b_high: Array, not_negative: int, relational: int
) -> Interval:
    """A product x*c = t says nothing about x where both c and t may be 0."""
    if not_negative:
        b_low, b_high = (
            np.where((a_low > 0) & (b_low < 0), np.minimum(0.0, b_high), b_low),
            np.where((a_high < 0) & (b_high > 0), np.maximum(0.0, b_low), b_high),
        )
    low, high = divide(a_low, a_high, b_low, b_high)
    if not relational:
        return low, high
    anything = (a_low <= 0) & (a_high >= 0) & (b_low <= 0) & (b_high >= 0)
    return np.where(anything, -np.inf, low), np.where(anything, np.inf, high)


def _within(a_low: Array, a_high: Array, b_low: Array, b_high: Array) -> Interval:
    """What two enclosures of one quantity have in common."""
    return np.fmax(a_low, b_low), np.fmin(a_high, b_high)


def _nested(chain: Chain) -> Iterator[Expression]:
    """Horner forms of the residual: equal to it, and narrower where powers of one variable compete."""
    residual = chain.assignments[-1].expression
    moving = {*chain.tears, *(item.name for item in chain.assignments)}
    for name in dict.fromkeys(n for n in nodes.names(residual) if n in moving):
        found = rational.equation(residual, Number(0.0), name, degree=HORNER_DEGREE)
        if found is None or found[1] or sum(1 for c in found[0] if not is_number(c, 0.0)) < 2:
            continue
        *lower, nested = found[0]
        for coefficient in reversed(lower):
            nested = add(coefficient, multiply(Name(name), nested))
        yield nested


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
