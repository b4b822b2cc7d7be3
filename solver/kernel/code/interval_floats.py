"""What compiled interval code calls on one box of floats: the rules of ``interval_arrays``, without numpy."""

from __future__ import annotations

from math import inf, isfinite, isnan

from rulesheets.functions.intervals.arithmetic import add, divide, multiply, power, scaled, square, within
from rulesheets.functions.intervals.bounds import EMPTY, Interval, greatest
from rulesheets.functions.intervals.bounds import least as smaller
from rulesheets.functions.intervals.floats import FLOAT_INTERVALS
from rulesheets.functions.intervals.forms import cut
from solver.kernel.code.interval_code import Operations


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


FLOATS = Operations(
    float,
    FLOAT_INTERVALS,
    {
        "isnan": isnan,
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
