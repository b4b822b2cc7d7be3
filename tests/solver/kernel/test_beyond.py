"""Rules whose terms grow beyond 1e100, or fall below 1e-100, with and without roots of ordinary
size."""

from __future__ import annotations

import pytest

import rulesheets
import solver


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
