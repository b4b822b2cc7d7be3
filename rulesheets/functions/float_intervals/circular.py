"""Interval forms of sine, cosine, tangent and the direction of a point, on floats."""

from __future__ import annotations

from collections.abc import Callable
from math import atan2 as direction
from math import ceil, floor, inf, isinf, isnan, nextafter, pi
from math import cos as cosine
from math import sin as sine
from math import tan as tangent

from rulesheets.functions import degrees
from rulesheets.functions.float_intervals.bounds import EMPTY, EPSILON, ULPS, Interval, down, up

_SLACK = 8.0 * EPSILON
"""What a count of turns can be off by, relative to the count or one."""
_LARGEST_ANGLE = 1e15
"""Up to here 180 times a whole number plus 90 is exact."""
LAST_PLACES = 256 * 5e-324
"""Directions are computed in radians: what the last place of the smallest of them is in degrees, and more."""


def _may_contain(low: float, high: float, offset: float) -> bool:
    """Whether some whole number plus ``offset`` may lie between two counts of turns."""
    first = low - offset - _SLACK * (abs(low) + 1.0)
    return ceil(first) <= floor(high - offset + _SLACK * (abs(high) + 1.0))


def _wave(function: Callable[[float], float], turn: float, top: float) -> Callable[[float, float], Interval]:
    """Interval form of a sine of period ``turn`` with its maxima at ``top`` turns."""

    def enclosure(low: float, high: float) -> Interval:
        if isnan(low):
            return EMPTY
        if isinf(low) or isinf(high) or isnan(high):
            return -1.0, 1.0
        first, last, at_low, at_high = low / turn, high / turn, function(low), function(high)
        below, above = down(min(at_low, at_high), ULPS), up(max(at_low, at_high), ULPS)
        if above > 1.0 or _may_contain(first, last, top):
            above = 1.0
        if below < -1.0 or _may_contain(first, last, top + 0.5):
            below = -1.0
        return below, above

    return enclosure


sin = _wave(sine, 2.0 * pi, 0.25)
cos = _wave(cosine, 2.0 * pi, 0.0)
sind = _wave(degrees.sind, 360.0, 0.25)
cosd = _wave(degrees.cosd, 360.0, 0.0)


def tan(low: float, high: float) -> Interval:
    if isnan(low):
        return EMPTY
    if isinf(low) or isinf(high) or isnan(high) or _may_contain(low / pi, high / pi, 0.5):
        return -inf, inf
    return down(tangent(low), ULPS), up(tangent(high), ULPS)


def tand(low: float, high: float) -> Interval:
    """Tangent of degrees: a pole at an end leaves a half line, one inside the whole line."""
    if isnan(low):
        return EMPTY
    if not (abs(low) <= _LARGEST_ANGLE and abs(high) <= _LARGEST_ANGLE):
        return -inf, inf
    start = _branch_start(low)
    if low == high == start:
        return EMPTY
    if high > start + 180.0:
        return -inf, inf
    below = -inf if low == start else down(degrees.tand(low), ULPS)
    return below, inf if high == start + 180.0 else up(degrees.tand(high), ULPS)


def _branch_start(angle: float) -> float:
    """The last pole of tand at or before an angle."""
    start = 180.0 * floor((angle + 90.0) / 180.0) - 90.0
    start = start - 180.0 if start > angle else start
    return start + 180.0 if start + 180.0 <= angle else start


def _direction(half_turn: float, unit: float) -> Callable[[float, float, float, float], Interval]:
    """Interval form of atan2(y, x), in (-half turn, half turn], ``unit`` to a radian.

    Away from the cut (y = 0, x < 0) the direction of a box is bounded by its corners; a box
    across the cut has directions up to the half turn both ways.
    """

    def enclosure(y_low: float, y_high: float, x_low: float, x_high: float) -> Interval:
        if isnan(y_low) or isnan(x_low):
            return EMPTY
        if isnan(y_high) or isnan(x_high) or (y_low < 0.0 <= y_high and x_low < 0.0):
            return -half_turn, half_turn
        corners = [
            direction(y, x) * unit
            for y in (y_low + 0.0, y_high + 0.0)
            for x in (x_low + 0.0, x_high + 0.0)
            if y or x
        ]
        if not corners:
            return EMPTY
        return down(min(corners), ULPS) - LAST_PLACES, up(max(corners), ULPS) + LAST_PLACES

    return enclosure


atan2 = _direction(nextafter(pi, inf), 1.0)
atan2d = _direction(180.0, 180.0 / pi)


def cut(y_low: float, y_high: float, x_low: float, _: float) -> bool:
    """Where the direction of (x, y) may jump from one half turn to the other, or is undefined."""
    return not (y_low > 0.0 or y_high < 0.0 or x_low > 0.0)
