"""Values of formulas of which floats lose digits: they belong to the answer, whatever else is listed."""

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
    result = solver.solve(rulesheets.loads("a = r*(1/cosd(d/2) - 1)\nq = a/d^2"), {"r": 300.0, "d": d})
    with mpmath.workdps(50):
        a = 300 * (1 / mpmath.cos(mpmath.radians(mpmath.mpf(d) / 2)) - 1)
        exact = float(a), float(a / mpmath.mpf(d) ** 2)
    assert (result["a"], result["q"]) == pytest.approx(exact, rel=4e-16)
