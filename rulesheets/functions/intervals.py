"""Intervals as pairs of floats, rounded outward.

Infinite ends mean unbounded, two nan mean empty; a single nan is an unknown end. Every operation
contains the exact result for every choice of real arguments from its intervals for which it is
defined; if there is none it is empty, and an empty argument makes the result empty. (R. E. Moore,
R. B. Kearfott, M. J. Cloud, *Introduction to Interval Analysis*, 2009.)
"""

from __future__ import annotations

from collections.abc import Callable
from math import copysign, fmod, hypot, inf, isinf, isnan, nan, nextafter
from typing import Any, NamedTuple, TypeAlias

Interval: TypeAlias = tuple[float, float]

EMPTY = nan, nan
ULPS = 4.0
"""The assumed error of functions of the C library, and of numpy, in units in the last place."""
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
    """The range of the absolute value, exact."""
    if low >= 0.0:
        return low, high
    if high <= 0.0:
        return -high, -low
    if low < 0.0 < high:
        return 0.0, max(-low, high)
    return EMPTY if isnan(low) and isnan(high) else (0.0, inf)


def least(a: float, b: float) -> float:
    """The smaller one; nan if either is."""
    return a if a < b or isnan(a) else b


def greatest(a: float, b: float) -> float:
    """The larger one; nan if either is."""
    return a if a > b or isnan(a) else b


def add(a_low: float, a_high: float, b_low: float, b_high: float) -> Interval:
    """Sum. A float sum that is 0 is exact (it cannot underflow) and stays 0, and so do exact sums
    of numbers: exponents may be whole ones."""
    low, high = a_low + b_low, a_high + b_high
    if a_low == a_high and b_low == b_high and low - a_low == b_low and low - b_low == a_low:
        return low, low
    return nextafter(low, -inf) if low else 0.0, nextafter(high, inf) if high else 0.0


def multiply(a_low: float, a_high: float, b_low: float, b_high: float) -> Interval:
    """Product; 0 times an unbounded interval is 0."""
    if a_low > 0.0 < b_low:
        low, high = a_low * b_low, a_high * b_high
        if low > 0.0 and high == high:
            return nextafter(low, -inf), nextafter(high, inf)
    corners = a_low * b_low, a_low * b_high, a_high * b_low, a_high * b_high
    return _hull(*corners, a_low, a_high, b_low, b_high)


def divide(a_low: float, a_high: float, b_low: float, b_high: float) -> Interval:
    """The quotient over the divisors that are not 0: a half line if 0 is an end of the divisor."""
    if a_low > 0.0 < b_low:
        low, high = a_low / b_high, a_high / b_low
        if low > 0.0 and high == high:
            return nextafter(low, -inf), nextafter(high, inf)
    if b_low > 0.0 or b_high < 0.0:
        corners = a_low / b_low, a_low / b_high, a_high / b_low, a_high / b_high
        return _hull(*corners, a_low, a_high, b_low, b_high)
    if isnan(a_low) or isnan(b_low) or b_low == b_high == 0.0:
        return EMPTY
    if b_low < 0.0 < b_high and not a_low == a_high == 0.0:
        return -inf, inf
    b_low, b_high = b_low or 0.0, b_high or -0.0
    first, second, third, fourth = (
        _quotient(a, b) for a in (a_low, a_high) for b in (b_low, b_high)
    )
    return _hull(first, second, third, fourth, a_low, a_high, b_low, b_high)


def both(a_low: float, a_high: float, b_low: float, b_high: float) -> Interval:
    """The intersection of two enclosures of the same value; the first if the second is unknown."""
    if isnan(b_low) or isnan(b_high):
        return a_low, a_high
    return greatest(a_low, b_low), least(a_high, b_high)


def _quotient(a: float, b: float) -> float:
    """a/b; infinite if b is a zero and a is not, with the sign of the quotient."""
    if b:
        return a / b
    return copysign(inf, a) * copysign(1.0, b) if a else nan


def _hull(
    first: float,
    second: float,
    third: float,
    fourth: float,
    a_low: float,
    a_high: float,
    b_low: float,
    b_high: float,
) -> Interval:
    """The least and the greatest of four corners, rounded outward, but not across 0 if the signs of
    a and b exclude that; an indeterminate corner (0*inf, 0/0, inf/inf) counts as 0."""
    low, high = (first, second) if first < second else (second, first)
    low, high = (third, high) if third < low else (low, third if third > high else high)
    low, high = (fourth, high) if fourth < low else (low, fourth if fourth > high else high)
    total = first + second + third + fourth
    if total != total:
        if isnan(a_low) or isnan(b_low):
            return EMPTY
        if isnan(a_high) or isnan(b_high):
            return -inf, inf
        corners = [0.0 if isnan(corner) else corner for corner in (first, second, third, fourth)]
        low, high = min(corners), max(corners)
    if low and high:
        return nextafter(low, -inf), nextafter(high, inf)
    alike = (a_low >= 0.0 and b_low >= 0.0) or (a_high <= 0.0 and b_high <= 0.0)
    opposed = (a_low >= 0.0 and b_high <= 0.0) or (a_high <= 0.0 and b_low >= 0.0)
    below = nextafter(low, -inf) if low or not alike else 0.0
    return below, nextafter(high, inf) if high or not opposed else 0.0


def square(low: float, high: float) -> Interval:
    """The product of a number with itself, which is never negative."""
    small, large = magnitudes(low, high)
    below = small * small
    return nextafter(below, -inf) if below else 0.0, nextafter(large * large, inf) if large else 0.0


def scaled(factor: float, _: float, low: float, high: float) -> Interval:
    """A number times an interval, rounded outward but not across 0."""
    if factor == 0.0:
        return EMPTY if isnan(low) else (0.0, 0.0)
    if low == high and factor % 1.0 == 0.0 == low % 1.0 and abs(factor * low) < WHOLE:
        return factor * low, factor * low
    first, last = (low, high) if factor > 0.0 else (-high, -low)
    size = abs(factor)
    below, above = nextafter(size * first, -inf), nextafter(size * last, inf)
    below = 0.0 if first >= 0.0 and below < 0.0 else below
    return below, 0.0 if last <= 0.0 and above > 0.0 else above


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
    """The power, infinite if it overflows or has a pole; for a base below 0 and an odd exponent."""
    try:
        return float(base**exponent)
    except (OverflowError, ZeroDivisionError):
        return inf if base >= 0.0 else -inf


def _real_power(a_low: float, a_high: float, b_low: float, b_high: float) -> Interval:
    """Corners suffice: for a base of 0 or more the power is monotone in either argument.

    A negative base has a power only for whole exponents. If the exponent may be one, the powers of
    the magnitude, of both signs, are included.
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


SPECIAL_ULPS = 32.0
"""The assumed error of special functions."""
LINE = -inf, inf
UNIT, POSITIVE = (-1.0, 1.0), (0.0, inf)
SLACK = 8.0 * EPSILON
"""The possible error of a number of turns, relative to it or to one."""


def unknown(*ends: float) -> Interval:
    """The range of a function about which nothing is known."""
    return EMPTY if any(isnan(low) for low in ends[::2]) else LINE


class Monotone(NamedTuple):
    """The range of a monotone function; ``image`` has ends that are exact floats.

    If ``value`` raises at an end of its domain, or overflows, its value is the nearer end of the
    image.
    """

    value: Callable[[float], float]
    domain: tuple[float, float] = LINE
    image: tuple[float, float] = LINE
    ulps: float = ULPS
    falling: bool = False

    def __call__(self, low: float, high: float) -> Interval:
        low, high = greatest(low, self.domain[0]), least(high, self.domain[1])
        if low > high or (low == high and low in self.domain and self._is_pole(low)):
            return EMPTY
        first, last = (high, low) if self.falling else (low, high)
        below, above = down(self._at(first), self.ulps), up(self._at(last), self.ulps)
        return greatest(below, self.image[0]), least(above, self.image[1])

    def _is_pole(self, x: float) -> bool:
        return not isinf(x) and isinf(self._at(x))

    def _at(self, x: float) -> float:
        if isnan(x):
            return nan
        try:
            return self.value(x)
        except (OverflowError, ValueError):
            small = x <= self.domain[0] or (x < 0.0 and x < self.domain[1])
            return self.image[0] if small is not self.falling else self.image[1]


class Even(NamedTuple):
    """The range of an even function, from that for arguments that are not negative."""

    rising: Monotone

    def __call__(self, low: float, high: float) -> Interval:
        return self.rising(*magnitudes(low, high))


# --- angles ---------------------------------------------------------------------


def may_contain(low: Any, high: Any, offset: float) -> Any:
    """Whether a whole number plus ``offset`` may lie between two finite numbers of turns, or arrays
    of them."""
    first = low - offset - SLACK * (abs(low) + 1.0)
    return -(-first // 1.0) <= (high - offset + SLACK * (abs(high) + 1.0)) // 1.0


class Wave(NamedTuple):
    """Range of a sine of period ``turn`` with its maxima at ``top`` turns."""

    value: Callable[[float], float]
    turn: float
    top: float

    def __call__(self, low: float, high: float) -> Interval:
        if isnan(low):
            return EMPTY
        if isinf(low) or isinf(high) or isnan(high):
            return -1.0, 1.0
        first, last = low / self.turn, high / self.turn
        at_low, at_high = self.value(low), self.value(high)
        below, above = down(min(at_low, at_high), ULPS), up(max(at_low, at_high), ULPS)
        if above > 1.0 or may_contain(first, last, self.top):
            above = 1.0
        if below < -1.0 or may_contain(first, last, self.top + 0.5):
            below = -1.0
        return below, above


def cut(y_low: float, y_high: float, x_low: float, _: float) -> bool:
    """Whether the direction of (x, y) may jump by a full turn, or is undefined."""
    return not (y_low > 0.0 or y_high < 0.0 or x_low > 0.0)


def ratio(a_low: float, a_high: float, b_low: float, b_high: float) -> Interval:
    """a/sqrt(a^2 + b^2): the cosine of the direction of a point (a, b), the sine of that of
    (b, a)."""
    if isnan(a_low) or isnan(b_low) or a_low == a_high == b_low == b_high == 0.0:
        return EMPTY
    if isnan(a_high) or isnan(b_high):
        return -1.0, 1.0
    near, far = magnitudes(b_low, b_high)
    below = down(_ratio(a_low, near if a_low < 0.0 else far), ULPS)
    above = up(_ratio(a_high, far if a_high < 0.0 else near), ULPS)
    return max(below, 0.0 if a_low >= 0.0 else -1.0), min(above, 0.0 if a_high <= 0.0 else 1.0)


def _ratio(a: float, b: float) -> float:
    if isinf(a) and not isinf(b):
        return copysign(1.0, a)
    return a / hypot(a, b) if a and not isinf(b) else 0.0


# --- jumps and kinks; all but mod are exact ----------------------------


def each_end(value: Callable[[float], float]) -> Callable[[float, float], Interval]:
    """The range of an increasing function that floats compute exactly."""

    def at(x: float) -> float:
        try:
            return x if isnan(x) else value(x)
        except OverflowError:  # of the whole part of an infinite number
            return x

    return lambda low, high: (at(low), at(high))


def step(x_low: float, x_high: float, a_low: float, a_high: float) -> Interval:
    if isnan(x_low) or isnan(a_low):
        return EMPTY
    return 1.0 if x_low >= a_high else 0.0, 0.0 if x_high < a_low else 1.0


def mod(x_low: float, x_high: float, y_low: float, y_high: float) -> Interval:
    """The remainder: the sign of x, smaller than y; exact within a period of a fixed y."""
    reach = magnitudes(y_low, y_high)[1]
    if isnan(x_low) or isnan(y_low) or reach == 0.0:
        return EMPTY
    one_sign = x_low >= 0.0 or x_high <= 0.0
    if y_low == y_high and one_sign and nextafter(x_high - x_low, inf) < abs(y_low):
        at_low, at_high = fmod(x_low, y_low), fmod(x_high, y_low)
        if at_low <= at_high:
            return at_low, at_high
    return -least(max(-x_low, 0.0), reach), least(max(x_high, 0.0), reach)
