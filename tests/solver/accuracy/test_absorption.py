"""Rules that no number satisfies, though some miss by less than any digits show; and rules that
hold."""

from __future__ import annotations

import pytest

import rulesheets
import solver
from rulesheets.evaluate.digits import Digits, context
from solver.accuracy import rule_check


@pytest.mark.parametrize(
    "rule",
    [
        "tanh((x*x)^3 + x) = 1",
        "erf(x) = 1",
        pytest.param("erf((x*x)^3) = 1", marks=pytest.mark.slow),
        "exp(-x^2 - x) + 1 = 1",
        "x + exp(-x^2) = x",
        "1/(1 + exp(-x^3 - x)) = 1",
        "atan(x^3 + x) = pi()/2",
    ],
)
def test_what_no_number_satisfies_has_no_answer_far_out_either(rule: str) -> None:
    model = rulesheets.loads(rule)
    assert str(solver.solve(model).status) in ("failed", "infeasible")
    for x in (-1.7976931348623157e308, -5e100, 1e20, 1.7976931348623157e308):
        assert not rule_check.check_rule(model.equations[0], {"x": x}).holds


@pytest.mark.parametrize(
    "text",
    [
        "tanh(1e5) = y",
        "erf(1e200*1e100) = y",
        "sin(1e200)^2 + cos(1e200)^2 = y",
        "min(1000, 5) = 5\ny = 1",
        "(exp(-1e200) + 3)*y = 3",
    ],
)
def test_what_a_last_place_of_a_value_mends_holds(text: str) -> None:
    result = solver.solve(rulesheets.loads(text))
    assert str(result.status) == "solved"
    assert result["y"] == 1.0


@pytest.mark.parametrize("digits", [50, 800])
@pytest.mark.parametrize("x", [2**20, -(2**20), 10**9, -(10**15)])
def test_powers_of_e_of_large_whole_numbers(x: int, digits: int) -> None:
    fine = context(digits + 40)
    exact = fine.exp(fine.mpf(x) / 4) ** 4
    found = Digits({}, digits).functions["exp"](context(digits).mpf(x))
    assert abs(fine.mpf(found) / exact - 1) < fine.mpf(10) ** (2 - digits)


def test_what_only_the_most_digits_show_is_seen() -> None:
    model = rulesheets.loads("cos(x) = 1")
    assert not rule_check.check_rule(model.equations[0], {"x": 2.4e-265}).holds
    assert rule_check.check_rule(model.equations[0], {"x": 0.0}).holds


def test_a_root_at_infinity_is_no_answer_for_want_of_digits() -> None:
    """Beside an endless m1 the temperature T is T1 to more digits than anybody looks at."""
    rules = "Q = m1*c*(T - T1)\nx = (T - T1)/(T2 - T1)\nT = (m1*T1 + m2*T2)/(m1 + m2)"
    inputs = {"m2": 0.03, "T1": 37.999012391489096, "T2": 36.5155298, "c": 3.5391}
    result = solver.solve(rulesheets.loads(rules), {**inputs, "Q": -0.13387993115783828})
    assert [one["m1"] for one in result.solutions] == [pytest.approx(0.17000003004835929)]
    assert result.complete
