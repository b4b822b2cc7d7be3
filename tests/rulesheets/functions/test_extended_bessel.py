"""Bessel functions of high order to many digits, against integrals, their Wronskian and scipy."""

from __future__ import annotations

import mpmath
import pytest
import scipy.special

from rulesheets.evaluate.digits import Digits, context
from rulesheets.functions import MOST_ORDER as MOST

DIGITS = 40


def bessel(name: str, order: int, x: float) -> mpmath.mpf:
    mp = context(DIGITS)
    return Digits({}, DIGITS).functions[name](mp.mpf(order), mp.mpf(x))


@pytest.mark.parametrize("order", [0, 1, 7, 9, 30, -12, -31])
@pytest.mark.parametrize("x", [0.0, 1e-3, 2.5, 29.0, 31.0, -14.25, 55.0])
def test_the_integral_of_bessel(order: int, x: float) -> None:
    """J is the mean of cos(n t − x sin t) over half a turn; trapezoids of a periodic function are
    exact."""
    with mpmath.workdps(DIGITS + 20):
        steps = 400
        angles = [mpmath.pi * k / steps for k in range(2 * steps)]
        mean = mpmath.fsum(mpmath.cos(order * t - x * mpmath.sin(t)) for t in angles) / (2 * steps)
        assert (
            abs(bessel("jn", order, x) - mean)
            <= mpmath.mpf(10) ** -(DIGITS + 5) + abs(mean) * 10**-36
        )


@pytest.mark.parametrize(("order", "x"), [(900, 810.0), (900, 900.0), (900, 1e8), (60, 2.0)])
def test_the_wronskian(order: int, x: float) -> None:
    """J(n+1) Y(n) − J(n) Y(n+1) = 2/(π x)."""
    with mpmath.workdps(DIGITS):
        crossed = [
            bessel("jn", order + shift, x) * bessel("yn", order + 1 - shift, x) for shift in (1, 0)
        ]
        assert mpmath.almosteq(
            crossed[0] - crossed[1], 2 / (mpmath.pi * x), rel_eps=mpmath.mpf(10) ** -30
        )
    assert float(bessel("jn", order, x)) == pytest.approx(scipy.special.jv(order, x), rel=1e-9)


@pytest.mark.parametrize("order", [2.5, MOST + 1])
def test_orders_that_are_refused(order: float) -> None:
    mp = context(DIGITS)
    for name in ("jn", "yn"):
        with pytest.raises(ValueError, match="order"):
            Digits({}, DIGITS).functions[name](mp.mpf(order), mp.mpf(3))
