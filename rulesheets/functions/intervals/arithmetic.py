"""Sums, products, quotients and powers of intervals, rounded outward (Moore, Kearfott & Cloud 2009)."""

from __future__ import annotations

import numpy as np

from rulesheets.functions.intervals.bounds import (
    NUMPY_ULPS,
    Array,
    Interval,
    Mask,
    down,
    magnitudes,
    quiet,
    up,
    where_not,
)


def negate(low: Array, high: Array) -> Interval:
    return -high, -low


@quiet
def add(a_low: Array, a_high: Array, b_low: Array, b_high: Array) -> Interval:
    """Sum. A float sum that is 0 is exact (it cannot underflow) and stays 0."""
    low, high = a_low + b_low, a_high + b_high
    return np.where(low == 0.0, 0.0, down(low)), np.where(high == 0.0, 0.0, up(high))


def subtract(a_low: Array, a_high: Array, b_low: Array, b_high: Array) -> Interval:
    return add(a_low, a_high, -b_high, -b_low)


def _hull(corners: tuple[Array, Array, Array, Array]) -> Interval:
    """Least and greatest of four corners; an indeterminate one (0*inf, 0/0, inf/inf) counts as 0."""
    first, second, third, fourth = (np.where(np.isnan(corner), 0.0, corner) for corner in corners)
    low = np.minimum(np.minimum(first, second), np.minimum(third, fourth))
    return low, np.maximum(np.maximum(first, second), np.maximum(third, fourth))


def _signed(low: Array, high: Array, a: Interval, b: Interval) -> Interval:
    """Bounds rounded outward, but not across 0 where the signs of a and b exclude that."""
    alike = (a[0] >= 0.0) & (b[0] >= 0.0) | (a[1] <= 0.0) & (b[1] <= 0.0)
    opposed = (a[0] >= 0.0) & (b[1] <= 0.0) | (a[1] <= 0.0) & (b[0] >= 0.0)
    low, high = down(low), up(high)
    return np.where(alike, np.maximum(low, 0.0), low), np.where(opposed, np.minimum(high, 0.0), high)


def _any_nan(ends: tuple[Array, ...]) -> Mask:
    result = np.isnan(ends[0])
    for end in ends[1:]:
        result = result | np.isnan(end)
    return result


@quiet
def multiply(a_low: Array, a_high: Array, b_low: Array, b_high: Array) -> Interval:
    """Product; 0 times an unbounded interval is 0."""
    low, high = _hull((a_low * b_low, a_low * b_high, a_high * b_low, a_high * b_high))
    low, high = _signed(low, high, (a_low, a_high), (b_low, b_high))
    return where_not(_any_nan((a_low, b_low)), low, high)


@quiet
def divide(a_low: Array, a_high: Array, b_low: Array, b_high: Array) -> Interval:
    """Quotient over the divisors that are not 0: a half line where 0 is an end of the divisor."""
    b_low = np.where(b_low == 0.0, 0.0, b_low)
    b_high = np.where(b_high == 0.0, -0.0, b_high)
    low, high = _hull((a_low / b_low, a_low / b_high, a_high / b_low, a_high / b_high))
    low, high = _signed(low, high, (a_low, a_high), (b_low, b_high))
    nothing = (a_low == 0.0) & (a_high == 0.0)
    across = (b_low < 0.0) & (b_high > 0.0) & ~nothing
    low, high = np.where(across, -np.inf, low), np.where(across, np.inf, high)
    by_zero = (b_low == 0.0) & (b_high == 0.0)
    return where_not(by_zero | _any_nan((a_low, b_low)), low, high)


@quiet
def power(a_low: Array, a_high: Array, b_low: Array, b_high: Array) -> Interval:
    """``a^b``: tight for whole exponents; for others over bases of 0 or more."""
    whole = (b_low == b_high) & (b_low == np.rint(b_low))
    if np.all(whole):
        return _whole_power(a_low, a_high, b_low)
    real = _real_power(a_low, a_high, b_low, b_high)
    if not np.any(whole):
        return real
    integer = _whole_power(a_low, a_high, np.where(whole, b_low, 1.0))
    return np.where(whole, integer[0], real[0]), np.where(whole, integer[1], real[1])


def _whole_power(low: Array, high: Array, exponent: Array) -> Interval:
    count = np.abs(exponent)
    even = np.fmod(count, 2.0) == 0.0
    least, greatest = magnitudes(low, high)
    first, last = np.where(even, least, low), np.where(even, greatest, high)
    below = down(np.power(first, count), NUMPY_ULPS)
    above = up(np.power(last, count), NUMPY_ULPS)
    below = np.where(first >= 0.0, np.maximum(below, 0.0), below)
    above = np.where(last <= 0.0, np.minimum(above, 0.0), above)
    below, above = np.where(count == 1.0, low, below), np.where(count == 1.0, high, above)
    one = np.ones(())
    inverse = divide(one, one, below, above)
    below = np.where(exponent < 0.0, inverse[0], below)
    above = np.where(exponent < 0.0, inverse[1], above)
    unit = (exponent == 0.0) & ~np.isnan(low)
    return np.where(unit, 1.0, below), np.where(unit, 1.0, above)


def _real_power(a_low: Array, a_high: Array, b_low: Array, b_high: Array) -> Interval:
    """Corners suffice: for a base of 0 or more the power is monotone in either argument.

    A negative base has a power at whole exponents only. Where the exponent may be one, the
    powers of the magnitude, of both signs, are included.
    """
    odd = (a_low < 0.0) & (np.ceil(b_low) <= np.floor(b_high))
    reach = np.where(odd, np.maximum(-a_low, a_high), a_high)
    base = np.maximum(a_low, 0.0), np.maximum(reach, 0.0)
    corners = tuple(np.power(x, y) for x in base for y in (b_low, b_high))
    low = np.maximum(down(np.minimum.reduce(corners), NUMPY_ULPS), 0.0)
    high = up(np.maximum.reduce(corners), NUMPY_ULPS)
    low = np.where(odd, -high, low)
    nowhere = (a_high < 0.0) & ~odd | (base[1] == 0.0) & (b_high < 0.0)
    return where_not(nowhere | _any_nan((a_low, b_low)), low, high)
