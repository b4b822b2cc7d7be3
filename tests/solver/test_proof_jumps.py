"""Proofs next to a jump: where a rule jumps over its root there is none, whatever its slopes
say."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath
import pytest

import rulesheets
import solver

pytest.importorskip("flint")


def proofs(rule: str, **options: object) -> list[tuple[float, solver.Solution]]:
    result = solver.solve(rulesheets.loads(rule), prove=True, **options)  # type: ignore[arg-type]
    return [(float(answer["x"]), answer) for answer in result.solutions]


@pytest.mark.parametrize(
    "rule",
    [
        "int(x) + x = 3",
        "int(x) + x^3 + x = 11",
        "step(x, 2) + x^3 + x = 10",
        "sgn(x - 1) + x^3 + x = 1",
        "round(x) + x^3 + x = 5.875",
        "mod(x, 1) + x^3 + x = 11",
        "frac(x) + x^3 + x = 11",
        "atan2d(x - 1, x - 2) + x = -179",
    ],
)
def test_a_limit_that_a_rule_jumps_away_from_is_no_proved_root(rule: str) -> None:
    """Each comes as near to equality as one likes on one side of a jump, and is off by much at
    it."""
    for x, answer in proofs(rule):
        edge = min((1.0, 1.5, 2.0), key=lambda edge: abs(x - edge))
        assert abs(x - edge) > 1e-9 or not answer.proof.proved


@pytest.mark.parametrize(
    ("rule", "smooth", "guess"),
    [
        ("round(x) + x^3 + x = 8.125", lambda x: x**3 + x - 6.125, 1.6),
        ("mod(x, 1) + x^3 + x = 11", lambda x: x**3 + 2 * x - 13, 2.1),
        ("step(x, 2) + x^3 + x = 12", lambda x: x**3 + x - 11, 2.1),
        ("sgn(x - 1) + x^3 + x = 4", lambda x: x**3 + x - 3, 1.2),
        ("abs(x - 1) + x^3 + x = 1.5", lambda x: x**3 - 0.5, 0.8),
    ],
)
def test_a_root_away_from_the_jumps_is_proved(
    rule: str, smooth: Callable[[Any], Any], guess: float
) -> None:
    with mpmath.workdps(50):
        root = mpmath.findroot(smooth, guess)
        found = [answer for x, answer in proofs(rule) if abs(x - root) < 1e-9]
        assert len(found) == 1 and found[0].proof.proved
        assert abs(root - found[0]["x"]) <= found[0].proof.radius["x"] < 1e-15


def test_a_number_too_small_for_a_float_is_not_within_0_of_its_answer() -> None:
    """1e-400 is answered by 0, the nearest float."""
    result = solver.solve(rulesheets.loads("x = 1e-200*a"), {"a": 1e-200}, prove=True)
    (answer,) = result.solutions
    assert answer.proof.proved and answer.proof.nearest
    assert answer["x"] == 0.0 < answer.proof.radius["x"]
