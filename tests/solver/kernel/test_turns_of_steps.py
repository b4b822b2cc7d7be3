"""Whole turns inside other functions: every preimage in a range, against a count of crossings."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import rulesheets
import solver

CASES: dict[str, tuple[str, Callable[[float], float], float, float]] = {
    "sine of a sine": (
        "sin(sin(x)) = 0.5",
        lambda x: math.sin(math.sin(x)) - 0.5,
        -math.pi,
        math.pi,
    ),
    "sine of a cosine": (
        "sin(cos(x)) = 0.5",
        lambda x: math.sin(math.cos(x)) - 0.5,
        -math.pi,
        math.pi,
    ),
    "sine of an exponential": (
        "sin(exp(x)) = 0.5",
        lambda x: math.sin(math.exp(x)) - 0.5,
        0.0,
        3.0,
    ),
    "sine of a square": ("sin(x^2) = 0.5", lambda x: math.sin(x * x) - 0.5, -5.0, 6.0),
    "sine of a multiple": ("sin(7*x + 1) = 0.5", lambda x: math.sin(7 * x + 1) - 0.5, -2.0, 5.0),
    "sine of a reciprocal": ("sin(1/x) = 0.5", lambda x: math.sin(1 / x) - 0.5, 0.05, 3.0),
    "twofold turns": (
        "sind(720*cosd(x)) = 0.5",
        lambda x: math.sin(4 * math.pi * math.cos(math.radians(x))) - 0.5,
        -180.0,
        180.0,
    ),
}


UNCOUNTED = ("sine of an exponential", "sine of a square", "sine of a reciprocal")
"""Of these the nearest 40 turns are tried, and not known to be all."""


@pytest.mark.parametrize("case", CASES)
def test_every_preimage_in_the_range(case: str) -> None:
    rule, function, low, high = CASES[case]
    result = solver.solve(rulesheets.loads(f"variables\nx in [{low!r}, {high!r}]\nrules\n{rule}"))
    found = sorted(float(str(solution["x"])) for solution in result.solutions)
    grid = np.linspace(low, high, 40_001)
    signs = np.sign([function(x) for x in grid])
    crossings = [(grid[i], grid[i + 1]) for i in np.flatnonzero(signs[:-1] * signs[1:] < 0)]
    assert str(result.status) == "solved"
    assert result.complete == (case not in UNCOUNTED)
    assert len(found) == len(crossings)
    assert all(a <= x <= b for x, (a, b) in zip(found, crossings, strict=True))


def test_an_infinite_number_of_preimages_is_not_called_complete() -> None:
    for rule in ("sin(exp(x)) = 0.5", "sin(x^2) = 0.5", "sin(1/x) = 0.5"):
        result = solver.solve(rulesheets.loads(rule))
        assert str(result.status) == "solved"
        assert not result.complete
    near = solver.solve(rulesheets.loads("variables\nx in [0, 3]\nrules\nsin(1/x) = 0.5"))
    assert not near.complete


def test_an_unknown_that_cancels_is_free() -> None:
    for rule in ("sin(a)*x/x = y", "(x - x)/(10 - x) + a = y"):
        text = (
            f"variables\na = 0.3\ny = {math.sin(0.3) if 'sin' in rule else 0.3!r}\nx\nrules\n{rule}"
        )
        assert str(solver.solve(rulesheets.loads(text)).status) == "singular"


@pytest.mark.parametrize("ranges", ["", "variables\nx in [-5, 5]\ny in [-5, 5]\nrules\n"])
def test_a_root_where_a_quotient_says_nothing(ranges: str) -> None:
    """The origin is the only root; solved for one unknown, either rule divides 0 by 0 there."""
    result = solver.solve(rulesheets.loads(f"{ranges}x*(x^2 + y^2) = 0\ny*(x^2 + y^2) = 0"))
    assert str(result.status) == "singular"
    assert [(s["x"], s["y"]) for s in result.solutions] == [(0.0, 0.0)]


def test_an_answer_on_a_turn_that_the_principal_value_does_not_lead_to() -> None:
    """exp(x) is -π/2 nowhere, and 3π/2 at one place."""
    result = solver.solve(rulesheets.loads("sin(exp(x)) = -1"))
    assert str(result.status) != "infeasible"
    assert any(abs(float(str(s["x"])) - math.log(1.5 * math.pi)) < 1e-7 for s in result.solutions)


def test_a_curve_of_answers_is_told_as_what_it_leaves_free() -> None:
    text = "variables\nx ~ -0.2\ny ~ 0.6\nz ~ 5\nrules\nx*z = 0\nx*y = 0\ny + z = -1.75"
    result = solver.solve(rulesheets.loads(text))
    assert str(result.status) == "partial"
    assert set(result.undetermined) == {"y", "z"}
    assert [dict(solution) for solution in result.solutions] == [{"x": 0.0}]


def test_a_division_by_zero_between_numbers_is_no_crash() -> None:
    text = "x^2 + y*sin(x) = 3 + 1/(2 - 2)\ny*cos(x) + x = 2"
    assert str(solver.solve(rulesheets.loads(text)).status) in (
        "failed",
        "infeasible",
        "inconsistent",
    )


@settings(max_examples=25, deadline=None)
@given(
    st.floats(1.0, 10.0),
    st.integers(8, 59),
    st.floats(0.01, 0.99),
    st.sampled_from([("sin(d + x) = c", mpmath.sin), ("d*cos(d + x) = c*d", mpmath.cos)]),
)
def test_an_angle_beside_a_number_that_drowns_it(
    leading: float, exponent: int, c: float, rule: tuple[str, Callable[[Any], Any]]
) -> None:
    """The float d is an exact number, and the two angles are too in one turn, whatever digits that
    takes."""
    text, function = rule
    d = leading * 10.0**exponent
    result = solver.solve(rulesheets.loads(text), {"d": d, "c": c})
    assert str(result.status) == "solved"
    assert len(result.solutions) == 2
    with mpmath.workdps(400):
        for solution in result.solutions:
            x = mpmath.mpf(solution["x"])
            assert abs(x) <= mpmath.pi
            assert abs(function(mpmath.mpf(d) + x) - mpmath.mpf(c)) < 1e-15


@pytest.mark.parametrize("d", [1.5e283, 1.7578125e283, 1e120])
def test_a_zero_beside_a_number_that_drowns_it_is_not_counted_as_none(d: float) -> None:
    """sin(d + x) is 0 at two angles in a turn; what no float is good enough for is no proof of
    fewer."""
    result = solver.solve(rulesheets.loads("sin(d + x) = c"), {"d": d, "c": 0.0})
    assert str(result.status) in ("solved", "failed")
    assert len(result.solutions) == 2 or not result.complete


@pytest.mark.parametrize("d", [8.140060753854967e90, 3e140])
def test_an_angle_of_which_no_digit_is_known_is_no_answer(d: float) -> None:
    """The rule holds to rounding whatever x is: values of d next to one another give any sine."""
    result = solver.solve(rulesheets.loads("sin(d + x) = c"), {"d": d, "c": 0.8155149614733322})
    for solution in result.solutions:
        with mpmath.workdps(400):
            assert (
                abs(mpmath.sin(mpmath.mpf(d) + mpmath.mpf(solution["x"])) - 0.8155149614733322)
                < 1e-15
            )


DAY = "d = 23.45*sind(360*(284 + n)/365)"


@pytest.mark.parametrize(
    ("sheet", "inputs", "guess", "expected"),
    [
        (DAY, {"d": 14.07}, {}, [118.38, 226.12]),
        (DAY, {"d": 14.07}, {"n": 100.0}, [118.38, 226.12]),
        (DAY, {"d": 14.07}, {"n": 900.0}, [848.38, 956.12]),
        ("u = sin(2*pi*f*t)", {"f": 50.0, "u": -0.5}, {}, [7 / 600, 11 / 600]),
        ("y = cosd(k*x + 90)", {"k": 2.0, "y": -0.5}, {}, [15.0, 75.0]),
        ("z = a/7\ny = sind(a/2)", {"y": -0.5}, {}, [-60.0, 420.0]),
    ],
)
def test_what_an_angle_is_computed_from_is_positive_or_near_its_guess(
    sheet: str, inputs: dict[str, float], guess: dict[str, float], expected: list[float]
) -> None:
    """A day of the year, a time, a place: the first period from 0. Shares of angles stay around
    0."""
    model = rulesheets.loads(sheet)
    unknown = next(n for n in model.variables if n not in inputs and n != "z")
    result = solver.solve(model, inputs, guesses=guess)
    assert [s[unknown] for s in result.solutions] == pytest.approx(expected, abs=0.01)
    plan = solver.prepare(model, list(inputs), [unknown], guesses=guess)
    last = list(inputs)[-1]
    for factor in (1.0, 0.9, 0.2, -0.3, -1.0, 1.5):
        moved = {**inputs, last: inputs[last] * factor}
        full = solver.solve(model, moved, guesses=guess)
        assert [row[0] for row in plan.all(*moved.values())] == pytest.approx(
            [s[unknown] for s in full.solutions], rel=1e-10
        )


def test_half_of_a_difference_of_angles_is_read_in_two_turns() -> None:
    """The haversine: two latitudes at a distance, known to be all; by the spherical law of
    cosines."""
    sheet = (
        "a = sind((p2 - p1)/2)^2 + cosd(p1)*cosd(p2)*sind(0.5*(l2 - l1))^2\nd = 2*asind(sqrt(a))"
    )
    given = {"p1": 48.2, "l1": 16.37, "l2": -74.0, "d": 61.1}
    result = solver.solve(rulesheets.loads(sheet), given)
    along = math.cos(math.radians(given["l2"] - given["l1"]))
    up, out = math.sin(math.radians(given["p1"])), math.cos(math.radians(given["p1"])) * along
    middle, off = (
        math.atan2(up, out),
        math.acos(math.cos(math.radians(given["d"])) / math.hypot(up, out)),
    )
    expected = [math.degrees(middle - off), math.degrees(middle + off)]
    assert sorted(float(s["p2"]) for s in result.solutions) == pytest.approx(expected)
    assert result.complete


@settings(max_examples=60, derandomize=True)
@given(
    st.integers(-90, 30),
    st.sampled_from([20, 45, 90]),
    st.sampled_from(["sind", "cosd", "tand"]),
    st.sampled_from([1.0, 2.0, 0.5, -1.0]),
    st.sampled_from([0.0, 15.0, -40.0]),
    st.integers(-99, 99),
)
def test_an_angle_outside_its_range_is_refused_with_the_nearest_that_it_would_be(
    low: int, width: int, function: str, factor: float, shift: float, percent: int
) -> None:
    r, high = percent / 100, low + width
    rule = f"{function}({factor!r}*x + {shift!r}) = r"
    result = solver.solve(
        rulesheets.loads(f"variables\nx in [{low}, {high}]\nrules\n{rule}"), {"r": r}
    )
    inverse = {"sind": math.asin, "cosd": math.acos, "tand": math.atan}[function](r)
    principal = [math.degrees(inverse)]
    principal += [180 - principal[0]] if function == "sind" else []
    principal += [-principal[0]] if function == "cosd" else []
    period = 180.0 if function == "tand" else 360.0
    every = [(p - shift + k * period) / factor for p in principal for k in range(-4, 5)]
    beyond = [max(low - x, x - high, 0.0) for x in every]
    inside = sorted(x for x, far in zip(every, beyond, strict=True) if far == 0.0)
    assume(not 0.0 < min(beyond) < 1e-6)
    if inside:
        assert sorted(s["x"] for s in result.solutions) == pytest.approx(inside, abs=1e-9)
        return
    assert (str(result.status), result.diagnoses[0].code) == ("infeasible", "S531")
    told = float(result.diagnoses[0].message.split()[3].strip(","))
    assert max(low - told, told - high) == pytest.approx(min(beyond), abs=2e-3)


def test_rows_of_which_no_root_lies_in_the_range_are_refused_alike() -> None:
    """Two roots of a square, both out of the range: as a record, and as a solve."""
    model = rulesheets.loads("variables\nx in [0, 20]\nrules\nx^2 - 3*x = 1000*r")
    plan = solver.prepare(model, ["r"], ["x"])
    for r in (0.9, 0.91, 0.33, 0.3, 5.0, 0.0, -0.001, -0.002, -0.01):
        expected = [s["x"] for s in solver.solve(model, {"r": r}).solutions]
        try:
            assert [row[0] for row in plan.all(r)] == pytest.approx(expected)
        except solver.Unsolved as refused:
            assert (expected, str(refused.status)) == ([], "infeasible")


@pytest.mark.parametrize("rate", ["377", "360*pi/180*60", "15.5"])
def test_a_time_is_read_in_the_first_period_whatever_its_rate(rate: str) -> None:
    """An angle that is multiplied by more than twelve is none: ``v = 170*sin(377*t)``."""
    result = solver.solve(rulesheets.loads(f"v = 170*sin({rate}*t)"), {"v": 85.0})
    w = eval(rate, {"pi": math.pi})
    assert [answer["t"] for answer in result.solutions] == pytest.approx(
        [math.pi / 6 / w, 5 * math.pi / 6 / w]
    )


WIND = "angle = wind - course\nspeed*sind(drift) = gust*sind(angle)\nheading = course + drift"


@given(
    wind=st.integers(0, 359),
    course=st.integers(-179, 180),
    share=st.floats(0.05, 0.9),
    known=st.sampled_from(["heading", "course"]),
)
def test_angles_that_sums_tie_turn_together(
    wind: int, course: int, share: float, known: str
) -> None:
    """A wind triangle: whole turns of the course are taken from the angle between the two."""
    drift = math.degrees(math.asin(share * math.sin(math.radians(wind - course))))
    inputs = {"wind": float(wind), "speed": 100.0, "gust": 100.0 * share}
    inputs[known] = {"heading": course + drift, "course": float(course)}[known]
    assume(abs(inputs[known]) < 180.0)
    result = solver.solve(rulesheets.loads(WIND), inputs)
    assert result.complete
    for answer in result.solutions:
        turned = [name for name in ("course", "drift") if abs(answer[name]) > 180.0 + 1e-6]
        assert known not in turned and len(turned) <= 1
    courses = [answer["course"] for answer in result.solutions]
    assert any(abs(math.remainder(one - course, 360.0)) < 1e-6 for one in courses)


@pytest.mark.parametrize("ranged", ["heading in [0, 360]", "course in [0, 360]"])
def test_whole_turns_lead_out_of_no_range(ranged: str) -> None:
    """Of the two headings, 330 and 50, the second is a whole turn from where the sums lead."""
    model = rulesheets.loads(f"variables\n {ranged}\nrules\n {WIND}")
    result = solver.solve(model, {"wind": 290, "speed": 110, "gust": 25, "drift": -10})
    low, high = model.variables[ranged.split()[0]].low, model.variables[ranged.split()[0]].high
    assert all(low <= answer[ranged.split()[0]] <= high for answer in result.solutions)
    assert len(result.solutions) == 2 or not result.complete
