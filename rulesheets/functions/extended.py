"""The built-in functions to any number of digits, by mpmath (the only import of it).

Each precision has a context of its own (in each thread), so nothing here touches mpmath's global one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, partial
from threading import get_ident
from typing import Any, TypeAlias

import mpmath
from mpmath.libmp import NoConvergence

from rulesheets.functions import extended_bessel, extended_erf

Extended: TypeAlias = Any
"""A number of mpmath (which has no types of its own)."""

LARGE = 2**20


def context(digits: int) -> Any:
    """The context that works with ``digits`` decimal digits, one of each thread: mpmath changes the
    precision of a context while it computes."""
    return _context(get_ident(), digits)


@cache
def _context(thread: int, digits: int) -> Any:
    made = mpmath.MPContext()
    made.dps = digits
    return made


def functions(digits: int) -> Mapping[str, Callable[..., Extended]]:
    """A function of mpmath numbers for every row of ``TABLE``.

    Outside its domain one raises ValueError or ZeroDivisionError.
    """
    return _functions(get_ident(), digits)


@cache
def _functions(thread: int, digits: int) -> Mapping[str, Callable[..., Extended]]:
    mp = context(digits)
    return {
        **{name: _real(mp, getattr(mp, name)) for name in _SAME_NAME},
        **{name: _real(mp, getattr(mp, other)) for name, other in _OTHER_NAME.items()},
        "exp": _real(mp, partial(_exp, mp)),
        "erf": _real(mp, partial(extended_erf.erf, mp)),
        "erfc": _real(mp, partial(extended_erf.erfc, mp)),
        "sinh": _real(mp, partial(_hyperbolic, mp, mp.sinh)),
        "cosh": _real(mp, partial(_hyperbolic, mp, mp.cosh)),
        **_of_parts(mp),
        **_of_degrees(mp),
        **_bessel(mp),
    }


_SAME_NAME = (
    *("sqrt", "ln", "sin", "cos", "tan", "asin", "acos", "atan"),
    *("tanh", "asinh", "acosh", "atanh", "gamma", "digamma", "beta"),
)
_OTHER_NAME = {"log": "log10", "log10": "log10", "abs": "fabs"}


def _real(mp: Any, function: Callable[..., Extended]) -> Callable[..., Extended]:
    """The function over the reals: complex and infinite answers are refused."""

    def value(*arguments: Extended) -> Extended:
        try:
            result = function(*arguments)
        except NoConvergence as endless:
            raise ValueError("no value within the limits of mpmath") from endless
        if isinstance(result, mp.mpc) or not mp.isfinite(result):
            raise ValueError("no real value")
        return mp.mpf(result)

    return value


def _exp(mp: Any, x: Extended) -> Extended:
    """Of large whole numbers mpmath makes a power of e, squared and squared again with ever more digits."""
    if abs(x) < LARGE or not mp.isint(x):
        return mp.exp(x)
    return mp.exp(mp.fsub(x, 0.5, exact=True)) * mp.exp(0.5)


def _hyperbolic(mp: Any, function: Callable[[Extended], Extended], x: Extended) -> Extended:
    """sinh and cosh; of large whole numbers half a power of e, as the other half is below any digits."""
    if abs(x) < LARGE or not mp.isint(x):
        return function(x)
    return _exp(mp, abs(x)) / 2 * mp.sign(function(mp.sign(x)))


def _of_parts(mp: Any) -> dict[str, Callable[..., Extended]]:
    """Constants and the functions with jumps and kinks."""

    def truncated(x: Extended) -> Extended:
        return mp.floor(x) if x >= 0 else mp.ceil(x)

    def rounded(x: Extended) -> Extended:
        return mp.sign(x) * mp.floor(abs(x) + mp.mpf(0.5))

    def mod(x: Extended, y: Extended) -> Extended:
        if y == 0:
            raise ValueError("remainder of a division by 0")
        remainder = abs(x) % abs(y)
        return remainder if x >= 0 else -remainder

    return {
        "pi": lambda: +mp.pi,
        "e": lambda: +mp.e,
        "sgn": mp.sign,
        "int": truncated,
        "frac": lambda x: x - truncated(x),
        "round": rounded,
        "mod": mod,
        "step": lambda x, a: mp.mpf(x >= a),
        "min": lambda *numbers: min(numbers),
        "max": lambda *numbers: max(numbers),
        "atan2": lambda y, x: _direction(mp, y, x, mp.pi),
        "lgamma": lambda x: mp.ln(abs(mp.gamma(x))) if x < 0 else _real(mp, mp.loggamma)(x),
    }


def _direction(mp: Any, y: Extended, x: Extended, half_turn: Extended) -> Extended:
    """Direction of (x, y) in (-half turn, half turn]."""
    if x == 0 and y == 0:
        raise ValueError("the origin has no direction")
    if y == 0:
        return mp.zero if x > 0 else +half_turn
    if abs(x) == abs(y):
        return mp.sign(y) * half_turn / 4 * (1 if x > 0 else 3)
    direction = mp.atan2(y, x) / mp.pi * half_turn
    return abs(direction) if direction <= -half_turn else direction


def _of_degrees(mp: Any) -> dict[str, Callable[..., Extended]]:
    """Degrees: reduction to the nearest right angle is exact, as in ``degrees``."""

    def wave(x: Extended, ahead: int) -> Extended:
        """Sine of x and ``ahead`` right angles."""
        turn = x % 360 if abs(x) > 180 else x  # a small angle below 0 would lose its digits
        nearest = int(mp.nint(turn / 90))
        rest, quarters = turn - 90 * nearest, nearest + ahead
        if quarters & 1:
            value = mp.cospi(rest / 180)
        else:
            value = mp.sign(rest) / 2 if abs(rest) == 30 else mp.sinpi(rest / 180)
        return -value if quarters & 2 else value

    def sind(x: Extended) -> Extended:
        return wave(x, 0)

    def cosd(x: Extended) -> Extended:
        return wave(x, 1)

    def tand(x: Extended) -> Extended:
        return mp.sign(x % 180 - 90) * -1 if x % 90 == 45 else sind(x) / cosd(x)

    def in_degrees(function: Callable[[Extended], Extended]) -> Callable[[Extended], Extended]:
        return _real(mp, lambda x: function(x) / mp.pi * 180)

    def atan2d(y: Extended, x: Extended) -> Extended:
        """A direction next to -180 to which no float belongs is a hair beyond 180, as floats have it."""
        direction = _direction(mp, y, x, mp.mpf(180))
        return direction + 360 if float(direction) == -180.0 else direction

    return {
        "sind": sind,
        "cosd": cosd,
        "tand": tand,
        "asind": in_degrees(mp.asin),
        "acosd": in_degrees(mp.acos),
        "atand": in_degrees(mp.atan),
        "atan2d": atan2d,
    }


def _bessel(mp: Any) -> dict[str, Callable[..., Extended]]:
    wide = context(mp.dps + extended_bessel.GUARD)

    def at_order(function: Callable[..., Extended], order: int) -> Callable[[Extended], Extended]:
        return _real(mp, lambda x: function(order, x))

    return {
        "j0": at_order(mp.besselj, 0),
        "j1": at_order(mp.besselj, 1),
        "jn": _real(mp, partial(extended_bessel.first_kind, wide)),
        "y0": at_order(mp.bessely, 0),
        "y1": at_order(mp.bessely, 1),
        "yn": _real(mp, partial(extended_bessel.second_kind, wide)),
        "i0": at_order(mp.besseli, 0),
        "bessel_i1": at_order(mp.besseli, 1),
        "k0": at_order(mp.besselk, 0),
        "bessel_k1": at_order(mp.besselk, 1),
    }
