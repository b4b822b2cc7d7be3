"""Interval forms of the functions of the language, on one box of floats.

Each takes the two ends of every argument in turn, ``f(low, high, low, high, …) -> (low, high)``, by the
conventions of ``bounds``. They are tight where the function is monotone; elsewhere the known extremes or a
bound on the slope serve (Abramowitz & Stegun 1964, tables 6.1, 9.1 and 9.5), and the whole line where nothing
is simple.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from math import atan2 as radians_of
from math import ceil, floor, fmod, inf, isfinite, isinf, isnan, nan, nextafter, pi
from math import tan as tangent
from typing import NamedTuple

from rulesheets.functions import floats
from rulesheets.functions.intervals import (
    EMPTY,
    EPSILON,
    ULPS,
    Interval,
    clipped,
    down,
    greatest,
    least,
    magnitudes,
    up,
)

SPECIAL_ULPS = 32.0
"""What special functions are trusted to; near their zeros the error is absolute, and ``TINY``."""
TINY = 1e-14
LINE = -inf, inf
UNIT, POSITIVE = (-1.0, 1.0), (0.0, inf)
_SLACK = 8.0 * EPSILON
"""What a count of turns can be off by, relative to the count or one."""
_LARGEST_ANGLE = 1e15
"""Up to here 180 times a whole number plus 90 is exact."""
_GAMMA_VALLEY = 1.4616321449683623
GAMMA_LEAST, LGAMMA_LEAST = 0.8856031944108886, -0.12148629053584964
"""Gamma and its logarithm have their least values for positive arguments at the valley."""


def unknown(*ends: float) -> Interval:
    """The range of a function of which nothing is known."""
    return EMPTY if any(isnan(low) for low in ends[::2]) else LINE


def constant(below: float) -> Callable[[], Interval]:
    """A constant that lies between ``below`` and the next float."""
    return lambda: (below, nextafter(below, inf))


class Monotone(NamedTuple):
    """Range of a monotone function; ``image`` has ends that are floats exactly.

    Where ``value`` raises at an end of its domain, or overflows, its value is the nearer end of the image.
    """

    value: Callable[[float], float]
    domain: tuple[float, float] = LINE
    image: tuple[float, float] = LINE
    ulps: float = ULPS
    falling: bool = False

    def __call__(self, low: float, high: float) -> Interval:
        low, high = clipped(low, high, self.domain)
        first, last = (high, low) if self.falling else (low, high)
        below, above = down(self._at(first), self.ulps), up(self._at(last), self.ulps)
        return greatest(below, self.image[0]), least(above, self.image[1])

    def _at(self, x: float) -> float:
        if isnan(x):
            return nan
        try:
            return self.value(x)
        except (OverflowError, ValueError):
            small = x <= self.domain[0] or (x < 0.0 and x < self.domain[1])
            return self.image[0] if small is not self.falling else self.image[1]


class Even(NamedTuple):
    """Range of an even function from that for arguments that are not negative."""

    rising: Monotone

    def __call__(self, low: float, high: float) -> Interval:
        return self.rising(*magnitudes(low, high))


# --- angles ---------------------------------------------------------------------


def _may_contain(low: float, high: float, offset: float) -> bool:
    """Whether some whole number plus ``offset`` may lie between two counts of turns."""
    first = low - offset - _SLACK * (abs(low) + 1.0)
    return ceil(first) <= floor(high - offset + _SLACK * (abs(high) + 1.0))


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
        first, last, at_low, at_high = low / self.turn, high / self.turn, self.value(low), self.value(high)
        below, above = down(min(at_low, at_high), ULPS), up(max(at_low, at_high), ULPS)
        if above > 1.0 or _may_contain(first, last, self.top):
            above = 1.0
        if below < -1.0 or _may_contain(first, last, self.top + 0.5):
            below = -1.0
        return below, above


def tan(low: float, high: float) -> Interval:
    if isnan(low):
        return EMPTY
    if isinf(low) or isinf(high) or isnan(high) or _may_contain(low / pi, high / pi, 0.5):
        return LINE
    return down(tangent(low), ULPS), up(tangent(high), ULPS)


def tand(low: float, high: float) -> Interval:
    """Tangent of degrees: a pole at an end leaves a half line, one inside the whole line."""
    if isnan(low):
        return EMPTY
    if not (abs(low) <= _LARGEST_ANGLE and abs(high) <= _LARGEST_ANGLE):
        return LINE
    start = _branch_start(low)
    if low == high == start:
        return EMPTY
    if high > start + 180.0:
        return LINE
    below = -inf if low == start else down(floats.tand(low), ULPS)
    return below, inf if high == start + 180.0 else up(floats.tand(high), ULPS)


def _branch_start(angle: float) -> float:
    """The last pole of tand at or before an angle."""
    start = 180.0 * floor((angle + 90.0) / 180.0) - 90.0
    start = start - 180.0 if start > angle else start
    return start + 180.0 if start + 180.0 <= angle else start


class Direction(NamedTuple):
    """Range of atan2(y, x), in (-half turn, half turn], ``unit`` to a radian.

    Away from the cut (y = 0, x < 0) the direction of a box is bounded by its corners; a box
    across the cut has directions up to the half turn both ways.
    """

    half_turn: float
    unit: float

    def __call__(self, y_low: float, y_high: float, x_low: float, x_high: float) -> Interval:
        if isnan(y_low) or isnan(x_low):
            return EMPTY
        if isnan(y_high) or isnan(x_high) or (y_low < 0.0 <= y_high and x_low < 0.0):
            return -self.half_turn, self.half_turn
        corners = [
            radians_of(y, x) * self.unit
            for y in (y_low + 0.0, y_high + 0.0)
            for x in (x_low + 0.0, x_high + 0.0)
            if y or x
        ]
        if not corners:
            return EMPTY
        return down(min(corners), ULPS), up(max(corners), ULPS)


def cut(y_low: float, y_high: float, x_low: float, _: float) -> bool:
    """Where the direction of (x, y) may jump from one half turn to the other, or is undefined."""
    return not (y_low > 0.0 or y_high < 0.0 or x_low > 0.0)


# --- jumps and kinks; all but frac and mod are exact ----------------------------


def each_end(value: Callable[[float], float]) -> Callable[[float, float], Interval]:
    """Range of a rising function that floats compute exactly."""

    def at(x: float) -> float:
        return x if isnan(x) or (isinf(x) and value is not floats.sgn) else value(x)

    return lambda low, high: (at(low), at(high))


def step(x_low: float, x_high: float, a_low: float, a_high: float) -> Interval:
    if isnan(x_low) or isnan(a_low):
        return EMPTY
    return 1.0 if x_low >= a_high else 0.0, 0.0 if x_high < a_low else 1.0


def least_of(*ends: float) -> Interval:
    return reduce(least, ends[::2]), reduce(least, ends[1::2])


def greatest_of(*ends: float) -> Interval:
    return reduce(greatest, ends[::2]), reduce(greatest, ends[1::2])


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
    return -least(max(-x_low, 0.0), reach), least(max(x_high, 0.0), reach)


# --- special functions ----------------------------------------------------------


def _below(value: Callable[[float], float], x: float) -> float:
    """Below the value by the error of the library; -inf where it has none."""
    try:
        return down(value(x), SPECIAL_ULPS) - TINY
    except (OverflowError, ValueError):
        return -inf


def _above(value: Callable[[float], float], x: float) -> float:
    try:
        return up(value(x), SPECIAL_ULPS) + TINY
    except (OverflowError, ValueError):
        return inf


class Valley(NamedTuple):
    """Range of gamma or lgamma, whose least value is ``lowest``: known for positive arguments."""

    value: Callable[[float], float]
    lowest: float

    def __call__(self, low: float, high: float) -> Interval:
        if isnan(low):
            return EMPTY
        if not 0.0 < low <= high:
            return LINE
        at_low, at_high = self._at(low), self._at(high)
        around = low <= _GAMMA_VALLEY + 1e-6 and high >= _GAMMA_VALLEY - 1e-6
        below = self.lowest if around else min(at_low, at_high)
        return down(below, SPECIAL_ULPS) - TINY, up(max(at_low, at_high), SPECIAL_ULPS) + TINY

    def _at(self, x: float) -> float:
        try:
            return self.value(x)
        except OverflowError:
            return inf


def digamma(low: float, high: float) -> Interval:
    """Rising for positive arguments; elsewhere the whole line."""
    if isnan(low):
        return EMPTY
    return (_below(floats.digamma, low), _above(floats.digamma, high)) if low > 0.0 else LINE


class Slow(NamedTuple):
    """Range from the middle and a bound on the slope, within the known extremes."""

    value: Callable[[float], float]
    slope: float
    image: tuple[float, float]

    def __call__(self, low: float, high: float) -> Interval:
        if isnan(low):
            return EMPTY
        if not (isfinite(low) and isfinite(high)):
            return self.image
        middle = 0.5 * low + 0.5 * high
        reach = self.slope * up(max(high - middle, middle - low)) + TINY + 1e-15 * abs(middle)
        try:
            at_middle = self.value(middle)
        except (OverflowError, ValueError):
            return self.image
        return max(at_middle - reach, self.image[0]), min(at_middle + reach, self.image[1])
