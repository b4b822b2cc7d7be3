"""Degree functions against exact answers and against mpmath, as scalars and as arrays."""

from __future__ import annotations

import math
from collections.abc import Callable

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rulesheets.evaluate.digits import Digits, context
from rulesheets.functions import ARRAYS, TABLE

# Enough digits for a float times 10**300 reduced to less than a turn.
EXACT = Digits({}, 700).functions
MPF = context(700).mpf


def scalar(name: str, *arguments: float) -> float:
    return TABLE[name].value(*arguments)


def array(name: str, *arguments: float) -> float:
    with np.errstate(all="ignore"):
        return float(ARRAYS[name](*(np.array([argument]) for argument in arguments))[0])


FORMS = pytest.mark.parametrize("form", [scalar, array])

HALF_SINES = {30: 0.5, 150: 0.5, 210: -0.5, 330: -0.5}
SINES = {0: 0.0, 90: 1.0, 180: 0.0, 270: -1.0} | HALF_SINES
TANGENTS = {0: 0.0, 45: 1.0, 135: -1.0, 180: 0.0, 225: 1.0, 315: -1.0}


@FORMS
@pytest.mark.parametrize("turns", [-3, -1, 0, 1, 1000, 2**40])
def test_exact_where_the_answer_is_a_float(form: Callable[..., float], turns: int) -> None:
    for angle, sine in SINES.items():
        assert form("sind", angle + 360.0 * turns) == sine
        assert form("cosd", angle - 90 + 360.0 * turns) == sine
    for angle, tangent in TANGENTS.items():
        assert form("tand", angle + 360.0 * turns) == tangent


@FORMS
def test_zeros_have_no_sign(form: Callable[..., float]) -> None:
    for angle in (90.0, 270.0, -90.0):
        assert math.copysign(1.0, form("cosd", angle)) == 1.0
    assert math.copysign(1.0, form("sind", 180.0)) == 1.0


@FORMS
def test_inverses_are_exact(form: Callable[..., float]) -> None:
    for angle, sine in {0: 0.0, 30: 0.5, 90: 1.0, -30: -0.5, -90: -1.0}.items():
        assert form("asind", sine) == angle
        assert form("acosd", sine) == 90 - angle
    assert [form("atand", slope) for slope in (-1.0, 0.0, 1.0)] == [-45.0, 0.0, 45.0]


@FORMS
@pytest.mark.parametrize(
    ("y", "x", "direction"),
    [
        (0.0, 2.0, 0.0),
        (-0.0, 2.0, 0.0),
        (3.0, 3.0, 45.0),
        (1.0, 0.0, 90.0),
        (1e-3, -1e-3, 135.0),
        (0.0, -1.0, 180.0),
        (-0.0, -1.0, 180.0),
        (-1e-300, -1.0, 180.0),
        (-7.0, -7.0, -135.0),
        (-1.0, 0.0, -90.0),
        (-1.0, -0.0, -90.0),
        (-2.0, 2.0, -45.0),
    ],
)
def test_directions(form: Callable[..., float], y: float, x: float, direction: float) -> None:
    assert form("atan2d", y, x) == direction


def test_refusals() -> None:
    for name, arguments in {
        "tand": (90.0,),
        "asind": (1.5,),
        "acosd": (-1.5,),
        "atan2d": (0.0, 0.0),
    }.items():
        with pytest.raises((ValueError, ZeroDivisionError)):
            scalar(name, *arguments)
        assert math.isnan(array(name, *arguments))


def errors_in_ulp(result: float, exact: mpmath.mpf) -> float:
    return float(abs(MPF(result) - exact) / MPF(math.ulp(float(exact))))


angles = st.one_of(
    st.floats(-1e3, 1e3),
    st.floats(-1e15, 1e15),
    st.floats(-1e300, 1e300),
    st.builds(lambda k, d: 30.0 * k + d, st.integers(-40, 40), st.floats(-1e-10, 1e-10)),
)


@FORMS
@given(angle=angles)
def test_waves_are_accurate_to_two_ulp(form: Callable[..., float], angle: float) -> None:
    assert errors_in_ulp(form("sind", angle), EXACT["sind"](MPF(angle))) <= 2.0
    assert errors_in_ulp(form("cosd", angle), EXACT["cosd"](MPF(angle))) <= 2.0


@FORMS
@given(angle=angles.filter(lambda angle: math.fmod(angle, 180.0) not in (90.0, -90.0)))
def test_tangent_is_accurate_to_three_ulp(form: Callable[..., float], angle: float) -> None:
    assert errors_in_ulp(form("tand", angle), EXACT["tand"](MPF(angle))) <= 3.0


small = Digits({}, 60).functions
small_mpf = context(60).mpf


@FORMS
@given(x=st.one_of(st.floats(-1.0, 1.0), st.floats(0.0, 1e-10).map(lambda d: 1.0 - d)))
def test_inverses_are_accurate_to_two_ulp(form: Callable[..., float], x: float) -> None:
    for name in ("asind", "acosd", "atand"):
        assert errors_in_ulp(form(name, x), small[name](small_mpf(x))) <= 2.0


@FORMS
@given(y=st.floats(-1e9, 1e9).filter(lambda y: abs(y) > 1e-280), x=st.floats(1e-9, 1e9))
def test_direction_is_accurate_to_two_ulp(form: Callable[..., float], y: float, x: float) -> None:
    assert errors_in_ulp(form("atan2d", y, x), small["atan2d"](small_mpf(y), small_mpf(x))) <= 2.0


@given(angle=st.floats(-180.0, 180.0, exclude_min=True))
def test_direction_undoes_sine_and_cosine(angle: float) -> None:
    direction = scalar("atan2d", scalar("sind", angle), scalar("cosd", angle))
    assert direction == pytest.approx(angle, rel=1e-15, abs=1e-300) or abs(angle) == pytest.approx(
        180.0
    )


@given(st.floats(1e-300, 1e6), st.sampled_from([("sind", -1), ("cosd", 1), ("tand", -1)]))
def test_many_digits_are_kept_on_either_side_of_zero(x: float, function: tuple[str, int]) -> None:
    """sind(-x) is -sind(x), however small x is beside a turn."""
    name, sign = function
    mp, found = context(50), Digits({}, 50).functions[name]
    if name == "tand" and x % 90 == 0:
        return
    one, other = found(mp.mpf(x)), found(-mp.mpf(x))
    assert abs(other - sign * one) <= abs(one) * mp.mpf(10) ** (-40 if x < 180 else -30)
