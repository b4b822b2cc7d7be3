"""At a dead centre the slider's acceleration tells the speed of the crank, its velocity nothing."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import rulesheets
import solver

MODEL = rulesheets.load(Path(__file__).parents[3] / "models" / "offset_slider_crank" / "model.tk")
AO, AB = 3.0, 8.0
REST = {"offset": 0.0, "omegaAO": None, "alphaAO": None, "vB": 0.0}


@pytest.mark.parametrize(
    ("place", "branch", "inward"),
    [
        ({"thetaAO": 0.0}, "open", 1 + AO / AB),
        ({"thetaAO": 180.0}, "open", -(1 - AO / AB)),
        ({"thetaAO": 180.0}, "crossed", -(1 + AO / AB)),
    ],
)
def test_the_speed_at_dead_centre(place: dict[str, float | None], branch: str, inward: float) -> None:
    """aB = -AO ω² (1 ± AO/AB), by the series of the slider's place at dead centre."""
    speed = 11.0
    inputs = {**REST, **place, "branch": branch, "aB": -AO * speed**2 * inward}
    result = solver.solve(MODEL, inputs)
    assert result.status is solver.Status.SINGULAR
    assert sorted(s["omegaAO"] for s in result.solutions) == pytest.approx([-speed, speed], rel=1e-14)
    assert set(result.undetermined) == {"alphaAO", "alphaAB"}
    assert [d.code for d in result.diagnoses if "alphaAO" in d.variables] == ["S540"]


def test_what_is_asked_for_is_solved_if_it_is_determined() -> None:
    result = solver.solve(MODEL, {**REST, "thetaAO": 0.0, "aB": -500.0}, want=["omegaAO", "omegaAB"])
    assert result.status is solver.Status.SOLVED
    speed = math.sqrt(500 / (AO * (1 + AO / AB)))
    assert sorted(s["omegaAO"] for s in result.solutions) == pytest.approx([-speed, speed], rel=1e-14)
    assert all(s["omegaAB"] == pytest.approx(-s["omegaAO"] * AO / AB, rel=1e-14) for s in result.solutions)


@pytest.mark.parametrize("motion", [{"vB": 1.0, "aB": -500.0}, {"aB": 500.0}])
def test_what_no_crank_can_do(motion: dict[str, float]) -> None:
    """A slider that moves at dead centre, or is drawn outward there."""
    assert solver.solve(MODEL, {**REST, "thetaAO": 0.0, **motion}).status is solver.Status.INFEASIBLE


def test_without_the_acceleration_the_speed_is_free() -> None:
    result = solver.solve(MODEL, {**REST, "thetaAO": 0.0, "aB": None})
    assert result.status is solver.Status.SINGULAR
    assert {"omegaAO", "alphaAO"} <= set(result.undetermined)


def test_a_factor_that_vanishes_in_a_small_sheet() -> None:
    """x is not told by the first rule; the third does, once the second has lost z."""
    result = solver.solve(rulesheets.loads("k = 0\n0 = k*x\nx^2 = y + k*z\ny = 4\nz*w = 1"), want=["x"])
    assert sorted(s["x"] for s in result.solutions) == [-2.0, 2.0]


@pytest.mark.parametrize(
    ("rules", "answers"),
    [
        ("x + y = 2\nx + k*y = 2\nx*y = 0.75", [(0.5, 1.5), (1.5, 0.5)]),
        ("x + y = 2\nx + k*y = 2\nz = x - y\nz^2 = 1", [(0.5, 1.5), (1.5, 0.5)]),
    ],
)
def test_what_reads_a_block_that_says_the_same_twice_is_solved_with_it(
    rules: str, answers: list[tuple[float, float]]
) -> None:
    model = rulesheets.loads(rules)
    result = solver.solve(model, {"k": 1.0})
    assert result.status is solver.Status.SOLVED
    assert sorted((s["x"], s["y"]) for s in result.solutions) == answers
    plan = solver.prepare(model, ["k"], want=["x", "y"])
    assert sorted(plan.all(1.0)) == answers
    whole = solver.prepare(model, ["k"])
    assert len(whole.all(1.0)) == len(answers)
    with pytest.raises(solver.Unsolved):
        whole(2.0)  # which makes y = 0: nothing of what held at 1 is taken for granted
    assert sorted(plan.all(1.0)) == answers


def test_a_block_that_says_the_same_twice_and_is_read_by_nothing_stays_open() -> None:
    result = solver.solve(rulesheets.loads("x + y = 2\nx + k*y = 2\nz = x - y"), {"k": 1.0})
    assert result.status is solver.Status.PARTIAL
    assert [d.code for d in result.diagnoses] == ["S511"]
