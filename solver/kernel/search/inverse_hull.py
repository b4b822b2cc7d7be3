"""What the value of one operation says about its operands: projections of elementary constraints on boxes.

Each function narrows an operand ``x`` to a hull of those of its numbers for which the operation can give a
number in ``z``; all are intervals as pairs of arrays, rounded outward. An empty hull has its ends crossed or
nan.
(F. Benhamou & W. J. Older, J. Logic Programming 32 (1997) 1–24, section 4.)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from rulesheets.functions.intervals.arrays import INTERVALS, Array, Interval, divide, magnitudes

ROOT_SLACK = 4096 * 2.0**-52
"""Relative: x^(1/n) with a rounded 1/n is off by at most |ln x| of them, 745 at most."""
TURN_SLACK = 16 * 2.0**-52


def meet(x: Interval, other: Interval) -> Interval:
    """The common part; nan stays."""
    return np.maximum(x[0], other[0]), np.minimum(x[1], other[1])


def outside(x: Interval, low: Array, high: Array) -> Interval:
    """The hull of the numbers of ``x`` that are not strictly between ``low`` and ``high``."""
    below, above = x[0] <= low, x[1] >= high
    first = np.where(below, x[0], np.maximum(x[0], high))
    last = np.where(above, x[1], np.minimum(x[1], low))
    return first, last


def factor(x: Interval, y: Interval, z: Interval) -> Interval:
    """x where x·y = z. A ``y`` on both sides of 0 leaves out the middle; if ``z`` has 0 too, nothing."""
    quotient = divide(*z, *y)
    y_zero, z_zero = (y[0] <= 0.0) & (y[1] >= 0.0), (z[0] <= 0.0) & (z[1] >= 0.0)
    inside = meet(x, quotient)
    # y across 0 and z off 0: |x| is at least |z| / |y|
    least, _ = magnitudes(*z)
    up = np.where(z[0] > 0.0, least / y[1], least / -y[0])
    down = np.where(z[0] > 0.0, least / y[0], -least / y[1])
    across = outside(x, np.nextafter(down, np.inf), np.nextafter(up, -np.inf))
    apart = y_zero & ~z_zero & (y[0] < 0.0) & (y[1] > 0.0)
    free = y_zero & z_zero
    low = np.where(free, x[0], np.where(apart, across[0], inside[0]))
    return low, np.where(free, x[1], np.where(apart, across[1], inside[1]))


def divisor(y: Interval, x: Interval, z: Interval) -> Interval:
    """y where x / y = z, that is y·z = x."""
    return factor(y, z, x)


def whole_root(x: Interval, z: Interval, exponent: int) -> Interval:
    """x where x^n = z for a whole n of 1 or more."""
    if exponent == 1:
        return meet(x, z)
    if exponent % 2:
        return meet(x, (_signed_root(z[0], exponent, -np.inf), _signed_root(z[1], exponent, np.inf)))
    z = np.maximum(z[0], 0.0), np.where(z[1] < 0.0, np.nan, z[1])
    least = np.maximum(_root(z[0], exponent, -np.inf), 0.0)
    greatest = _root(z[1], exponent, np.inf)
    return outside(meet(x, (-greatest, greatest)), -least, least)


def _root(z: Array, exponent: int, towards: float) -> Array:
    if exponent == 2:
        return np.nextafter(np.sqrt(z), towards)
    root = np.power(z, 1.0 / exponent)
    slack = root * ROOT_SLACK
    result: Array = np.nextafter(root + slack if towards > 0 else root - slack, towards)
    return result


def _signed_root(z: Array, exponent: int, towards: float) -> Array:
    return np.where(z >= 0.0, _root(abs(z), exponent, towards), -_root(abs(z), exponent, -towards))


def real_root(x: Interval, z: Interval, exponent: float) -> Interval:
    """x where x^a = z for an a that is no whole number: x and z are not negative."""
    z = np.maximum(z[0], 0.0), np.where(z[1] < 0.0, np.nan, z[1])
    ends = np.power(z[0], 1.0 / exponent), np.power(z[1], 1.0 / exponent)
    low, high = ends if exponent > 0 else ends[::-1]
    slack = ROOT_SLACK / min(abs(exponent), 1.0)
    return meet(x, (np.maximum(low * (1.0 - slack), 0.0), np.nextafter(high * (1.0 + slack), np.inf)))


def square(x: Interval, z: Interval) -> Interval:
    """x where √x = z."""
    least = np.maximum(np.nextafter(np.maximum(z[0], 0.0) ** 2, -np.inf), 0.0)
    return meet(x, (least, np.nextafter(z[1] ** 2, np.inf)))


def magnitude(x: Interval, z: Interval) -> Interval:
    """x where |x| = z."""
    least, greatest = np.maximum(z[0], 0.0), np.where(z[1] < 0.0, np.nan, z[1])
    return outside(meet(x, (-greatest, greatest)), -least, least)


def cosine(x: Interval, z: Interval, turn: float, top: float) -> Interval:
    """x where cos(2π (x / turn - top)) = z: the first and the last preimage in ``x``."""
    z = np.maximum(z[0], -1.0), np.minimum(z[1], 1.0)
    z = np.where(z[0] > z[1], np.nan, z[0]), z[1]
    half = np.arccos(z[1]) / (2 * np.pi) - TURN_SLACK, np.arccos(z[0]) / (2 * np.pi) + TURN_SLACK
    start, stop = x[0] / turn - top, x[1] / turn - top
    slack = TURN_SLACK * (1.0 + np.maximum(abs(x[0]), abs(x[1])) / turn)
    first = _next_preimage(start - slack, *half) - slack
    last = -_next_preimage(-stop - slack, *half) + slack
    wide = ~(np.isfinite(start) & np.isfinite(stop))
    low = np.where(wide, x[0], np.maximum(x[0], (first + top) * turn))
    high = np.where(wide, x[1], np.minimum(x[1], (last + top) * turn))
    return np.where(np.isnan(z[0]), np.nan, low), high


def _next_preimage(start: Array, near: Array, far: Array) -> Array:
    """The least t ≥ start, in turns, within [near, far] of a whole number on either side of it."""
    whole = np.floor(start)
    t = start - whole
    near = np.maximum(near, 0.0)
    found = np.where(t < near, near, np.where(t <= far, t, np.where(t < 1.0 - far, 1.0 - far, t)))
    found = np.where(found > 1.0 - near, np.maximum(found, 1.0 + near), found)
    return whole + found


def _through(name: str, x: Interval, z: Interval) -> Interval:
    """x where x is the function ``name`` of z."""
    return meet(x, INTERVALS[name](*z))


INVERSES: Mapping[str, Callable[[Interval, Interval], Interval]] = {
    "sqrt": square,
    "abs": magnitude,
    **{
        name: partial(_through, inverse)
        for name, inverse in {
            "exp": "ln",
            "ln": "exp",
            "sinh": "asinh",
            "asinh": "sinh",
            "tanh": "atanh",
            "atanh": "tanh",
            "acosh": "cosh",
            "asin": "sin",
            "acos": "cos",
            "asind": "sind",
            "acosd": "cosd",
        }.items()
    },
    "sin": partial(cosine, turn=2 * np.pi, top=0.25),
    "cos": partial(cosine, turn=2 * np.pi, top=0.0),
    "sind": partial(cosine, turn=360.0, top=0.25),
    "cosd": partial(cosine, turn=360.0, top=0.0),
}
"""By function of one argument; those that are not here narrow nothing."""
