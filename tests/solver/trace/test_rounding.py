"""What records know of their own rounding, against many digits."""

from __future__ import annotations

import math

import mpmath
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rulesheets
import solver
from rulesheets.evaluate import Undefined
from rulesheets.evaluate.digits import extended
from rulesheets.model import Equation
from solver.accuracy.rule_check import check_rule
from solver.solution.explore import planner
from solver.trace.flow import Flow, Numbers
from solver.trace.graph import NotCompilable

DIGITS = 640
"""Of the oracle: what it rounds in the largest of floats is nothing beside 1e-300."""
FUNCTIONS = st.sampled_from(
    ["sin", "cos", "exp", "sqrt", "atan", "abs", "tanh", "sind", "cosd", "ln"]
)


def expressions(leaves: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    return st.recursive(
        leaves,
        lambda inside: st.one_of(
            st.builds("({} {} {})".format, inside, st.sampled_from("+-*/"), inside),
            st.builds("{}({})".format, FUNCTIONS, inside),
            st.builds("({})^2".format, inside),
        ),
        max_leaves=6,
    )


def equation(text: str) -> Equation:
    return rulesheets.loads(f"{text}\n").equations[0]


@settings(max_examples=80, deadline=None)
@given(expressions(st.sampled_from(["x", "y"])), st.floats(0.01, 100), st.floats(-9, 9))
def test_the_error_bound_of_an_operation_holds(text: str, x: float, y: float) -> None:
    """Against many digits; bounds are of first order, so where they are small."""
    rule = equation(f"z = {text}")
    flow = Flow()
    numbers = Numbers(flow, {0: x, 1: y})
    try:
        exact = extended(rule.right, {"x": x, "y": y}, DIGITS)
        node = flow.expression(rule.right, {"x": flow.input(0), "y": flow.input(1)})
    except (Undefined, NotCompilable):
        return
    result, error = float(numbers(node)), numbers.error(node)
    if error < 1e-6 * abs(result) < 1e290:
        with mpmath.workdps(DIGITS):
            assert abs(mpmath.mpf(result) - exact) <= 1.01 * error + 1e-300


def test_the_nearest_to_the_guesses_comes_first_from_plans_too() -> None:
    text = "variables\n  a\n  x ~ -3\n  y ~ 5\nrules\n  x*x = a\n  y*y = a\n"
    plan = solver.prepare(rulesheets.loads(text), ["a"], ["x", "y"])
    for a in (4.0, 9.0, 16.0):
        assert plan(a) == (-math.sqrt(a), math.sqrt(a))
        right = solver.solve(rulesheets.loads(text), {"a": a})
        assert plan.all(a) == [(s["x"], s["y"]) for s in right.solutions]
        assert plan.sweep([a] * 20)["x"] == pytest.approx([-math.sqrt(a)] * 20)


def test_a_row_that_lacks_an_input_teaches_nothing() -> None:
    model = rulesheets.loads("x + y = 3\nx - y = 1\n")
    plan = solver.prepare(model, ["y"], ["x"])
    assert plan(math.nan) == plan(1.0) == (2.0,)
    assert planner(model) is not None


@settings(max_examples=25, deadline=None)
@given(
    st.floats(-2, 2).map(lambda power: 10.0**power),
    st.floats(1, 360),
    st.floats(-100, 100),
    st.floats(-100, 100),
)
def test_rules_hold_where_formulas_cancel(size: float, angle: float, x: float, y: float) -> None:
    """A distance and a direction between points that may be near to one another: the sine and the
    cosine that formulas give are then off the unit circle by more than their rounding."""
    model = rulesheets.loads(f"u = {x!r} + d*cosd(p)\nv = {y!r} + d*sind(p)\n")
    plan = solver.prepare(model, ["u", "v"], ["d", "p"])
    for distance in (30.0, size, 25.0, size):
        u, v = (
            centre + distance * turned(math.radians(angle))
            for centre, turned in ((x, math.cos), (y, math.sin))
        )
        if u == x or v == y:
            continue
        for d, p in (plan(u, v), *plan.all(u, v)):
            values = {"u": u, "v": v, "d": d, "p": p}
            assert all(check_rule(rule, values).holds for rule in model.equations), values
