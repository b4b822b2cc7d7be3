"""Rounding functions and special functions on floats.

The special functions that ``math`` lacks come from scipy, which is imported at the first call.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache


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


def mod(x: float, y: float) -> float:
    """``x - y*int(x/y)``, exact; it has the sign of x. Raises ValueError where y is 0."""
    return math.fmod(x, y)


def atan2(y: float, x: float) -> float:
    """Direction of the point (x, y) in radians, in (-pi, pi]. Raises ValueError at the origin."""
    if x == 0.0 and y == 0.0:
        raise ValueError("the origin has no direction")
    return math.atan2(y + 0.0, x)


def step(x: float, a: float) -> float:
    """1 where x is a or more, else 0."""
    return 1.0 if x >= a else 0.0


@cache
def _scipy(name: str) -> Callable[..., float]:
    from scipy import special

    function: Callable[..., float] = getattr(special, name)
    return function


def _finite(name: str, *arguments: float) -> float:
    result = float(_scipy(name)(*arguments))
    if not math.isfinite(result):
        raise ValueError(f"{name} is not defined there")
    return result


def _whole(order: float) -> int:
    if order != math.trunc(order):
        raise ValueError("the order of a Bessel function is a whole number")
    return int(order)


def _of_scipy(name: str) -> Callable[..., float]:
    return lambda *arguments: _finite(name, *arguments)


def jn(order: float, x: float) -> float:
    return _finite("jv", _whole(order), x)


def yn(order: float, x: float) -> float:
    return _finite("yv", _whole(order), x)


beta, digamma = _of_scipy("beta"), _of_scipy("digamma")
j0, j1, y0, y1 = map(_of_scipy, ("j0", "j1", "y0", "y1"))
i0, i1, k0, k1 = map(_of_scipy, ("i0", "i1", "k0", "k1"))
