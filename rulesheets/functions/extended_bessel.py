"""Bessel functions of whole order to any number of digits, by recurrence in the order.

The power series that mpmath sums loses x/2 digits, and takes as many terms. The recurrence
f(k+1) + f(k−1) = 2k/x · f(k) takes one step an order and loses none, upward while f does not fall, downward
from far above where it does (J. C. P. Miller; Olver and Sookne, Math. Comp. 26 (1972) 941–947).
"""

from __future__ import annotations

from typing import Any, TypeAlias

Extended: TypeAlias = Any

MOST = 10_000
"""The largest order: beyond it, one value takes longer than an answer is worth."""
FEW = 8
"""Orders up to which mpmath's own series and asymptotic forms are as fast."""
GUARD = 15
"""Digits that the steps may lose: contexts here have so many more than the result."""


def first_kind(mp: Any, order: Extended, x: Extended) -> Extended:
    """J of a whole order. Raises ValueError for other orders, and for those beyond ``MOST``."""
    n, sign = _folded(mp, order, x)
    x = mp.mpf(abs(x))
    if n <= FEW or not x:
        return sign * mp.besselj(n, x)
    if n <= x:
        return sign * _upward(n, x, mp.besselj(0, x), mp.besselj(1, x))
    return sign * _downward(mp, n, x)


def second_kind(mp: Any, order: Extended, x: Extended) -> Extended:
    """Y of a whole order, for positive x. Raises ValueError elsewhere, and for orders beyond ``MOST``."""
    n, sign = _folded(mp, order, x)
    if x <= 0:
        raise ValueError("Y is defined for positive arguments")
    return sign * _upward(n, mp.mpf(x), mp.bessely(0, x), mp.bessely(1, x))


def _folded(mp: Any, order: Extended, x: Extended) -> tuple[int, int]:
    """The size of the order, and the sign: f(−n, x) = f(n, −x) = (−1)ⁿ f(n, x)."""
    if not mp.isint(order) or abs(order) > MOST:
        raise ValueError("the order is no whole number of ordinary size")
    n = int(order)
    return abs(n), -1 if n % 2 and (n < 0) != (x < 0) else 1


def _upward(n: int, x: Extended, below: Extended, here: Extended) -> Extended:
    for k in range(1, n):
        below, here = here, 2 * k / x * here - below
    return here if n else below


def _downward(mp: Any, n: int, x: Extended) -> Extended:
    """From an order so high that what is assumed there does not matter, scaled to order 0 or 1."""
    above, here, value = mp.zero, mp.one, mp.zero
    for k in range(_start(mp, n, x), 0, -1):
        if k == n:
            value = here
        above, here = here, 2 * k / x * here - above
    if abs(here) > abs(above):
        return value * (mp.besselj(0, x) / here)
    return value * (mp.besselj(1, x) / above)


def _start(mp: Any, n: int, x: Extended) -> int:
    """The order from which on J is smaller than at ``n`` by all the digits: the other solution grows so."""
    below, here, k, limit = mp.zero, mp.one, n, mp.mpf(10) ** mp.dps
    while abs(here) < limit:
        below, here = here, 2 * k / x * here - below
        k += 1
    return k
