"""The functions of the language on floats.

The special functions that ``math`` lacks come from scipy, which is imported at the first call.
Trigonometry in degrees is exact wherever the exact answer is a float: reduction to the nearest
right angle is exact for every float, so no accuracy is lost near the zeros or at huge angles. The
step to radians is carried out in about 70 bits: the angle in radians is a sum ``high + low``, and
``low`` enters by the first term of the Taylor series (the scheme of Cody and Waite 1980, products
split as in Dekker 1971). Errors stay near one unit in the last place."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from math import acos, asin, atan, copysign, cos, fmod, sin, tan


def sgn(x: float) -> float:
    """-1, 0 or 1."""
    return math.copysign(1.0, x) if x else 0.0


def int_(x: float) -> float:
    """The whole part: truncated toward zero, as in TK."""
    return float(math.trunc(x))


def frac(x: float) -> float:
    """The part after the point, with the sign of x: ``x - int(x)``."""
    return math.fmod(x, 1.0)


def round_(x: float) -> float:
    """The nearest whole number, halves away from zero."""
    whole = math.trunc(x)
    rest = x - whole
    if abs(rest) >= 0.5:
        whole += 1 if rest > 0.0 else -1
    return float(whole)


def atan2(y: float, x: float) -> float:
    """Direction of the point (x, y) in radians, in (-pi, pi]. Raises ValueError at the origin."""
    if x == 0.0 and y == 0.0:
        raise ValueError("the origin has no direction")
    return math.atan2(y + 0.0, x)


def step(x: float, a: float) -> float:
    """1 if x is a or more, else 0."""
    return 1.0 if x >= a else 0.0


@cache
def _scipy(name: str) -> Callable[..., float]:
    from scipy import special

    function: Callable[..., float] = getattr(special, name)
    return function


def _of_scipy(name: str) -> Callable[..., float]:
    def value(*arguments: float) -> float:
        result = float(_scipy(name)(*arguments))
        if not math.isfinite(result):
            raise ValueError(f"{name} is not defined there")
        return result

    return value


def _whole(order: float) -> int:
    if order != math.trunc(order):
        raise ValueError("the order of a Bessel function is a whole number")
    return int(order)


_jv, _yv = map(_of_scipy, ("jv", "yv"))


def jn(order: float, x: float) -> float:
    return _jv(_whole(order), x)


def yn(order: float, x: float) -> float:
    return _yv(_whole(order), x)


beta, digamma = _of_scipy("beta"), _of_scipy("digamma")
j0, j1, y0, y1 = map(_of_scipy, ("j0", "j1", "y0", "y1"))
i0, i1, k0, k1 = map(_of_scipy, ("i0", "i1", "k0", "k1"))


_SPLITTER = 134217729.0  # 2**27 + 1, Veltkamp's constant for 53 bits

# pi/180 and 180/pi as sums: 26 leading bits (so that products with 27 bits are exact), then the
# rest.
RADIAN = 0.01745329238474369, 1.3519960527851425e-10
_DEGREE = 57.29577922821045, 2.8487187165804814e-07


def scaled(x: float, head: float, tail: float) -> tuple[float, float]:
    """``x * (head + tail)`` as an unevaluated sum of two floats (or arrays of them)."""
    spread = _SPLITTER * x
    x_head = spread - (spread - x)
    product = x_head * head
    rest = (x - x_head) * head + x * tail
    high = product + rest
    return high, rest - (high - product)


def _wave(degrees: float, ahead: int) -> float:
    """The sine of an angle plus ``ahead`` right angles, reduced exactly to the nearest right
    angle."""
    turn = fmod(degrees, 360.0)
    nearest = round(turn / 90.0)
    rest, quarters = turn - 90.0 * nearest, nearest + ahead
    if not quarters & 1 and (rest == 30.0 or rest == -30.0):
        value = copysign(0.5, rest)
    else:
        high, low = scaled(rest, *RADIAN)
        value = cos(high) - low * sin(high) if quarters & 1 else sin(high) + low * cos(high)
    return 0.0 - value if quarters & 2 else value


def sind(degrees: float) -> float:
    return _wave(degrees, 0)


def cosd(degrees: float) -> float:
    """Cosine of an angle in degrees; zero comes out as +0.0."""
    return _wave(degrees, 1) + 0.0


def tand(degrees: float) -> float:
    """Tangent of an angle in degrees. Raises ZeroDivisionError at its poles."""
    turn = fmod(degrees, 360.0)
    quarters = round(turn / 90.0)
    rest = turn - 90.0 * quarters
    if rest == 45.0 or rest == -45.0:
        tangent = copysign(1.0, rest)
    else:
        high, low = scaled(rest, *RADIAN)
        tangent = tan(high)
        tangent += low * (1.0 + tangent * tangent)
    return -1.0 / tangent if quarters & 1 else tangent


def in_degrees(radians: float) -> float:
    high, low = scaled(radians, *_DEGREE)
    return high + low


def _inverse(
    radians: Callable[[float], float], known: dict[float, float]
) -> Callable[[float], float]:
    """An inverse function in degrees; ``known`` has the arguments whose result is a float."""

    def degrees(x: float) -> float:
        exact = known.get(x)
        return in_degrees(radians(x)) if exact is None else exact

    return degrees


asind = _inverse(asin, {0.5: 30.0, -0.5: -30.0, 1.0: 90.0, -1.0: -90.0})
acosd = _inverse(acos, {1.0: 0.0, 0.5: 60.0, 0.0: 90.0, -0.5: 120.0, -1.0: 180.0})
atand = _inverse(atan, {1.0: 45.0, -1.0: -45.0})


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
    degrees = in_degrees(math.atan2(y, x))
    return 180.0 if degrees == -180.0 else degrees
