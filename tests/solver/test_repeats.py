"""A solve that is repeated with other numbers says what the first solve of a fresh model says."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rulesheets
import solver
from solver.attempts import Method
from solver.result import Result

MODELS = Path(__file__).parents[2] / "models"


def load(name: str) -> rulesheets.Model:
    return rulesheets.load(str(MODELS / name / "model.tk"))


TAUGHT = load("offset_slider_crank")


def same(one: Result, other: Result) -> None:
    assert one.status is other.status
    assert one.complete == other.complete
    assert one.inputs == other.inputs
    assert one.wanted == other.wanted
    assert one.undetermined == other.undetermined
    assert one.path == other.path
    refined = any(a.method is Method.EXTENDED for found in other.attempts.values() for a in found)
    assert refined or one.attempts == other.attempts
    assert [str(d.code) for d in one.diagnoses] == [str(d.code) for d in other.diagnoses]
    assert len(one.solutions) == len(other.solutions)
    for mine, theirs in zip(one.solutions, other.solutions, strict=True):
        assert set(mine) == set(theirs)
        assert mine.checked == theirs.checked
        assert mine.worst_residual <= 64 * 2**-52
        for name, value in theirs.items():
            if isinstance(value, str):
                assert mine[name] == value
            else:
                error = max(theirs.error.get(name, 0.0), 1e-12 * abs(value))
                assert mine[name] == pytest.approx(value, rel=1e-12, abs=10 * error + 1e-12)


@settings(max_examples=25)
@given(st.floats(-180, 180), st.sampled_from(["open", "crossed"]))
def test_forward(theta: float, branch: str) -> None:
    inputs = {"thetaAO": theta, "branch": branch}
    for angle in (-30.0, -31.0, -32.0):
        solver.solve(TAUGHT, {**inputs, "thetaAO": angle})
    same(solver.solve(TAUGHT, inputs), solver.solve(load("offset_slider_crank"), inputs))


@settings(max_examples=25)
@given(st.floats(4.5, 11.5))
def test_backward(xB: float) -> None:
    for place in (9.0, 9.1, 9.2):
        solver.solve(TAUGHT, {"thetaAO": None, "xB": place})
    inputs = {"thetaAO": None, "xB": xB}
    same(solver.solve(TAUGHT, inputs), solver.solve(load("offset_slider_crank"), inputs))


def test_what_is_asked_for_and_guessed_makes_another_pattern() -> None:
    model = load("offset_slider_crank")
    backward = {"thetaAO": None, "xB": 9.79}
    for _ in range(4):
        first = solver.solve(model, backward, want=["thetaAO"])
        other = solver.solve(model, backward, want=["thetaAO"], guesses={"thetaAO": 50.0})
    to_slider = math.hypot(9.79, 2.0)  # the triangle of the shaft, the pin A and the slider, sides 3 and 8
    middle = math.degrees(math.atan2(2.0, 9.79))
    apart = math.degrees(math.acos((3.0**2 + to_slider**2 - 8.0**2) / (2.0 * 3.0 * to_slider)))
    assert first["thetaAO"] == pytest.approx(middle - apart, rel=1e-12)
    assert other["thetaAO"] == pytest.approx(middle + apart, rel=1e-12)
    assert "vB" not in first.solutions[0]


def test_error_bars_and_sensitivities_come_when_they_are_asked_for() -> None:
    model, fresh = load("offset_slider_crank"), load("offset_slider_crank")
    for theta in (-30.0, -31.0, -32.0, -33.0):
        repeated = solver.solve(model, {"thetaAO": theta})
    once = solver.solve(fresh, {"thetaAO": -33.0})
    assert repeated.solutions[0].error == pytest.approx(once.solutions[0].error, rel=0.5)
    slopes = repeated.sensitivity(["xB"], ["thetaAO"])["xB", "thetaAO"]
    assert slopes == pytest.approx(once.sensitivity(["xB"], ["thetaAO"])["xB", "thetaAO"], rel=1e-12)


@pytest.mark.parametrize("pitch", [25.0, 26.3, 31.0])
def test_one_way_out_of_a_block_needs_no_order(pitch: float) -> None:
    """A pattern whose block has a single answer, among which nothing is to be ordered, is compiled too."""
    taught, backward = load("planetary_gear"), {"ns": None, "pl": None, "sl": 1.28}
    for number in (20.0, 22.0, pitch):
        same(
            solver.solve(taught, {**backward, "np": number}),
            solver.solve(load("planetary_gear"), {**backward, "np": number}),
        )
