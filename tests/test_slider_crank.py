"""The paper's sheet, forward and slider-driven, against the closed form at 50 digits."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import rulesheets
import solver
from rulesheets.variables import read_variable_sheet
from tests.oracles import slider_crank as oracle
from tests.oracles.slider_crank import Crank
from tests.sampling import sampled

MODELS = Path(__file__).parent.parent / "models"
AS_PRINTED, SLOPE_FREE = "offset_slider_crank", "offset_slider_crank_slope_free"
FIGURE_4 = {"xB": "9.79", "vB": "-41.46", "omegaAB": "5.42", "aB": "-709.1", "alphaAB": "-29.03"}
PAPER = Crank(3.0, 8.0, 2.0, -15.0, -10.0, -30.0)
SLOPES = {"m1", "m2"}
EPS = 2.0**-52


@cache
def model(name: str) -> Any:
    return rulesheets.load(MODELS / name / "model.tk")


@cache
def full_names(name: str) -> dict[str, str]:
    """Bare name of each quantity of the closed form -> its full name in the model, where it has
    it."""
    known = model(name).variables
    found = {bare: bare for bare in (*oracle.SHARED, "yA", "yB") if bare in known}
    for scope, names in oracle.LOCALS.items():
        found |= {bare: f"{scope}.{bare}" for bare in names if f"{scope}.{bare}" in known}
    return found


@cache
def prepared(name: str, is_open: bool, slopes: bool) -> Any:
    want = [full for bare, full in full_names(name).items() if slopes or bare not in SLOPES]
    given = {"branch": "open" if is_open else 0.0}
    return solver.prepare(model(name), inputs=list(PAPER.inputs), want=want, given=given)


def solved(name: str, crank: Crank, slopes: bool) -> dict[str, float]:
    """What the prepared plan makes of the crank, by bare names."""
    names = [bare for bare in full_names(name) if slopes or bare not in SLOPES]
    answer = prepared(name, crank.open, slopes)(*crank.inputs.values())
    return dict(zip(names, answer, strict=True))


def allowed(exact: Any, sensitivity: float) -> float:
    """1e-12 relative, and what a few roundings of the inputs explain."""
    return 1e-12 * abs(float(exact)) + 8 * EPS * sensitivity


def assert_agrees(name: str, crank: Crank) -> None:
    """Every named quantity of the three subsheets agrees with the closed form."""
    exact, sensitivity = oracle.forward(crank), oracle.sensitivity(crank)
    for bare, value in solved(name, crank, slopes="m2" in exact).items():
        error = float(abs(value - exact[bare]))
        assert error <= allowed(exact[bare], sensitivity[bare]), (bare, value, exact[bare], crank)


def feasible(crank: Crank) -> bool:
    return abs(oracle.rise(crank)) < crank.AB


def linkages(count: int, seed: int) -> Iterator[Crank]:
    """Random linkages at half degrees, feasible or not."""
    draw = random.Random(seed)
    for _ in range(count):
        lengths = draw.uniform(0.5, 5.0), draw.uniform(0.5, 10.0), draw.uniform(-4.0, 4.0)
        rates = draw.uniform(-20.0, 20.0), draw.uniform(-20.0, 20.0)
        yield Crank(*lengths, *rates, draw.randrange(721) / 2)


def with_angle(crank: Crank, thetaAO: float, is_open: bool) -> Crank:
    return Crank(crank.AO, crank.AB, crank.offset, crank.omegaAO, crank.alphaAO, thetaAO, is_open)


# --- forward ---------------------------------------------------------------------


@pytest.mark.parametrize("name", [AS_PRINTED, SLOPE_FREE])
def test_figure_4(name: str) -> None:
    result = solver.solve(model(name))
    assert str(result.status) == "solved"
    for quantity, printed in FIGURE_4.items():
        assert round(result[quantity], len(printed.split(".")[1])) == float(printed)


@pytest.mark.parametrize("branch", [0.0, 1.0, "crossed"])
def test_anything_but_open_runs_the_crossed_branch(branch: float | str) -> None:
    exact = oracle.forward(with_angle(PAPER, -30.0, False))
    result = solver.solve(model(AS_PRINTED), {"branch": branch})
    assert str(result.status) == "solved"
    for quantity in FIGURE_4:
        assert result[quantity] == pytest.approx(float(exact[quantity]), rel=1e-13)


@pytest.mark.parametrize("is_open", [True, False])
@pytest.mark.parametrize("name", [AS_PRINTED, SLOPE_FREE])
@pytest.mark.parametrize("step", [2.5, pytest.param(0.5, marks=pytest.mark.slow)])
def test_full_turn_of_the_papers_linkage(name: str, is_open: bool, step: float) -> None:
    for k in range(round(360 / step) + 1):
        assert_agrees(name, with_angle(PAPER, k * step, is_open))


@pytest.mark.parametrize("is_open", [True, False])
@pytest.mark.parametrize("name", [AS_PRINTED, SLOPE_FREE])
@pytest.mark.parametrize("angles", [1, pytest.param(20, marks=pytest.mark.slow)])
def test_random_linkages(name: str, is_open: bool, angles: int) -> None:
    """200 linkages, each at so many random half degrees."""
    draw = random.Random(name)
    for linkage in linkages(200, seed=7):
        for _ in range(angles):
            crank = with_angle(linkage, draw.randrange(721) / 2, is_open)
            if feasible(crank):
                assert_agrees(name, crank)


@pytest.mark.parametrize("name", [AS_PRINTED, SLOPE_FREE])
def test_positions_that_do_not_close_are_infeasible(name: str) -> None:
    apart = [crank for crank in linkages(60, seed=11) if abs(oracle.rise(crank)) > crank.AB][:12]
    assert len(apart) == 12
    for crank in apart:
        result = solver.solve(model(name), crank.inputs)
        assert str(result.status) == "infeasible", crank
        assert not result.solutions


HORIZONTAL = [
    Crank(3.0, 8.0, 0.0, -15.0, -10.0, 0.0, False),
    Crank(3.0, 8.0, 0.0, -15.0, -10.0, 0.0, True),
    Crank(3.0, 8.0, 0.0, -15.0, -10.0, 180.0, True),
    Crank(3.0, 8.0, 0.0, -15.0, -10.0, 360.0, False),
    Crank(1.0, 4.0, 1.0, -15.0, -10.0, 90.0, False),
    Crank(1.0, 4.0, 1.0, -15.0, -10.0, 90.0, True),
    Crank(3.0, 8.0, 1.5, -15.0, -10.0, 30.0, True),
    Crank(3.0, 8.0, -1.5, -15.0, -10.0, 210.0, False),
]


@pytest.mark.parametrize("name", [AS_PRINTED, SLOPE_FREE])
@pytest.mark.parametrize("crank", HORIZONTAL)
def test_horizontal_rod(name: str, crank: Crank) -> None:
    assert_agrees(name, crank)
    result = solver.solve(model(name), {**crank.inputs, "branch": "open" if crank.open else 0.0})
    assert str(result.status) == "solved"
    if name == AS_PRINTED:
        assert result["m2"] is None


@pytest.mark.parametrize("exponent", range(3, 16, 2))
def test_nearly_horizontal_rod(exponent: int) -> None:
    """The slope m2 grows without bound there, and nothing that is wanted may lose digits by it."""
    crank = Crank(3.0, 8.0, 0.0, -15.0, -10.0, 10.0**-exponent)
    for is_open in (True, False):
        turned = with_angle(crank, 180.0 - 10.0**-exponent, is_open)
        exact, sensitivity = oracle.forward(turned), oracle.sensitivity(turned)
        result = solver.solve(
            model(AS_PRINTED), {**turned.inputs, "branch": "open" if is_open else 0.0}
        )
        assert str(result.status) == "solved"
        for quantity in FIGURE_4:
            error = float(abs(result[quantity] - exact[quantity]))
            assert error <= allowed(exact[quantity], sensitivity[quantity]), quantity


@pytest.mark.parametrize("name", [AS_PRINTED, SLOPE_FREE])
@pytest.mark.parametrize("inputs", [{"AO": 2.0, "AB": 4.0, "offset": 5.0, "thetaAO": 30.0}])
def test_vertical_rod_is_never_solved(name: str, inputs: dict[str, float]) -> None:
    """The slider has its position, and no finite velocity."""
    result = solver.solve(model(name), inputs)
    assert str(result.status) in {"singular", "infeasible"}
    assert not result.solutions
    assert result["xB"] == pytest.approx(2.0 * math.cos(math.radians(30.0)), rel=1e-15)


# --- the slider drives -----------------------------------------------------------


def angles(result: Any) -> list[float]:
    return sorted(solution["thetaAO"] for solution in result.solutions)


@pytest.mark.parametrize("name", [AS_PRINTED, SLOPE_FREE])
def test_slider_gives_both_crank_angles(name: str) -> None:
    result = solver.solve(model(name), {"xB": 9.791823496, "thetaAO": None}, want=["thetaAO"])
    assert str(result.status) == "solved"
    assert result.complete
    exact = oracle.crank_angles(3.0, 8.0, 2.0, 9.791823496)
    assert angles(result) == pytest.approx([float(angle) for angle in exact], rel=1e-12)


def assert_slider_drives(name: str, crank: Crank, xB: float, vB: float, aB: float) -> None:
    """Every answer of the slider-driven sheet is one of the closed form, and none is missing."""
    cleared = {"thetaAO": None, "omegaAO": None, "alphaAO": None}
    given = {**crank.inputs, **cleared, "xB": xB, "vB": vB, "aB": aB}
    result = solver.solve(model(name), {**given, "branch": "open" if crank.open else 0.0})
    exact = [
        (theta, *oracle.crank_rates(crank.AO, crank.offset, xB, theta, vB, aB))
        for theta in oracle.crank_angles(crank.AO, crank.AB, crank.offset, xB)
        if oracle.is_open(crank.AO, xB, theta) == crank.open
    ]
    assert str(result.status) == ("solved" if exact else "infeasible")
    found = sorted((s["thetaAO"], s["omegaAO"], s["alphaAO"]) for s in result.solutions)
    assert len(found) == len(exact)
    for answer, reference in zip(found, exact, strict=True):
        assert answer == pytest.approx([float(number) for number in reference], rel=1e-9, abs=1e-9)
        assert_runs_forward_again(name, crank, answer, (xB, vB, aB))


def assert_runs_forward_again(
    name: str, crank: Crank, answer: tuple[float, ...], given: tuple[float, ...]
) -> None:
    driven = dict(zip(("thetaAO", "omegaAO", "alphaAO"), answer, strict=True))
    branch = "open" if crank.open else 0.0
    result = solver.solve(model(name), {**crank.inputs, **driven, "branch": branch})
    assert [result[key] for key in ("xB", "vB", "aB")] == pytest.approx(given, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("name", [AS_PRINTED, SLOPE_FREE])
def test_slider_drives_the_papers_linkage(name: str) -> None:
    assert_slider_drives(name, PAPER, 9.791823496, -41.460771861, -709.098870834)


@pytest.mark.parametrize("is_open", [True, False])
@pytest.mark.parametrize("name", [AS_PRINTED, SLOPE_FREE])
def test_slider_drives_random_linkages(name: str, is_open: bool) -> None:
    """At random states, away from dead centre, where the angle is ill-conditioned by nature."""
    tried = 0
    for linkage in linkages(40, seed=5):
        crank = with_angle(linkage, linkage.thetaAO, is_open)
        if not abs(oracle.rise(crank)) < 0.95 * crank.AB:
            continue
        state = {key: float(value) for key, value in oracle.forward(crank).items()}
        gain = state["vB"] / crank.omegaAO
        if abs(gain) < 0.05 * crank.AO:
            continue
        tried += 1
        assert_slider_drives(name, crank, state["xB"], state["vB"], state["aB"])
    assert tried > 10


@pytest.mark.parametrize("name", [AS_PRINTED, SLOPE_FREE])
@pytest.mark.parametrize("xB", [11.0, -11.0, 4.0])
def test_slider_out_of_reach_is_infeasible(name: str, xB: float) -> None:
    assert not oracle.crank_angles(3.0, 8.0, 2.0, xB)
    result = solver.solve(model(name), {"xB": xB, "thetaAO": None})
    assert str(result.status) == "infeasible"


@pytest.mark.parametrize("vB", [0.0, 5.0])
@pytest.mark.parametrize("name", [AS_PRINTED, SLOPE_FREE])
def test_slider_at_dead_centre_leaves_the_crank_free(name: str, vB: float) -> None:
    """Crank and rod in line: the slider can only stand still, and the crank may turn anyhow."""
    inputs = {"AB": 5.0, "offset": 0.0, "xB": 8.0, "vB": vB, "aB": -1.0}
    cleared = {"thetaAO": None, "omegaAO": None, "alphaAO": None}
    result = solver.solve(model(name), {**inputs, **cleared})
    assert str(result.status) in ({"singular"} if vB == 0.0 else {"infeasible", "inconsistent"})


# --- the rod or the acceleration drives ------------------------------------------

SCANNED = {
    "thetaAO": np.linspace(-180.0, 180.0, 7_201) + 1e-7,
    "AO": np.linspace(-40.0, 40.0, 8_001) + 1e-7,
    "AB": np.linspace(0.0, 40.0, 8_001) + 1e-7,
    "offset": np.linspace(-30.0, 30.0, 6_001) + 1e-7,
}


@pytest.mark.parametrize(
    ("quantity", "wanted", "share"),
    sampled([*product(("omegaAB", "alphaAB", "aB"), SCANNED, (1.0, 0.6))], 3),
)
def test_all_positions_with_a_given_motion(quantity: str, wanted: str, share: float) -> None:
    """Whatever is asked for, the answers are those of the closed form: none at a case of the sheet
    where other rules contradict the given number."""
    value = share * float(oracle.forward(PAPER)[quantity])
    exact = oracle.driven_by(quantity, value, PAPER, wanted, SCANNED[wanted])
    for want in ([wanted], None):
        result = solver.solve(model(AS_PRINTED), {quantity: value, wanted: None}, want=want)
        found = sorted(solution[wanted] for solution in result.solutions)
        assert str(result.status) == ("solved" if found else "infeasible")
        # the acceleration has poles at the longest cranks that fit
        assert result.complete or (quantity, wanted) == ("aB", "AO")
        found = [number for number in found if wanted != "AB" or number > 0.0]
        assert found == pytest.approx(sorted(exact), rel=1e-7)


# --- the variable sheets -----------------------------------------------------------


@pytest.mark.parametrize("name", [AS_PRINTED, SLOPE_FREE])
def test_variable_sheet_of_the_crank(name: str) -> None:
    sheet = read_variable_sheet(MODELS / name / "crank_driven.csv", model(name))
    result = solver.solve(model(name), sheet.inputs, guesses=sheet.guesses)
    assert str(result.status) == "solved"
    assert round(result["vB"], 2) == float(FIGURE_4["vB"])


@pytest.mark.parametrize("name", [AS_PRINTED, SLOPE_FREE])
def test_variable_sheet_of_the_slider(name: str) -> None:
    """Fig. 4's rounded answers given back: one of the two positions is near the crank angle of
    -30°."""
    sheet = read_variable_sheet(MODELS / name / "slider_driven.csv", model(name))
    result = solver.solve(model(name), sheet.inputs, guesses=sheet.guesses)
    assert str(result.status) == "solved"
    exact = oracle.crank_angles(3.0, 8.0, 2.0, 9.79)
    assert angles(result) == pytest.approx([float(angle) for angle in exact], rel=1e-11)
    rates = oracle.crank_rates(3.0, 2.0, 9.79, exact[0], -41.46, -709.1)
    found = min(result.solutions, key=lambda solution: solution["thetaAO"])
    assert (found["omegaAO"], found["alphaAO"]) == pytest.approx(
        [float(rate) for rate in rates], rel=1e-9
    )
    assert found["omegaAO"] == pytest.approx(PAPER.omegaAO, rel=2e-3)


@pytest.mark.parametrize("name", [AS_PRINTED, SLOPE_FREE])
def test_variable_sheet_of_the_rod(name: str) -> None:
    """Both positions, put back through the crank, give the rod the motion that it was given."""
    sheet = read_variable_sheet(MODELS / name / "rod_driven.csv", model(name))
    result = solver.solve(model(name), sheet.inputs)
    assert (str(result.status), result.complete) == ("solved", True)
    rise = 2.0 + 8.0 * float(oracle.sind(-154.0))
    first = math.degrees(math.asin(rise / 3.0))
    assert sorted(angles(result)) == pytest.approx([-180.0 - first, first], rel=1e-12)
    for solution in result.solutions:
        crank = Crank(
            3.0, 8.0, 2.0, *(solution[f"{rate}AO"] for rate in ("omega", "alpha", "theta"))
        )
        exact = oracle.forward(crank)
        for quantity in ("thetaAB", "omegaAB", "alphaAB"):
            assert sheet.inputs[quantity] == pytest.approx(float(exact[quantity]), rel=1e-10)
