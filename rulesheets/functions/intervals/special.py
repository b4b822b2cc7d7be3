"""Interval forms of gamma, error and Bessel functions.

They are tight where the function is monotone; elsewhere the known extremes or a bound on the slope
serve (Abramowitz & Stegun 1964, tables 6.1, 9.1 and 9.5), and the whole line where nothing is simple.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from rulesheets.functions import scipy_special as special
from rulesheets.functions.intervals.bounds import (
    EPSILON,
    SCIPY_ULPS,
    Array,
    Interval,
    clipped,
    down,
    magnitudes,
    monotone,
    quiet,
    up,
    where_not,
)

erf = monotone(special.erf, image=(-1.0, 1.0), ulps=SCIPY_ULPS)
# Where scipy's i0 and i1 are infinite, which compute exp(x) first, they are no less than this.
_LEAST_OVERFLOW = 1e306
_rising_i1 = monotone(special.i1, ulps=SCIPY_ULPS)
k0 = monotone(special.k0, domain=(0.0, np.inf), image=(0.0, np.inf), ulps=SCIPY_ULPS, falling=True)
k1 = monotone(special.k1, domain=(0.0, np.inf), image=(0.0, np.inf), ulps=SCIPY_ULPS, falling=True)


def _erfc(x: Array) -> Array:
    """Scipy's; that of the C library where scipy has 0 already, and there is something left."""
    late = (x > 26.0) & (x < 28.0)
    found = np.array(special.erfc(x))
    found[late] = [math.erfc(number) for number in np.asarray(x)[late].tolist()]
    return found


# In its tail scipy's erfc is off by some hundred units in the last place.
erfc = monotone(_erfc, image=(0.0, 2.0), ulps=1024.0, falling=True)


# gamma and its logarithm have their least values for positive arguments here.
_GAMMA_VALLEY = 1.4616321449683623
_GAMMA_LEAST, _LGAMMA_LEAST = 0.8856031944108886, -0.12148629053584964
# Nearer to 0, where both only rise, scipy has infinity for the logarithm of gamma.
_LEAST_NORMAL = float(np.finfo(float).tiny)


def _valley(function: Callable[[Array], Array], least: float) -> Callable[[Array, Array], Interval]:
    """Interval form of gamma or lgamma: known for positive arguments, else the whole line."""

    @quiet
    def enclosure(low: Array, high: Array) -> Interval:
        above = np.maximum(function(low), function(high))
        below = np.minimum(*(function(np.maximum(end, _LEAST_NORMAL)) for end in (low, high)))
        around = (low <= _GAMMA_VALLEY + 1e-6) & (high >= _GAMMA_VALLEY - 1e-6)
        below = np.where(around, least, _outward_down(below))
        return _for_positive(low, low, below, _outward_up(above))

    return enclosure


def _outward_down(x: Array) -> Array:
    """Below by the error of scipy, which is absolute near the zeros of a function."""
    return down(x, SCIPY_ULPS) - 1e-14


def _outward_up(x: Array) -> Array:
    return up(x, SCIPY_ULPS) + 1e-14


def _for_positive(first: Array, second: Array, low: Array, high: Array) -> Interval:
    """The interval where both arguments are positive, else the whole line."""
    positive = (first > 0.0) & (second > 0.0)
    low = np.where(positive & ~np.isnan(low), low, -np.inf)
    high = np.where(positive & ~np.isnan(high), high, np.inf)
    return where_not(np.isnan(first) | np.isnan(second), low, high)


gamma = _valley(special.gamma, _GAMMA_LEAST)
lgamma = _valley(special.gammaln, _LGAMMA_LEAST)


@quiet
def digamma(low: Array, high: Array) -> Interval:
    """Rising for positive arguments; elsewhere the whole line."""
    return _for_positive(low, low, _outward_down(special.digamma(low)), _outward_up(special.digamma(high)))


@quiet
def beta(a_low: Array, a_high: Array, b_low: Array, b_high: Array) -> Interval:
    """Falling in either argument where both are positive; elsewhere the whole line."""
    least, greatest = special.beta(a_high, b_high), special.beta(a_low, b_low)
    low = down(least) * np.maximum(1.0 - _beta_error(a_high, b_high), 0.0)
    high = up(greatest) * (1.0 + _beta_error(a_low, b_low))
    return _for_positive(a_low, b_low, np.maximum(low, 0.0), high)


def _beta_error(a: Array, b: Array) -> Array:
    """Bound on the relative error of scipy's beta, which cancels logarithms of gamma."""
    logarithms = np.abs(special.gammaln(a)) + np.abs(special.gammaln(b)) + np.abs(special.gammaln(a + b))
    return np.asarray(SCIPY_ULPS * EPSILON * (1.0 + logarithms))


def _slow(
    function: Callable[[Array], Array], slope: float, image: tuple[float, float]
) -> Callable[[Array, Array], Interval]:
    """Interval form from the middle and a bound on the slope, within the known extremes."""

    @quiet
    def enclosure(low: Array, high: Array) -> Interval:
        bounded = np.isfinite(low) & np.isfinite(high)
        middle = np.where(bounded, 0.5 * low + 0.5 * high, 0.0)
        radius = up(np.maximum(high - middle, middle - low))
        at_middle = function(middle)
        reach = slope * radius + 1e-14 + 1e-15 * np.abs(middle)
        below = np.where(bounded, np.maximum(at_middle - reach, image[0]), image[0])
        above = np.where(bounded, np.minimum(at_middle + reach, image[1]), image[1])
        return where_not(np.isnan(low), below, above)

    return enclosure


j0 = _slow(special.j0, 0.5819, (-0.4028, 1.0))
j1 = _slow(special.j1, 0.5, (-0.5819, 0.5819))


@quiet
def jn(n_low: Array, n_high: Array, x_low: Array, x_high: Array) -> Interval:
    """At most 1 in size and in slope; orders between the two ends are bounded by that alone."""
    one_order = (n_low == n_high) & (n_low == np.trunc(n_low))
    low, high = _slow(lambda x: special.jv(n_low, x), 1.0, (-1.0, 1.0))(x_low, x_high)
    low, high = np.where(one_order, low, -1.0), np.where(one_order, high, 1.0)
    return where_not(np.isnan(n_low) | np.isnan(x_low), low, high)


def _second_kind(
    function: Callable[[Array], Array], rising_until: float, least: float, greatest: float
) -> Callable[[Array, Array], Interval]:
    """Interval form of y0 or y1: rising at first, then between the first extremes."""

    @quiet
    def enclosure(low: Array, high: Array) -> Interval:
        low, high = clipped(low, high, (0.0, np.inf))
        at_low = _outward_down(np.asarray(function(low)))
        rising = high <= rising_until
        below = np.where(rising, at_low, np.where(low <= rising_until, np.minimum(at_low, least), least))
        above = np.where(rising, _outward_up(np.asarray(function(high))), greatest)
        return where_not(np.isnan(low) | (high == 0.0), below, above)

    return enclosure


y0 = _second_kind(special.y0, 2.19, -0.3404, 0.5209)
y1 = _second_kind(special.y1, 3.68, -0.3033, 0.4168)


@quiet
def yn(n_low: Array, n_high: Array, x_low: Array, x_high: Array) -> Interval:
    """The whole line wherever there may be a value (positive arguments)."""
    empty = np.isnan(n_low) | np.isnan(n_high) | np.isnan(x_low) | (x_high <= 0.0)
    everything = np.full(np.shape(empty), np.inf)
    return where_not(empty, -everything, everything)


@quiet
def i0(low: Array, high: Array) -> Interval:
    """Even, rising with the size of its argument."""
    least, greatest = magnitudes(low, high)
    below = np.minimum(special.i0(least), _LEAST_OVERFLOW)
    return np.maximum(down(below, SCIPY_ULPS), 1.0), up(special.i0(greatest), SCIPY_ULPS)


@quiet
def i1(low: Array, high: Array) -> Interval:
    """Odd and rising."""
    low, high = _rising_i1(low, high)
    return np.minimum(low, _LEAST_OVERFLOW), np.maximum(high, -_LEAST_OVERFLOW)
