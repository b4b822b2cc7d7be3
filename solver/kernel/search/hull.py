"""Boxes narrowed by the rules themselves: forward and backward through their expressions.

Forward, every part of every rule gets its range over the box; each rule says that its left minus its right is
0; backward, each part is narrowed to what its whole needs it to be, and so the unknowns are in the end. Parts
that rules have in common are one node, narrowed by all of them. (HC4-revise: F. Benhamou, F. Goualard,
L. Granvilliers & J.-F. Puget, ICLP 1999; on the graph: H. Schichl & A. Neumaier, J. Global Optimization 33
(2005) 541–562.) No root in a box is lost.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate

import numpy as np

from rulesheets.deadline import expect_time
from rulesheets.functions.intervals.arrays import (
    INTERVALS,
    Array,
    Interval,
    Mask,
    add,
    divide,
    multiply,
    power,
    square,
)
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Call, Expression, Name, Negative, Number, Power, Product, Quotient, Sum
from solver.kernel.code.interval_code import ROUNDED
from solver.kernel.search.inverse_hull import (
    INVERSES,
    divisor,
    factor,
    meet,
    real_root,
    whole_root,
)

PASSES = 4
GAIN = 0.9
"""A pass that leaves every side of a box longer than this share of it is the last one."""


@dataclass(frozen=True, slots=True)
class Node:
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
            below = tuple(map(self._place, nodes.operands(form)))
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
