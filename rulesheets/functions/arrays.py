"""The built-in functions on numpy arrays, for sweeps.

``ARRAYS`` has a row for every row of ``TABLE``. Arguments broadcast; outside its domain a
function gives nan or inf. Callers silence numpy's floating point warnings (``numpy.errstate``).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import reduce
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.functions import array_degrees as degrees
from rulesheets.functions import scipy_special as special

Array: TypeAlias = NDArray[np.float64]


def frac(x: Array) -> Array:
    return np.fmod(x, 1.0)


def round_(x: Array) -> Array:
    """The nearest whole number, halves away from zero."""
    whole = np.trunc(x)
    away = np.where(np.abs(x - whole) >= 0.5, np.copysign(1.0, x), 0.0)
    return whole + away


def step(x: Array, a: Array) -> Array:
    return np.where(np.isnan(x) | np.isnan(a), np.nan, np.where(x >= a, 1.0, 0.0))


def atan2(y: Array, x: Array) -> Array:
    """Direction of (x, y) in (-pi, pi], nan at the origin."""
    direction: Array = np.arctan2(y + 0.0, x)
    return np.where((x == 0.0) & (y == 0.0), np.nan, direction)


def least(*numbers: Array) -> Array:
    return reduce(np.minimum, numbers)


def greatest(*numbers: Array) -> Array:
    return reduce(np.maximum, numbers)


def lgamma(x: Array) -> Array:
    return np.asarray(special.gammaln(x))


def jn(order: Array, x: Array) -> Array:
    """Bessel function of the first kind, nan where the order is not a whole number."""
    return np.where(order == np.trunc(order), special.jv(order, x), np.nan)


def yn(order: Array, x: Array) -> Array:
    """Bessel function of the second kind, nan where the order is not a whole number."""
    return np.where(order == np.trunc(order), special.yv(order, x), np.nan)


ARRAYS: Mapping[str, Callable[..., Array]] = {
    "pi": lambda: np.asarray(math.pi),
    "e": lambda: np.asarray(math.e),
    "abs": np.abs,
    "sgn": np.sign,
    "int": np.trunc,
    "frac": frac,
    "round": round_,
    "mod": np.fmod,
    "step": step,
    "min": least,
    "max": greatest,
    "sqrt": np.sqrt,
    "exp": np.exp,
    "ln": np.log,
    "log": np.log10,
    "log10": np.log10,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "asin": np.arcsin,
    "acos": np.arccos,
    "atan": np.arctan,
    "atan2": atan2,
    "sind": degrees.sind,
    "cosd": degrees.cosd,
    "tand": degrees.tand,
    "asind": degrees.asind,
    "acosd": degrees.acosd,
    "atand": degrees.atand,
    "atan2d": degrees.atan2d,
    "sinh": np.sinh,
    "cosh": np.cosh,
    "tanh": np.tanh,
    "asinh": np.arcsinh,
    "acosh": np.arccosh,
    "atanh": np.arctanh,
    "gamma": special.gamma,
    "lgamma": lgamma,
    "digamma": special.digamma,
    "beta": special.beta,
    "erf": special.erf,
    "erfc": special.erfc,
    "j0": special.j0,
    "j1": special.j1,
    "jn": jn,
    "y0": special.y0,
    "y1": special.y1,
    "yn": yn,
    "i0": special.i0,
    "bessel_i1": special.i1,
    "k0": special.k0,
    "bessel_k1": special.k1,
}
