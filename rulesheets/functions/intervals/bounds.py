"""Intervals as pairs of arrays, and rounding outward.

An interval is ``(low, high)``, two float arrays of one shape (or scalars that broadcast);
infinite ends mean unbounded, two nan mean empty. Every operation contains the exact result of
every choice of real arguments from its intervals for which the operation is defined; where there
is none it is empty, and an empty argument makes the result empty.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
Mask: TypeAlias = NDArray[np.bool_]
Interval: TypeAlias = tuple[Array, Array]

# What the vector functions of numpy are trusted to, in units in the last place (measured: 1.5), and of scipy.
NUMPY_ULPS = 4.0
SCIPY_ULPS = 32.0
EPSILON = float(np.finfo(float).eps)

quiet = np.errstate(all="ignore")
"""Decorator: operations meet infinities and nan on purpose."""


def down(x: Array, ulps: float = 1.0) -> Array:
    """A bound below every number whose floating-point result is within ``ulps`` of x."""
    lower: Array = np.nextafter(x, -np.inf)
    return lower if ulps <= 1.0 else lower - np.abs(lower) * (ulps * EPSILON)


def up(x: Array, ulps: float = 1.0) -> Array:
    """A bound above every number whose floating-point result is within ``ulps`` of x."""
    upper: Array = np.nextafter(x, np.inf)
    return upper if ulps <= 1.0 else upper + np.abs(upper) * (ulps * EPSILON)


def where_not(empty: Mask, low: Array, high: Array) -> Interval:
    """The interval, emptied where ``empty`` says so."""
    return np.where(empty, np.nan, low), np.where(empty, np.nan, high)


def magnitudes(low: Array, high: Array) -> Interval:
    """Range of the absolute value, exact."""
    straddles = (low <= 0.0) & (high >= 0.0)
    least = np.where(straddles, 0.0, np.minimum(np.abs(low), np.abs(high)))
    return least, np.maximum(np.abs(low), np.abs(high))


def clipped(low: Array, high: Array, domain: tuple[float, float]) -> Interval:
    """The part within ``domain``; empty where there is none."""
    inside_low, inside_high = np.maximum(low, domain[0]), np.minimum(high, domain[1])
    return where_not(inside_low > inside_high, inside_low, inside_high)


def monotone(
    function: Callable[[Array], Array],
    domain: tuple[float, float] = (-np.inf, np.inf),
    image: tuple[float, float] = (-np.inf, np.inf),
    ulps: float = NUMPY_ULPS,
    falling: bool = False,
) -> Callable[[Array, Array], Interval]:
    """Interval form of a monotone function; ``image`` has ends that are floats exactly."""

    @quiet
    def enclosure(low: Array, high: Array) -> Interval:
        low, high = clipped(low, high, domain)
        first, last = (high, low) if falling else (low, high)
        at_first, at_last = function(first), function(last)
        return np.maximum(down(at_first, ulps), image[0]), np.minimum(up(at_last, ulps), image[1])

    return enclosure
