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
def test_the_speed_at_dead_centre(
    place: dict[str, float | None], branch: str, inward: float
) -> None:
    """aB = -AO ω² (1 ± AO/AB), by the series of the slider's place at dead centre."""
    speed = 11.0
    inputs = {**REST, **place, "branch": branch, "aB": -AO * speed**2 * inward}
    result = solver.solve(MODEL, inputs)
    assert result.status is solver.Status.SINGULAR
    assert sorted(s["omegaAO"] for s in result.solutions) == pytest.approx(
        [-speed, speed], rel=1e-14
    )
    assert set(result.undetermined) == {"alphaAO", "alphaAB"}
    assert [d.code for d in result.diagnoses if "alphaAO" in d.variables] == ["S540"]


def test_what_is_asked_for_is_solved_if_it_is_determined() -> None:
    result = solver.solve(
        MODEL, {**REST, "thetaAO": 0.0, "aB": -500.0}, want=["omegaAO", "omegaAB"]
    )
    assert result.status is solver.Status.SOLVED
    speed = math.sqrt(500 / (AO * (1 + AO / AB)))
    assert sorted(s["omegaAO"] for s in result.solutions) == pytest.approx(
        [-speed, speed], rel=1e-14
    )
    assert all(
        s["omegaAB"] == pytest.approx(-s["omegaAO"] * AO / AB, rel=1e-14) for s in result.solutions
    )


@pytest.mark.parametrize("motion", [{"vB": 1.0, "aB": -500.0}, {"aB": 500.0}])
def test_what_no_crank_can_do(motion: dict[str, float]) -> None:
    """A slider that moves at dead centre, or is drawn outward there."""
    assert (
        solver.solve(MODEL, {**REST, "thetaAO": 0.0, **motion}).status is solver.Status.INFEASIBLE
    )


def test_without_the_acceleration_the_speed_is_free() -> None:
    result = solver.solve(MODEL, {**REST, "thetaAO": 0.0, "aB": None})
    assert result.status is solver.Status.SINGULAR
    assert {"omegaAO", "alphaAO"} <= set(result.undetermined)


def test_a_factor_that_vanishes_in_a_small_sheet() -> None:
    """x is not told by the first rule; the third does, once the second has lost z."""
    result = solver.solve(
        rulesheets.loads("k = 0\n0 = k*x\nx^2 = y + k*z\ny = 4\nz*w = 1"), want=["x"]
    )
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


TRIANGLE = rulesheets.loads(
    "c^2 = a^2 + b^2 - 2*a*b*cosd(C)\na/sind(A) = c/sind(C)\nb/sind(B) = c/sind(C)\nA + B + C = "
    "180\n"
    "area = a*b*sind(C)/2"
)


@pytest.mark.parametrize("given", ["bAS", "acS", "CcS", "bBS"])
def test_a_rule_that_follows_from_others_takes_no_place_from_one_that_is_needed(given: str) -> None:
    """The sides 7 and 9 with 50° between them: the law of cosines follows from that of sines, the
    area from neither."""
    a, b, turn = 7.0, 9.0, math.radians(50)
    c = math.sqrt(a**2 + b**2 - 2 * a * b * math.cos(turn))
    triangle = {"a": a, "b": b, "c": c, "C": 50.0, "S": a * b * math.sin(turn) / 2}
    triangle["A"] = math.degrees(math.asin(a * math.sin(turn) / c))
    triangle["B"] = 130 - triangle["A"]
    inputs = {"area" if name == "S" else name: triangle[name] for name in given}
    result = solver.solve(TRIANGLE, inputs)
    assert result.status is solver.Status.SOLVED
    assert [result[name] for name in "abcABC"] == pytest.approx(
        [triangle[n] for n in "abcABC"], rel=1e-9
    )


def test_answers_of_the_other_rules_that_break_one_are_left_out() -> None:
    """Freudenstein's equation repeats the loop of a four-bar linkage in part: beside
    ``b*sind(th3)`` it has answers with th3 in the wrong quadrant."""
    model = rulesheets.loads(
        "b*sind(th3) = c*sind(th4) - a*sind(th2)\nb*cosd(th3) = d + c*cosd(th4) - a*cosd(th2)\n"
        "d/a*cosd(th4) - d/c*cosd(th2) + (a^2 - b^2 + c^2 + d^2)/(2*a*c) = cosd(th2 - th4)\n"
        "w4*c*sind(th4 - th3) = a*sind(th2 - th3)"
    )
    sides = {"a": 40.0, "b": 110.0, "c": 80.0, "d": 100.0}
    x, y = (
        100 - 40 * math.cos(math.radians(50)),
        40 * math.sin(math.radians(50)),
    )  # from crank to pivot
    far = math.hypot(x, y)
    at_pivot = math.acos((far**2 + 80**2 - 110**2) / (2 * far * 80))
    th4 = math.pi - math.atan2(y, x) - at_pivot
    th3 = math.atan2(80 * math.sin(th4) - y, x + 80 * math.cos(th4))
    ratio = 40 * math.sin(math.radians(50) - th3) / (80 * math.sin(th4 - th3))
    result = solver.solve(model, {**sides, "w4": ratio})
    assert result.status is solver.Status.SOLVED
    found = [[s["th2"], s["th3"], s["th4"]] for s in result.solutions]
    expected = [50.0, math.degrees(th3), math.degrees(th4)]
    assert any(angles == pytest.approx(expected, rel=1e-9) for angles in found)
    for angles in found:
        crank, link, rocker = (math.cos(math.radians(angle)) for angle in angles)
        assert 110 * link == pytest.approx(100 + 80 * rocker - 40 * crank, abs=1e-9)


TRUSS = """
theta = atan2d(h, a)
RA + RB = P
RB*2*a = P*a + H*h
RA + N1*sind(theta) = 0
-H + N1*cosd(theta) + N2 = 0
H - N1*cosd(theta) + N4*cosd(theta) = 0
-N1*sind(theta) - N4*sind(theta) - N5 = 0
N5 = P
smax = max(abs(N1), abs(N2))
"""
"""The rules of the joints of a truss repeat those of the whole, at the exact angle."""


def test_loads_of_a_truss_that_its_redundant_rules_leave_free() -> None:
    """The point where the load is 0 but for rounding contradicts no rule."""
    result = solver.solve(rulesheets.loads(TRUSS), {"H": 5.0, "h": 2.0, "a": 3.0})
    assert result.status is solver.Status.PARTIAL
    assert {"P", "N1", "RA"} <= set(result.undetermined)


def test_redundant_rules_of_a_truss_leave_the_others_in_force() -> None:
    given = {"H": 5.0, "h": 2.0, "a": 3.0, "smax": 17.5}
    result = solver.solve(rulesheets.loads(TRUSS), given)
    # N2 = 17.5, or N1 = 17.5 as a bar in tension: P = 10/3 - 35 sin(theta)
    assert result.status is solver.Status.SOLVED
    assert sorted(s["P"] for s in result.solutions) == pytest.approx(
        [10 / 3 - 70 / 13**0.5, 20.0], rel=1e-12
    )
