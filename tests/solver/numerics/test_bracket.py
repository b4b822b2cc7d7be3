"""Bracketing to the last bit, across any number of decades."""

from __future__ import annotations

import math

import mpmath
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.numerics.one_unknown import bracketed_root, is_zero_crossing, lowest_point, split_point


@given(st.floats(-1e300, 1e300))
def test_a_linear_root_is_found_exactly(root: float) -> None:
    assert bracketed_root(lambda x: x - root, -1.7e308, 1.7e308) == root


@given(st.floats(1e-100, 1e100))
def test_logarithm_against_fifty_digits(target: float) -> None:
    with mpmath.workdps(50):
        exact = float(mpmath.log(target))
    found = bracketed_root(lambda x: math.exp(x) - target, -300.0, 300.0)
    assert found == pytest.approx(exact, rel=1e-15, abs=4e-16)


def test_few_evaluations_across_600_decades() -> None:
    calls = []

    def f(x: float) -> float:
        calls.append(x)
        return x - 1e-200

    assert bracketed_root(f, 1e-300, 1e300) == 1e-200
    assert len(calls) < 40


@pytest.mark.parametrize(
    ("f", "is_root"),
    [
        (lambda x: x - 1.1, True),
        (lambda x: math.copysign(abs(x - 1.1) ** (1 / 3), x - 1.1), True),
        (lambda x: (x - 1.1) ** 5, True),
        (lambda x: 1 / (x - 1.1) if x != 1.1 else math.nan, False),
        (lambda x: math.copysign(1.0, x - 1.1), False),
    ],
)
def test_poles_and_jumps_are_told_from_roots(f, is_root: bool) -> None:  # type: ignore[no-untyped-def]
    x = bracketed_root(f, 0.0, 3.0)
    assert x == pytest.approx(1.1, rel=1e-3)
    assert is_zero_crossing(f, x, 0.0, 3.0) is is_root


@given(st.floats(), st.floats())
def test_split_point_lies_between(low: float, high: float) -> None:
    if (
        not low < high
        or math.nextafter(low, math.inf) >= high
        or (math.isinf(high) and low >= 1.7e308)
    ):
        return
    if math.isinf(low) and high <= -1.7e308:
        return
    assert low < split_point(low, high) < high


@pytest.mark.parametrize("point", [0.0, -0.0, 1.0, -2.0, 5e-324, 1e308])
def test_a_point_is_split_into_itself(point: float) -> None:
    assert split_point(point, point) == point


def test_the_whole_line_is_shallow() -> None:
    for target in (1e-300, 1e-9, 1.0, 1e300):
        low, high, depth = 0.0, math.inf, 0
        while high - low > 1e-6 * target:
            middle = split_point(low, high)
            low, high = (middle, high) if middle < target else (low, middle)
            depth += 1
        assert depth < 45


def test_lowest_point_of_a_few_floats_is_exact() -> None:
    low, high = 1 - 1e-15, 1 + 1e-15
    assert lowest_point(lambda x: (x - 1) ** 2, low, high) == 1.0
