"""Answers that agree in many digits are two: their distance is known, for it is what the rule
gives."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rulesheets
import solver

DISTANCE = {
    "abs(x - a) = b": lambda b: b,
    "(x - a)^2 = b^2": lambda b: b,
    "max((x - a)^2, -1) = b^2": lambda b: b,
    "(x - a)^2 + (x - a)^4 = b^2": lambda b: (
        math.sqrt((math.sqrt(1 + 4 * b * b) - 1) / 2) if b > 1e-4 else b
    ),
}


@pytest.mark.parametrize("rule", DISTANCE)
@settings(max_examples=4, deadline=None)
@given(st.integers(-200, 200), st.integers(7, 42))
def test_two_answers_that_differ_in_late_digits_are_both_listed(rule: str, a: int, k: int) -> None:
    """All in short binary numbers, so that each distance is that of the rule but for its last
    digits."""
    centre, b = a / 16 or 1.0, 2.0**-k * (abs(a) / 16 or 1.0)
    result = solver.solve(rulesheets.loads(rule), {"a": centre, "b": b})
    far = DISTANCE[rule](b)
    found = sorted(answer["x"] for answer in result.solutions)
    assert str(result.status) == "solved" and len(found) == 2
    for x, exact in zip(found, (centre - far, centre + far), strict=True):
        assert abs(x - exact) <= 1e-3 * far


@pytest.mark.parametrize("a", [0.1 * 3, 1 / 3, 1e10 / 7])
def test_two_ways_to_one_answer_are_one(a: float) -> None:
    """Both signs of a number of size 0 lead to a, by roundings of their own."""
    result = solver.solve(rulesheets.loads("abs(3*x - 3*a) = b"), {"a": a, "b": 0.0})
    (answer,) = result.solutions
    assert answer["x"] == pytest.approx(a, rel=1e-15)


@pytest.mark.parametrize("d", ["1e98", "1e30", "1"])
def test_unknowns_far_below_their_usual_size_that_change_places_are_two_answers(d: str) -> None:
    result = solver.solve(rulesheets.loads(f"d = {d}\nd/(z + w) = {d}/4e20\nz*w = 6e-31"))
    assert result.complete
    found = sorted(answer["z"] for answer in result.solutions)
    assert found == pytest.approx([1.5e-51, 4e20], rel=1e-14, abs=0.0)
