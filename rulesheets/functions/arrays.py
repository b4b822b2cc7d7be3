"""The functions of the language on numpy arrays.

Arguments broadcast; outside its domain a function gives nan or inf. Callers silence numpy's
floating point warnings (``numpy.errstate``). This module has the functions that neither numpy nor
scipy has; those in degrees follow the method of ``floats``, with the same exact results.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from importlib import import_module
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.functions import TABLE, floats
from rulesheets.functions.row import Forms, Function

Array: TypeAlias = NDArray[np.float64]


def _library(name: str) -> Callable[..., Any]:
    """The function of that name here or in numpy; ``special.…`` is scipy's, imported on demand."""
    if name.startswith("special."):
        function: Callable[..., Any] = getattr(
            import_module("scipy.special"), name.removeprefix("special.")
        )
    else:
        function = globals().get(name) or getattr(np, name)
    return function


def _form(row: Function) -> Callable[..., Array]:
    if row.array is None:
        return _one_by_one(row.value)
    return _library(row.array) if isinstance(row.array, str) else row.array


def _one_by_one(value: Callable[..., float]) -> Callable[..., Array]:
    """A function of floats on arrays, nan where it raises."""

    def at(*numbers: float) -> float:
        try:
            return value(*numbers)
        except (ArithmeticError, ValueError):
            return np.nan

    def on_arrays(*arguments: Any) -> Array:
        if not arguments:
            return np.asarray(value())
        arrays = np.broadcast_arrays(*arguments)
        rows = zip(*(np.ravel(array).tolist() for array in arrays), strict=True)
        return np.array([at(*row) for row in rows], dtype=float).reshape(arrays[0].shape)

    return on_arrays


ARRAYS = Forms(TABLE, _form)
"""Every function of the table on arrays, by name."""


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


def least_of(*numbers: Array) -> Array:
    return reduce(np.minimum, numbers)


def greatest_of(*numbers: Array) -> Array:
    return reduce(np.maximum, numbers)


def jn(order: Array, x: Array) -> Array:
    """A Bessel function, nan where the order is not a whole number."""
    return np.where(order == np.trunc(order), _library("special.jv")(order, x), np.nan)


def yn(order: Array, x: Array) -> Array:
    return np.where(order == np.trunc(order), _library("special.yv")(order, x), np.nan)


# --- degrees --------------------------------------------------------------------

_scaled: Callable[..., tuple[Any, Any]] = floats.scaled
_in_degrees: Callable[..., Any] = floats.in_degrees


def _reduced(degrees: Array) -> tuple[NDArray[np.int64], Array]:
    """The number of right angles modulo 4 and the remainder, from -45 to 45, both exact."""
    turn = np.fmod(degrees, 360.0)
    quarters = np.rint(turn / 90.0)
    rest = turn - 90.0 * quarters
    return np.where(np.isnan(rest), 0.0, quarters).astype(np.int64) & 3, rest


def _sine(degrees: Array, ahead: int) -> Array:
    """The sine of angles plus ``ahead`` right angles."""
    quarters, rest = _reduced(np.asarray(degrees, dtype=float))
    quarters = quarters + ahead
    high, low = _scaled(rest, *floats.RADIAN)
    sine, cosine = np.sin(high), np.cos(high)
    exact = np.where(np.abs(rest) == 30.0, np.copysign(0.5, rest), sine + low * cosine)
    value = np.where(quarters & 1, cosine - low * sine, exact)
    return np.where(quarters & 2, 0.0 - value, value)


def sind(degrees: Array) -> Array:
    return _sine(degrees, 0)


def cosd(degrees: Array) -> Array:
    return _sine(degrees, 1) + 0.0


def tand(degrees: Array) -> Array:
    """Tangent, nan at the poles."""
    quarters, rest = _reduced(np.asarray(degrees, dtype=float))
    high, low = _scaled(rest, *floats.RADIAN)
    tangent = np.tan(high)
    tangent = tangent + low * (1.0 + tangent * tangent)
    tangent = np.where(np.abs(rest) == 45.0, np.copysign(1.0, rest), tangent)
    odd = (quarters & 1) == 1
    turned = -1.0 / np.where(odd & (rest != 0.0), tangent, np.nan)
    return np.where(odd, turned, tangent)


def asind(x: Array) -> Array:
    half = np.abs(x) == 0.5
    return np.where(half, np.copysign(30.0, x), _in_degrees(np.arcsin(x)))


def acosd(x: Array) -> Array:
    half = np.abs(x) == 0.5
    return np.where(half, 90.0 - np.copysign(30.0, x), _in_degrees(np.arccos(x)))


def atand(x: Array) -> Array:
    return np.where(np.abs(x) == 1.0, np.copysign(45.0, x), _in_degrees(np.arctan(x)))


def atan2d(y: Array, x: Array) -> Array:
    """Direction of (x, y) in degrees, in (-180, 180]; nan at the origin."""
    y, x = np.asarray(y, dtype=float) + 0.0, np.asarray(x, dtype=float) + 0.0
    diagonal = np.copysign(np.where(x > 0.0, 45.0, 135.0), y)
    angle = np.where(np.abs(x) == np.abs(y), diagonal, _in_degrees(np.arctan2(y, x)))
    angle = np.where(angle == -180.0, 180.0, angle)
    return np.where((x == 0.0) & (y == 0.0), np.nan, angle)
