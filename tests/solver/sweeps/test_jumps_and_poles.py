"""What is only computed between two rows: one curve with a maximum, or a jump, or a pole."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from solver.sweeps.curves import is_discontinuous


def has_jump(function: Callable[[float], float], start: float, end: float) -> bool:
    def value(place: float) -> float | None:
        try:
            return function(place)
        except ZeroDivisionError:
            return None

    return is_discontinuous(start, end, value)


@settings(max_examples=40)
@given(st.floats(0.05, 0.95), st.floats(0.0, 60.0), st.sampled_from([0.0, 1e-30, 1.0, -3.0]))
def test_a_maximum_parts_nothing(middle: float, sharp: float, foot: float) -> None:
    """However small the value is at both rows: 0 at both, for the first."""
    assert not has_jump(
        lambda x: x * (1.0 - x) * math.exp(-((sharp * (x - middle)) ** 2)), 0.0, 1.0
    )
    assert not has_jump(lambda x: foot + math.exp(-((sharp * (x - middle)) ** 2)), 0.0, 1.0)


@settings(max_examples=40)
@given(st.floats(0.05, 0.95), st.sampled_from([1.0, 2.0, 4.0]), st.booleans())
def test_a_pole_parts(place: float, order: float, ends_at_0: bool) -> None:
    """Of one sign on both sides, where half-way the value is larger than at both rows: these may be
    0."""

    def pole(x: float) -> float:
        return (x * (1.0 - x) if ends_at_0 else 1.0) / abs(x - place) ** order

    assume(place == 0.5 or pole(0.5) > max(pole(0.0), pole(1.0)))
    assert has_jump(pole, 0.0, 1.0)


@pytest.mark.parametrize("place", [0.1, 0.5, 0.77])
def test_a_jump_parts_and_a_steep_slope_does_not(place: float) -> None:
    assert has_jump(lambda x: 0.1 * x + (1.0 if x > place else 0.0), 0.0, 1.0)
    assert not has_jump(lambda x: 0.1 * x + math.tanh(1e4 * (x - place)), 0.0, 1.0)
