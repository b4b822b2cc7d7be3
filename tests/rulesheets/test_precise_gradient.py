"""Slopes to many digits: against differences at twice the digits, for every function and
operation."""

from __future__ import annotations

import mpmath
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rulesheets
from rulesheets.evaluate import Undefined, derivatives
from rulesheets.evaluate.digits import extended, extended_derivatives
from rulesheets.functions import TABLE
from rulesheets.syntax.nodes import Call, Expression, Name, Number

DIGITS = 40
X, Y = Name("x"), Name("y")
OF_ORDER = ("jn", "yn")
NO_FORMULA = ("digamma", "bessel_i1", "bessel_k1")
ONE = sorted(n for n, row in TABLE.items() if row.accepts(1) and n not in NO_FORMULA)
TWO = sorted(n for n, row in TABLE.items() if row.accepts(2) and n not in OF_ORDER)


def assert_right(expression: Expression, at: dict[str, float]) -> None:
    """Central differences have the square of their step for an error: 10⁻⁶⁰."""
    value, slopes = extended_derivatives(expression, at, DIGITS)
    with mpmath.workdps(2 * DIGITS):
        assert_equal(value, extended(expression, at, DIGITS))
        step = mpmath.mpf(10) ** -30
        for name in at:
            ahead, behind = ({**at, name: mpmath.mpf(at[name]) + sign * step} for sign in (1, -1))
            moved = extended(expression, ahead, 2 * DIGITS) - extended(
                expression, behind, 2 * DIGITS
            )
            assert_equal(slopes[name], moved / (2 * step))


def assert_equal(one: mpmath.mpf, other: mpmath.mpf) -> None:
    assert abs(one - other) <= mpmath.mpf(10) ** (6 - DIGITS) * (1 + abs(other))


@pytest.mark.parametrize("function", ONE)
def test_a_function_of_one_argument(function: str) -> None:
    x = 1.7 if function == "acosh" else 0.37
    assert_right(Call(function, (X,)), {"x": x})


@pytest.mark.parametrize("function", TWO)
def test_a_function_of_two_arguments(function: str) -> None:
    assert_right(Call(function, (X, Y)), {"x": 2.3, "y": -1.1 if function == "atan2" else 0.9})


@pytest.mark.parametrize("function", OF_ORDER)
def test_a_function_of_an_order(function: str) -> None:
    assert_right(Call(function, (Number(2.0), X)), {"x": 1.3})
    with pytest.raises(Undefined):
        extended_derivatives(Call(function, (X, Y)), {"x": 2.0, "y": 1.3}, DIGITS)


numbers = st.floats(0.3, 3.0)
(OPERATIONS,) = rulesheets.loads(
    "x^y/(x + 2*y) - sqrt(x*y)*y^3 - -x^2/y + (x - 7)^2 = x*cosd(40*x)/3"
).equations


@settings(max_examples=25)
@given(numbers, numbers)
def test_operations_together(x: float, y: float) -> None:
    """Variables that occur several times, powers of variables, quotients, constants and signs."""
    left, at = OPERATIONS.left, {"x": x, "y": y}
    assert_right(left, at)
    assert_right(OPERATIONS.right, {"x": x})
    slopes = {
        name: float(slope) for name, slope in extended_derivatives(left, at, DIGITS)[1].items()
    }
    assert slopes == pytest.approx(derivatives(left, at)[1], rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("text", ["sqrt(x)", "ln(x)", "1/x", "x^0.5", "atan2(x, x)", "asin(1 + x)"])
def test_where_there_is_no_slope_it_says_so(text: str) -> None:
    (equation,) = rulesheets.loads(f"{text} = y").equations
    with pytest.raises(Undefined):
        extended_derivatives(equation.left, {"x": 0.0}, DIGITS)


def test_what_does_not_vary_has_no_slope() -> None:
    (equation,) = rulesheets.loads("x*0 + sqrt(0) + 0^2 + x^0 = y").equations
    assert extended_derivatives(equation.left, {"x": 2.0}, DIGITS) == (1, {"x": 0})


def test_slopes_along_some_variables_need_none_along_others() -> None:
    """The slope along n of a power of a negative number has no value."""
    left = rulesheets.loads("x^(2*n) = 1").equations[0].left
    at = {"x": -1.5, "n": 2.0}
    with pytest.raises(Undefined):
        extended_derivatives(left, at, DIGITS)
    assert extended_derivatives(left, at, DIGITS, ["x"]) == (1.5**4, {"x": 4 * (-1.5) ** 3})
