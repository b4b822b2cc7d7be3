"""Functions asked for the end of their image that they never attain."""

from __future__ import annotations

import pytest

import rulesheets
import solver


def solved(rules: str) -> solver.Result:
    return solver.solve(rulesheets.loads(rules))


@pytest.mark.parametrize(
    ("rules", "needs"),
    [
        ("erfc((-0.5)/x) = 2.0", "erfc = 2"),
        ("erfc(z - 1) - 60.00000000000001 = -60.00000000000001", "erfc = 0"),
        ("erf(x) = 1", "erf = 1"),
        ("7 = 5 - 2*erf(x*x*x + x)", "erf = -1"),
        ("3*tanh(x + sin(x))/4 = 0.75", "tanh = 1"),
        ("erfc(x) - y = -0.5\ny = 0.5", "erfc = 0"),
        ("x + y = 3\nexp(x*y + sin(x)) + 1 = 1", "exp = 0"),
        ("h = 2*A/w\nA = w*h/2 + exp(w)\nw*h = sqrt(q)\nq = 2", "exp = 0"),
        ("x*y = 5\n5 - y*x = cosh(x) - 0.5", "cosh = 0.5"),
        ("p = q + 3*erf(x)\n2*p - 2*q = 6\np + q = x", "erf = 1"),
    ],
)
def test_the_end_of_an_image_that_is_never_attained_has_no_preimage(rules: str, needs: str) -> None:
    result = solved(rules)
    assert result.status is solver.Status.INFEASIBLE
    assert f"it needs {needs}" in result.diagnoses[0].message


def test_a_target_beyond_the_end_by_rounding_alone_is_not_refused() -> None:
    """0.1 + 0.2 is more than 0.3, and three times it over 0.9 more than 1."""
    result = solved("p = q + 0.9*sind(x)\n p - q = 3*(0.1 + 0.2)\nq*x = 900")
    assert result.status is not solver.Status.INFEASIBLE


def test_what_is_rounded_to_the_end_of_an_image_proves_nothing() -> None:
    assert solved("erf(x) = y/3\ny*0.1 = 0.3").status is not solver.Status.INFEASIBLE
