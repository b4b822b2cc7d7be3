"""Rules that jump: answers are what satisfies them, and not a limit that they jump away from."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rulesheets
import solver

LOW, HIGH = -2, 3


EXACTLY = {
    "int": lambda x: Fraction(math.trunc(x)),
    "frac": lambda x: x - math.trunc(x),
    "round": lambda x: Fraction(math.floor(abs(x) + Fraction(1, 2))) * (1 if x > 0 else -1),
}


def roots(function: str, slope: Fraction, level: Fraction) -> list[Fraction]:
    """All x of the range with f(x) + slope·x = level: of the lines between jumps, what holds as
    written."""
    f, steep = EXACTLY[function], slope + (function == "frac")
    shifts = range(LOW - 2, HIGH + 3)
    found = (
        {(level - (-n if function == "frac" else n)) / steep for n in shifts} if steep else set()
    )
    return [x for x in found if LOW <= x <= HIGH and f(x) + slope * x == level]


@settings(max_examples=6, deadline=None)
@given(
    st.sampled_from(["int", "frac", "round"]),
    st.sampled_from([Fraction(k, 4) for k in (-6, -5, -3, 1, 2, 3, 5, 7)]),
    st.integers(-12, 12).map(lambda k: Fraction(k, 8)),
)
def test_a_line_and_a_jump_meet_where_exact_arithmetic_says(
    function: str, slope: Fraction, level: Fraction
) -> None:
    rule = f"{function}(x) + ({float(slope)})*x = {float(level)}"
    result = solver.solve(rulesheets.loads(f"variables\n  x in [{LOW}, {HIGH}]\nrules\n  {rule}\n"))
    exact = roots(function, slope, level)
    answers = [float(answer["x"]) for answer in result.solutions]
    assert all(any(abs(x - root) < 1e-12 for root in exact) for x in answers)
    if result.complete or str(result.status) == "infeasible":
        assert all(any(abs(x - root) < 1e-12 for x in answers) for root in exact)


@pytest.mark.parametrize(
    ("rule", "edge"),
    [
        ("mod(x, 1) + x^3 + x = 11", 2.0),
        ("step(x, 2) + x^3 + x = 10", 2.0),
        ("sgn(x - 1) + x^3 + x = 1", 1.0),
        ("sgn(x - 1) + x^3 + x = 3", 1.0),
    ],
)
def test_no_answer_next_to_an_edge_that_has_none(rule: str, edge: float) -> None:
    result = solver.solve(rulesheets.loads(rule))
    assert all(abs(answer["x"] - edge) > 1e-3 for answer in result.solutions)


@pytest.mark.parametrize(
    ("rule", "edge"),
    [("int(x) + x = 4", 2.0), ("step(x, 2) + x^3 + x = 11", 2.0), ("round(x) - x = 0.5", 0.5)],
)
def test_an_edge_that_satisfies_its_rule_is_an_answer(rule: str, edge: float) -> None:
    result = solver.solve(rulesheets.loads(rule))
    assert edge in [answer["x"] for answer in result.solutions]


def test_another_variable_may_make_up_for_rounding_next_to_an_edge() -> None:
    """int(x) is 1: 3·y rounds, and y explains it."""
    (answer,) = solver.solve(
        rulesheets.loads("int(x) + 3*y = 3.1"), {"x": 2.0 - 2.0**-52}
    ).solutions
    assert answer["y"] == pytest.approx(0.7, rel=1e-15)


def test_plans_and_sweeps_refuse_a_check_next_to_an_edge() -> None:
    """x is a hair less than 2: no value so near satisfies the check."""
    model = rulesheets.loads("variables\n  a = 3\nrules\n  x = a/3\n  int(x) + x = 3\n")
    below = 5.999999999999999
    assert str(solver.solve(model, {"a": below}).status) == "inconsistent"
    plan = solver.prepare(model, inputs=["a"], want=["x"])
    with pytest.raises(solver.Unsolved):
        plan(below)
    assert np.isnan(plan.sweep([below] * 4)["x"]).all()
