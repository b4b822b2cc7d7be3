"""Angles of the variable sheet within one turn."""

from __future__ import annotations

import math
from cmath import phase

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
    text = (
        "variables\n  a [deg]\nrules\n  cosd(a + 90) = cosd(200)\n  sind(a + 90) = sind(200)\n  b "
        "= a + 90"
    )
    result = solver.solve(rulesheets.loads(text))
    assert str(result.status) == "solved"
    for solution in result.solutions:
        assert -180 < solution["a"] <= 180
        assert solution["b"] == pytest.approx(solution["a"] + 90, rel=1e-15)


@pytest.mark.parametrize(
    ("rule", "y", "expected"),
    [
        ("y = tand(x/2)", 1.0, [90.0]),
        ("y = tand(0.5*x)", -1.0, [-90.0]),
        ("y = tand(x/3)", 1.0, [135.0]),
        ("y = tan(x/2)", 1.0, [math.pi / 2]),
        ("y = sind(x/2)", 0.5, [60.0]),
        ("y = cosd(x/2)", 0.5, [-120.0, 120.0]),
        ("y = cosd(x/2)", -0.5, [-240.0, 240.0]),
        ("y = sind(1.5*x)", 1.0, [60.0]),
        ("y = sind(2*x)", 1.0, [-135.0, 45.0]),
    ],
)
def test_an_angle_that_is_read_in_parts_is_looked_for_in_one_turn(
    rule: str, y: float, expected: list[float]
) -> None:
    """(-180, 180] comes first, and it is known that these are all, although x goes on for more
    turns."""
    result = solver.solve(rulesheets.loads(rule), {"y": y})
    assert sorted(s["x"] for s in result.solutions) == pytest.approx(sorted(expected))
    assert result.complete or str(result.status) == "singular"


def test_the_angle_of_a_cone_is_one_answer() -> None:
    """Radii and height of a frustum, its angle by the halves of two triangles."""
    rules = "r1/h1 = tand(th/2)\nr2/h2 = tand(th/2)\nh = h2 - h1"
    result = solver.solve(rulesheets.loads(rules), {"r1": 1.0, "r2": 2.0, "h": 3.0})
    assert [s["th"] for s in result.solutions] == pytest.approx(
        [2 * math.degrees(math.atan(1 / 3))]
    )


LOOP = "110*sind(t3) = 80*sind(t4) - 40*sind(50)\n110*cosd(t3) = 100 + 80*cosd(t4) - 40*cosd(50)\n"


@pytest.mark.parametrize(
    ("rule", "value", "complete"),
    [
        ("mu = abs(t4 - t3)", lambda t3, t4: abs(t4 - t3), False),
        ("mu = min(t4 - t3, 180 + t3 - t4)", lambda t3, t4: min(t4 - t3, 180 + t3 - t4), False),
        ("mu = 180 + 2*t3 - 4*t4", lambda t3, t4: 180 + 2 * t3 - 4 * t4, True),
    ],
)
def test_what_is_made_of_angles_does_not_call_for_their_other_turns(
    rule: str, value, complete: bool
) -> None:
    """The two positions of a four-bar linkage, by the circles of its joints, and its transmission
    angle."""
    crank = 40 * complex(math.cos(math.radians(50)), math.sin(math.radians(50)))
    far, pivot = abs(100 - crank), (100 - crank) / abs(100 - crank)
    along = (110**2 - 80**2 + far**2) / (2 * far)
    joints = [
        crank + pivot * complex(along, side * math.sqrt(110**2 - along**2)) for side in (1, -1)
    ]
    angles = [[math.degrees(phase(j - crank)), math.degrees(phase(j - 100))] for j in joints]
    result = solver.solve(rulesheets.loads(LOOP + rule))
    found = sorted([s["t3"], s["t4"], s["mu"]] for s in result.solutions)
    assert found == [pytest.approx([*pair, value(*pair)], rel=1e-9) for pair in sorted(angles)]
    assert result.complete == complete
