"""Isolated answers beside a curve of others: such a list is not complete, and rules on a curve can
hold."""

from __future__ import annotations

import pytest

import rulesheets
import solver
from solver import Status

THROWN = "{factor}*(v - 4.9*t) = 0\n{factor}*(v - 2*t - 3) = 0"


@pytest.mark.parametrize("factor", ["t", "t^2", "(t - 1)", "(t - 1)^2", "(t + v - 1)", "sin(t)"])
def test_a_list_beside_a_curve_is_not_complete(factor: str) -> None:
    result = solver.solve(rulesheets.loads(THROWN.format(factor=factor)))
    assert result.status is Status.SOLVED
    assert not result.complete
    isolated = [s for s in result.solutions if abs(s["t"] - 3 / 2.9) < 1e-9]
    assert len(isolated) == 1


def test_the_curve_is_named() -> None:
    result = solver.solve(rulesheets.loads(THROWN.format(factor="t")))
    assert [d.message for d in result.diagnoses] == [
        "beside these answers there is a curve of others: v can vary where t = 0"
    ]


@pytest.mark.parametrize(
    "rules",
    [
        "(v - 3)*t^2 = 0\nw = t^2*2\nw*(v - 2*t - 3) = 0",
        "t^2*(v - 5) = 0\nw = t^2\nw*(v - 6) = 0",
        "t^2*(v^2 - t - 5) = 0\nt^2*(v + 3*t - 7) = 0",
    ],
)
def test_rules_that_hold_on_a_curve_are_neither_denied_nor_all_known(rules: str) -> None:
    result = solver.solve(rulesheets.loads(rules))
    assert result.status not in (Status.INFEASIBLE, Status.INCONSISTENT)
    assert not result.complete


def test_rules_divided_by_an_unknown_that_is_not_zero_stay_complete() -> None:
    result = solver.solve(rulesheets.loads("t*v = 3\nv^2 + t^3*v + t = 3"))
    assert result.complete


def test_an_answer_beside_a_curve_on_which_unknowns_vanish() -> None:
    """Two pucks collide: with a first one of no mass its speed can be anything; it has a mass of
    2."""
    model = rulesheets.loads(
        "m1*u = m1*v1*cosd(t1) + m2*v2*cosd(t2)\n0 = m1*v1*sind(t1) - m2*v2*sind(t2)\n"
        "m1*u^2 = m1*v1^2 + m2*v2^2"
    )
    hit = solver.solve(model, {"m1": 2.0, "m2": 3.0, "u": 6.0, "t1": 40.0})
    result = solver.solve(model, {"t2": hit["t2"], "m2": 3.0, "u": 6.0, "t1": 40.0})
    assert str(result.status) == "solved"
    assert not result.complete
    assert result["m1"] == pytest.approx(2.0)
    assert result["v1"] == pytest.approx(hit["v1"])
    assert any("curve" in d.message for d in result.diagnoses)


LAGRANGE = """a*y^2 + 16*b*x + 16*x = 0
2*y*(a*x + b + 1) = 0
x*y^2 = 0
8*x^2 + y^2 = 24"""


def test_an_unknown_left_free_saves_no_rule_of_its_block() -> None:
    """For b = -1.1 the first three rules ask x = y = 0, whatever a is, and the last refuses
    that."""
    result = solver.solve(rulesheets.loads(LAGRANGE), {"b": -1.1})
    assert result.status in (solver.Status.INCONSISTENT, solver.Status.FAILED)


def test_what_a_block_determines_beside_a_free_unknown_is_not_known_to_be_all() -> None:
    """For b = -1 also y = 0 and x = √3, where a is free."""
    result = solver.solve(rulesheets.loads(LAGRANGE), {"b": -1.0})
    assert result["y"] == pytest.approx(24**0.5) and not result.complete


def test_rules_that_agree_only_at_infinity_leave_no_curve_of_answers() -> None:
    """As both sides of the third tend to 1, they differ by less than rounding from k = 1e17 on."""
    result = solver.solve(
        rulesheets.loads(
            "T = 1.5 + 0.5*k\ny^2 = (T - 1)/k\nT/(1 + 0.5*k) = 2*y^2*(1 + k)/(1 + 2*k*y^2)"
        )
    )
    assert not result.diagnoses
    assert [(s["k"], s["y"]) for s in result.solutions] == [(1, 1), (1, -1)]


def test_answers_on_a_curve_along_which_a_slope_is_infinite_are_not_listed() -> None:
    """No flow over a flood plain: any water level up to it."""
    rules = "A = 40*max(y - 2, 0)\nP = 2*(20 + max(y - 2, 0))\nQ = 0.5*A*(A/P)^(2/3)"
    result = solver.solve(rulesheets.loads(rules), {"Q": 0.0})
    assert result.status is Status.SINGULAR
    assert result.undetermined == ("y",)
