"""Values as text."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.report.numbers import exact, magnitude, readable


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


def test_magnitudes() -> None:
    assert magnitude(0.0) == "0"
    assert magnitude(1.4e-16) == "1e-16"
