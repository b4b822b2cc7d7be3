"""Intervals as pairs of floats, and rounding outward.

Infinite ends mean unbounded, two nan mean empty; one nan alone is an end that nothing is known of. Every
operation contains the exact result of every choice of real arguments from its intervals for which it is
defined; where there is none it is empty, and an empty argument makes the result empty.
"""

from __future__ import annotations

from math import inf, isnan, nan, nextafter
from typing import TypeAlias

Interval: TypeAlias = tuple[float, float]

EMPTY = nan, nan
ULPS = 4.0
"""What functions of the C library are trusted to, in units in the last place, as those of numpy are."""
EPSILON = 2.0**-52


def down(x: float, ulps: float = 1.0) -> float:
    """A bound below every number whose floating-point result is within ``ulps`` of x."""
    lower = nextafter(x, -inf)
    return lower if ulps <= 1.0 else lower - abs(lower) * (ulps * EPSILON)


def up(x: float, ulps: float = 1.0) -> float:
    """A bound above every number whose floating-point result is within ``ulps`` of x."""
    upper = nextafter(x, inf)
    return upper if ulps <= 1.0 else upper + abs(upper) * (ulps * EPSILON)


def magnitudes(low: float, high: float) -> Interval:
    """Range of the absolute value, exact."""
    if low >= 0.0:
        return low, high
    if high <= 0.0:
        return -high, -low
    if low < 0.0 < high:
        return 0.0, max(-low, high)
    return EMPTY if isnan(low) and isnan(high) else (0.0, inf)


def least(a: float, b: float) -> float:
    """The smaller one; nan where one of them is."""
    return a if a < b or isnan(a) else b


def greatest(a: float, b: float) -> float:
    """The larger one; nan where one of them is."""
    return a if a > b or isnan(a) else b


def clipped(low: float, high: float, domain: tuple[float, float]) -> Interval:
    """The part within ``domain``; empty where there is none."""
    low, high = greatest(low, domain[0]), least(high, domain[1])
    return EMPTY if low > high else (low, high)
