"""Interval operations that compiled code calls, on one box of floats and on arrays of boxes.

Callers of those on arrays silence numpy's warnings once.
"""

from __future__ import annotations

from math import inf, isfinite, isnan

import numpy as np

from rulesheets.evaluate.number import FLOAT_INTERVALS
from rulesheets.functions import intervals
from rulesheets.functions.intervals import EMPTY, Interval, arrays, divide, greatest
from rulesheets.functions.intervals import least as smaller
from rulesheets.functions.intervals.arrays import INTERVALS, Array, Mask, box_by_box
from rulesheets.functions.intervals.forms import cut
from solver.kernel.emitter import Operations

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


def from_zero(low: float, high: float) -> Interval:
    """The hull of 0 and a box."""
    return smaller(low, 0.0), greatest(high, 0.0)


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


def all_within(a_low: Array, a_high: Array, b_low: Array, b_high: Array) -> tuple[Array, Array]:
    """What two enclosures of one quantity have in common."""
    return np.fmax(a_low, b_low), np.fmin(a_high, b_high)


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
        "from_zero": from_zero,
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
        "quotient": box_by_box(quotient),
        "within": all_within,
        "from_zero": box_by_box(from_zero),
        "by_slopes": box_by_box(by_slopes),
    },
)
