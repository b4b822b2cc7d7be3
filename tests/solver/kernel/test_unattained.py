"""Functions asked for the end of their image that they never attain."""

from __future__ import annotations

import pytest

import rulesheets
import solver


def solved(rules: str) -> solver.Result:
    return solver.solve(rulesheets.loads(rules))


def test_a_target_beyond_the_end_by_rounding_alone_is_not_refused() -> None:
    """0.1 + 0.2 is more than 0.3, and three times it over 0.9 more than 1."""
    result = solved("p = q + 0.9*sind(x)\n p - q = 3*(0.1 + 0.2)\nq*x = 900")
    assert result.status is not solver.Status.INFEASIBLE


@pytest.mark.parametrize(
    "rules",
    [
        "erfc((-0.5)/x) = 2.0",
        "erfc(z - 1) - 60.00000000000001 = -60.00000000000001",
        "erf(x) = 1",
        "erf(x) = y/3\ny*0.1 = 0.3",
        "7 = 5 - 2*erf(x*x*x + x)",
        "3*tanh(x + sin(x))/4 = 0.75",
        "erfc(x) - y = -0.5\ny = 0.5",
        "x + y = 3\nexp(x*y + sin(x)) + 1 = 1",
        "x*y = 5\n5 - y*x = cosh(x) - 0.5",
        "p = q + 3*erf(x)\n2*p - 2*q = 6\np + q = x",
        "y = (1 + erf(x))/2\ny = 0",
        "y = 3*(1 + erf((x - 5)/2))/2\nx = 4*z + 1\ny = 3",
        "y = erfc(x)\ny = 2",
        "u = erfc(x)\ny = u\ny = 0",
        "x/sqrt(1 + x^2) = 1",
        "(exp(x) - exp(-x))/(exp(x) + exp(-x)) = 1",
        "tanh(x)*erf(x) = 1",
        "tanh(x) + erf(x) = 2",
        "x^2/(1 + x^2)*tanh(x) = 1",
        "x*(sqrt(1 + 1/x^2) - 1) = 0",
        "y = 3*(1 + erf((x - 5)/2))/2\nq = y + 2\nq = 5",
        "y = 4\nu = 4*x + 1\nw = erfc(u)\ny = 0.5*w + 4",
        "y = 8*tanh(min(x, 2*x + 1))\ny = -8",
        "y = (1 + 1/x)^x\ny = exp(1)",
        "u = cosh(x)\nv = sinh(x)\nv/u = 1",
    ],
)
def test_a_limit_at_infinity_is_neither_an_answer_nor_leaves_the_unknown_free(rules: str) -> None:
    result = solved(rules)
    assert result.status in (solver.Status.INFEASIBLE, solver.Status.FAILED)
    assert not result.solutions


@pytest.mark.parametrize(
    ("rules", "x"),
    [
        ("x + exp(-x) = 1e20/3", 1e20 / 3),
        ("y = 1/x\nx - y = 1e18/7", 1e18 / 7),
        ("x*tanh(x) = 1e18/3", 1e18 / 3),
        ("x*erf(x) + 1/x = 1e20/7", 1e20 / 7),
    ],
)
def test_an_answer_far_out_beside_terms_that_it_absorbs_is_no_limit(rules: str, x: float) -> None:
    assert pytest.approx(x, rel=1e-15) in [one["x"] for one in solved(rules).solutions]


def test_a_spread_of_options_that_pays_less_than_floats_tell_is_not_excluded() -> None:
    """At S = 100 + 1e-16, between two floats."""
    result = solved("K = 100\nP = max(0, S - K) - max(0, S - 110)\nP = 1e-16")
    assert result.status is not solver.Status.INFEASIBLE and not result.complete


def test_numbers_that_vanish_only_in_floats_satisfy_nothing() -> None:
    """The volatility of a firm (R. C. Merton, 1974): at one of -0.008 all is 1e-240."""
    model = rulesheets.loads(
        "d1 = (ln(V/D) + (r + s^2/2)*T)/(s*sqrt(T))\nd2 = d1 - s*sqrt(T)\n"
        "N1 = (1 + erf(d1/sqrt(2)))/2\nN2 = (1 + erf(d2/sqrt(2)))/2\n"
        "E = V*N1 - D*exp(-r*T)*N2\nsE*E = N1*s*V"
    )
    result = solver.solve(model, {"V": 12.4, "D": 10.0, "r": 0.05, "T": 1.0, "sE": 0.8})
    assert result["s"] == pytest.approx(0.2125371909775, rel=1e-11)  # brentq on the last rule
    assert all(abs(answer["N1"]) > 0.1 for answer in result.solutions)
