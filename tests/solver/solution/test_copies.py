"""A number copied from an answer back among the inputs contradicts nothing by its rounding."""

from __future__ import annotations

import math

import pytest
from scipy.optimize import brentq

import rulesheets
import solver

CHILLER = """
q = 1.53e-5*t1^4 + 1.67e-2*t1^3 + 6.85*t1^2 + 2746*t1 - 57793
q = 13.3*(t1 - t2)
q = 1.53e-5*t2^4 + 1.67e-2*t2^3 + 6.85*t2^2 + 4846*t2 - 49161
"""
"""Heat flows in balance, as posted to a forum: the first rule loses three digits at its answer."""


def balance() -> tuple[float, float]:
    """The temperatures between 0 and 100, by bisection."""

    def flow(t: float, slope: float, level: float) -> float:
        return 1.53e-5 * t**4 + 1.67e-2 * t**3 + 6.85 * t**2 + slope * t - level

    def second(t1: float) -> float:
        return t1 - flow(t1, 2746, 57793) / 13.3

    t1 = brentq(
        lambda t: flow(t, 2746, 57793) - flow(second(t), 4846, 49161), 19.5, 20.5, xtol=1e-15
    )
    return t1, second(t1)


def test_a_copied_number_is_accepted() -> None:
    model = rulesheets.loads(CHILLER)
    t1 = float(solver.solve(model).solutions[0]["t1"])
    assert t1 == pytest.approx(balance()[0], rel=1e-13)
    result = solver.solve(model, {"t1": t1})
    assert [float(found["t2"]) for found in result.solutions] == pytest.approx(
        [balance()[1]], rel=1e-12
    )
    assert str(solver.solve(model, {"t1": t1 * (1 + 1e-9)}).status) == "inconsistent"


def test_a_plan_keeps_no_record_of_a_copied_number() -> None:
    model = rulesheets.loads(CHILLER)
    t1 = float(solver.solve(model).solutions[0]["t1"])
    plan = solver.prepare(model, ["t1"], ["t2"])
    assert plan(t1) == pytest.approx((balance()[1],), rel=1e-12)
    with pytest.raises(solver.Unsolved):
        plan(t1 * 1.01)
    table = plan.sweep([t1, t1 * 1.01] * 20)
    assert [math.isnan(t2) for t2 in table["t2"]] == [False, True] * 20


def test_a_difference_of_copied_numbers_is_that_of_the_other_rules() -> None:
    """The amount that is left of 3 is known from the other rules to more digits."""
    k = 3.549171130924784e-08
    model = rulesheets.loads("f + k = 3\nk*s = t\nt^2 = 4.9e-15")
    result = solver.solve(model, {"f": 3.0 - k, "s": 7e-8 / k})
    assert [float(found["k"]) for found in result.solutions] == pytest.approx([k], rel=1e-14)


def test_of_redundant_rules_the_linear_ones_are_solved() -> None:
    """The others would give a double root: of all rectangles of a given girth the square is the
    largest."""
    result = solver.solve(rulesheets.loads("x*y = z + 10\nx + y = 10\nx - y = 0"), {"z": 15.0})
    assert str(result.status) == "solved"
    assert dict(result.solutions[0]) == {"x": 5.0, "y": 5.0, "z": 15.0}


@pytest.mark.parametrize("want", [None, ["x"]])
def test_what_is_given_may_be_computed_though_not_wanted(want: list[str] | None) -> None:
    """a = x^2 + 4.4 alone leaves x = 0 a double root; b does not, and gives a."""
    model = rulesheets.loads("x^2 = a - 4.4\nb = x^2 + 2*x - 5")
    result = solver.solve(model, {"a": 4.4, "b": -5.0}, want=want)
    assert str(result.status) == "solved"
    assert [found["x"] for found in result.solutions] == [0.0]


def test_every_number_of_an_orbit_is_accepted_back() -> None:
    model = rulesheets.load("kepler")
    answer = solver.solve(model).solutions[0]
    for name in ("E", "nu", "r", "M"):
        assert str(solver.solve(model, {name: answer[name]}).status) == "solved", name
