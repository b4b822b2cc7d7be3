"""Roots beyond 1e±100 beside one of ordinary size are not looked for, and not denied."""

from __future__ import annotations

import pytest

import rulesheets
import solver


@pytest.mark.parametrize(
    "rule", ["sinh(x) - asinh(30/x) = -464.61136316103125", "max(45, asinh(270/x)) + x = 697"]
)
def test_a_list_without_a_root_next_to_nothing_is_not_complete(rule: str) -> None:
    result = solver.solve(rulesheets.loads(rule))
    assert len(result.solutions) == 1
    assert not result.complete


def test_a_root_that_floats_cannot_check_is_not_denied() -> None:
    """ln(1/z^2) = 1112.35… at z = ±2.85e-242, where z^2 is no float."""
    result = solver.solve(rulesheets.loads("ln(z/z/z^2) = 1112.356547020557"))
    assert result.status is not solver.Status.INFEASIBLE


@pytest.mark.parametrize(
    "rule", ["exp(x)/x = 2", "1/x^2 + 1/x = -1", "ln(x^2) + 1/x^2 + x^4 = 0", "atan(x) + 1/x = 0"]
)
def test_what_has_no_root_out_there_either_is_still_denied(rule: str) -> None:
    assert solver.solve(rulesheets.loads(rule)).status is solver.Status.INFEASIBLE


@pytest.mark.parametrize("rule", ["x*ln(x) = 2", "x + sqrt(x) + ln(x) = 7", "asinh(x) + x^3 = 5"])
def test_a_list_is_still_complete_where_the_sign_stays(rule: str) -> None:
    result = solver.solve(rulesheets.loads(rule))
    assert len(result.solutions) == 1
    assert result.complete
