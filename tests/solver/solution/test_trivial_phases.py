"""Two phases in equilibrium: the rules also hold on a curve where both are the same, which a
requirement excludes."""

from __future__ import annotations

import math

import pytest
from scipy.optimize import brentq

import rulesheets
import solver

LIQUIDS = """
    ln(g1a) = xa2^2*(A12 + 2*(A21 - A12)*xa1)
    ln(g2a) = xa1^2*(A21 + 2*(A12 - A21)*xa2)
    ln(g1b) = xb2^2*(A12 + 2*(A21 - A12)*xb1)
    ln(g2b) = xb1^2*(A21 + 2*(A12 - A21)*xb2)
    xa1 + xa2 = 1
    xb1 + xb2 = 1
    xa1*g1a = xb1*g1b
    xa2*g2a = xb2*g2b
    xa1 > xb1
"""
VAPOUR = """
    kap = 0.37464 + 1.54226*w - 0.26992*w^2
    al = (1 + kap*(1 - sqrt(T/Tc)))^2
    a = 0.45724*R^2*Tc^2/Pc*al
    b = 0.0778*R*Tc/Pc
    A = a*P/(R*T)^2
    B = b*P/(R*T)
    ZL^3 - (1 - B)*ZL^2 + (A - 3*B^2 - 2*B)*ZL - (A*B - B^2 - B^3) = 0
    ZV^3 - (1 - B)*ZV^2 + (A - 3*B^2 - 2*B)*ZV - (A*B - B^2 - B^3) = 0
    r = sqrt(2)
    lnL = ZL - 1 - ln(ZL - B) - A/(2*r*B)*ln((ZL + (1 + r)*B)/(ZL + (1 - r)*B))
    lnV = ZV - 1 - ln(ZV - B) - A/(2*r*B)*ln((ZV + (1 + r)*B)/(ZV + (1 - r)*B))
    lnL = lnV
    ZV > ZL
"""


def no_curve(result: solver.Result) -> bool:
    return not {d.code for d in result.diagnoses} & {"S511", "S596"}


@pytest.mark.parametrize("a", [2.1, 2.5, 3.5])
def test_two_liquids_of_a_symmetric_mixture(a: float) -> None:
    """x and 1 - x with ln(x/(1 - x)) = A (2x - 1)."""
    found = solver.solve(rulesheets.loads(LIQUIDS), {"A12": a, "A21": a})
    x = brentq(lambda x: math.log(x / (1 - x)) - a * (2 * x - 1), 0.5 + 1e-4, 1 - 1e-9, xtol=1e-15)
    assert found.status is solver.Status.SOLVED
    assert (found["xa1"], found["xb1"]) == pytest.approx((x, 1 - x), rel=1e-10)
    assert no_curve(found)


def test_liquids_that_mix_in_any_share_are_no_freedom() -> None:
    found = solver.solve(rulesheets.loads(LIQUIDS), {"A12": 1.5, "A21": 1.5})
    assert found.status is solver.Status.FAILED
    assert no_curve(found)


@pytest.mark.parametrize("Tc", [400.0, 420.948, 450.0])
def test_the_vapour_pressure_by_an_equation_of_state(Tc: float) -> None:
    given = {"T": 350.0, "Tc": Tc, "Pc": 38.0, "w": 0.193, "R": 83.14}
    found = solver.solve(rulesheets.loads(VAPOUR), given)
    assert found.status is solver.Status.SOLVED
    assert float(found["ZV"] or 0) > 0.5 > float(found["ZL"] or 1)
    assert no_curve(found)
    swapped = {**given, "T": None, "P": found["P"]}
    assert solver.solve(rulesheets.loads(VAPOUR), swapped)["T"] == pytest.approx(350.0, rel=1e-9)
