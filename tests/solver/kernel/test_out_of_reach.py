"""What a rule tends to far out, or beside a point where it is 0/0: nothing beyond it is an answer,
and short of it something is."""

from __future__ import annotations

import math
from typing import NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rulesheets
import solver
from solver import Status


class Limited(NamedTuple):
    """``rule`` gives y, which comes as near to ``limit`` as one likes and stays below it (``side``
    1) or above it (-1)."""

    rule: str
    limit: float
    side: int


LIMITED = [
    Limited("y = 2*x*sinh(50/x)", 100.0, -1),  # the length of a chain, far beyond its span
    Limited("y = x*tanh(49.05/x)", 49.05, 1),  # the speed of a heavy body that falls for 5 s
    Limited("y = 300*sqrt(x)*tanh(0.04/sqrt(x))", 12.0, 1),  # the heat that a thick rod gives off
    Limited("y = x*atan(3/x)", 3.0, 1),
    Limited("y = 4*erf(x)/x", 4.51351666838205, 1),
    Limited("y = tanh(8*x)/(8*x)", 1.0, 1),  # the efficiency of a short fin
]
TWO_RATES = "y = 0.6*(exp(-1.2) - exp(-4*x))/(x - 0.3)"
"""The product of one reaction after another: 0/0 where both are as fast, and positive."""


def asked(rule: str, y: float) -> solver.Result:
    return solver.solve(rulesheets.loads(rule), {"y": y})


@pytest.mark.parametrize("limited", LIMITED)
@settings(max_examples=6, deadline=None)
@given(st.floats(-6.0, 1.0))
def test_beyond_a_limit_nothing_is_an_answer(limited: Limited, decades: float) -> None:
    result = asked(limited.rule, limited.limit * (1.0 + limited.side * min(10**decades, 0.9)))
    assert result.status is Status.INFEASIBLE and result.complete


@pytest.mark.parametrize("limited", LIMITED)
@settings(max_examples=6, deadline=None)
@given(st.floats(-6.0, -0.5))
def test_short_of_a_limit_there_is_an_answer(limited: Limited, decades: float) -> None:
    result = asked(limited.rule, limited.limit * (1.0 - limited.side * 10**decades))
    assert result.status is Status.SOLVED and result["x"] != 0.0


@pytest.mark.parametrize("rule", ["y = 2*x*sinh(50/x)", "y = 100*x*(exp(1/x) - 1)"])
def test_a_limit_itself_is_no_answer(rule: str) -> None:
    assert asked(rule, 100.0).status in (Status.INFEASIBLE, Status.FAILED)


@pytest.mark.parametrize("y", [-1e-9, -0.3, -11.0])
def test_a_quotient_that_is_positive_beside_its_gap_as_well_is_never_negative(y: float) -> None:
    result = asked(TWO_RATES, y)
    assert result.status is Status.INFEASIBLE and result.complete


@pytest.mark.parametrize("x", [0.29, 0.301, 1.7])
def test_beside_a_gap_there_are_answers(x: float) -> None:
    assert asked(TWO_RATES, solver.solve(rulesheets.loads(TWO_RATES), {"x": x})["y"])[
        "x"
    ] == pytest.approx(x, rel=1e-9)


@pytest.mark.parametrize("x", [-4.48, -0.2176, 3649.8, -2935.5])
@pytest.mark.parametrize(
    "rule",
    ["y = (1 - (1 + x)^(-3))/x", "y = x*(1 - (1 - 2/x)^(-3))", "y = x*(1 - (1 + 5000/x)^(-2))"],
)
def test_a_pole_between_a_gap_and_an_answer_hides_none(rule: str, x: float) -> None:
    y = solver.solve(rulesheets.loads(rule), {"x": x})["y"]
    found = [answer["x"] for answer in asked(rule, y).solutions]
    assert any(one == pytest.approx(x, rel=1e-9) for one in found)


@pytest.mark.parametrize(
    ("rule", "limit"),
    [("y = sin(x)/x", 1.0), ("y = (exp(x) - 1)/x", 1.0), ("y = (1 - cos(x))/x^2", 0.5)],
)
def test_a_limit_at_a_gap_is_told(rule: str, limit: float) -> None:
    result = asked(rule, limit)
    assert result.status is Status.SINGULAR
    assert f"the limit is {limit:g}" in result.diagnoses[0].message


def test_a_sewer_that_is_too_narrow_for_its_area_is_denied() -> None:
    """At a given depth the area is least where the pipe is full; 0/0 where it is empty."""
    sewer = rulesheets.loads(
        "variables\n y = 0.4\n t in [0, 6.28]\nrules\n"
        " y = D/2*(1 - cos(t/2))\n A = D^2/8*(t - sin(t))\n"
    )
    assert solver.solve(sewer, {"A": 0.09}).status is Status.INFEASIBLE
    assert solver.solve(sewer, {"A": 0.16}).complete


@pytest.mark.parametrize("a", [0.3, 0.5, 0.7])
def test_an_answer_stands_beside_a_gap_where_a_choice_takes_an_irrational_number(a: float) -> None:
    """At x = 0 the slope of the dividend is abs(ln(a)) - ln(a), which is not 0."""
    model = rulesheets.loads("rules\n  (abs(ln(a))*x - ln(a)*x - x^2)/sin(x) = y\n")
    result = solver.solve(model, {"a": a, "y": 0.0})
    assert [answer["x"] for answer in result.solutions] == pytest.approx([-2 * math.log(a)])
