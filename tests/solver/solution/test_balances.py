"""Balances that leave nothing: floats of numbers that cancel leave their last places."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rulesheets
import solver

PUMPS = rulesheets.loads(
    """
variables
  H1 = 40
  a1 = 900
  H2 = 28
  a2 = 700
  Hs = 15
  k = 2500
rules
  Q1 = sqrt(max(0, (H1 - H)/a1))
  Q2 = sqrt(max(0, (H2 - H)/a2))
  Q = Q1 + Q2
  H = Hs + k*Q^2
"""
)


def round_to(digits: int, low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high).map(lambda number: float(f"{number:.{digits}g}"))


@settings(max_examples=15)
@given(round_to(3, 35.0, 80.0), round_to(3, 300.0, 3000.0), round_to(3, 2000.0, 9000.0))
def test_what_stands_behind_a_shut_valve_is_free(H1: float, a1: float, k: float) -> None:
    """The weak pump gives nothing at any head up to that of the strong one."""
    state = solver.solve(PUMPS, {"H1": H1, "a1": a1, "k": k, "H2": 14.0}).solutions[0]
    assert state["Q2"] == 0.0
    for unknown in ("H2", "a2"):
        asked = {"H1": H1, "a1": a1, "k": k, "H2": 14.0, "Q1": state["Q1"], unknown: None}
        result = solver.solve(PUMPS, asked)
        assert str(result.status) == "singular"
        assert unknown in result.undetermined
        assert result.solutions[0]["Q2"] == 0.0
        assert result.solutions[0]["Q"] == pytest.approx(state["Q1"], rel=1e-12)


def test_a_small_rest_of_computed_numbers_is_kept() -> None:
    """A share of 1e-14 is dozens of last places, and may be meant."""
    model = rulesheets.loads("rules\n  a = 2*d\n  a = b + c\n")
    a = 1.0 + 48 * 2.0**-52
    assert solver.solve(model, {"d": a / 2, "b": 1.0})["c"] == a - 1.0
    a = 1.0 + 4 * 2.0**-52
    assert solver.solve(model, {"d": a / 2, "b": 1.0})["c"] == 0.0


def test_a_rest_of_given_numbers_alone_is_kept_to_the_last_place() -> None:
    model = rulesheets.loads("rules\n  a = b + c\n")
    assert solver.solve(model, {"a": 1.0 + 2.0**-52, "b": 1.0})["c"] == 2.0**-52
