"""The functions of the language, and interval arithmetic, on numpy arrays.

Arguments broadcast; outside its domain a function gives nan or inf. Callers silence numpy's floating point
warnings (``numpy.errstate``). Here are the functions that neither numpy nor scipy has; in degrees by the
scheme of ``floats``, with the same exact answers. Intervals are pairs of arrays by the conventions of
``intervals``, rounded outward, many boxes at once; the forms of functions that are neither monotone nor waves
are those on floats, box by box.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from importlib import import_module
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.functions import TABLE, floats
from rulesheets.functions.intervals import EPSILON, ULPS, WHOLE, Even, Monotone, Wave, unknown
from rulesheets.functions.row import Forms, Function

Array: TypeAlias = NDArray[np.float64]


def _library(name: str) -> Callable[..., Any]:
    """The function of that name here or in numpy; ``special.…`` is scipy's, imported when it is needed."""
    if name.startswith("special."):
        function: Callable[..., Any] = getattr(import_module("scipy.special"), name.removeprefix("special."))
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


def _of_whole_order(name: str) -> Callable[[Array, Array], Array]:
    """A Bessel function, nan where the order is not a whole number."""
    return lambda order, x: np.where(order == np.trunc(order), _library(name)(order, x), np.nan)


jn, yn = _of_whole_order("special.jv"), _of_whole_order("special.yv")

# --- degrees --------------------------------------------------------------------

_scaled: Callable[..., tuple[Any, Any]] = floats.scaled
_in_degrees: Callable[..., Any] = floats.in_degrees


def _reduced(degrees: Array) -> tuple[NDArray[np.int64], Array]:
    """Number of right angles modulo 4 and what is left, from -45 to 45, both exact."""
    turn = np.fmod(degrees, 360.0)
    quarters = np.rint(turn / 90.0)
    rest = turn - 90.0 * quarters
    return np.where(np.isnan(rest), 0.0, quarters).astype(np.int64) & 3, rest


def _sine(degrees: Array, ahead: int) -> Array:
    """Sine of angles and ``ahead`` right angles."""
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


Mask: TypeAlias = NDArray[np.bool_]
Interval: TypeAlias = tuple[Array, Array]


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


# --- arithmetic -----------------------------------------------------------------


def add(a_low: Array, a_high: Array, b_low: Array, b_high: Array) -> Interval:
    """Sum. A float sum that is 0 is exact (it cannot underflow) and stays 0."""
    low, high = a_low + b_low, a_high + b_high
    points = np.ndim(low) == 0 and a_low == a_high and b_low == b_high
    if points and low - a_low == b_low and low - b_low == a_low:
        return low, low
    return np.where(low == 0.0, 0.0, down(low)), np.where(high == 0.0, 0.0, up(high))


def _hull(corners: tuple[Array, ...], a: Interval, b: Interval) -> Interval:
    """Least and greatest of four corners, rounded outward, but not across 0 where the signs of a and b
    exclude that; an indeterminate corner (0*inf, 0/0, inf/inf) counts as 0."""
    first, second, third, fourth = (np.where(np.isnan(corner), 0.0, corner) for corner in corners)
    low = down(np.minimum(np.minimum(first, second), np.minimum(third, fourth)))
    high = up(np.maximum(np.maximum(first, second), np.maximum(third, fourth)))
    alike = (a[0] >= 0.0) & (b[0] >= 0.0) | (a[1] <= 0.0) & (b[1] <= 0.0)
    opposed = (a[0] >= 0.0) & (b[1] <= 0.0) | (a[1] <= 0.0) & (b[0] >= 0.0)
    return np.where(alike, np.maximum(low, 0.0), low), np.where(opposed, np.minimum(high, 0.0), high)


def multiply(a_low: Array, a_high: Array, b_low: Array, b_high: Array) -> Interval:
    """Product; 0 times an unbounded interval is 0."""
    corners = a_low * b_low, a_low * b_high, a_high * b_low, a_high * b_high
    low, high = _hull(corners, (a_low, a_high), (b_low, b_high))
    return where_not(np.isnan(a_low) | np.isnan(b_low), low, high)


def divide(a_low: Array, a_high: Array, b_low: Array, b_high: Array) -> Interval:
    """Quotient over the divisors that are not 0: a half line where 0 is an end of the divisor."""
    b_low = np.where(b_low == 0.0, 0.0, b_low)
    b_high = np.where(b_high == 0.0, -0.0, b_high)
    corners = a_low / b_low, a_low / b_high, a_high / b_low, a_high / b_high
    low, high = _hull(corners, (a_low, a_high), (b_low, b_high))
    nothing = (a_low == 0.0) & (a_high == 0.0)
    across = (b_low < 0.0) & (b_high > 0.0) & ~nothing
    low, high = np.where(across, -np.inf, low), np.where(across, np.inf, high)
    by_zero = (b_low == 0.0) & (b_high == 0.0)
    return where_not(by_zero | np.isnan(a_low) | np.isnan(b_low), low, high)


def scaled(factor: Array, _: Array, low: Array, high: Array) -> Interval:
    """A number times an interval, rounded outward but not across 0."""
    if factor == 0.0:
        return where_not(np.isnan(low), np.zeros_like(low), np.zeros_like(high))
    if np.ndim(low) == 0 and low == high and factor % 1.0 == 0.0 == low % 1.0 and abs(factor * low) < WHOLE:
        return factor * low, factor * low
    first, last = (low, high) if factor > 0.0 else (-high, -low)
    size = abs(factor)
    below, above = down(size * first), up(size * last)
    return np.where(first >= 0.0, np.maximum(below, 0.0), below), np.where(
        last <= 0.0, np.minimum(above, 0.0), above
    )


def square(low: Array, high: Array) -> Interval:
    """The product of a number with itself, which is never negative."""
    least, greatest = magnitudes(low, high)
    below, above = np.maximum(down(least * least), 0.0), up(greatest * greatest)
    return below, np.where(greatest == 0.0, 0.0, above)


def power(a_low: Array, a_high: Array, b_low: Array, b_high: Array) -> Interval:
    """``a^b``: tight for whole exponents; for others over bases of 0 or more."""
    whole = (b_low == b_high) & (b_low == np.rint(b_low))
    if np.all(whole):
        return _whole_power(a_low, a_high, b_low)
    real = _real_power(a_low, a_high, b_low, b_high)
    if not np.any(whole):
        return real
    integer = _whole_power(a_low, a_high, np.where(whole, b_low, 1.0))
    return np.where(whole, integer[0], real[0]), np.where(whole, integer[1], real[1])


def _whole_power(low: Array, high: Array, exponent: Array) -> Interval:
    count = np.abs(exponent)
    even = np.fmod(count, 2.0) == 0.0
    least, greatest = magnitudes(low, high)
    first, last = np.where(even, least, low), np.where(even, greatest, high)
    below, above = down(np.power(first, count), ULPS), up(np.power(last, count), ULPS)
    below = np.where(first >= 0.0, np.maximum(below, 0.0), below)
    above = np.where(last <= 0.0, np.minimum(above, 0.0), above)
    below, above = np.where(count == 1.0, low, below), np.where(count == 1.0, high, above)
    one = np.ones(())
    inverse = divide(one, one, below, above)
    below = np.where(exponent < 0.0, inverse[0], below)
    above = np.where(exponent < 0.0, inverse[1], above)
    unit = (exponent == 0.0) & ~np.isnan(low)
    return np.where(unit, 1.0, below), np.where(unit, 1.0, above)


def _real_power(a_low: Array, a_high: Array, b_low: Array, b_high: Array) -> Interval:
    """Corners suffice: for a base of 0 or more the power is monotone in either argument.

    A negative base has a power at whole exponents only. Where the exponent may be one, the
    powers of the magnitude, of both signs, are included.
    """
    odd = (a_low < 0.0) & (np.ceil(b_low) <= np.floor(b_high))
    reach = np.where(odd, np.maximum(-a_low, a_high), a_high)
    base = np.maximum(a_low, 0.0), np.maximum(reach, 0.0)
    corners = tuple(np.power(x, y) for x in base for y in (b_low, b_high))
    low = np.maximum(down(np.minimum.reduce(corners), ULPS), 0.0)
    high = up(np.maximum.reduce(corners), ULPS)
    low = np.where(odd, -high, low)
    nowhere = (a_high < 0.0) & ~odd | (base[1] == 0.0) & (b_high < 0.0)
    return where_not(nowhere | np.isnan(a_low) | np.isnan(b_low), low, high)


# --- functions ------------------------------------------------------------------


def _monotone(form: Monotone, function: Callable[[Array], Array]) -> Callable[[Array, Array], Interval]:
    def enclosure(low: Array, high: Array) -> Interval:
        inside_low, inside_high = np.maximum(low, form.domain[0]), np.minimum(high, form.domain[1])
        low, high = where_not(inside_low > inside_high, inside_low, inside_high)
        first, last = (high, low) if form.falling else (low, high)
        below, above = down(function(first), form.ulps), up(function(last), form.ulps)
        return np.maximum(below, form.image[0]), np.minimum(above, form.image[1])

    return enclosure


def _wave(form: Wave, function: Callable[[Array], Array]) -> Callable[[Array, Array], Interval]:
    def enclosure(low: Array, high: Array) -> Interval:
        at_low, at_high = function(low), function(high)
        below = np.maximum(down(np.minimum(at_low, at_high), ULPS), -1.0)
        above = np.minimum(up(np.maximum(at_low, at_high), ULPS), 1.0)
        first, last = low / form.turn, high / form.turn
        unbounded = np.isinf(low) | np.isinf(high)
        above = np.where(unbounded | _may_contain(first, last, form.top), 1.0, above)
        below = np.where(unbounded | _may_contain(first, last, form.top + 0.5), -1.0, below)
        return where_not(np.isnan(low), below, above)

    return enclosure


def _may_contain(low: Array, high: Array, offset: float) -> Mask:
    """Whether some whole number plus ``offset`` may lie between two counts of turns."""
    slack = 8.0 * EPSILON
    first, last = low - offset - slack * (np.abs(low) + 1.0), high - offset + slack * (np.abs(high) + 1.0)
    return np.ceil(first) <= np.floor(last)


def box_by_box(form: Callable[..., tuple[float, float]]) -> Callable[..., Interval]:
    """A form on one box of floats, applied to every box of arrays."""

    def enclosure(*ends: Array) -> Interval:
        arrays = np.broadcast_arrays(*ends) if ends else [np.zeros(())]
        boxes = zip(*(array.ravel().tolist() for array in arrays), strict=True)
        found = [form(*box) for box in boxes] if ends else [form()]
        low, high = np.array(found, dtype=float).T.reshape(2, *arrays[0].shape)
        return low, high

    return enclosure


def _interval_form(row: Function) -> Callable[..., Interval]:
    match row.interval:
        case Monotone() as form if form.ulps <= ULPS:
            return _monotone(form, ARRAYS[row.name])
        case Even(rising) if rising.ulps <= ULPS:
            even = _monotone(rising, ARRAYS[row.name])
            return lambda low, high: even(*magnitudes(low, high))
        case Wave() as form:
            return _wave(form, ARRAYS[row.name])
        case None:
            return box_by_box(unknown)
        case form:
            return magnitudes if row.name == "abs" else box_by_box(form)


INTERVALS = Forms(TABLE, _interval_form)
"""The range of every function of the table over arrays of boxes, by name."""
