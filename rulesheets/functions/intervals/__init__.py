"""Intervals as pairs of floats, and rounding outward.

Infinite ends mean unbounded, two nan mean empty; one nan alone is an end that nothing is known of. Every
operation contains the exact result of every choice of real arguments from its intervals for which it is
defined; where there is none it is empty, and an empty argument makes the result empty. One box at a time;
``arrays`` does the same to many boxes, each operation a few dozen times as fast on them. (R. E. Moore, R. B.
Kearfott, M. J. Cloud, *Introduction to Interval Analysis*, 2009.)
"""

from __future__ import annotations

from math import copysign, inf, isinf, isnan, nan, nextafter
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


def add(a_low: float, a_high: float, b_low: float, b_high: float) -> Interval:
    """Sum. A float sum that is 0 is exact (it cannot underflow) and stays 0, and so do exact sums of numbers:
    exponents may be whole ones."""
    low, high = a_low + b_low, a_high + b_high
    if a_low == a_high and b_low == b_high and low - a_low == b_low and low - b_low == a_low:
        return low, low
    return nextafter(low, -inf) if low else 0.0, nextafter(high, inf) if high else 0.0


def multiply(a_low: float, a_high: float, b_low: float, b_high: float) -> Interval:
    """Product; 0 times an unbounded interval is 0."""
    if isnan(a_low) or isnan(b_low):
        return EMPTY
    return _hull(
        a_low * b_low, a_low * b_high, a_high * b_low, a_high * b_high, (a_low, a_high), (b_low, b_high)
    )


def divide(a_low: float, a_high: float, b_low: float, b_high: float) -> Interval:
    """Quotient over the divisors that are not 0: a half line where 0 is an end of the divisor."""
    if isnan(a_low) or isnan(b_low) or b_low == b_high == 0.0:
        return EMPTY
    if b_low < 0.0 < b_high and not a_low == a_high == 0.0:
        return -inf, inf
    b_low, b_high = b_low or 0.0, b_high or -0.0
    return _hull(
        _quotient(a_low, b_low),
        _quotient(a_low, b_high),
        _quotient(a_high, b_low),
        _quotient(a_high, b_high),
        (a_low, a_high),
        (b_low, b_high),
    )


def _quotient(a: float, b: float) -> float:
    """a/b; infinite where b is a zero and a is not, with the sign that both make."""
    if b:
        return a / b
    return copysign(inf, a) * copysign(1.0, b) if a else nan


def _hull(first: float, second: float, third: float, fourth: float, a: Interval, b: Interval) -> Interval:
    """Least and greatest of four corners, rounded outward, but not across 0 where the signs of a and b
    exclude that; an indeterminate corner (0*inf, 0/0, inf/inf) counts as 0."""
    if isnan(first + second + third + fourth):
        if isnan(a[1]) or isnan(b[1]):
            return -inf, inf
        corners = [0.0 if isnan(corner) else corner for corner in (first, second, third, fourth)]
        low, high = min(corners), max(corners)
    else:
        low, high = min(first, second, third, fourth), max(first, second, third, fourth)
    low, high = nextafter(low, -inf), nextafter(high, inf)
    if low < 0.0 and ((a[0] >= 0.0 and b[0] >= 0.0) or (a[1] <= 0.0 and b[1] <= 0.0)):
        low = 0.0
    if high > 0.0 and ((a[0] >= 0.0 and b[1] <= 0.0) or (a[1] <= 0.0 and b[0] >= 0.0)):
        high = 0.0
    return low, high


def square(low: float, high: float) -> Interval:
    """The product of a number with itself, which is never negative."""
    small, large = magnitudes(low, high)
    below, above = nextafter(small * small, -inf), nextafter(large * large, inf)
    return 0.0 if below < 0.0 else below, above if large else 0.0


def scaled(factor: float, _: float, low: float, high: float) -> Interval:
    """A number times an interval, rounded outward but not across 0."""
    if factor == 0.0:
        return EMPTY if isnan(low) else (0.0, 0.0)
    if low == high and factor % 1.0 == 0.0 == low % 1.0 and abs(factor * low) < WHOLE:
        return factor * low, factor * low
    first, last = (low, high) if factor > 0.0 else (-high, -low)
    size = abs(factor)
    below, above = nextafter(size * first, -inf), nextafter(size * last, inf)
    return (
        0.0 if first >= 0.0 and below < 0.0 else below,
        0.0 if last <= 0.0 and above > 0.0 else above,
    )


WHOLE = 2.0**53
"""Below this products of whole numbers are exact, so that exponents stay whole."""


def power(a_low: float, a_high: float, b_low: float, b_high: float) -> Interval:
    """``a^b``: tight for whole exponents; for others over bases of 0 or more."""
    if isnan(a_low) or isnan(b_low):
        return EMPTY
    if b_low == b_high and not isinf(b_low) and b_low == round(b_low):
        return _whole_power(a_low, a_high, b_low)
    return _real_power(a_low, a_high, b_low, b_high)


def _whole_power(low: float, high: float, exponent: float) -> Interval:
    if exponent == 0.0:
        return 1.0, 1.0
    count = abs(exponent)
    below, above = low, high
    if count != 1.0:
        first, last = magnitudes(low, high) if count % 2.0 == 0.0 else (low, high)
        below, above = down(_raised(first, count), ULPS), up(_raised(last, count), ULPS)
        if first >= 0.0:
            below = max(below, 0.0)
        if last <= 0.0:
            above = min(above, 0.0)
    return divide(1.0, 1.0, below, above) if exponent < 0.0 else (below, above)


def _raised(base: float, exponent: float) -> float:
    """The power as a float, infinite where it overflows or has a pole; a base below 0 has an odd exponent."""
    try:
        return float(base**exponent)
    except (OverflowError, ZeroDivisionError):
        return inf if base >= 0.0 else -inf


def _real_power(a_low: float, a_high: float, b_low: float, b_high: float) -> Interval:
    """Corners suffice: for a base of 0 or more the power is monotone in either argument.

    A negative base has a power at whole exponents only. Where the exponent may be one, the
    powers of the magnitude, of both signs, are included.
    """
    if isnan(a_high) or isnan(b_high):
        return -inf, inf
    odd = a_low < 0.0 and (isinf(b_low) or isinf(b_high) or -(-b_low // 1.0) <= b_high // 1.0)
    base = max(a_low, 0.0), max(a_high, -a_low if odd else 0.0, 0.0)
    if (a_high < 0.0 and not odd) or (base[1] == 0.0 and b_high < 0.0):
        return EMPTY
    corners = [_raised(x, y) for x in base for y in (b_low, b_high)]
    high = up(max(corners), ULPS)
    return (-high if odd else max(down(min(corners), ULPS), 0.0)), high


def within(a_low: float, a_high: float, b_low: float, b_high: float) -> Interval:
    """What two enclosures of one quantity have in common; an end that is nan says nothing."""
    low = b_low if isnan(a_low) else a_low if isnan(b_low) else greatest(a_low, b_low)
    high = b_high if isnan(a_high) else a_high if isnan(b_high) else least(a_high, b_high)
    return low, high
