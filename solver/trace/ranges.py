"""Ranges of the numbers of a record over spans of rows, and the conditions that hold in all of
them.

The ends of a result come from the ends of its operands by the operation used for rows. As rounding
is monotonic, they enclose the results of every row of the span (R. E. Moore, Interval Analysis,
1966, without outward rounding); those of functions with errors in the last places are moved
outward. So a condition that holds for a span holds in each of its rows. If a number might be
undefined or infinite, both ends are nan, and so are those of all results computed from it;
comparisons with it are undecided.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial, reduce
from math import isfinite
from typing import Any, TypeAlias

import numpy as np

from rulesheets.functions import ARRAYS, TABLE
from rulesheets.functions.intervals import ULPS, Monotone, Wave, may_contain
from solver.trace.flow import Flow
from solver.trace.graph import DEGREE, schedule

Pair: TypeAlias = tuple[Any, Any]
"""The least and the largest number (spans,); of a condition where it surely holds and where it
surely does not, masks (spans,). Constants are the same for all spans."""

OUTWARD = 16.0 * 2.0**-52
"""How far functions may be off, relative to their value, or to 1 where that is less."""
FAR = 1e9
"""Angles up to which sines and cosines are as exact as that."""


class Ranges:
    """Pairs of some nodes of a graph."""

    def __init__(self, flow: Flow, wanted: Sequence[int]) -> None:
        self.wanted = wanted
        order, last = schedule(flow, wanted)
        self._inputs, self._known = dict[int, int](), dict[int, Pair]()
        for node in last.keys() - set(order):
            kind, value, *_ = flow.nodes[node]
            if kind == "input":
                self._inputs[node] = int(value)
            else:
                true = np.bool_(value), np.bool_(not value)
                self._known[node] = true if isinstance(value, bool) else (np.float64(value),) * 2
        self._steps = []
        for at, node in enumerate(order):
            parts = flow.operands[node]
            done = [part for part in dict.fromkeys(parts) if last[part] == at]
            self._steps.append((node, _form(flow, node), parts, done))

    @np.errstate(all="ignore")
    def __call__(self, inputs: Sequence[Pair]) -> list[Pair]:
        """The pairs of the wanted nodes, from those of the inputs by place."""
        found = self._known | {node: inputs[place] for node, place in self._inputs.items()}
        for node, form, parts, done in self._steps:
            low, high = form(*(found[part] for part in parts))
            if low.dtype != bool and not isfinite(np.add.reduce(high - low)):
                finite = np.isfinite(high - low)
                low, high = np.where(finite, low, np.nan), np.where(finite, high, np.nan)
            found[node] = low, high
            for part in done:
                del found[part]
        return [found[node] for node in self.wanted]


def _form(flow: Flow, node: int) -> Callable[..., Pair]:
    """The pair of an operation from those of its operands."""
    kind, *rest = flow.nodes[node]
    if kind == "unfolded":
        return partial(_within, flow.finders[int(rest[0])])
    name = str(rest[0] if kind == "call" else kind)
    if kind == "mul" and rest[0] == rest[1]:
        return lambda a, _: _square(a)
    if name in _FORMS:
        return _FORMS[name]
    row = TABLE.get(name)
    if row is not None and isinstance(row.interval, Wave):
        return partial(_wave, row.interval, ARRAYS[name])
    if row is not None and isinstance(row.interval, Monotone) and row.interval.ulps <= ULPS:
        return partial(_monotone, ARRAYS[name])
    return lambda *_: (np.array(np.nan), np.array(np.nan))


def _wave(form: Wave, function: Callable[..., Any], a: Pair) -> Pair:
    """A sine is between its ends, if no maximum and no minimum may lie in between."""
    first, last, one, other = a[0] / form.turn, a[1] / form.turn, function(a[0]), function(a[1])
    low = np.where(may_contain(first, last, form.top + 0.5), -1.0, np.minimum(one, other))
    high = np.where(may_contain(first, last, form.top), 1.0, np.maximum(one, other))
    return _outward(np.where(_size(a)[1] > FAR, np.nan, low), high)


def _outward(low: Any, high: Any) -> Pair:
    off = OUTWARD * np.maximum(np.maximum(abs(low), abs(high)), 1.0)
    return low - off, high + off


def _monotone(function: Callable[..., Any], a: Pair) -> Pair:
    """A function that is monotone wherever it has a value."""
    one, other = function(a[0]), function(a[1])
    return _outward(np.minimum(one, other), np.maximum(one, other))


def _hull(*corners: Any) -> Pair:
    return reduce(np.minimum, corners), reduce(np.maximum, corners)


def _product(a: Pair, b: Pair) -> Pair:
    for number, (low, high) in ((a, b), (b, a)):
        if number[0] is number[1]:  # a constant
            one, other = number[0] * low, number[0] * high
            return (one, other) if number[0] >= 0.0 else (other, one)
    return _hull(a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1])


def _square(a: Pair) -> Pair:
    low, high = _size(a)
    return low * low, high * high


def _quotient(a: Pair, b: Pair) -> Pair:
    low, high = _hull(a[0] / b[0], a[0] / b[1], a[1] / b[0], a[1] / b[1])
    return np.where((b[0] > 0.0) | (b[1] < 0.0), low, np.nan), high


def _size(a: Pair) -> Pair:
    return np.maximum(np.maximum(a[0], -a[1]), 0.0), np.maximum(-a[0], a[1])


def _power(base: Pair, exponent: Pair) -> Pair:
    low, high = _hull(*(x**y for x in base for y in exponent))
    return np.where(base[0] > 0.0, low * (1.0 - OUTWARD), np.nan), high * (1.0 + OUTWARD)


def _direction(y: Pair, x: Pair) -> Pair:
    """Away from the cut the corners bound it."""
    low, high = _hull(*(np.arctan2(one, other) for one in y for other in x))
    away = (y[0] > 0.0) | (y[1] < 0.0) | (x[0] > 0.0)
    return _outward(np.where(away, low, np.nan), high)


def _degrees(y: Pair, x: Pair) -> Pair:
    low, high = _direction(y, x)
    return _outward(low * DEGREE, high * DEGREE)


def _chosen(condition: Pair, a: Pair, b: Pair) -> Pair:
    """One of two pairs, or their hull."""
    upper = np.minimum if np.asarray(a[0]).dtype == bool else np.maximum
    low, high = (
        np.where(condition[0], one, np.where(condition[1], other, join(one, other)))
        for one, other, join in zip(a, b, (np.minimum, upper), strict=True)
    )
    return low, high


def _within(finder: Any, *known: Pair) -> Pair:
    """Whether the known numbers of a block lie in ranges with a known number of roots."""
    ends = tuple(zip(*known, strict=True))
    if not (held := finder.covers(*ends)).all():
        for some in ends:
            finder.array(*some)
        held = finder.covers(*ends)
    return held, np.zeros_like(held)


_FORMS: dict[str, Callable[..., Pair]] = {
    "neg": lambda a: (-a[1], -a[0]),
    "add": lambda a, b: (a[0] + b[0], a[1] + b[1]),
    "sub": lambda a, b: (a[0] - b[1], a[1] - b[0]),
    "mul": _product,
    "div": _quotient,
    "abs": _size,
    "sqrt": lambda a: (np.sqrt(a[0]), np.sqrt(a[1])),
    "rint": lambda a: (np.rint(a[0]), np.rint(a[1])),
    "max": lambda a, b: (np.maximum(a[0], b[0]), np.maximum(a[1], b[1])),
    "expm1": lambda a: _monotone(np.expm1, a),
    "log1p": lambda a: _monotone(np.log1p, a),
    "pow": _power,
    "direction": _direction,
    "directiond": _degrees,
    "atan2": _direction,
    "atan2d": _degrees,
    "where": _chosen,
    "lt": lambda a, b: (a[1] < b[0], a[0] >= b[1]),
    "le": lambda a, b: (a[1] <= b[0], a[0] > b[1]),
    "eq": lambda a, b: ((a[1] == b[0]) & (a[0] == b[1]), (a[1] < b[0]) | (b[1] < a[0])),
    "finite": lambda a: (np.isfinite(a[1] - a[0]), np.False_),
    "and": lambda a, b: (a[0] & b[0], a[1] | b[1]),
    "or": lambda a, b: (a[0] | b[0], a[1] & b[1]),
    "xor": lambda a, b: (a[0] & b[1] | a[1] & b[0], a[0] & b[0] | a[1] & b[1]),
    "not": lambda a: (a[1], a[0]),
}
