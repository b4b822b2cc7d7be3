"""Functions in many digits that mpmath lacks, or defines differently; ``mp`` is a context."""

from __future__ import annotations

from typing import Any, TypeAlias

Extended: TypeAlias = Any
"""A number of mpmath (which has no types of its own)."""

MOST_ORDER = 1_000
"""The largest order of a Bessel function: beyond it, one value takes longer than an answer is
worth."""


def truncated(mp: Any, x: Extended) -> Extended:
    return mp.floor(x) if x >= 0 else mp.ceil(x)


def lgamma(mp: Any, x: Extended) -> Extended:
    return mp.ln(abs(mp.gamma(x))) if x < 0 else mp.loggamma(x)


# --- angles ---------------------------------------------------------------------


def atan2(mp: Any, y: Extended, x: Extended) -> Extended:
    if x == 0 and y == 0:
        raise ValueError("the origin has no direction")
    return mp.atan2(y, x)


def atan2d(mp: Any, y: Extended, x: Extended) -> Extended:
    """A direction closer to -180 than any float counts as just beyond 180, as in floats."""
    if abs(x) == abs(y) != 0:
        return mp.sign(y) * (45 if x > 0 else 135)
    direction = atan2(mp, y, x) / mp.pi * 180
    return direction + 360 if float(direction) == -180.0 else direction


def _wave(mp: Any, x: Extended, ahead: int) -> Extended:
    """The sine of x degrees plus ``ahead`` right angles, with an exact reduction."""
    turn = x % 360 if abs(x) > 180 else x  # a small angle below 0 would lose its digits
    nearest = int(mp.nint(turn / 90))
    rest, quarters = turn - 90 * nearest, nearest + ahead
    if quarters & 1:
        value = mp.cospi(rest / 180)
    else:
        value = mp.sign(rest) / 2 if abs(rest) == 30 else mp.sinpi(rest / 180)
    return -value if quarters & 2 else value


def sind(mp: Any, x: Extended) -> Extended:
    return _wave(mp, x, 0)


def cosd(mp: Any, x: Extended) -> Extended:
    return _wave(mp, x, 1)


def tand(mp: Any, x: Extended) -> Extended:
    return mp.sign(x % 180 - 90) * -1 if x % 90 == 45 else sind(mp, x) / cosd(mp, x)


# --- Bessel functions -----------------------------------------------------------


def bessel(mp: Any, kind: str, order: Extended, x: Extended) -> Extended:
    """A Bessel function of whole order."""
    if not mp.isint(order) or abs(order) > MOST_ORDER:
        raise ValueError("the order is no whole number of ordinary size")
    return getattr(mp, f"bessel{kind}")(order, x)


# --- balls: of ``arb`` and its balls --------------------------------------------


def ball_truncated(arb: Any, x: Any) -> Any:
    return x.floor() if x >= 0 else x.ceil() if x <= 0 else x.floor().union(x.ceil())


def ball_step(arb: Any, x: Any, a: Any) -> Any:
    return arb(1) if x >= a else arb(0) if x < a else arb(0).union(arb(1))


def ball_direction(arb: Any, y: Any, x: Any) -> Any:
    """In degrees. A direction closer to -180 than any float counts as just beyond 180, as in
    floats."""
    direction = arb.atan2(y, x) / arb.pi() * 180
    behind = float(direction.lower()) == float(direction.upper()) == -180.0
    return direction + 360 if behind else direction


def same_whole(x: Any) -> bool:
    """Whether all numbers of a ball have the same integer part."""
    return bool(ball_truncated(None, x.lower()) == ball_truncated(None, x.upper()))


def on_one_side(y: Any, x: Any) -> bool:
    """Whether a direction stays on one side of its cut, which belongs to the half plane above
    it."""
    return bool(x > 0 or y < 0 or y >= 0)
