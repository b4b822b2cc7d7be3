"""What compiled interval code calls on arrays of boxes; callers silence numpy's warnings once."""

from __future__ import annotations

import numpy as np

from rulesheets.functions.intervals.arrays import (
    INTERVALS,
    Array,
    Interval,
    Mask,
    add,
    divide,
    multiply,
    power,
    scaled,
    square,
)
from solver.kernel.code.interval_code import Operations


def cut(y_low: Array, y_high: Array, x_low: Array, _: Array) -> Mask:
    """Where the direction of (x, y) may jump from one half turn to the other, or is undefined."""
    return ~((y_low > 0.0) | (y_high < 0.0) | (x_low > 0.0))


def bounded(
    low: Array, high: Array, least: float, most: float, empty: Mask, doubtful: Mask
) -> tuple[Array, Array, Mask, Mask]:
    """What lies between ``least`` and ``most``."""
    outside = (high < least) | (low > most)
    doubtful = doubtful | (low < least) | (high > most)
    low, high = np.maximum(low, least), np.minimum(high, most)
    empty = empty | outside | np.isnan(low) | np.isnan(high)
    return np.where(empty, np.nan, low), np.where(empty, np.nan, high), empty, doubtful


def quotient(
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


def within(a_low: Array, a_high: Array, b_low: Array, b_high: Array) -> Interval:
    """What two enclosures of one quantity have in common."""
    return np.fmax(a_low, b_low), np.fmin(a_high, b_high)


def from_zero(low: Array, high: Array) -> Interval:
    """The hull of 0 and a box."""
    return np.minimum(low, 0.0), np.maximum(high, 0.0)


def by_slopes(a_low: Array, a_high: Array, b_low: Array, b_high: Array) -> Interval:
    """The quotient of two slopes where both are bounded: where they are not, they may not be defined."""
    low, high = divide(a_low, a_high, b_low, b_high)
    known = np.isfinite(a_low) & np.isfinite(a_high) & np.isfinite(b_low) & np.isfinite(b_high)
    return np.where(known, low, np.nan), np.where(known, high, np.nan)


ARRAYS = Operations(
    np.float64,
    INTERVALS,
    {
        "isnan": np.isnan,
        "add": add,
        "divide": divide,
        "multiply": multiply,
        "power": power,
        "square": square,
        "scaled": scaled,
        "cut": cut,
        "bounded": bounded,
        "quotient": quotient,
        "within": within,
        "from_zero": from_zero,
        "by_slopes": by_slopes,
    },
)
