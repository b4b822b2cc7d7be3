"""Values of formulas of which floats lose digits: they belong to the answer, whatever else is
listed."""

from __future__ import annotations

import math

import mpmath
import pytest

import rulesheets
import solver

ROAD = """t = r*tand(d/2)
l = pi*r*d/180
a = r*(1/cosd(d/2) - 1)
m = r*(1 - cosd(d/2))
b = 2*r*sind(d/2)
"""


@pytest.mark.parametrize("d", [0.44, 0.583, 1.7, 20.0])
def test_a_flat_road_curve_comes_first(d: float) -> None:
    """From its length and the offset of its middle; hundreds of others wind around many times."""
    r, half = 300.0, math.radians(d / 2)
    given = {"l": 2 * r * half, "m": 2 * r * math.sin(half / 2) ** 2}
    result = solver.solve(rulesheets.loads(ROAD), given)
    assert (result["r"], result["d"]) == pytest.approx((r, d), rel=1e-8)


@pytest.mark.parametrize("d", [1e-6, 1e-3, 0.1, 3.0])
def test_a_difference_has_the_digits_of_its_inputs(d: float) -> None:
    result = solver.solve(
        rulesheets.loads("a = r*(1/cosd(d/2) - 1)\nq = a/d^2"), {"r": 300.0, "d": d}
    )
    with mpmath.workdps(50):
        a = 300 * (1 / mpmath.cos(mpmath.radians(mpmath.mpf(d) / 2)) - 1)
        exact = float(a), float(a / mpmath.mpf(d) ** 2)
    assert (result["a"], result["q"]) == pytest.approx(exact, rel=4e-16)


@pytest.mark.parametrize("x", [-6.0, -12.0, -17.3, -21.9, -26.0])
def test_a_tail_of_the_normal_distribution_has_all_digits(x: float) -> None:
    """1 + erf(-26) is 6e-296, of which as many digits as floats have decades tell nothing."""
    result = solver.solve(rulesheets.loads("p = (1 + erf(x))/2\nq = 3*p"), {"x": x})
    with mpmath.workdps(50):
        p = mpmath.erfc(-mpmath.mpf(x)) / 2
        exact = float(p), float(3 * p)
    assert (result["p"], result["q"]) == pytest.approx(exact, rel=4e-16, abs=0.0)


def test_an_option_beyond_reach_contradicts_nothing() -> None:
    rules = """d = (ln(S/K) + (r + s^2/2)*T)/(s*sqrt(T))
N1 = (1 + erf(d/sqrt(2)))/2
N2 = (1 + erf((d - s*sqrt(T))/sqrt(2)))/2
C = S*N1 - K*exp(-r*T)*N2"""
    result = solver.solve(
        rulesheets.loads(rules), {"S": 50.0, "K": 100.0, "r": 0.05, "s": 0.2, "T": 0.02}
    )
    with mpmath.workdps(50):
        S, K, r, s, T = (mpmath.mpf(v) for v in (50.0, 100.0, 0.05, 0.2, 0.02))
        d = (mpmath.log(S / K) + (r + s**2 / 2) * T) / (s * mpmath.sqrt(T))
        one, two = (mpmath.erfc(-z / mpmath.sqrt(2)) / 2 for z in (d, d - s * mpmath.sqrt(T)))
        exact = float(S * one - K * mpmath.exp(-r * T) * two)
    assert result["C"] == pytest.approx(exact, rel=1e-14, abs=0.0)


@pytest.mark.parametrize("p", [1e-12, 0.001, 0.05, 0.5, 0.95, 0.975, 1 - 1e-9])
def test_a_quantile_of_the_normal_distribution(p: float) -> None:
    """By the inverse of erf, with the digits that 2*p - 1 loses in the tails."""
    model = rulesheets.loads("p = (1 + erf((x - 100)/(15*sqrt(2))))/2")
    result = solver.solve(model, {"p": p})
    plan = solver.prepare(model, ["p"], ["x"])
    with mpmath.workdps(50):
        exact = float(100 + 15 * mpmath.sqrt(2) * mpmath.erfinv(2 * mpmath.mpf(p) - 1))
    for found in (result["x"], plan(p)[0], plan(p)[0]):
        assert found == pytest.approx(exact, rel=4e-15)
    assert result.complete and len(result.solutions) == 1
