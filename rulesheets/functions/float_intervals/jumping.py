"""Interval forms of the functions with jumps and kinks, on floats. All but frac and mod are exact."""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from math import fmod, inf, isinf, isnan, nextafter

from rulesheets.functions import special
from rulesheets.functions.float_intervals import bounds
from rulesheets.functions.float_intervals.bounds import EMPTY, Interval, magnitudes


def _each_end(function: Callable[[float], float]) -> Callable[[float, float], Interval]:
    """Interval form of a rising function that floats compute exactly."""

    def at(x: float) -> float:
        return x if isnan(x) or isinf(x) else function(x)

    return lambda low, high: (at(low), at(high))


int_ = _each_end(special.int_)
round_nearest = _each_end(special.round_)


def sgn(low: float, high: float) -> Interval:
    return low if isnan(low) else special.sgn(low), high if isnan(high) else special.sgn(high)


def step(x_low: float, x_high: float, a_low: float, a_high: float) -> Interval:
    if isnan(x_low) or isnan(a_low):
        return EMPTY
    return 1.0 if x_low >= a_high else 0.0, 0.0 if x_high < a_low else 1.0


def least(*ends: float) -> Interval:
    return reduce(bounds.least, ends[::2]), reduce(bounds.least, ends[1::2])


def greatest(*ends: float) -> Interval:
    return reduce(bounds.greatest, ends[::2]), reduce(bounds.greatest, ends[1::2])


def frac(low: float, high: float) -> Interval:
    return mod(low, high, 1.0, 1.0)


def mod(x_low: float, x_high: float, y_low: float, y_high: float) -> Interval:
    """Remainder: the sign of x, smaller than y, no larger than x; exact within a period of a fixed y."""
    reach = magnitudes(y_low, y_high)[1]
    if isnan(x_low) or isnan(y_low) or reach == 0.0:
        return EMPTY
    one_sign = x_low >= 0.0 or x_high <= 0.0
    if y_low == y_high and one_sign and nextafter(x_high - x_low, inf) < abs(y_low):
        at_low, at_high = fmod(x_low, y_low), fmod(x_high, y_low)
        if at_low <= at_high:
            return at_low, at_high
    return -bounds.least(max(-x_low, 0.0), reach), bounds.least(max(x_high, 0.0), reach)
