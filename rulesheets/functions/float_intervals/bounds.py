"""Intervals as pairs of floats, and rounding outward; the conventions are those of ``intervals.bounds``.

Two nan mean empty. One nan alone is an end that nothing is known of.
"""

from __future__ import annotations

from collections.abc import Callable
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


def monotone(
    function: Callable[[float], float],
    domain: tuple[float, float] = (-inf, inf),
    image: tuple[float, float] = (-inf, inf),
    ulps: float = ULPS,
    falling: bool = False,
) -> Callable[[float, float], Interval]:
    """Interval form of a monotone function; ``image`` has ends that are floats exactly.

    Where ``function`` raises at an end of its domain, or overflows, its value is the nearer end of the image.
    """

    def enclosure(low: float, high: float) -> Interval:
        low, high = clipped(low, high, domain)
        first, last = (high, low) if falling else (low, high)
        return greatest(down(at(first), ulps), image[0]), least(up(at(last), ulps), image[1])

    def at(x: float) -> float:
        if isnan(x):
            return nan
        try:
            return function(x)
        except (OverflowError, ValueError):
            small = x <= domain[0] or (x < 0.0 and x < domain[1])
            return image[0] if small is not falling else image[1]

    return enclosure
