"""Interval forms of the built-in functions on floats, one box at a time, without numpy.

For a few boxes they are quicker than those on arrays, and need no library. They contain what they have to
as those do, by the same rules. ``FLOAT_INTERVALS`` has a row for every row of ``TABLE``; the functions that
come from scipy have the forms on arrays.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from math import inf, isnan, nextafter

from rulesheets.functions import degrees
from rulesheets.functions.float_intervals import circular, jumping
from rulesheets.functions.float_intervals.bounds import EMPTY, Interval, down, magnitudes, monotone, up

_UNIT, _POSITIVE = (-1.0, 1.0), (0.0, inf)
_SPECIAL_ULPS = 32.0
_GAMMA_VALLEY = 1.4616321449683623
_GAMMA_LEAST, _LGAMMA_LEAST = 0.8856031944108886, -0.12148629053584964
"""Gamma and its logarithm have their least values for positive arguments here."""


def _constant(below: float) -> Callable[[], Interval]:
    """A constant that lies between ``below`` and the next float."""
    return lambda: (below, nextafter(below, inf))


_rising_cosh = monotone(math.cosh, _POSITIVE, (1.0, inf))


def _cosh(low: float, high: float) -> Interval:
    return _rising_cosh(*magnitudes(low, high))


def _valley(function: Callable[[float], float], lowest: float) -> Callable[[float, float], Interval]:
    """Interval form of gamma or lgamma: known for positive arguments, else the whole line."""

    def at(x: float) -> float:
        try:
            return function(x)
        except OverflowError:
            return inf

    def enclosure(low: float, high: float) -> Interval:
        if isnan(low):
            return EMPTY
        if not 0.0 < low <= high:
            return -inf, inf
        at_low, at_high = at(low), at(high)
        around = low <= _GAMMA_VALLEY + 1e-6 and high >= _GAMMA_VALLEY - 1e-6
        below = lowest if around else min(at_low, at_high)
        return down(below, _SPECIAL_ULPS) - 1e-14, up(max(at_low, at_high), _SPECIAL_ULPS) + 1e-14

    return enclosure


def _on_arrays(name: str) -> Callable[..., Interval]:
    def enclosure(*ends: float) -> Interval:
        import numpy as np

        from rulesheets.functions.intervals import INTERVALS

        low, high = INTERVALS[name](*map(np.asarray, ends))
        return float(low), float(high)

    return enclosure


_FROM_SCIPY = ("digamma", "beta", "j0", "j1", "jn", "y0", "y1", "yn", "i0", "bessel_i1", "k0", "bessel_k1")

FLOAT_INTERVALS: Mapping[str, Callable[..., Interval]] = {
    "pi": _constant(math.pi),
    "e": _constant(math.e),
    "abs": magnitudes,
    "sgn": jumping.sgn,
    "int": jumping.int_,
    "frac": jumping.frac,
    "round": jumping.round_nearest,
    "mod": jumping.mod,
    "step": jumping.step,
    "min": jumping.least,
    "max": jumping.greatest,
    "sqrt": monotone(math.sqrt, _POSITIVE, _POSITIVE, ulps=1.0),
    "exp": monotone(math.exp, image=_POSITIVE),
    "ln": monotone(math.log, _POSITIVE),
    "log": monotone(math.log10, _POSITIVE),
    "log10": monotone(math.log10, _POSITIVE),
    "sin": circular.sin,
    "cos": circular.cos,
    "tan": circular.tan,
    "asin": monotone(math.asin, _UNIT),
    "acos": monotone(math.acos, _UNIT, _POSITIVE, falling=True),
    "atan": monotone(math.atan),
    "atan2": circular.atan2,
    "sind": circular.sind,
    "cosd": circular.cosd,
    "tand": circular.tand,
    "asind": monotone(degrees.asind, _UNIT, (-90.0, 90.0)),
    "acosd": monotone(degrees.acosd, _UNIT, (0.0, 180.0), falling=True),
    "atand": monotone(degrees.atand, image=(-90.0, 90.0)),
    "atan2d": circular.atan2d,
    "sinh": monotone(math.sinh),
    "cosh": _cosh,
    "tanh": monotone(math.tanh, image=_UNIT),
    "asinh": monotone(math.asinh),
    "acosh": monotone(math.acosh, (1.0, inf), _POSITIVE),
    "atanh": monotone(math.atanh, _UNIT),
    "gamma": _valley(math.gamma, _GAMMA_LEAST),
    "lgamma": _valley(math.lgamma, _LGAMMA_LEAST),
    "erf": monotone(math.erf, image=_UNIT, ulps=_SPECIAL_ULPS),
    "erfc": monotone(math.erfc, image=(0.0, 2.0), ulps=_SPECIAL_ULPS, falling=True),
    **{name: _on_arrays(name) for name in _FROM_SCIPY},
}
