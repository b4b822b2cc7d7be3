"""What compiled ways know of their own rounding, against exact numbers."""

from __future__ import annotations

import math
import random
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rulesheets
import solver
from rulesheets.evaluate import Undefined, extended, value
from rulesheets.model import Equation
from solver.path.isolate import isolate
from solver.result import CODES
from solver.solution.explore import planner
from solver.trace.arrays import ArrayKernel
from solver.trace.flow import Flow
from solver.trace.graph import NotCompilable
from solver.trace.rounding import Analysis, covered, inverted

UNIT = 2.0**-52
DIGITS = 640
"""Of the oracle: what it rounds in the largest of floats is nothing beside 1e-300."""
NUMBERS = st.sampled_from(["0.1", "3", "90", "1e-3", "7.3", "1e6", "2"])
FUNCTIONS = st.sampled_from(["sin", "cos", "exp", "sqrt", "atan", "abs", "tanh", "sind", "cosd", "ln"])


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
@given(expressions(st.one_of(NUMBERS, st.sampled_from(["x", "y"]))), st.floats(0.01, 100), st.floats(-9, 9))
def test_the_error_bound_of_an_operation_holds(text: str, x: float, y: float) -> None:
    """Against many digits; bounds are of first order, so where they are small."""
    rule = equation(f"z = {text}")
    flow = Flow()
    values = {"x": flow.input(0), "y": flow.input(1)}
    try:
        exact = extended(rule.right, {"x": x, "y": y}, DIGITS)
        node = flow.expression(rule.right, values)
        bound = Analysis(flow).error(node)
    except (Undefined, NotCompilable):
        return
    found = [np.empty(1), np.empty(1)]
    ArrayKernel(flow, (node, bound))([np.array([x]), np.array([y])], found)
    result, error = (float(column[0]) for column in found)
    if error < 1e-6 * abs(result) < 1e290:
        with mpmath.workdps(DIGITS):
            assert abs(mpmath.mpf(result) - exact) <= 1.01 * error + 1e-300


@settings(max_examples=80, deadline=None)
@given(expressions(NUMBERS))
def test_constants_know_how_far_they_are_off(text: str) -> None:
    flow, rule = Flow(), equation(f"z = {text}")
    try:
        exact = extended(rule.right, {}, DIGITS)
        node = flow.expression(rule.right, {})
    except (Undefined, NotCompilable):
        return
    found = flow.value_of(node)
    assert isinstance(found, float)
    if flow.off(node) <= 1e-6 * abs(found):
        with mpmath.workdps(DIGITS):
            assert abs(mpmath.mpf(found) - exact) <= 1.01 * flow.off(node) + 1e-300


@settings(max_examples=80, deadline=None)
@given(expressions(st.one_of(NUMBERS, st.sampled_from(["a", "b", "c"]))), st.data())
def test_variables_explain_what_the_form_of_a_rule_says_they_do(text: str, data: st.DataObject) -> None:
    """The rounding of ``x - (…)`` is at most so many units of Σ|∂F/∂v · v|."""
    rule = equation(f"x = {text}")
    units = covered(rule, False)
    if not units < 1e3:
        return
    values = {name: data.draw(st.floats(0.01, 100)) for name in rule.names}
    try:
        values["x"] = float(extended(rule.right, values, 50))
        miss = missed(rule, values)
        slopes = [slope(rule, values, name) for name in values]
        rough = value(rule.left, values) - value(rule.right, values)
    except Undefined:
        return
    with mpmath.workdps(50):
        size = sum(abs(one * mpmath.mpf(values[name])) for one, name in zip(slopes, values, strict=True))
        assert abs(mpmath.mpf(rough) - miss) <= 1.01 * (units + 1) * UNIT * size + 1e-300


def missed(rule: Equation, values: Mapping[str, Any]) -> Any:
    return extended(rule.left, values, 50) - extended(rule.right, values, 50)


def slope(rule: Equation, values: Mapping[str, Any], name: str) -> Any:
    with mpmath.workdps(50):
        step = mpmath.mpf(values[name] or 1) * mpmath.mpf(10) ** -20
        above, below = (missed(rule, {**values, name: mpmath.mpf(values[name]) + s}) for s in (step, -step))
        return (above - below) / (2 * step)


@pytest.mark.parametrize(
    ("text", "unknown", "explained"),
    [
        ("a*b - c/d = x", "x", True),
        ("a*b - c/d = x", "d", True),
        ("x - 90 = a", "x", True),
        ("cosd(a + 90) = x*b", "x", False),
        ("x + cos(1) = (a + 1e6) - 1e6", "x", False),
        ("x*(a - b) = c", "x", True),
        ("x*a - x*b = c", "x", True),
        ("x*a - x*a^2 = c", "x", False),
    ],
)
def test_rules_that_hold_by_construction(text: str, unknown: str, explained: bool) -> None:
    rule = equation(text)
    isolation = isolate(rule.left, rule.right, unknown)
    assert isolation is not None
    assert (inverted(isolation, False) < 32) is explained
    if "cosd" in text:
        assert inverted(isolation, True) < 32  # minus the sine of a, without rounding


C = math.cos(math.cos(360))
CASES = [
    ("cos(cos(360)) - atan(w)^0.5 = c", (0.4, C, math.nextafter(C, 0), math.nextafter(C, 1), C - 1e-14)),
    ("k = cos(cos(360))\nk - sqrt(w) = c", (0.4, C, math.nextafter(C, 0), math.nextafter(C, 1))),
    ("acos(w + c) = 1.0893743437393861", (1.4611, 1e15, -1e300, 1e9)),
    ("tanh(v*v) = 0.9999999999707602\nw = v*c", (0.5, 3.0)),
    ("(1/c)/(c + w) = c", (0.5, -1e300, 1e6)),
    ("(w + c)^4 = 6.47", (0.495, 1e18, -1e300)),
    ("abs(c - w) = 0.652", (0.3, 1e300, 1e16)),
    ("w^2 + 3e-160*w = c", (1.0, 1e-319, 4e-320)),
    ("cosd(c + 90) = w*1e-9", (30.0, 1e-9, 1e-13, 1e17)),
]


@pytest.mark.parametrize(("text", "numbers"), CASES)
def test_what_rounding_decides_goes_step_by_step(text: str, numbers: tuple[float, ...]) -> None:
    """A plan that was taught by the first number says what a solve says at the others."""
    plan = solver.prepare(rulesheets.loads(text), ["c"], ["w"])
    plan.all(numbers[0])
    table = plan.sweep(list(numbers) * 6)
    for place, number in enumerate(numbers):
        right = solver.solve(rulesheets.loads(text), {"c": number}, ["w"])
        assert set(table.status[place :: len(numbers)]) == {CODES[right.status]}
        if right.status is not solver.Status.SOLVED:
            with pytest.raises(solver.Unsolved) as refused:
                plan(number)
            assert refused.value.status is right.status
            continue
        expected = [solution["w"] for solution in right.solutions]
        assert [w for (w,) in plan.all(number)] == pytest.approx(expected, rel=1e-9, abs=0)
        assert plan(number)[0] == pytest.approx(expected[0], rel=1e-9, abs=0)


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


EDGES = {
    "sqrt(b - c*d)": 1.0,
    "sqrt(3*(b - c*d))": 1.0,
    "sqrt(b/c - d)": 1.0,
    "(2*(b - c*d))^0.5": 1.0,
    "acosd(c*d/b)": 1.0,
    "ln(c*d - b)": -1.0,
    "acosh(c*d/b)": -1.0,
}
"""Rules with an end of their domain where b is c times d, and on which side of it they are defined."""


@pytest.mark.parametrize("text", EDGES)
def test_numbers_next_to_the_end_of_a_domain_are_told_by_exact_numbers(text: str) -> None:
    """On which side b lies is told by fractions, where floats make c*d of it."""
    dice = random.Random(7)
    plan = solver.prepare(rulesheets.loads(f"x = {text}\n"), ["b", "c", "d"], ["x"])
    for b in (7.0, 6.5, 5.5):
        plan(6.0 + EDGES[text] * (b - 5.0), 2.0, 3.0)
    assert plan.records.programs, "nothing was learned, nothing is tried"
    for _ in range(5):
        c, d = dice.uniform(0.1, 10.0), dice.uniform(0.1, 10.0)
        b = c * d
        inside = (Fraction(b) - Fraction(c) * Fraction(d)) * Fraction(EDGES[text])
        try:
            found = plan(b, c, d)[0]
        except solver.Unsolved:
            assert inside < 0
        else:
            with mpmath.workdps(50):
                exact = extended(equation(f"x = {text}").right, {"b": b, "c": c, "d": d}, 50)
                assert inside > 0 and found == pytest.approx(float(exact), rel=1e-12)
