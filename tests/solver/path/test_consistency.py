"""Cases that can be, against brute force: what conditions say at the points of a grid, in
floats."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import rulesheets
import solver
from rulesheets.evaluate import holds
from rulesheets.model import Model
from rulesheets.syntax.nodes import Number
from solver.path import equations_of
from solver.path.cases import (
    AT_LEAST,
    AT_MOST,
    DIFFERENT,
    EQUAL,
    GREATER,
    LESS,
    Pair,
    compatible,
    possible,
)
from solver.path.planner import path_tree

SIGNS = {"<": LESS, "<=": AT_MOST, ">": GREATER, ">=": AT_LEAST, "=": EQUAL, "<>": DIFFERENT}


def signed(*comparisons: str) -> list[tuple[Pair, int]]:
    rules = "\n".join(f"if {comparison} then y = {k}" for k, comparison in enumerate(comparisons))
    conditions = rulesheets.loads(rules).conditions
    return [((c.left, c.right), SIGNS[c.operator]) for c in conditions]  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("comparisons", "expected"),
    [
        (("x >= 0", "x < -2"), False),
        (("x >= -2", "x < 0"), True),
        (("x <= 5", "5 <= x"), True),
        (("x < 5", "5 <= x"), False),
        (("x > 5", "5 > x"), False),
        (("x >= a", "x < b"), False),
        (("x >= b", "x < a"), True),
        (("x = 3", "x >= 4"), False),
        (("x = 3", "x <> 3"), True),
        (("x >= w", "w > x"), False),
        (("x >= w", "x < w + 2"), True),
        (("x - a >= 0", "x - b < 0"), True),
        (("x/2 >= a", "b > x/2"), False),
        (("x^2 >= a", "x^2 < b"), False),
        (("x^2 >= a", "x < b"), True),
        (("x >= 0", "w < -2"), True),
        (("x*1/c > 1", "x < 0"), True),
    ],
)
def test_bounds_on_one_quantity_leave_it_a_value_or_none(
    comparisons: tuple[str, ...], expected: bool
) -> None:
    """a = 0, b = -2; dividing by c = 0 says nothing."""
    assert possible(signed(*comparisons), {"a": 0.0, "b": -2.0, "c": 0.0}) is expected


def test_terms_of_and_and_or_are_alternatives() -> None:
    rules = (
        "if or(x < 0, x > 5) then y = 1\nif and(x >= 1, x < 3) then y = 2\nif not(x < 9) then y = 3"
    )
    outside, inside, far = rulesheets.loads(rules).conditions
    assert not compatible([(outside, True), (inside, True)], {})
    assert compatible([(outside, False), (inside, True)], {})
    assert compatible([(outside, True), (inside, False)], {})
    assert not compatible([(outside, False), (far, True)], {})


OPERATORS = st.sampled_from(["<", "<=", ">", ">="])
PLAIN = st.sampled_from(["x {} {}", "{1} {0} x"])
EXACT = PLAIN | st.sampled_from(["2*x {} {}", "-x {} {}", "x/2 {} {}", "x - {1} {0} 0"])
ROUNDED = st.sampled_from(
    ["3*x {} {}", "x + 0.1 {} {}", "x/3 + x {} {}", "0.7*x - {1} {0} 0.2", "1 - x {} {}"]
)


def chains(
    forms: st.SearchStrategy[str], thresholds: st.SearchStrategy[float]
) -> st.SearchStrategy[list[str]]:
    atom = st.builds(
        lambda form, operator, at: form.format(operator, f"({at!r})"), forms, OPERATORS, thresholds
    )
    return st.lists(atom, min_size=2, max_size=4)


def sheet(conditions: list[str]) -> Model:
    """Arm k gives y = k, and x follows from y."""
    arms = " else ".join(f"if {c} then y = {k}" for k, c in enumerate(conditions))
    return rulesheets.loads(f"{arms} else y = {len(conditions)}\nx = u*y + v")


def arm(model: Model, x: float) -> float:
    """The number of the arm that takes part at x."""
    outcomes = [holds(condition, {"x": x}) for condition in model.conditions]
    return float([*outcomes, True].index(True))


def listed(model: Model) -> set[float]:
    """The arms of the cases that the path shows."""
    ends = path_tree(model, {"u": 1.0, "v": 0.0}).ends()
    used = {equation for end in ends for step in end.path.steps for equation in equations_of(step)}
    return {
        e.right.value for e in model.equations if e.index in used and isinstance(e.right, Number)
    }


@given(chains(PLAIN, st.integers(-4, 4).map(float)))
def test_a_path_shows_the_arms_that_some_point_reaches(conditions: list[str]) -> None:
    """Thresholds are multiples of 1/2 from -8 to 8: steps of 1/4 meet them all, and what lies
    between."""
    model = sheet(conditions)
    assert listed(model) == {arm(model, k / 4) for k in range(-40, 41)}


@given(chains(EXACT | ROUNDED, st.integers(-12, 12).map(lambda k: k / 10)))
def test_no_arm_is_lost_to_rounding(conditions: list[str]) -> None:
    """Points of a decimal grid, which thresholds are next to, and floats next to those."""
    model = sheet(conditions)
    points = [k / n for n in (7, 10, 30) for k in range(-20 * n // 10, 20 * n // 10 + 1)]
    around = [x + step * math.ulp(x) for x in points if x for step in (-2, -1, 0, 1, 2)]
    assert {arm(model, x) for x in around} <= listed(model)


@given(
    chains(EXACT | ROUNDED, st.integers(-4, 4).map(float)), st.sampled_from([-2.0, -0.5, 1.0, 2.0])
)
def test_answers_are_those_of_trying_every_arm(conditions: list[str], slope: float) -> None:
    model = sheet(conditions)
    for offset in (-2.0, 0.0, 1.5):
        tried = {slope * k + offset: float(k) for k in range(len(conditions) + 1)}
        expected = {x: k for x, k in tried.items() if arm(model, x) == k}
        result = solver.solve(model, {"u": slope, "v": offset})
        assert {s["x"]: s["y"] for s in result.solutions} == expected
        assert str(result.status) == ("solved" if expected else "infeasible")
        assert result.complete
