"""Functions of angles, in radians and in degrees: the rows of the table, with every form.

Trigonometry in degrees is exact wherever the exact answer is a float: reduction to the nearest
right angle is exact for every float, so no accuracy is lost near the zeros or at huge angles. The
step to radians is carried out in about 70 bits: the angle in radians is a sum ``high + low``, and
``low`` enters by the first term of the Taylor series (the scheme of Cody and Waite 1980, products
split as in Dekker 1971). Errors stay near one unit in the last place.

``np`` is numpy, ``mp`` a context of mpmath.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from math import acos, asin, atan, copysign, cos, floor, fmod, inf, isinf, isnan, pi, sin, tan
from typing import Any

from rulesheets.functions.intervals import (
    EMPTY,
    LINE,
    POSITIVE,
    ULPS,
    UNIT,
    Interval,
    Monotone,
    Wave,
    down,
    may_contain,
    up,
)
from rulesheets.functions.row import Function, Inverse, both_signs, by, entry
from rulesheets.syntax.nodes import ONE, Expression, Number, call

_SPLITTER = 134217729.0  # 2**27 + 1, Veltkamp's constant for 53 bits

# pi/180 and 180/pi as sums: 26 leading bits (so that products with 27 bits are exact), then the
# rest.
_RADIAN = 0.01745329238474369, 1.3519960527851425e-10
_DEGREE = 57.29577922821045, 2.8487187165804814e-07


def _scaled(x: Any, head: float, tail: float) -> tuple[Any, Any]:
    """``x * (head + tail)`` as an unevaluated sum of two floats (or arrays of them)."""
    spread = _SPLITTER * x
    x_head = spread - (spread - x)
    product = x_head * head
    rest = (x - x_head) * head + x * tail
    high = product + rest
    return high, rest - (high - product)


# --- sine and cosine of degrees: that of an angle plus ``ahead`` right angles ---


def _wave(degrees: float, ahead: int) -> float:
    """Reduced exactly to the nearest right angle."""
    turn = fmod(degrees, 360.0)
    nearest = round(turn / 90.0)
    rest, quarters = turn - 90.0 * nearest, nearest + ahead
    if not quarters & 1 and (rest == 30.0 or rest == -30.0):
        value = copysign(0.5, rest)
    else:
        high, low = _scaled(rest, *_RADIAN)
        value = cos(high) - low * sin(high) if quarters & 1 else sin(high) + low * cos(high)
    return 0.0 - value if quarters & 2 else value


def _waves(np: Any, degrees: Any, ahead: int) -> Any:
    """On arrays."""
    quarters, rest = _reduced(np, degrees)
    quarters = quarters + ahead
    high, low = _scaled(rest, *_RADIAN)
    sine, cosine = np.sin(high), np.cos(high)
    exact = np.where(np.abs(rest) == 30.0, np.copysign(0.5, rest), sine + low * cosine)
    value = np.where(quarters & 1, cosine - low * sine, exact)
    return np.where(quarters & 2, 0.0 - value, value)


def _reduced(np: Any, degrees: Any) -> tuple[Any, Any]:
    """The number of right angles modulo 4 and the remainder, from -45 to 45, both exact."""
    turn = np.fmod(np.asarray(degrees, dtype=float), 360.0)
    quarters = np.rint(turn / 90.0)
    rest = turn - 90.0 * quarters
    return np.where(np.isnan(rest), 0.0, quarters).astype(np.int64) & 3, rest


def _long_wave(mp: Any, x: Any, ahead: int) -> Any:
    """In many digits, with an exact reduction."""
    turn = x % 360 if abs(x) > 180 else x  # a small angle below 0 would lose its digits
    nearest = int(mp.nint(turn / 90))
    rest, quarters = turn - 90 * nearest, nearest + ahead
    if quarters & 1:
        value = mp.cospi(rest / 180)
    else:
        value = mp.sign(rest) / 2 if abs(rest) == 30 else mp.sinpi(rest / 180)
    return -value if quarters & 2 else value


# --- tangent of degrees ---


def _tand(degrees: float) -> float:
    """Raises ZeroDivisionError at its poles."""
    turn = fmod(degrees, 360.0)
    quarters = round(turn / 90.0)
    rest = turn - 90.0 * quarters
    if rest == 45.0 or rest == -45.0:
        tangent = copysign(1.0, rest)
    else:
        high, low = _scaled(rest, *_RADIAN)
        tangent = tan(high)
        tangent += low * (1.0 + tangent * tangent)
    return -1.0 / tangent if quarters & 1 else tangent


def _tangents(np: Any, degrees: Any) -> Any:
    """On arrays, nan at the poles."""
    quarters, rest = _reduced(np, degrees)
    high, low = _scaled(rest, *_RADIAN)
    tangent = np.tan(high)
    tangent = tangent + low * (1.0 + tangent * tangent)
    tangent = np.where(np.abs(rest) == 45.0, np.copysign(1.0, rest), tangent)
    odd = (quarters & 1) == 1
    turned = -1.0 / np.where(odd & (rest != 0.0), tangent, np.nan)
    return np.where(odd, turned, tangent)


def _long_tangent(mp: Any, x: Any) -> Any:
    if x % 90 == 45:
        return mp.sign(x % 180 - 90) * -1
    return _long_wave(mp, x, 0) / _long_wave(mp, x, 1)


def _tangent_range(low: float, high: float) -> Interval:
    """In radians."""
    if isnan(low):
        return EMPTY
    if isinf(low) or isinf(high) or isnan(high) or may_contain(low / pi, high / pi, 0.5):
        return LINE
    return down(tan(low), ULPS), up(tan(high), ULPS)


_LARGEST_ANGLE = 1e15
"""Up to here 180 times a whole number plus 90 is exact."""


def _tand_range(low: float, high: float) -> Interval:
    """In degrees: a pole at an end leaves a half line, one inside the whole line."""
    if isnan(low):
        return EMPTY
    if not (abs(low) <= _LARGEST_ANGLE and abs(high) <= _LARGEST_ANGLE):
        return LINE
    start = 180.0 * floor((low + 90.0) / 180.0) - 90.0  # the last pole at or before it
    start = start - 180.0 if start > low else start
    start = start + 180.0 if start + 180.0 <= low else start
    if low == high == start:
        return EMPTY
    if high > start + 180.0:
        return LINE
    below = -inf if low == start else down(_tand(low), ULPS)
    return below, inf if high == start + 180.0 else up(_tand(high), ULPS)


# --- inverse functions ---


def _in_degrees(radians: Any) -> Any:
    """A float or an array."""
    high, low = _scaled(radians, *_DEGREE)
    return high + low


def _inverse(
    radians: Callable[[float], float], known: Mapping[float, float]
) -> Callable[[float], float]:
    """An inverse function in degrees; ``known`` has the arguments whose result is a float."""

    def degrees(x: float) -> float:
        exact = known.get(x)
        found: float = _in_degrees(radians(x)) if exact is None else exact
        return found

    return degrees


def _arc_sine(x: Expression) -> Expression:
    """``1/sqrt((1 - x)*(1 + x))``, the form without cancellation near the ends."""
    return 1.0 / call("sqrt", (1.0 - x) * (1.0 + x))


# --- the direction of a point (x, y) ---


def _atan2(y: float, x: float) -> float:
    """In radians, in (-pi, pi]. Raises ValueError at the origin."""
    if x == 0.0 and y == 0.0:
        raise ValueError("the origin has no direction")
    return math.atan2(y + 0.0, x)


def _atan2d(y: float, x: float) -> float:
    """In degrees, in (-180, 180]. Raises ValueError at the origin.

    Directions that would round to -180 come out as 180, and a negative zero counts as zero.
    """
    if y == 0.0:
        if x == 0.0:
            raise ValueError("the origin has no direction")
        return 0.0 if x > 0.0 else 180.0
    if x == 0.0:
        return copysign(90.0, y)
    if x == y or x == -y:
        return copysign(45.0 if x > 0.0 else 135.0, y)
    degrees: float = _in_degrees(math.atan2(y, x))
    return 180.0 if degrees == -180.0 else degrees


def _directions_in_degrees(np: Any, y: Any, x: Any) -> Any:
    y, x = np.asarray(y, dtype=float) + 0.0, np.asarray(x, dtype=float) + 0.0
    diagonal = np.copysign(np.where(x > 0.0, 45.0, 135.0), y)
    angle = np.where(np.abs(x) == np.abs(y), diagonal, _in_degrees(np.arctan2(y, x)))
    angle = np.where(angle == -180.0, 180.0, angle)
    return np.where((x == 0.0) & (y == 0.0), np.nan, angle)


def _long_direction(mp: Any, y: Any, x: Any) -> Any:
    if x == 0 and y == 0:
        raise ValueError("the origin has no direction")
    return mp.atan2(y, x)


def _long_direction_in_degrees(mp: Any, y: Any, x: Any) -> Any:
    """A direction closer to -180 than any float counts as just beyond 180, as in floats."""
    if abs(x) == abs(y) != 0:
        return mp.sign(y) * (45 if x > 0 else 135)
    direction = _long_direction(mp, y, x) / mp.pi * 180
    return direction + 360 if float(direction) == -180.0 else direction


def _ball_direction(arb: Any, y: Any, x: Any) -> Any:
    """The same in balls, in degrees."""
    direction = arb.atan2(y, x) / arb.pi() * 180
    behind = float(direction.lower()) == float(direction.upper()) == -180.0
    return direction + 360 if behind else direction


def _direction_range(half_turn: float, unit: float) -> Callable[..., Interval]:
    """Directions in (-half turn, half turn], ``unit`` to a radian.

    Away from the cut (y = 0, x < 0) the direction of a box is bounded by its corners; a box across
    the cut has directions up to half a turn both ways.
    """

    def enclosure(y_low: float, y_high: float, x_low: float, x_high: float) -> Interval:
        if isnan(y_low) or isnan(x_low):
            return EMPTY
        if isnan(y_high) or isnan(x_high) or (y_low < 0.0 <= y_high and x_low < 0.0):
            return -half_turn, half_turn
        ys, xs = (y_low + 0.0, y_high + 0.0), (x_low + 0.0, x_high + 0.0)
        corners = [math.atan2(y, x) * unit for y in ys for x in xs if y or x]
        return (down(min(corners), ULPS), up(max(corners), ULPS)) if corners else EMPTY

    return enclosure


# --- the rows ---

_IN_RADIANS: Mapping[str, Mapping[str, Any]] = {
    "sin": {"value": sin},
    "cos": {"value": cos},
    "tan": {"value": tan, "interval": _tangent_range},
    "asin": {"value": asin, "array": "arcsin"},
    "acos": {"value": acos, "array": "arccos"},
    "atan": {"value": atan, "array": "arctan"},
    "atan2": {
        "value": _atan2,
        "array": lambda np, y, x: np.where(  # nan at the origin
            (x == 0.0) & (y == 0.0), np.nan, np.arctan2(y + 0.0, x)
        ),
        "interval": _direction_range(math.nextafter(pi, inf), 1.0),
        "digits": _long_direction,
        "ball": "atan2",
    },
}
_IN_DEGREES: Mapping[str, Mapping[str, Any]] = {
    "sin": {
        "value": lambda x: _wave(x, 0),
        "array": lambda np, x: _waves(np, x, 0),
        "digits": lambda mp, x: _long_wave(mp, x, 0),
    },
    "cos": {  # + 0.0: its zeros have no sign
        "value": lambda x: _wave(x, 1) + 0.0,
        "array": lambda np, x: _waves(np, x, 1) + 0.0,
        "digits": lambda mp, x: _long_wave(mp, x, 1),
    },
    "tan": {"value": _tand, "array": _tangents, "interval": _tand_range, "digits": _long_tangent},
    "asin": {
        "value": _inverse(asin, {0.5: 30.0, -0.5: -30.0, 1.0: 90.0, -1.0: -90.0}),
        "array": lambda np, x: np.where(
            np.abs(x) == 0.5, np.copysign(30.0, x), _in_degrees(np.arcsin(x))
        ),
    },
    "acos": {
        "value": _inverse(acos, {1.0: 0.0, 0.5: 60.0, 0.0: 90.0, -0.5: 120.0, -1.0: 180.0}),
        "array": lambda np, x: np.where(
            np.abs(x) == 0.5, 90.0 - np.copysign(30.0, x), _in_degrees(np.arccos(x))
        ),
    },
    "atan": {
        "value": _inverse(atan, {1.0: 45.0, -1.0: -45.0}),
        "array": lambda np, x: np.where(
            np.abs(x) == 1.0, np.copysign(45.0, x), _in_degrees(np.arctan(x))
        ),
    },
    "atan2": {
        "value": _atan2d,
        "array": _directions_in_degrees,
        "interval": _direction_range(180.0, 180.0 / pi),
        "digits": _long_direction_in_degrees,
        "ball": _ball_direction,
    },
}
"""Forms of the functions whose names have the end ``d``."""


def _angular(end: str, unit: str, half: Expression, turn: float) -> tuple[Function, ...]:
    """The functions of angles in a unit, named with this ``end``; ``half`` is half a turn."""
    degrees = end == "d"
    forms = _IN_DEGREES if degrees else _IN_RADIANS
    radian, per_unit = (180.0 / call("pi"), call("pi") / 180.0) if degrees else (ONE, ONE)
    straight, right = ("180", "90") if degrees else ("pi", "pi/2")
    names = ("sin", "cos", "tan", "asin", "acos", "atan")
    sin, cos, tan, asin, acos, atan = (f"{name}{end}" for name in names)

    def takes(name: str, word: str, example: str, **facets: Any) -> Function:
        if degrees:
            facets["ball"] = lambda arb, x: getattr(x / 180, f"{name}_pi")()
            facets["definition"] = lambda x: call(name, call("pi") * x / 180.0)
        return entry(name + end, f"{word} of x {unit}", example, turn=turn, **forms[name], **facets)

    def gives(name: str, meaning: str, example: str, **facets: Any) -> Function:
        if degrees:
            facets["definition"] = lambda *x: call(name, *x) / call("pi") * 180.0
        return entry(name + end, meaning, example, angle=turn, **forms[name], **facets)

    return (
        takes(
            *("sin", "sine", "sind(30) = 0.5" if degrees else "sin(pi/6) = 0.5"),
            slopes=lambda x: per_unit * call(cos, x),
            inverse=Inverse(
                lambda t: (call(asin, t), half - call(asin, t)), -1.0, 1.0, period=turn
            ),
            interval=Wave(forms["sin"]["value"], turn, 0.25),
        ),
        takes(
            *("cos", "cosine", "cosd(90) = 0" if degrees else "cos(pi/3) = 0.5"),
            slopes=lambda x: per_unit * -call(sin, x),
            inverse=Inverse(both_signs(acos), -1.0, 1.0, period=turn),
            interval=Wave(forms["cos"]["value"], turn, 0.0),
        ),
        takes(
            *("tan", "tangent", "tand(45) = 1" if degrees else "tan(pi/4) = 1"),
            slopes=lambda x: per_unit * (1.0 + call(tan, x) ** 2.0),
            inverse=Inverse(lambda t: (call(atan, t), call(atan, t) + half), period=turn),
            half_turn=True,
        ),
        gives(
            *("asin", f"inverse sine, in {unit} from -{right} to {right}"),
            "asind(0.5) = 30" if degrees else "asin(1) = pi/2",
            slopes=lambda x: radian * _arc_sine(x),
            inverse=Inverse(by(sin), -turn / 4, turn / 4),
            interval=Monotone(forms["asin"]["value"], UNIT, (-90.0, 90.0) if degrees else LINE),
        ),
        gives(
            *("acos", f"inverse cosine, in {unit} from 0 to {straight}"),
            "acosd(0.5) = 60" if degrees else "acos(-1) = pi",
            slopes=lambda x: radian * -_arc_sine(x),
            inverse=Inverse(by(cos), 0.0, turn / 2),
            interval=Monotone(
                forms["acos"]["value"], UNIT, (0.0, 180.0) if degrees else POSITIVE, falling=True
            ),
        ),
        gives(
            *("atan", f"inverse tangent, in {unit} from -{right} to {right}"),
            "atand(1) = 45" if degrees else "atan(1) = pi/4",
            slopes=lambda x: radian * (1.0 / (1.0 + x**2.0)),
            inverse=Inverse(by(tan), -turn / 4, turn / 4, True, True),
            interval=Monotone(forms["atan"]["value"], image=(-90.0, 90.0) if degrees else LINE),
        ),
        gives(
            *("atan2", f"angle of the point (x, y) in {unit}, to {straight}"),
            "atan2d(1, -1) = 135" if degrees else "atan2(1, -1) = 3*pi/4",
            arguments="y, x",
            slopes=lambda y, x: (radian * x / (x**2.0 + y**2.0), -(radian * y / (x**2.0 + y**2.0))),
            steady=lambda y, x: bool(x > 0 or y < 0 or y >= 0),  # on one side of its cut
            alike=True,
        ),
    )


_RADIANS = _angular("", "radians", call("pi"), math.tau)
ANGULAR = *_RADIANS, *_angular("d", "degrees", Number(180.0), 360.0)
