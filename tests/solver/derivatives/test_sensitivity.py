"""Sensitivities: against 50-digit differences on every shipped model, and where there are none."""

from __future__ import annotations

import math
import random
from pathlib import Path

import mpmath
import pytest

import rulesheets
import solver
from benchmarks.sensitivities import compared, states
from rulesheets.diagnosis import RuleSheetError
from rulesheets.variables import read_variable_sheet
from tests.oracles.differences import Differences

MODELS = Path(__file__).parents[3] / "models"
SHEETS = sorted(MODELS.glob("*/model.tk"))
DRIVEN = sorted({p.parent: p for p in MODELS.glob("*/*.csv") if p.stem != "crank_driven"}.values())


def solved(path: Path) -> solver.Result:
    model = rulesheets.load(path.parent / "model.tk")
    if path.suffix == ".tk":
        return solver.solve(model)
    given = read_variable_sheet(path, model)
    return solver.solve(model, given.inputs, guesses=given.guesses)


def assert_right(result: solver.Result, inputs: tuple[str, ...]) -> None:
    found = result.sensitivity(inputs=inputs)
    oracle = Differences(result.model, result.solutions[0], result.inputs)
    for given in inputs:
        right = oracle.by(given)
        for output in found.outputs:
            assert found[output, given] == pytest.approx(
                right.get(output, 0.0), rel=1e-10, abs=1e-20
            ), output
    assert found.diagnoses == ()


@pytest.mark.parametrize("path", SHEETS, ids=lambda path: path.parent.name)
def test_every_derivative_of_a_shipped_sheet_agrees_with_differences_at_50_digits(
    path: Path,
) -> None:
    result = solved(path)
    assert_right(result, result.sensitivity([]).inputs)


@pytest.mark.parametrize("path", DRIVEN, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_derivatives_of_answers_found_backwards_agree_too(path: Path) -> None:
    result = solved(path)
    inputs = result.sensitivity([]).inputs
    assert_right(result, inputs[-1:])


@pytest.mark.parametrize("name", ["planetary_gear", "rachford_rice", "triangle", "two_circles"])
def test_random_states_and_other_inputs_agree_too(name: str) -> None:
    draw = random.Random(name)
    for result in states(name, 1):
        for one in compared(result, draw, most=1):
            assert one.difference is not None and one.difference <= 1e-10, one


def test_every_answer_has_its_own_sensitivities() -> None:
    result = solver.solve(rulesheets.loads("x^2 = a"), {"a": 9.0})
    slopes = {result.solutions[k]["x"]: result.sensitivity(answer=k)["x", "a"] for k in range(2)}
    assert slopes == {3.0: 1 / 6, -3.0: -1 / 6}


@pytest.mark.parametrize("distance", [1e-3, 1e-6, 1e-9])
def test_near_dead_centre_the_digits_are_right(distance: float) -> None:
    """A crank in line, driven by its slider: cosd(theta) = (AO² + x² − AB²)/(2 AO x)."""
    model = rulesheets.loads(
        "AB^2 = AO^2 + x^2 - 2*AO*x*cosd(theta)\nvariables\ntheta in [0, 180]\nAO=3\nAB=8\nx"
    )
    x = 11.0 * (1.0 - distance)
    found = solver.solve(model, {"x": x}).sensitivity(["theta"], ["x"])
    with mpmath.workdps(60):
        exact = mpmath.diff(
            lambda s: mpmath.degrees(mpmath.acos((mpmath.mpf(9) + s * s - 64) / (6 * s))),
            mpmath.mpf(x),
        )
    assert found["theta", "x"] == pytest.approx(float(exact), rel=1e-12)


@pytest.mark.parametrize("distance", [1e-6, 1e-14])
def test_the_slider_crank_near_the_end_of_its_stroke(distance: float) -> None:
    """In line with the shaft cosd(thetaAO) = (AO² + xB² − AB²)/(2 AO xB), for both answers."""
    x = 11.0 * (1.0 - distance)
    model = rulesheets.load("offset_slider_crank_slope_free")
    result = solver.solve(model, {"thetaAO": None, "xB": x, "offset": 0.0}, ["thetaAO"])
    assert len(result.solutions) == 2
    with mpmath.workdps(60):
        far = mpmath.mpf(x)
        cosine = (9 + far**2 - 64) / (6 * far)
        exact = -mpmath.degrees((1 + 55 / far**2) / 6 / mpmath.sqrt(1 - cosine**2))
    for answer, solution in enumerate(result.solutions):
        found = result.sensitivity(["thetaAO"], ["xB"], answer)["thetaAO", "xB"]
        assert found == pytest.approx(
            math.copysign(1.0, solution["thetaAO"]) * float(exact), rel=1e-14
        )


# --- where there is no derivative -----------------------------------------------------


def reasons(found: object) -> str:
    return " / ".join(diagnosis.message for diagnosis in found.diagnoses)  # type: ignore[attr-defined]


def test_at_a_double_root_there_is_none_and_what_follows_from_it_has_none() -> None:
    result = solver.solve(rulesheets.loads("x^2 = a\ny = x^2\nz = 2*a"), {"a": 0.0})
    found = result.sensitivity(["x", "y", "z"])
    assert (found["x", "a"], found["y", "a"], found["z", "a"]) == (None, None, 2.0)
    assert "x and y by a does not exist: the answer is singular" in reasons(found)


def test_inputs_that_repeat_one_another_are_tied() -> None:
    result = solver.solve(rulesheets.loads("V = I*R\nP = V*I"), {"V": 12.0, "I": 2.0, "R": 6.0})
    found = result.sensitivity(["P"])
    assert set(found.values()) == {None}
    assert "would break this rule" in reasons(found)


def test_a_corner_has_no_derivative_and_its_two_slopes_are_told() -> None:
    model = rulesheets.loads("if x >= 0 then y = 3*x else y = -x\nz = x + 1")
    found = solver.solve(model, {"x": 0.0}).sensitivity(["y", "z"])
    assert (found["y", "x"], found["z", "x"]) == (None, 1.0)
    assert "the rules change at x = 0" in reasons(found)
    assert found.diagnoses[0].notes == ("it is 3 upwards and -1 downwards",)


def test_an_edge_where_the_rules_agree_to_first_order_has_a_derivative() -> None:
    model = rulesheets.loads("if x >= 0 then y = x^2 + x else y = sind(x)*180/pi()")
    assert solver.solve(model, {"x": 0.0}).sensitivity(["y"])["y", "x"] == pytest.approx(
        1.0, rel=1e-15
    )


def test_a_rule_that_holds_at_a_point_only_says_nothing_of_slopes() -> None:
    model = rulesheets.loads("if x = 1 then y = 2 else y = 2*x")
    assert solver.solve(model, {"x": 1.0}).sensitivity(["y"])["y", "x"] == 2.0


def test_an_edge_that_an_input_does_not_move_is_none_for_it() -> None:
    model = rulesheets.loads("if k = 0 then y = 5*x else y = 7*x + k")
    found = solver.solve(model, {"k": 0.0, "x": 1.0}).sensitivity(["y"])
    assert found["y", "x"] == 5.0
    assert found["y", "k"] is None


@pytest.mark.parametrize(("theta", "offset"), [(90.0, 2.0), (0.0, 0.0)])
def test_where_rules_have_no_slope_or_are_exchanged_the_limit_is_told(
    theta: float, offset: float
) -> None:
    """Link AB at rest, and horizontal: the printed rules there against those that need no slope of
    AB."""
    given, names = (
        {"thetaAO": theta, "offset": offset},
        (["vB", "omegaAB", "aB", "alphaAB"], ["thetaAO", "offset"]),
    )
    printed = solver.solve(rulesheets.load("offset_slider_crank"), given).sensitivity(*names)
    plain = solver.solve(rulesheets.load("offset_slider_crank_slope_free"), given).sensitivity(
        *names
    )
    assert printed.diagnoses == plain.diagnoses == ()
    for pair, slope in plain.items():
        assert printed[pair] == pytest.approx(slope, rel=1e-12, abs=1e-15), pair


def test_a_corner_of_a_function_is_told_with_its_slopes() -> None:
    found = solver.solve(rulesheets.loads("y = 3*abs(x) + x"), {"x": 0.0}).sensitivity(["y"])
    assert found["y", "x"] is None
    assert "y by x does not exist: it has a corner" in reasons(found)
    assert found.diagnoses[0].notes == ("it is 4 upwards and -2 downwards",)


@pytest.mark.parametrize(
    ("rule", "x", "slope"),
    [
        ("y = max(x, 2*x - 1, 5*x - 4)", 1.0, None),
        ("y = max(2*x, x^2 + 1)", 1.0, 2.0),
        ("y = int(x)", 2.0, None),
        ("y = int(x)", 2.5, 0.0),
        ("y = round(x)", 2.5, None),
        ("y = mod(x, 3)", 6.0, None),
        ("y = step(x, 1) + 2*x", 1.0, None),
        ("y = abs(x - 1)*(x - 1)", 1.0, 0.0),
        ("y = abs(k)*x + 3*x", 1.0, 3.0),
    ],
)
def test_corners_and_jumps_of_functions(rule: str, x: float, slope: float | None) -> None:
    found = solver.solve(rulesheets.loads(rule), {"x": x, **({"k": 0.0} if "k" in rule else {})})
    assert found.sensitivity(["y"], ["x"])["y", "x"] == slope


def test_a_jump_has_no_derivative_though_its_slopes_agree() -> None:
    found = solver.solve(
        rulesheets.loads("if x >= 1 then y = x + 1 else y = x"), {"x": 1.0}
    ).sensitivity(["y"])
    assert found["y", "x"] is None


def test_a_rule_without_a_slope_is_blamed() -> None:
    found = solver.solve(rulesheets.loads("y = sqrt(x)\nz = y + 1"), {"x": 0.0}).sensitivity(
        ["y", "z"]
    )
    assert set(found.values()) == {None}
    assert "this rule has no slope at these values" in reasons(found)


# --- what is asked, and units ---------------------------------------------------------


def test_names_are_checked_and_units_composed() -> None:
    result = solver.solve(rulesheets.load("offset_slider_crank"))
    found = result.sensitivity(["omegaAB", "xB"], ["thetaAO", "alphaAO"])
    assert list(found) == [
        ("omegaAB", "thetaAO"),
        ("omegaAB", "alphaAO"),
        ("xB", "thetaAO"),
        ("xB", "alphaAO"),
    ]
    assert found.unit("omegaAB", "thetaAO") == "rad/s/deg"
    assert found.unit("xB", "alphaAO") == "1/(rad/s^2)"
    assert found.unit("xB", "AO") == ""
    with pytest.raises(KeyError):
        found["vB", "thetaAO"]
    for outputs, inputs, code in (
        (["nope"], None, "E407"),
        (None, ["vB"], "E425"),
        (None, ["branch"], "E425"),
    ):
        with pytest.raises(RuleSheetError) as wrong:
            result.sensitivity(outputs, inputs)
        assert wrong.value.diagnoses[0].code == code


def test_an_output_without_a_number_says_so() -> None:
    found = solver.solve(rulesheets.loads("y = x\nz = u + x"), {"x": 1.0}).sensitivity(["z"])
    assert found["z", "x"] is None
    assert "z has no number here" in reasons(found)


def test_the_command_prints_the_table_and_the_object(capsys: pytest.CaptureFixture[str]) -> None:
    import json

    from solver.__main__ import main

    assert main(["solve", "offset_slider_crank", "--json", "--sensitivity", "vB,omegaAO"]) == 0
    members = json.loads(capsys.readouterr().out)["sensitivities"]
    (one,) = members
    answer = solver.solve(rulesheets.load("offset_slider_crank"))["vB"]
    assert one["value"] == pytest.approx(
        answer / -15.0, rel=1e-12
    )  # velocities are proportional to omegaAO
    assert (one["output"], one["input"], one["unit"]) == ("vB", "omegaAO", "1/(rad/s)")
