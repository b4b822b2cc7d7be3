"""Blocks with several tears in finite ranges: every root, with proof."""

from __future__ import annotations

import pytest

import rulesheets
import solver

HIMMELBLAU = """\
variables
  x in [-6, 6]
  y in [-6, 6]
rules
  4*x^3 + 4*x*y - 42*x + 2*y^2 - 14 = 0
  4*y^3 + 2*x^2 - 26*y + 4*x*y - 22 = 0
"""
MINIMA = [(3.0, 2.0), (-2.805118, 3.131312), (-3.779310, -3.283186), (3.584428, -1.848126)]
"""D. M. Himmelblau, *Applied Nonlinear Programming* (1972): the four minima of his function."""


def test_all_nine_stationary_points_are_found_and_proven() -> None:
    result = solver.solve(rulesheets.loads(HIMMELBLAU))
    assert str(result.status) == "solved"
    assert result.complete
    points = [(solution["x"], solution["y"]) for solution in result.solutions]
    assert len(points) == 9
    for minimum in MINIMA:
        assert any(point == pytest.approx(minimum, abs=1e-6) for point in points)


def test_ranges_without_a_root_are_proven_infeasible() -> None:
    sheet = HIMMELBLAU.replace("x in [-6, 6]", "x in [4, 6]")
    assert str(solver.solve(rulesheets.loads(sheet)).status) == "infeasible"


def test_no_box_is_left_where_the_first_is_ruled_out() -> None:
    sheet = (
        "variables\n  x in [0, 1]\n  y in [0, 1]\nrules\n  x + sin(y*x) = 5 - y*x\n  y + "
        "exp(-x*y) = 5 + x\n"
    )
    assert str(solver.solve(rulesheets.loads(sheet)).status) == "infeasible"
