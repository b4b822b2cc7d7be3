"""Roots beyond 1e±100 beside one of ordinary size, held to what 500 digits say."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath
import pytest

import rulesheets
import solver

BESIDE: list[tuple[str, float, float, Callable[[Any], Any]]] = [
    (
        "sinh(x) - asinh(30/x) = -464.61136316103125",
        1e-200,
        -6.84,
        lambda x: mpmath.sinh(x) - mpmath.asinh(30 / x) + mpmath.mpf(464.61136316103125),
    ),
    (
        "max(45, asinh(270/x)) + x = 697",
        1e-300,
        652.0,
        lambda x: max(mpmath.mpf(45), mpmath.asinh(270 / x)) + x - 697,
    ),
]


@pytest.mark.parametrize(("rule", "far", "near", "miss"), BESIDE)
def test_a_root_next_to_nothing_is_listed(
    rule: str, far: float, near: float, miss: Callable[[Any], Any]
) -> None:
    result = solver.solve(rulesheets.loads(rule))
    found = sorted((float(solution["x"]) for solution in result.solutions), key=abs)
    assert len(found) == 2
    assert not result.complete
    assert found[0] == pytest.approx(far, rel=0.5)
    assert found[1] == pytest.approx(near, rel=1e-2)
    with mpmath.workdps(500):
        for x in map(mpmath.mpf, found):
            assert miss(x * (1 - mpmath.mpf("1e-12"))) * miss(x * (1 + mpmath.mpf("1e-12"))) <= 0


def test_a_root_that_floats_cannot_check_is_not_denied() -> None:
    """ln(1/z^2) = 1112.35… at z = ±2.85e-242, where z^2 is no float."""
    result = solver.solve(rulesheets.loads("ln(z/z/z^2) = 1112.356547020557"))
    assert result.status is not solver.Status.INFEASIBLE


def test_a_root_where_a_square_overflows_is_found() -> None:
    """log(y - 0.5)*acosh(y^2) at y = 1e200, of which the square is no float."""
    with mpmath.workdps(500):
        y = mpmath.mpf(1e200)
        right = float(mpmath.log10(y - 0.5) * mpmath.acosh(y * y))
    result = solver.solve(rulesheets.loads(f"log(y - 0.5)*acosh(y^2) = {right!r}"))
    assert result["y"] == pytest.approx(1e200, rel=1e-11)  # the right side to half a unit of its last place


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
