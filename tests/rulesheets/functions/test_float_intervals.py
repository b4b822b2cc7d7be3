"""Interval forms on floats contain every value on a box, by mpmath, as tightly as those on arrays."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rulesheets.evaluate.digits import functions
from rulesheets.evaluate.number import FLOAT_INTERVALS
from rulesheets.functions import TABLE
from rulesheets.functions import arrays as on_arrays
from rulesheets.functions import intervals as arithmetic
from rulesheets.functions.arrays import INTERVALS
from tests.rulesheets.functions.test_intervals import assert_contains, quiet, real_power

__all__ = ["quiet"]

INF = math.inf
EXACT = functions(40)
ARITHMETIC = ("add", "multiply", "divide", "power")
SPECIAL = (-INF, INF, -1e308, 1e308, -360.0, -90.0, -1.0, -0.0, 0.0, 5e-324, 0.5, 1.0, 2.0, 90.0, 180.0, 1e15)
NUMBERS = st.one_of(st.sampled_from(SPECIAL), st.floats(-1e3, 1e3), st.floats(allow_nan=False))
BOXES = st.tuples(NUMBERS, NUMBERS).map(sorted).filter(lambda box: box[0] < INF and box[1] > -INF)
NAMED = [name for name in TABLE if TABLE[name].arity != (0, 0)]


def each(form: Callable[..., tuple[float, float]]) -> Callable[..., Any]:
    """The form on floats, given arrays as the form on arrays is."""

    def boxes(*ends: Any) -> Any:
        rows = zip(*(end.tolist() for end in np.broadcast_arrays(*ends)), strict=True)
        return np.array([form(*row) for row in rows]).T

    return boxes


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("name", NAMED)
def test_contains_every_value(name: str, seed: int) -> None:
    count = TABLE[name].arity[1]
    count = 3 if count is None else count
    assert_contains(name, each(FLOAT_INTERVALS[name]), EXACT[name], count, seed)


@pytest.mark.parametrize("name", ["pi", "e"])
def test_constants_lie_within(name: str) -> None:
    low, high = FLOAT_INTERVALS[name]()
    assert low < EXACT[name]() < high == math.nextafter(low, INF)


@pytest.mark.parametrize("seed", range(1, 5))
def test_arithmetic_contains_every_value(seed: int) -> None:
    assert_contains("add", each(arithmetic.add), lambda x, y: x + y, 2, seed)
    assert_contains("multiply", each(arithmetic.multiply), lambda x, y: x * y, 2, seed)
    assert_contains("divide", each(arithmetic.divide), lambda x, y: x / y, 2, seed)
    assert_contains("power", each(arithmetic.power), real_power, 2, seed)


def assert_alike(found: tuple[float, float], expected: tuple[float, float], tolerance: float) -> None:
    assert found == pytest.approx(expected, rel=tolerance, abs=1e-320, nan_ok=True)


@pytest.mark.parametrize("name", ARITHMETIC)
@settings(max_examples=50)
@given(BOXES, BOXES)
def test_arithmetic_is_that_on_arrays(name: str, a: list[float], b: list[float]) -> None:
    """To the last bit, powers to the few that the libraries are trusted to be off."""
    low, high = (float(end) for end in getattr(on_arrays, name)(*map(np.asarray, (*a, *b))))
    assert_alike(getattr(arithmetic, name)(*a, *b), (low, high), 1e-14 if name == "power" else 0.0)


@pytest.mark.parametrize("name", NAMED)
@settings(max_examples=25)
@given(st.lists(BOXES, min_size=3, max_size=3))
def test_functions_are_those_on_arrays(name: str, boxes: list[list[float]]) -> None:
    """To the last places in which the libraries differ. (Scipy has infinity for some numbers next to 0.)"""
    ends = [end if abs(end) > 1e-300 else 0.0 for box in boxes[: TABLE[name].arity[1] or 3] for end in box]
    low, high = (float(end) for end in INTERVALS[name](*map(np.asarray, ends)))
    assert_alike(FLOAT_INTERVALS[name](*ends), (low, high), 1e-12 if name == "erfc" else 1e-13)


@pytest.mark.parametrize("name", NAMED)
def test_empty_arguments_stay_empty(name: str) -> None:
    count = max(TABLE[name].arity[0], 1)
    for place in range(count):
        ends = [1.0] * (2 * count)
        ends[2 * place : 2 * place + 2] = [math.nan] * 2
        assert all(map(math.isnan, FLOAT_INTERVALS[name](*ends)))


def test_an_end_that_nothing_is_known_of_leaves_no_false_bound() -> None:
    assert arithmetic.multiply(2.0, math.nan, 1.0, 1.0) == (-INF, INF)
    assert arithmetic.divide(1.0, 1.0, 2.0, math.nan) == (-INF, INF)
    assert FLOAT_INTERVALS["abs"](-1.0, math.nan) == (0.0, INF)
    assert FLOAT_INTERVALS["sin"](1.0, math.nan) == (-1.0, 1.0)
    assert arithmetic.within(1.0, math.nan, math.nan, 2.0) == (1.0, 2.0)


def test_the_logarithm_of_gamma_next_to_zero() -> None:
    ends = 5e-324, 1e-310
    for low, high in (FLOAT_INTERVALS["lgamma"](*ends), INTERVALS["lgamma"](*map(np.asarray, ends))):
        assert low <= EXACT["lgamma"](1e-310) <= EXACT["lgamma"](5e-324) <= high


def test_there_is_a_form_of_every_function() -> None:
    assert set(FLOAT_INTERVALS) == set(TABLE)
