"""A block with several tears whose unknowns all have finite ranges: searched box by box, with proof.

Boxes are narrowed by the rules themselves. Forward, every part of every rule gets its range over the box;
each rule says that its left minus its right is 0; backward, each part is narrowed to what its whole needs it
to be, and so the unknowns are in the end. Parts that rules have in common are one node, narrowed by all.
(HC4-revise: F. Benhamou, F. Goualard, L. Granvilliers & J.-F. Puget, ICLP 1999; on the graph: H. Schichl &
A. Neumaier, J. Global Optimization 33 (2005) 541–562.) No root in a box is lost.

What the value of one operation says about its operands are projections of elementary constraints on boxes.
Each narrows an operand ``x`` to a hull of those of its numbers for which the operation can give a number in
``z``; all are intervals as pairs of arrays, rounded outward. An empty hull has its ends crossed or nan.
(F. Benhamou & W. J. Older, J. Logic Programming 32 (1997) 1–24, section 4.)
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from rulesheets.deadline import expect_time
from rulesheets.functions import TABLE
from rulesheets.functions.intervals.arrays import (
    INTERVALS,
    Array,
    Interval,
    Mask,
    add,
    divide,
    magnitudes,
    multiply,
    power,
    square,
)
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Call, Expression, Name, Negative, Number, Power, Product, Quotient, Sum
from solver.kernel.candidates import Candidates
from solver.kernel.emitter import ROUNDED, IntervalEmitter
from solver.kernel.interval_forms import ARRAYS
from solver.kernel.question import Question
from solver.numerics.subdivision import BoxFunction, SubdivisionLimits, branch_and_prune

ROOT_SLACK = 4096 * 2.0**-52
"""Relative: x^(1/n) with a rounded 1/n is off by at most |ln x| of them, 745 at most."""
TURN_SLACK = 16 * 2.0**-52


def meet(x: Interval, other: Interval) -> Interval:
    """The common part; nan stays."""
    return np.maximum(x[0], other[0]), np.minimum(x[1], other[1])


def outside(x: Interval, low: Array, high: Array) -> Interval:
    """The hull of the numbers of ``x`` that are not strictly between ``low`` and ``high``."""
    below, above = x[0] <= low, x[1] >= high
    first = np.where(below, x[0], np.maximum(x[0], high))
    last = np.where(above, x[1], np.minimum(x[1], low))
    return first, last


def factor(x: Interval, y: Interval, z: Interval) -> Interval:
    """x where x·y = z. A ``y`` on both sides of 0 leaves out the middle; if ``z`` has 0 too, nothing."""
    quotient = divide(*z, *y)
    y_zero, z_zero = (y[0] <= 0.0) & (y[1] >= 0.0), (z[0] <= 0.0) & (z[1] >= 0.0)
    inside = meet(x, quotient)
    # y across 0 and z off 0: |x| is at least |z| / |y|
    least, _ = magnitudes(*z)
    up = np.where(z[0] > 0.0, least / y[1], least / -y[0])
    down = np.where(z[0] > 0.0, least / y[0], -least / y[1])
    across = outside(x, np.nextafter(down, np.inf), np.nextafter(up, -np.inf))
    apart = y_zero & ~z_zero & (y[0] < 0.0) & (y[1] > 0.0)
    free = y_zero & z_zero
    low = np.where(free, x[0], np.where(apart, across[0], inside[0]))
    return low, np.where(free, x[1], np.where(apart, across[1], inside[1]))


def divisor(y: Interval, x: Interval, z: Interval) -> Interval:
    """y where x / y = z, that is y·z = x."""
    return factor(y, z, x)


def whole_root(x: Interval, z: Interval, exponent: int) -> Interval:
    """x where x^n = z for a whole n of 1 or more."""
    if exponent == 1:
        return meet(x, z)
    if exponent % 2:
        return meet(x, (_signed_root(z[0], exponent, -np.inf), _signed_root(z[1], exponent, np.inf)))
    z = np.maximum(z[0], 0.0), np.where(z[1] < 0.0, np.nan, z[1])
    least = np.maximum(_root(z[0], exponent, -np.inf), 0.0)
    greatest = _root(z[1], exponent, np.inf)
    return outside(meet(x, (-greatest, greatest)), -least, least)


def _root(z: Array, exponent: int, towards: float) -> Array:
    if exponent == 2:
        return np.nextafter(np.sqrt(z), towards)
    root = np.power(z, 1.0 / exponent)
    slack = root * ROOT_SLACK
    result: Array = np.nextafter(root + slack if towards > 0 else root - slack, towards)
    return result


def _signed_root(z: Array, exponent: int, towards: float) -> Array:
    return np.where(z >= 0.0, _root(abs(z), exponent, towards), -_root(abs(z), exponent, -towards))


def real_root(x: Interval, z: Interval, exponent: float) -> Interval:
    """x where x^a = z for an a that is no whole number: x and z are not negative."""
    z = np.maximum(z[0], 0.0), np.where(z[1] < 0.0, np.nan, z[1])
    ends = np.power(z[0], 1.0 / exponent), np.power(z[1], 1.0 / exponent)
    low, high = ends if exponent > 0 else ends[::-1]
    slack = ROOT_SLACK / min(abs(exponent), 1.0)
    return meet(x, (np.maximum(low * (1.0 - slack), 0.0), np.nextafter(high * (1.0 + slack), np.inf)))


def root_operand(x: Interval, z: Interval) -> Interval:
    """x where √x = z."""
    least = np.maximum(np.nextafter(np.maximum(z[0], 0.0) ** 2, -np.inf), 0.0)
    return meet(x, (least, np.nextafter(z[1] ** 2, np.inf)))


def magnitude(x: Interval, z: Interval) -> Interval:
    """x where |x| = z."""
    least, greatest = np.maximum(z[0], 0.0), np.where(z[1] < 0.0, np.nan, z[1])
    return outside(meet(x, (-greatest, greatest)), -least, least)


def cosine(x: Interval, z: Interval, turn: float, top: float) -> Interval:
    """x where cos(2π (x / turn - top)) = z: the first and the last preimage in ``x``."""
    z = np.maximum(z[0], -1.0), np.minimum(z[1], 1.0)
    z = np.where(z[0] > z[1], np.nan, z[0]), z[1]
    half = np.arccos(z[1]) / (2 * np.pi) - TURN_SLACK, np.arccos(z[0]) / (2 * np.pi) + TURN_SLACK
    start, stop = x[0] / turn - top, x[1] / turn - top
    slack = TURN_SLACK * (1.0 + np.maximum(abs(x[0]), abs(x[1])) / turn)
    first = _next_preimage(start - slack, *half) - slack
    last = -_next_preimage(-stop - slack, *half) + slack
    wide = ~(np.isfinite(start) & np.isfinite(stop))
    low = np.where(wide, x[0], np.maximum(x[0], (first + top) * turn))
    high = np.where(wide, x[1], np.minimum(x[1], (last + top) * turn))
    return np.where(np.isnan(z[0]), np.nan, low), high


def _next_preimage(start: Array, near: Array, far: Array) -> Array:
    """The least t ≥ start, in turns, within [near, far] of a whole number on either side of it."""
    whole = np.floor(start)
    t = start - whole
    near = np.maximum(near, 0.0)
    found = np.where(t < near, near, np.where(t <= far, t, np.where(t < 1.0 - far, 1.0 - far, t)))
    found = np.where(found > 1.0 - near, np.maximum(found, 1.0 + near), found)
    return whole + found


def _through(name: str, x: Interval, z: Interval) -> Interval:
    """x where x is the function ``name`` of z."""
    return meet(x, INTERVALS[name](*z))


def _undone() -> Iterator[tuple[str, Callable[[Interval, Interval], Interval]]]:
    """The functions that one other function undoes, whatever the value."""
    for name, row in TABLE.items():
        if row.inverse is None or row.inverse.period is not None or row.source is not None:
            continue
        match row.inverse.branches(Name("z")):
            case (Call(inverse, (Name(),)),):
                yield name, partial(_through, inverse)


INVERSES: Mapping[str, Callable[[Interval, Interval], Interval]] = {
    **dict(_undone()),
    "sqrt": root_operand,
    "abs": magnitude,
    "sin": partial(cosine, turn=2 * np.pi, top=0.25),
    "cos": partial(cosine, turn=2 * np.pi, top=0.0),
    "sind": partial(cosine, turn=360.0, top=0.25),
    "cosd": partial(cosine, turn=360.0, top=0.0),
}
"""By function of one argument; those that are not here narrow nothing."""

PASSES = 4
GAIN = 0.9
"""A pass that leaves every side of a box longer than this share of it is the last one."""


class Node(NamedTuple):
    """A part of a rule: how it is made, and the places of its operands before it."""

    form: Expression
    operands: tuple[int, ...]


class Hull:
    """The parts of the ``forms``, each of which is 0 at a root, in the order in which they are computed."""

    def __init__(
        self, forms: Sequence[Expression], unknowns: Sequence[str], known: Mapping[str, float]
    ) -> None:
        self.unknowns = tuple(unknowns)
        self.nodes: list[Node] = []
        self._places: dict[Expression, int] = {}
        self.known = known
        self.roots = [self._place(form) for form in forms]
        self.inputs = [self._places.get(Name(name)) for name in unknowns]

    def _place(self, form: Expression) -> int:
        found = self._places.get(form)
        if found is None:
            below = tuple(map(self._place, nodes.children(form)))
            found = self._places[form] = len(self.nodes)
            self.nodes.append(Node(form, below))
        return found

    def contract(self, low: Array, high: Array) -> tuple[Array, Array, Mask]:
        """Boxes (k, n) narrowed, and which of them hold no root. Empty ones keep the ends that they had."""
        low, high = low.copy(), high.copy()
        empty = np.zeros(len(low), bool)
        live, values = np.arange(len(low)), None
        for _ in range(PASSES):
            expect_time()
            before = low[live], high[live]
            after, values = self._narrowed(*before, values)
            void = ~(after[0] <= after[1]).all(axis=1)
            empty[live[void]] = True
            low[live[~void]], high[live[~void]] = after[0][~void], after[1][~void]
            shorter = (after[1] - after[0]) < GAIN * (before[1] - before[0])
            gained: Mask = np.logical_or.reduce(shorter, axis=1) & ~void
            if not gained.any():
                break
            live = live[gained]
            values = [(_chosen(a, gained), _chosen(b, gained)) for a, b in values]
        return low, high, empty

    def _narrowed(
        self, low: Array, high: Array, known: Sequence[Interval] | None
    ) -> tuple[tuple[Array, Array], list[Interval]]:
        """One pass forward and one backward, and what is ``known`` of every part afterwards.

        Ends of an empty box are crossed or nan.
        """
        values = self._forward({n: (low[:, i], high[:, i]) for i, n in enumerate(self.unknowns)}, known)
        zero = np.zeros(len(low))
        for root in self.roots:
            values[root] = _zero(values[root], zero)
        for place in range(len(self.nodes) - 1, -1, -1):
            if self.nodes[place].operands:
                self._backward(values, place)
        low, high = low.copy(), high.copy()
        for i, source in enumerate(self.inputs):
            if source is not None:
                low[:, i], high[:, i] = values[source]
        void = np.zeros(len(low), bool)
        for below, above in values:
            void |= ~(below <= above)
        low[void] = np.nan
        return (low, high), values

    def _forward(self, at: Mapping[str, Interval], known: Sequence[Interval] | None) -> list[Interval]:
        values: list[Interval] = []
        for place, node in enumerate(self.nodes):
            value = self._value(node.form, [values[operand] for operand in node.operands], at)
            values.append(value if known is None else meet(value, known[place]))
        return values

    def _value(self, form: Expression, operands: Sequence[Interval], at: Mapping[str, Interval]) -> Interval:
        result: Interval
        match form:
            case Number(number):
                ends = ROUNDED.get(number, (number, number))
                return np.asarray(ends[0]), np.asarray(ends[1])
            case Name(name):
                return at[name] if name in at else (np.asarray(self.known[name]),) * 2
            case Negative():
                return -operands[0][1], -operands[0][0]
            case Sum():
                total = operands[0]
                for term in operands[1:]:
                    total = add(*total, *term)
                return total
            case Product(left, right):
                result = square(*operands[0]) if left == right else multiply(*operands[0], *operands[1])
            case Quotient():
                result = divide(*operands[0], *operands[1])
            case Power(_, Number(2.0)):
                result = square(*operands[0])
            case Power():
                result = power(*operands[0], *operands[1])
            case Call(function):
                result = INTERVALS[function](*(end for pair in operands for end in pair))
            case nodes.Symbol(name):
                raise ValueError(f"the symbol '{name} has no range")
        return result

    def _backward(self, values: list[Interval], place: int) -> None:
        node, z = self.nodes[place], values[place]
        operands = [values[source] for source in node.operands]
        match node.form:
            case Negative():
                narrowed = [meet(operands[0], (-z[1], -z[0]))]
            case Sum():
                narrowed = _terms(operands, z)
            case Product(left, right) if left == right:
                narrowed = [whole_root(operands[0], z, 2)] * 2
            case Product():
                narrowed = [factor(operands[0], operands[1], z)]
                narrowed.append(factor(operands[1], narrowed[0], z))
            case Quotient():
                narrowed = [meet(operands[0], multiply(*z, *operands[1]))]
                narrowed.append(divisor(operands[1], narrowed[0], z))
            case Power(_, Number(exponent)) if exponent.is_integer() and 1 <= exponent <= 64:
                narrowed = [whole_root(operands[0], z, int(exponent)), operands[1]]
            case Power(_, Number(exponent)) if not exponent.is_integer():
                narrowed = [real_root(operands[0], z, exponent), operands[1]]
            case Call(function) if function in INVERSES:
                narrowed = [INVERSES[function](operands[0], z)]
            case _:
                return
        for source, interval in zip(node.operands, narrowed, strict=True):
            values[source] = interval


def _chosen(end: Array, chosen: Mask) -> Array:
    return end[chosen] if np.ndim(end) else end


def _zero(value: Interval, zero: Array) -> Interval:
    """0, or an empty interval where the value excludes it."""
    excluded = ~((value[0] <= 0.0) & (value[1] >= 0.0))
    return np.where(excluded, np.nan, zero), np.where(excluded, np.nan, zero)


def _terms(terms: Sequence[Interval], total: Interval) -> list[Interval]:
    """Each term is the total less the others, which are added up from both sides."""
    before = list(accumulate(terms[:-1], lambda a, b: add(*a, *b)))
    after = list(accumulate(terms[:0:-1], lambda a, b: add(*a, *b)))[::-1]
    narrowed = []
    for k, term in enumerate(terms):
        others = [
            side[place]
            for side, place, there in ((before, k - 1, k > 0), (after, k, k < len(terms) - 1))
            if there
        ]
        rest = others[0] if len(others) == 1 else add(*others[0], *others[1])
        narrowed.append(meet(term, add(*total, -rest[1], -rest[0])))
    return narrowed


LIMITS = SubdivisionLimits(boxes=20_000, alive=2_000)
THOROUGH = SubdivisionLimits(boxes=600_000, alive=400_000)


def search_boxes(question: Question, candidates: Candidates, thorough: bool = False) -> bool:
    """Refine every box that may hold a root. True where the roots are proven to be all.

    ``thorough``: with thirty times the boxes.
    """
    kernel = question.kernel
    ranges = [question.domain(name) for name in question.unknowns]
    hull = Hull(kernel.forms, question.unknowns, dict(zip(kernel.known, question.known, strict=True)))
    partials = [partial for partial in kernel.partials if partial is not None]
    n = len(question.unknowns)
    residual = _bounds(kernel.forms, question, (n,))
    jacobian = _bounds(partials, question, (n, n))
    limits = THOROUGH if thorough else LIMITS
    found = branch_and_prune(residual, jacobian, ranges, limits, hull.contract)
    for root in found.roots:
        candidates.refine(list(root))
    return found.complete


def _bounds(forms: Sequence[Expression], question: Question, shape: tuple[int, ...]) -> BoxFunction:
    """Bounds (k, *shape) of as many forms over boxes (k, n), compiled."""
    emitter = IntervalEmitter(question.unknowns, question.kernel.known, ARRAYS)
    ends = [end for form in forms for end in emitter.of(form)]
    compiled = emitter.function(", ".join(ends))
    known = [np.float64(number) for number in question.known]

    def bounds(low: Array, high: Array) -> tuple[Array, Array]:
        corners = [corner[:, i] for i in range(low.shape[1]) for corner in (low, high)]
        found = [np.broadcast_to(end, len(low)) for end in compiled(*corners, *known)]
        below, above = np.stack(found[0::2], 1), np.stack(found[1::2], 1)
        return below.reshape(-1, *shape), above.reshape(-1, *shape)

    return bounds
