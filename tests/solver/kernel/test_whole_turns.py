"""Whole turns in ranges that hold more of them than are listed, or than there are floats."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

import rulesheets
import solver


def answers(rule: str, low: float, high: float) -> tuple[solver.Result, list[float]]:
    model = rulesheets.loads(f"variables\n  x in [{low!r}, {high!r}]\nrules\n  {rule}\n")
    result = solver.solve(model)
    return result, [float(answer["x"]) for answer in result.solutions]


@pytest.mark.parametrize("low", [1e6, -1e7, 123_456_789.0, -5e6])
def test_a_range_far_from_0_is_answered_from_its_near_end(low: float) -> None:
    high = low + 9e6
    result, found = answers("sind(x) = 0.5", low, high)
    assert str(result.status) == "solved" and not result.complete
    assert all(low <= x <= high and x % 360.0 in (30.0, 150.0) for x in found)
    near = min(max(0.0, low), high)
    closest = sorted((t + r for t in range(-720, 721, 360) for r in (30.0, 150.0)), key=abs)
    around = [near - near % 360.0 + turn for turn in closest]
    inside = sorted((x for x in around if low <= x <= high), key=lambda x: abs(x - near))
    assert set(inside[:2]) <= set(found)


@pytest.mark.parametrize(
    ("rule", "power"), [("sin(1e308*x) = 0.5", 1), ("sin(1e308*x^2) = 0.5", 2)]
)
def test_more_turns_than_there_are_floats(rule: str, power: int) -> None:
    """Answers next to 0 are there; that there are others is said."""
    result, found = answers(rule, 0.0, 1e300)
    assert str(result.status) == "solved" and not result.complete
    with mpmath.workdps(50):
        first = (mpmath.asin(0.5) / mpmath.mpf(1e308)) ** (mpmath.mpf(1) / power)
        assert abs(min(found) / first - 1) < 1e-14


@pytest.mark.parametrize("reach", [23.45, 80.0, 200.0, 500.0])
@pytest.mark.parametrize("phase", [0.0, 77.0])
@pytest.mark.parametrize("tangent", [-2.0, 0.1, 5.0])
def test_the_rule_of_a_quantity_bounds_its_turns(
    reach: float, phase: float, tangent: float
) -> None:
    """The sun's declination is within 23.45 degrees, though no range of it is declared."""
    model = rulesheets.loads(
        f"variables\n  day in [0, 365]\nrules\n"
        f"  dec = {reach}*sind(360*day/365 + {phase})\n  t = tand(dec)\n"
    )
    result = solver.solve(model, {"t": tangent})
    days = np.linspace(0.0, 365.0, 400_001)
    turned = reach * np.sin(np.radians(360.0 * days / 365.0 + phase)) - np.degrees(
        np.arctan(tangent)
    )
    crossed = np.diff(np.floor(turned / 180.0)) != 0.0
    assert result.complete
    found = sorted(answer["day"] for answer in result.solutions)
    assert found == pytest.approx(days[1:][crossed], abs=2e-3)
