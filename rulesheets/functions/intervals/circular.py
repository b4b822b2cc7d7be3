"""Interval forms of sine, cosine, tangent and the direction of a point."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from rulesheets.functions import array_degrees
from rulesheets.functions.float_intervals.circular import LAST_PLACES
from rulesheets.functions.intervals.bounds import (
    NUMPY_ULPS,
    Array,
    Interval,
    Mask,
    down,
    quiet,
    up,
    where_not,
)

# What a count of turns can be off by, relative to the count or one.
_SLACK = 8.0 * float(np.finfo(float).eps)


def _may_contain(low: Array, high: Array, offset: float) -> Mask:
    """Whether some whole number plus ``offset`` may lie between two counts of turns."""
    first, last = low - offset, high - offset
    first, last = first - _SLACK * (np.abs(low) + 1.0), last + _SLACK * (np.abs(high) + 1.0)
    return np.ceil(first) <= np.floor(last)


def _wave(function: Callable[[Array], Array], turn: float, top: float) -> Callable[[Array, Array], Interval]:
    """Interval form of a sine of period ``turn`` with its maxima at ``top`` turns."""

    @quiet
    def enclosure(low: Array, high: Array) -> Interval:
        first, last = low / turn, high / turn
        at_low, at_high = function(low), function(high)
        below = np.maximum(down(np.minimum(at_low, at_high), NUMPY_ULPS), -1.0)
        above = np.minimum(up(np.maximum(at_low, at_high), NUMPY_ULPS), 1.0)
        unbounded = np.isinf(low) | np.isinf(high)
        above = np.where(unbounded | _may_contain(first, last, top), 1.0, above)
        below = np.where(unbounded | _may_contain(first, last, top + 0.5), -1.0, below)
        return where_not(np.isnan(low), below, above)

    return enclosure


sin = _wave(np.sin, 2.0 * np.pi, 0.25)
cos = _wave(np.cos, 2.0 * np.pi, 0.0)
sind = _wave(array_degrees.sind, 360.0, 0.25)
cosd = _wave(array_degrees.cosd, 360.0, 0.0)


@quiet
def tan(low: Array, high: Array) -> Interval:
    first, last = low / np.pi, high / np.pi
    across = np.isinf(low) | np.isinf(high) | _may_contain(first, last, 0.5)
    below = np.where(across, -np.inf, down(np.tan(low), NUMPY_ULPS))
    above = np.where(across, np.inf, up(np.tan(high), NUMPY_ULPS))
    return where_not(np.isnan(low), below, above)


# Up to here 180 times a whole number plus 90 is exact.
_LARGEST_ANGLE = 1e15


def _branch_start(degrees: Array) -> Array:
    """The last pole of tand at or before an angle."""
    start = 180.0 * np.floor((degrees + 90.0) / 180.0) - 90.0
    start = np.where(start > degrees, start - 180.0, start)
    return np.where(start + 180.0 <= degrees, start + 180.0, start)


@quiet
def tand(low: Array, high: Array) -> Interval:
    """Tangent of degrees: a pole at an end leaves a half line, one inside the whole line."""
    start = _branch_start(low)
    far = (np.abs(low) > _LARGEST_ANGLE) | (np.abs(high) > _LARGEST_ANGLE)
    across = far | (high > start + 180.0)
    point = (low == high) & (low == start)
    at_low, at_high = array_degrees.tand(low), array_degrees.tand(high)
    below = np.where(across | (low == start), -np.inf, down(at_low, NUMPY_ULPS))
    above = np.where(across | (high == start + 180.0), np.inf, up(at_high, NUMPY_ULPS))
    return where_not(np.isnan(low) | (point & ~far), below, above)


def _direction(half_turn: float, unit: float) -> Callable[[Array, Array, Array, Array], Interval]:
    """Interval form of atan2(y, x), in (-half turn, half turn], ``unit`` to a radian.

    Away from the cut (y = 0, x < 0) the direction of a box is bounded by its corners; a box
    across the cut has directions up to the half turn both ways.
    """

    @quiet
    def enclosure(y_low: Array, y_high: Array, x_low: Array, x_high: Array) -> Interval:
        corners = [
            np.where((y == 0.0) & (x == 0.0), np.nan, np.arctan2(y, x) * unit)
            for y in (y_low + 0.0, y_high + 0.0)
            for x in (x_low + 0.0, x_high + 0.0)
        ]
        below = down(np.fmin.reduce(corners), NUMPY_ULPS) - LAST_PLACES
        above = up(np.fmax.reduce(corners), NUMPY_ULPS) + LAST_PLACES
        cut = (y_low < 0.0) & (y_high >= 0.0) & (x_low < 0.0)
        around = cut & ~(np.isnan(y_high) | np.isnan(x_low))
        below = np.where(around, -half_turn, below)
        above = np.where(around, half_turn, above)
        return where_not(np.isnan(y_low) | np.isnan(x_low), below, above)

    return enclosure


atan2 = _direction(float(np.nextafter(np.pi, np.inf)), 1.0)
atan2d = _direction(180.0, 180.0 / np.pi)
