"""Two answers that nearly meet at 0, where neither is far from the other but beside its own
size."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath
import pytest

import rulesheets
import solver

MP = mpmath.mp.clone()
MP.dps = 60

FOLDS: dict[str, Callable[[Any], Any]] = {
    "exp(x) - x = d": lambda x: MP.exp(x) - x,
    "cosh(x) + x^2 = d": lambda x: MP.cosh(x) + x * x,
    "y = exp(x)\ny - x = d": lambda x: MP.exp(x) - x,
}
"""Rules in x and a d, of which x is 0 at d = 1, a minimum of d."""


def roots(function: Callable[[Any], Any], d: float) -> list[Any]:
    """The two numbers beside 0 at which a convex function is d, by bisection."""
    found = []
    for low, high in ((MP.mpf(-3), MP.mpf(0)), (MP.mpf(3), MP.mpf(0))):
        for _ in range(180):
            middle = (low + high) / 2
            low, high = (middle, high) if function(middle) > d else (low, middle)
        found.append(low)
    return found


@pytest.mark.parametrize("rule", FOLDS)
@pytest.mark.parametrize("gap", [1e-13, 3e-14, 1e-14, 3e-15, 1e-15])
def test_both_answers_are_found_to_the_last_digit(rule: str, gap: float) -> None:
    """Points between the two satisfy the rules as far as floats tell: that makes them no one
    answer."""
    result = solver.solve(rulesheets.loads(rule), {"d": 1.0 + gap})
    assert result.status is solver.Status.SOLVED
    assert result.complete
    expected = [float(root) for root in roots(FOLDS[rule], 1.0 + gap)]
    assert sorted(s["x"] for s in result.solutions) == pytest.approx(expected, rel=1e-15, abs=0.0)


@pytest.mark.parametrize("rule", FOLDS)
@pytest.mark.parametrize("gap", [1e-13, 1e-15])
def test_what_is_a_hair_out_of_reach_has_no_answer(rule: str, gap: float) -> None:
    result = solver.solve(rulesheets.loads(rule), {"d": 1.0 - gap})
    assert result.status is solver.Status.INFEASIBLE
    assert not result.solutions


@pytest.mark.parametrize("rule", FOLDS)
def test_where_the_two_coincide(rule: str) -> None:
    result = solver.solve(rulesheets.loads(rule), {"d": 1.0})
    assert result.status is solver.Status.SINGULAR
    assert result["x"] == pytest.approx(0.0, abs=1e-8)


@pytest.mark.parametrize("gap", [1e-14, 1e-15])
def test_three_answers_that_nearly_meet_are_no_plateau(gap: float) -> None:
    """sin(x) = q x is next to nothing around 0, and beyond: it determines x all the same."""
    q = 1.0 - gap
    result = solver.solve(rulesheets.loads("sin(x) = q*x\nz = x"), {"q": q})
    low, high = MP.mpf("1e-9"), MP.mpf(1)
    for _ in range(180):
        middle = (low + high) / 2
        low, high = (middle, high) if MP.sin(middle) > q * middle else (low, middle)
    assert result.status is solver.Status.SOLVED
    found = [s["x"] for s in result.solutions]
    assert 0.0 in found
    assert all(x == 0.0 or abs(x) == pytest.approx(float(low), rel=1e-14, abs=0.0) for x in found)
    assert len(found) == 3 or not result.complete


@pytest.mark.parametrize(
    "rule", ["int(x) = 3", "int(x*1e9) = 0\nz = x", "abs(x - 1) + abs(x + 1) = 2\nz = x"]
)
def test_a_plateau_of_any_width_leaves_its_unknown_free(rule: str) -> None:
    result = solver.solve(rulesheets.loads(rule))
    assert result.status is solver.Status.PARTIAL
    assert "x" in result.undetermined


@pytest.mark.parametrize("d", [1e-300, 1e-45])
@pytest.mark.parametrize("rules", ["exp(x) = y\ny = x + 1 + d", "cosh(x) = y\ny = 1 + d*x"])
def test_what_drowns_beside_one_leaves_nothing_free(rules: str, d: float) -> None:
    """Each of these has two answers next to 0 and is far from holding anywhere else."""
    result = solver.solve(rulesheets.loads(rules), {"d": d})
    assert result.status is not solver.Status.PARTIAL
    assert all(abs(s["x"]) < 1e-7 for s in result.solutions)


@pytest.mark.parametrize("n", [0.5, 1.5, 3.0])
def test_a_power_that_does_not_turn_back_has_one_answer_at_0(n: float) -> None:
    """As at an effect of no dose: both roots that an even power has are 0 there, but it has one."""
    model = rulesheets.loads("E = 100*C^n/(2^n + C^n)")
    result = solver.solve(model, {"E": 0.0, "n": n})
    assert (result.status, result["C"], result.complete) == (solver.Status.SOLVED, 0.0, True)
    plan = solver.prepare(model, ["E"], ["C"], given={"n": n})
    assert plan(50.0)[0] == pytest.approx(2.0)
    assert plan(0.0) == (0.0,)


@pytest.mark.parametrize("n", [2.0, 4.0])
def test_an_even_power_has_a_double_root_at_0(n: float) -> None:
    model = rulesheets.loads("E = 100*C^n/(2^n + C^n)")
    assert solver.solve(model, {"E": 0.0, "n": n}).status is solver.Status.SINGULAR


@pytest.mark.parametrize(
    ("constants", "share", "acids"),
    [
        ((7.5e-3, 6.2e-8, 4.8e-13), 0.79994541894, (2.4794867975e-7, 1.87539171724e-3)),
        ((8.6e-4, 5.08e-13, 5.01e-13), 0.04236617948730212, (1.17941477e-13, 0.0194392106)),
    ],
)
def test_a_fold_between_other_roots_hides_none(
    constants: tuple[float, ...], share: float, acids: tuple[float, ...]
) -> None:
    """The acid in which an ion of a triprotic acid has this share; roots by mpmath.polyroots."""
    rules = "H = 10^(-pH)\nden = H^3 + K1*H^2 + K1*K2*H + K1*K2*K3\na = K1*H^2/den"
    given = dict(zip(("K1", "K2", "K3"), constants, strict=True))
    found = solver.solve(rulesheets.loads(rules), {**given, "a": share})
    assert sorted(answer["H"] for answer in found.solutions) == pytest.approx(acids, rel=1e-8)
