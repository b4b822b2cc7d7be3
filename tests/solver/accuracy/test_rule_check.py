"""The rule check: rules hold at the numbers as they are, not as floats round them on the way."""

from __future__ import annotations

import math
from collections.abc import Sequence
from decimal import Decimal
from functools import cache
from typing import Any

import mpmath
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import rulesheets
import solver
from rulesheets.model import Equation
from solver.accuracy import rule_check


def holds(rule: str, **values: float) -> bool:
    return all(rule_check.check_rule(equation, values).holds for equation in equations(rule))


@cache
def equations(rule: str) -> Sequence[Equation]:
    return rulesheets.loads(rule + "\n").equations


FALSE: list[tuple[str, dict[str, Any]]] = [
    ("exp(1e6*b)^4 = 0", {"b": -4.7}),
    ("exp(1e6*b)*exp(1e7*b) = 0", {"b": -4.7}),
    ("(-exp(1e6*b))^2 = 0", {"b": -4.7}),
    ("(exp(1e6*b) + exp(1e7*b))^2 = 0", {"b": -4.7}),
    ("exp(c^0.5 - y) = 1", {"c": 0.0, "y": -2e-87}),
    ("erfc(x + w + x) = 0", {"w": -1.6418, "x": 41.68606275130904}),
    ("tanh(x) = 1", {"x": 20.0}),
    ("erf(x) = 1", {"x": 7.0}),
    ("x^x = 1", {"x": 1e-19}),
    ("1 - exp(-x^2) = 0", {"x": 1e-9}),
    ("cos(x) = 1", {"x": 1e-9}),
    ("sin(pi) = x", {"x": math.sin(math.pi)}),
    ("ln(x*sin(pi) + 1) = 0.5", {"x": 1e16}),
    ("(x + 1e16) - 1e16 = y", {"x": 0.3, "y": 0.0}),
    ("x*y = 0", {"x": 1e-200, "y": 1e-200}),
    ("cosd(x) = 2", {"x": 3e89}),
    ("max(x, pi) + 1 = 4.141592653589793", {"x": math.pi}),
    ("1/x = 0", {"x": 0.0}),
    ("x/x = 1", {"x": 0.0}),
    ("ln(x) = 0", {"x": 0.0}),
    ("x*x/(x*x) = 2", {"x": 1e-200}),
    ("y^3*(abs(b) - cosd(x)) = -1.9e-5", {"x": -3e89, "y": 27.3, "b": 206.0}),
    ("1/(x*x) = 0", {"x": 1e200}),
    ("cos(asin(x)) = 1e-6", {"x": 1.0}),
    ("350*(1 - (1 + rate)^-36)/rate = 12000", {"rate": 2e-16}),
    ("cosd(30*x) + y = 7", {"x": -9.1e141, "y": 1e9}),
    ("tand(x) = 0.6", {"x": 90.00000000000001}),
    ("350 = 12000*x/(1 - (1 + x)^(-n))", {"x": -2.0000000000000036, "n": 36.0}),
    ("r/h = tand(x/2)", {"r": 2.0, "h": 3.0, "x": -179.99999999999983}),
    ("y = 1/(x - z)", {"y": 1e14, "x": 2.5, "z": 2.5 + 1e-15}),
    ("I = Is*(exp(u) - 1)", {"I": 0.0026, "Is": 0.0, "u": 4569.0}),
]
TRUE: list[tuple[str, dict[str, Any]]] = [
    ("x^x = 1", {"x": 1.0}),
    ("1 - exp(-x^2) = 0", {"x": 0.0}),
    ("max(x, 0) = y", {"x": 0.0, "y": 0.0}),
    ("(x + y - z)^2 = 0", {"x": 0.1, "y": 0.25, "z": 0.35}),
    ("0*exp(1e6*b)^4 = 0", {"b": -4.7}),
    ("max(2*x, y) = z", {"x": 0.1, "y": 0.2, "z": 0.2}),
    ("x - y = z", {"x": 1.0, "y": 1.0, "z": 3e-15}),
    ("x*x/(x*x) = 1", {"x": 1e-200}),
    ("ln(x*x) = y", {"x": 1e-200, "y": -400 * math.log(10)}),
    ("sin(pi) = x", {"x": 0.0}),
    ("sin(pi) = x - 1", {"x": 1.0}),
    ("(x + 1e16) - 1e16 = y", {"x": 0.3, "y": 0.3}),
    ("sin(x)^2 + cos(x)^2 = 1", {"x": 0.7}),
    ("x + y + z = z + x + y", {"x": 0.1, "y": 1e20, "z": 0.3}),
    ("exp(-x) = y", {"x": 1000.0, "y": 0.0}),
    ("1 + exp(-x) = y", {"x": 1000.0, "y": 1.0}),
    ("sqrt(x) = y", {"x": 0.0, "y": 0.0}),
    ("cosd(x + 90) = y", {"x": 1e-9, "y": -1e-9 * math.pi / 180}),
    ("cos(asin(x)) = 1e-8", {"x": 1.0}),
    ("tan(x) = y", {"x": math.pi / 2, "y": 1.633123935319537e16}),
    ("cosd(x) + y = 7", {"x": 1e18, "y": 6.6}),
    ("y = m*(x - z)", {"y": 3.0, "m": -1e28, "x": 2.5, "z": 2.5}),
    ("((90 - w)^0.5)^2 = 90.30382", {"w": 90 - 90.30382}),
]


@pytest.mark.parametrize(("rule", "values"), FALSE)
def test_what_holds_in_floats_alone_does_not_hold(rule: str, values: dict[str, Any]) -> None:
    assert not holds(rule, **values)


@pytest.mark.parametrize(("rule", "values"), TRUE)
def test_what_floats_cannot_see_may_hold(rule: str, values: dict[str, Any]) -> None:
    assert holds(rule, **values)


@given(st.floats(1.0, 1e3), st.floats(1.0, 1e3))
def test_a_root_taken_and_undone_is_the_number_itself(a: float, b: float) -> None:
    (solution,) = solver.solve(rulesheets.loads(f"(sqrt({a!r} - w))^2 = {b!r}")).solutions
    assert solution["w"] == pytest.approx(a - b, rel=rule_check.BACKWARD, abs=0.0)


@given(st.floats(1e-90, 1e90), st.floats(1e-90, 1e90), st.sampled_from((-4.0, -1.0, 0.0, 1.0, 4.0)))
def test_values_next_to_a_sum_that_cancels(small: float, large: float, shares: float) -> None:
    """z = (x + y) - y is x, whatever floats make of it."""
    rule, z = "(x + y) - y = z", small * (1 + shares * rule_check.BACKWARD / 16)
    assert holds(rule, x=small, y=large, z=z)
    assert not holds(rule, x=small, y=large, z=small * 1.001)


def test_a_rate_that_floats_make_up_is_no_answer() -> None:
    """``(1 + rate)^-term`` is 1 in floats at a tiny rate, and the payment comes out as it may."""
    sheet = "variables\npayment = 350\nloan = 12000\nterm = 36\nrate\nrules\n"
    result = solver.solve(
        rulesheets.loads(sheet + "payment = loan*(rate/(1 - (1 + rate)^(-term)))\n")
    )
    assert str(result.status) == "solved"
    assert result["rate"] == pytest.approx(0.00266144471, rel=1e-8)
    assert all(abs(solution["rate"]) > 1e-3 for solution in result.solutions)


@pytest.mark.parametrize("rules", ["x = sin(pi)\nx = 0", "x*cos(pi/2) = y\ny = 0\nx = 3"])
def test_rules_agree_that_say_the_same_of_parts_of_pi(rules: str) -> None:
    assert solver.solve(rulesheets.loads(rules)).status is solver.Status.SOLVED


def test_no_digit_of_pi_makes_a_coefficient() -> None:
    """``sin(pi)`` is 0 at all digits of π, so that no value of the others makes 3e-51 of the
    product."""
    result = solver.solve(rulesheets.loads("cos(y*z)*((b - z)*sin(pi)) = 3e-51\ny = 0.6\nb = 2"))
    assert result.status in (solver.Status.INFEASIBLE, solver.Status.INCONSISTENT)
    assert not result.solutions


@pytest.mark.parametrize(
    "whole", ["sgn(1/b) = a*a", "sgn(b^-1) = a*a", "sgn(b^-0.5) = a", "1/(1 + b^-2) = 0*a"]
)
def test_nothing_holds_at_a_pole(whole: str) -> None:
    """However the division by 0 is written, and whatever bounds what it comes to."""
    assert not holds(whole, a=1.0, b=0.0)


def test_no_direction_of_the_origin_holds() -> None:
    assert not holds("atan2d(x, z) = 0", x=0.0, z=0.0)
    assert holds("atan2d(x, z) = 0", x=0.0, z=1.0)
    assert solver.solve(rulesheets.loads("(x - x)/2 = atan2d(x, z)\nz = x - z")).solutions == ()


def test_a_value_of_which_no_digit_counts_does_not_stand_against_the_others() -> None:
    """cos(y) at 2.6e57 turns over with the last place of y; d alone satisfies the rule."""
    y = 2.5955e57
    with mpmath.workdps(120):
        d = float(-2.75 * mpmath.cos(mpmath.mpf(y)))
    assert holds("d/cos(y) = -2.75", d=d, y=y)
    assert not holds("d/cos(y) = -2.75", d=d * (1 + 1e-9), y=y)


def test_a_divisor_below_floats_is_no_zero() -> None:
    """c^2.5 at 1e-160 is 1e-400."""
    result = solver.solve(rulesheets.loads("a*d/(7*c*c^1.5) = 2e200\nc = 1e-160\nd = 1e-100"))
    assert result.status is solver.Status.SOLVED
    assert result["a"] == pytest.approx(1.4e-99, rel=1e-12)


def test_a_quotient_of_floats_makes_no_root() -> None:
    """6.7077/36 is 0.186325 to decimals, and another number to the floats next to them: the
    payments of a loan without interest, which the formula does not hold for at 0, are no nearer to
    it beside 0.
    """
    assert not holds("6.7077*(x/(1 - (1 + x)^(-36))) = 6.7077/36", x=-2.684022334860396e-18)


def test_a_slope_leads_no_farther_than_its_function() -> None:
    """The slope of a cosine at 1e261 takes it by 1e245 within the last places of its angle: it is
    below 1."""
    assert not holds("cos(d) + y = 7.28e252", d=-1.17e261, y=7.279999893284968e252)
    assert holds("cos(d) + y = 7.28e252", d=-1.17e261, y=7.28e252)


def test_rounding_below_the_smallest_float_is_rounding() -> None:
    """erfc(27.3) is 2e-326: no float, and not 0."""
    assert not holds("0.014*erfc(w) = 0", w=27.3)
    assert not holds("1e-300*exp(w) = 0", w=-900.0)
    assert holds("0.014*w*erfc(27.3) = 0", w=0.0)


@pytest.mark.parametrize(
    ("rule", "values"),
    [
        ("abs(270*y)*sinh(30*y - 1e100) = -1e-300", {"y": 90.0}),  # -1e(4e99)
        ("1e9^(-1e200 - x) = 0", {"x": 30.0}),
        ("tanh(asinh(1e300 - z)) = 1", {"z": 3.0}),  # 5e-601 less
        ("mod(1, -90 - y) + 1e-200/y = 1", {"y": -1.7e308}),
        ("atan2d(y, 1e200) = 0", {"y": 1e-300}),
        ("atan2(5e-324, x) = 0", {"x": 3600.0}),
        ("atan2d(z^3, -90) = 90", {"z": 1e300}),
        ("1e-200^(x^3) = 1", {"x": -1e-300}),
        ("abs(erfc(x)) = 0", {"x": 400.0}),
        ("abs(exp(1e9*x + 45)) = 0", {"x": -2.0}),
        ("sgn(sind(x)) = 0", {"x": 5e-324}),
    ],
)
def test_what_is_beyond_the_digits_looked_at_is_not_there(
    rule: str, values: dict[str, float]
) -> None:
    assert not holds(rule, **values)


@pytest.mark.parametrize(
    "rule", ["a + b - c = 0", "0 = a + b - c", "a*d - c*d + b*d = 0", "d*(a + b - c) = 0"]
)
def test_a_rule_that_adds_up_to_nothing_is_judged_by_its_terms(rule: str) -> None:
    """Kirchhoff's and Newton's laws are often written so; moved to the other side, terms say no
    more."""
    a, b, d = 1.7, 2.9000000000000004, 3.3
    for share in (0.0, 2e-16, 8e-16):
        assert holds(rule, a=a, b=b, c=(a + b) * (1 + share), d=d)
    for share in (3e-14, 1e-12, 1e-6):
        assert not holds(rule, a=a, b=b, c=(a + b) * (1 + share), d=d)


@given(
    st.integers(-300, -10).map(lambda n: Decimal(n) / 100),
    st.integers(1, 7),
    st.sampled_from(["{b}^x = {z}", "{b}^(-x)*{z} = 1", "({b})^x/4 + 1 = {quarter} + 1"]),
)
def test_powers_of_negative_decimals_have_their_exponents(b: Decimal, n: int, form: str) -> None:
    """No exponent beside n has a power there: what may give is the last place of the written
    numbers."""
    rule = form.format(b=f"({b})", z=f"({b**n})", quarter=f"({b**n / 4})")
    assume(b not in (-1, 0) and len((b**n / 4).as_tuple().digits) <= 15)
    result = solver.solve(rulesheets.loads(f"rules\n{rule}\n"))
    assert result["x"] == n


@pytest.mark.parametrize("rule", ["(-0.2)^x = -0.0080000000001", "(-1.2)^x = 1.44000000000001"])
def test_a_digit_more_is_another_number(rule: str) -> None:
    result = solver.solve(rulesheets.loads(f"rules\n{rule}\n"))
    assert result.status is solver.Status.INFEASIBLE


@pytest.mark.parametrize(
    "rule",
    ["q = sqrt(y - n^2)", "q = acosd(y/n^2)", "q = (y - n^2)^0.3", "q = acosd(n^2/y)"],
)
@pytest.mark.parametrize("off", [0.0, 1e-12, 1e-9, 1e-5, 1.0])
def test_only_what_lies_on_the_side_of_the_values_holds_at_the_end_of_a_domain(
    rule: str, off: float
) -> None:
    """None of these is negative anywhere."""
    assert holds(rule, y=1.21, n=1.1, q=-off) is (off == 0.0)
