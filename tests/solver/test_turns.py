"""Angles of the variable sheet within one turn."""

from __future__ import annotations

import pytest

import rulesheets
import solver

TWO_CRANKS = """\
variables
  thetaA [deg]
  x = -1
  y = -1
rules
  thetaB = atan2d(y, x)
  thetaB = thetaA + 90
  z = cosd(thetaA)
"""


def test_an_angle_stays_where_a_rule_ties_it_to_a_direction() -> None:
    """thetaB is -135 by its rule, so that no turn of thetaA keeps ``thetaB = thetaA + 90``."""
    result = solver.solve(rulesheets.loads(TWO_CRANKS))
    assert result["thetaA"] == pytest.approx(-225.0, rel=1e-15)


def test_an_angle_by_its_cosine_moves_and_the_sum_still_holds() -> None:
    text = "variables\n  a [deg]\nrules\n  cosd(a + 90) = cosd(200)\n  sind(a + 90) = sind(200)\n  b = a + 90"
    result = solver.solve(rulesheets.loads(text))
    assert str(result.status) == "solved"
    for solution in result.solutions:
        assert -180 < solution["a"] <= 180
        assert solution["b"] == pytest.approx(solution["a"] + 90, rel=1e-15)
