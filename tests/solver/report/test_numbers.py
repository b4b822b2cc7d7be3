"""Values as text."""

from __future__ import annotations

import math
from decimal import Decimal
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rulesheets.inputs import exact, readable
from solver.report.sheet import certain


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, ""),
        ("open", "'open"),
        (3.0, "3"),
        (-0.0, "0"),
        (-30.0, "-30"),
        (1 / 3, "0.3333333333"),
        (123456789012.0, "1.23456789e+11"),
        (1e-300, "1e-300"),
    ],
)
def test_people_read_ten_digits(value: float | str | None, text: str) -> None:
    assert readable(value) == text


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_files_read_back_the_same_float(value: float) -> None:
    assert float(exact(value)) == value


@given(st.floats(-1e300, 1e300))
def test_what_people_read_is_right_to_ten_digits(value: float) -> None:
    assert float(readable(value)) == pytest.approx(value, rel=5.1e-10, abs=5e-324)


numbers = st.floats(min_value=-1e200, max_value=1e200, allow_subnormal=False).filter(
    lambda x: abs(x) > 1e-200
)


@given(value=numbers, relative=st.floats(1e-17, 0.4), share=st.floats(-1.0, 1.0))
def test_certain_digits_are_off_by_one_at_most(value: float, relative: float, share: float) -> None:
    """Whatever the true value is within the error, the last digit printed is off by one at most."""
    error = abs(value) * relative
    text = certain(value, error)
    if text.startswith("±"):
        assert error > 0.04 * abs(value)
        return
    true = Fraction(value) + Fraction(error) * Fraction(share)
    printed = Decimal(text)
    unit = Fraction(10) ** printed.as_tuple().exponent  # type: ignore[operator]
    assert abs(Fraction(printed) - true) <= unit
    assert unit <= 21 * Fraction(error)


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (4.0, 0.0, "4"),
        (2.0 / 3.0, 1e-4, "0.667"),
        (9.7918, 0.0, "9.7918"),
        (120345.0, 300.0, "1.20e5"),
        (1e-17, 1e-16, "±1e-16"),
        (1.0, math.inf, "±?"),
        ("open", 0.0, "'open"),
        (None, 0.0, ""),
    ],
)
def test_certain(value: float | str | None, error: float, text: str) -> None:
    assert certain(value, error) == text
