"""Trigonometry in degrees on numpy arrays: the scheme of ``degrees``, with the same exact answers."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.functions.degrees import DEGREE, RADIAN, SPLITTER

Array: TypeAlias = NDArray[np.float64]


def _scaled(x: Array, factor: tuple[float, float]) -> tuple[Array, Array]:
    """``x * (head + tail)`` as an unevaluated sum of two floats."""
    head, tail = factor
    spread = SPLITTER * x
    x_head = spread - (spread - x)
    product = x_head * head
    rest = (x - x_head) * head + x * tail
    high = product + rest
    return high, rest - (high - product)


def _reduced(degrees: Array) -> tuple[NDArray[np.int64], Array]:
    """Number of right angles modulo 4 and what is left, from -45 to 45, both exact."""
    turn = np.fmod(degrees, 360.0)
    quarters = np.rint(turn / 90.0)
    rest = turn - 90.0 * quarters
    return np.where(np.isnan(rest), 0.0, quarters).astype(np.int64) & 3, rest


def _sine_and_cosine(rest: Array) -> tuple[Array, Array]:
    high, low = _scaled(rest, RADIAN)
    sine, cosine = np.sin(high), np.cos(high)
    exact = np.abs(rest) == 30.0
    return np.where(exact, np.copysign(0.5, rest), sine + low * cosine), cosine - low * sine


def sind(degrees: Array) -> Array:
    quarters, rest = _reduced(np.asarray(degrees, dtype=float))
    sine, cosine = _sine_and_cosine(rest)
    value = np.where(quarters & 1, cosine, sine)
    return np.where(quarters & 2, 0.0 - value, value)


def cosd(degrees: Array) -> Array:
    quarters, rest = _reduced(np.asarray(degrees, dtype=float))
    sine, cosine = _sine_and_cosine(rest)
    value = np.where(quarters & 1, sine, cosine)
    return np.where((quarters + 1) & 2, 0.0 - value, value + 0.0)


def tand(degrees: Array) -> Array:
    """Tangent, nan at the poles."""
    quarters, rest = _reduced(np.asarray(degrees, dtype=float))
    high, low = _scaled(rest, RADIAN)
    tangent = np.tan(high)
    tangent = tangent + low * (1.0 + tangent * tangent)
    tangent = np.where(np.abs(rest) == 45.0, np.copysign(1.0, rest), tangent)
    odd = (quarters & 1) == 1
    turned = -1.0 / np.where(odd & (rest != 0.0), tangent, np.nan)
    return np.where(odd, turned, tangent)


def _in_degrees(radians: Array) -> Array:
    high, low = _scaled(radians, DEGREE)
    return high + low


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
