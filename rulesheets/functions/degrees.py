"""Trigonometry in degrees on floats, exact wherever the exact answer is a float.

Reduction to the nearest right angle is exact for every float, so no accuracy is lost near the
zeros or at huge angles. The step to radians is carried out in about 70 bits: the angle in radians
is a sum ``high + low``, and ``low`` enters by the first term of the Taylor series (the scheme of
Cody and Waite 1980, products split as in Dekker 1971). Errors stay near one unit in the last place.
"""

from __future__ import annotations

from math import acos, asin, atan, atan2, copysign, cos, fmod, sin, tan

SPLITTER = 134217729.0  # 2**27 + 1, Veltkamp's constant for 53 bits

# pi/180 and 180/pi as sums: 26 leading bits (so that products with 27 bits are exact), then the rest.
RADIAN = 0.01745329238474369, 1.3519960527851425e-10
DEGREE = 57.29577922821045, 2.8487187165804814e-07


_ASIND = {0.5: 30.0, -0.5: -30.0, 1.0: 90.0, -1.0: -90.0}
_ACOSD = {1.0: 0.0, 0.5: 60.0, 0.0: 90.0, -0.5: 120.0, -1.0: 180.0}
_ATAND = {1.0: 45.0, -1.0: -45.0}


def _scaled(x: float, head: float, tail: float) -> tuple[float, float]:
    """``x * (head + tail)`` as an unevaluated sum of two floats."""
    spread = SPLITTER * x
    x_head = spread - (spread - x)
    product = x_head * head
    rest = (x - x_head) * head + x * tail
    high = product + rest
    return high, rest - (high - product)


def _sine(degrees: float) -> float:
    """Sine for angles up to 45 degrees either way."""
    if degrees == 30.0 or degrees == -30.0:
        return copysign(0.5, degrees)
    high, low = _scaled(degrees, *RADIAN)
    return sin(high) + low * cos(high)


def _cosine(degrees: float) -> float:
    """Cosine for angles up to 45 degrees either way."""
    high, low = _scaled(degrees, *RADIAN)
    return cos(high) - low * sin(high)


def _tangent(degrees: float) -> float:
    """Tangent for angles up to 45 degrees either way."""
    if degrees == 45.0 or degrees == -45.0:
        return copysign(1.0, degrees)
    high, low = _scaled(degrees, *RADIAN)
    tangent = tan(high)
    return tangent + low * (1.0 + tangent * tangent)


def _reduced(degrees: float) -> tuple[int, float]:
    """Number of right angles (to the nearest) and what is left, both exact."""
    turn = fmod(degrees, 360.0)
    quarters = round(turn / 90.0)
    return quarters, turn - 90.0 * quarters


def sind(degrees: float) -> float:
    """Sine of an angle in degrees."""
    quarters, rest = _reduced(degrees)
    sine = _cosine(rest) if quarters & 1 else _sine(rest)
    return 0.0 - sine if quarters & 2 else sine


def cosd(degrees: float) -> float:
    """Cosine of an angle in degrees; zero comes out as +0.0."""
    quarters, rest = _reduced(degrees)
    cosine = _sine(rest) if quarters & 1 else _cosine(rest)
    return 0.0 - cosine if (quarters + 1) & 2 else cosine + 0.0


def tand(degrees: float) -> float:
    """Tangent of an angle in degrees. Raises ZeroDivisionError at its poles."""
    quarters, rest = _reduced(degrees)
    tangent = _tangent(rest)
    return -1.0 / tangent if quarters & 1 else tangent


def _in_degrees(radians: float) -> float:
    high, low = _scaled(radians, *DEGREE)
    return high + low


def asind(x: float) -> float:
    """Arc sine in degrees, from -90 to 90."""
    exact = _ASIND.get(x)
    return _in_degrees(asin(x)) if exact is None else exact


def acosd(x: float) -> float:
    """Arc cosine in degrees, from 0 to 180."""
    exact = _ACOSD.get(x)
    return _in_degrees(acos(x)) if exact is None else exact


def atand(x: float) -> float:
    """Arc tangent in degrees, from -90 to 90."""
    exact = _ATAND.get(x)
    return _in_degrees(atan(x)) if exact is None else exact


def atan2d(y: float, x: float) -> float:
    """Direction of the point (x, y) in degrees, in (-180, 180]. Raises ValueError at the origin.

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
    degrees = _in_degrees(atan2(y, x))
    return 180.0 if degrees == -180.0 else degrees
