"""Interval forms of the built-in functions, vectorised and rounded outward.

``INTERVALS`` has a row for every row of ``TABLE``; a function takes the two ends of every argument
in turn, ``f(low, high, low, high, …) -> (low, high)``. Arithmetic is in ``arithmetic``; the
conventions are those of ``bounds``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from rulesheets.functions import array_degrees
from rulesheets.functions.intervals import circular, special, steps
from rulesheets.functions.intervals.arithmetic import add, divide, multiply, negate, power, subtract
from rulesheets.functions.intervals.bounds import Array, Interval, magnitudes, monotone, quiet

_UNIT, _POSITIVE = (-1.0, 1.0), (0.0, math.inf)


def _constant(below: float) -> Callable[[], Interval]:
    """A constant that lies between ``below`` and the next float."""
    return lambda: (np.asarray(below), np.asarray(math.nextafter(below, math.inf)))


@quiet
def _cosh(low: Array, high: Array) -> Interval:
    return _rising_cosh(*magnitudes(low, high))


_rising_cosh = monotone(np.cosh, image=(1.0, math.inf))

INTERVALS: Mapping[str, Callable[..., Interval]] = {
    "pi": _constant(math.pi),
    "e": _constant(math.e),
    "abs": magnitudes,
    "sgn": steps.sgn,
    "int": steps.int_,
    "frac": steps.frac,
    "round": steps.round_nearest,
    "mod": steps.mod,
    "step": steps.step,
    "min": steps.least,
    "max": steps.greatest,
    "sqrt": monotone(np.sqrt, _POSITIVE, _POSITIVE, ulps=1.0),
    "exp": monotone(np.exp, image=_POSITIVE),
    "ln": monotone(np.log, _POSITIVE),
    "log": monotone(np.log10, _POSITIVE),
    "log10": monotone(np.log10, _POSITIVE),
    "sin": circular.sin,
    "cos": circular.cos,
    "tan": circular.tan,
    "asin": monotone(np.arcsin, _UNIT),
    "acos": monotone(np.arccos, _UNIT, _POSITIVE, falling=True),
    "atan": monotone(np.arctan),
    "atan2": circular.atan2,
    "sind": circular.sind,
    "cosd": circular.cosd,
    "tand": circular.tand,
    "asind": monotone(array_degrees.asind, _UNIT, (-90.0, 90.0)),
    "acosd": monotone(array_degrees.acosd, _UNIT, (0.0, 180.0), falling=True),
    "atand": monotone(array_degrees.atand, image=(-90.0, 90.0)),
    "atan2d": circular.atan2d,
    "sinh": monotone(np.sinh),
    "cosh": _cosh,
    "tanh": monotone(np.tanh, image=_UNIT),
    "asinh": monotone(np.arcsinh),
    "acosh": monotone(np.arccosh, (1.0, math.inf), _POSITIVE),
    "atanh": monotone(np.arctanh, _UNIT),
    "gamma": special.gamma,
    "lgamma": special.lgamma,
    "digamma": special.digamma,
    "beta": special.beta,
    "erf": special.erf,
    "erfc": special.erfc,
    "j0": special.j0,
    "j1": special.j1,
    "jn": special.jn,
    "y0": special.y0,
    "y1": special.y1,
    "yn": special.yn,
    "i0": special.i0,
    "bessel_i1": special.i1,
    "k0": special.k0,
    "bessel_k1": special.k1,
}

__all__ = ["INTERVALS", "Array", "Interval", "add", "divide", "multiply", "negate", "power", "subtract"]
