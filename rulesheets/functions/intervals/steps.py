"""Interval forms of the functions with jumps and kinks. All but frac and mod are exact."""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce

import numpy as np

from rulesheets.functions.arrays import round_
from rulesheets.functions.intervals.bounds import Array, Interval, magnitudes, quiet, up, where_not


def _each_end(function: Callable[[Array], Array]) -> Callable[[Array, Array], Interval]:
    """Interval form of a rising function that floats compute exactly."""

    @quiet
    def enclosure(low: Array, high: Array) -> Interval:
        return function(low), function(high)

    return enclosure


sgn = _each_end(np.sign)
int_ = _each_end(np.trunc)
round_nearest = _each_end(round_)


@quiet
def step(x_low: Array, x_high: Array, a_low: Array, a_high: Array) -> Interval:
    low = np.where(x_low >= a_high, 1.0, 0.0)
    high = np.where(x_high >= a_low, 1.0, 0.0)
    return where_not(np.isnan(x_low) | np.isnan(a_low), low, high)


def least(*ends: Array) -> Interval:
    return reduce(np.minimum, ends[::2]), reduce(np.minimum, ends[1::2])


def greatest(*ends: Array) -> Interval:
    return reduce(np.maximum, ends[::2]), reduce(np.maximum, ends[1::2])


def frac(low: Array, high: Array) -> Interval:
    one = np.ones(())
    return mod(low, high, one, one)


@quiet
def mod(x_low: Array, x_high: Array, y_low: Array, y_high: Array) -> Interval:
    """Remainder: the sign of x, smaller than y, no larger than x; exact within a period of a fixed y."""
    at_low, at_high = np.fmod(x_low, y_low), np.fmod(x_high, y_low)
    one_sign = (x_low >= 0.0) | (x_high <= 0.0)
    short = up(x_high - x_low) < np.abs(y_low)
    same = (y_low == y_high) & one_sign & short & (at_low <= at_high)
    reach = magnitudes(y_low, y_high)[1]
    low = np.where(same, at_low, -np.minimum(np.maximum(-x_low, 0.0), reach))
    high = np.where(same, at_high, np.minimum(np.maximum(x_high, 0.0), reach))
    empty = np.isnan(x_low) | np.isnan(y_low) | (reach == 0.0)
    return where_not(empty, low, high)
