"""The mechanisms of the velocity-diagram unit against complex numbers at 50 digits, from every
driver."""

from __future__ import annotations

from functools import cache
from itertools import pairwise, product
from math import remainder
from pathlib import Path
from typing import Any

import pytest

import rulesheets
import solver
from rulesheets.variables import read_variable_sheet
from tests.oracles.mechanisms import MECHANISMS, Mechanism
from tests.sampling import sampled

MODELS = Path(__file__).parent.parent / "models"
SHEETS = [
    path
    for mechanism in MECHANISMS
    for path in sorted((MODELS / mechanism.model).glob("*_driven.csv"))
    if path.stem != "crank_driven"
]
BY_NAME = {mechanism.model: mechanism for mechanism in MECHANISMS}
ANGLES = [-90.0, 0.0, 90.0, 180.0, *(float(angle) for angle in range(-175, 180, 44))]
"""With the positions that are in line or at right angles."""
EVERY_DEGREE = [float(angle) for angle in range(-179, 181)]
RATES = (7.0, -11.0)
"""Angular velocity and acceleration of the crank."""

ENGINE_ANGLES = {-9.4: (38.922355258782, 120.2876343397), 9.4: (-120.2876343397, -38.92235525878)}
"""Crank angles at which the piston has that velocity: 12 digits, by root finding on the closed
form."""


@cache
def model(name: str) -> Any:
    return rulesheets.load(MODELS / name / "model.tk")


@cache
def prepared(mechanism: Mechanism, mode: int) -> tuple[Any, list[str]]:
    """The plan from the crank, and what it computes."""
    driver = [f"{rate}{mechanism.crank}" for rate in ("theta", "omega", "alpha")]
    known, fixed = model(mechanism.model).variables, mechanism.inputs(mode)
    state = mechanism.state(ANGLES[0], *RATES, mode)
    want = [name for name in state if name in known and name not in (*driver, *fixed)]
    cleared = {n: None for n, v in known.items() if v.value is not None and n not in fixed}
    given = {
        name: value for name, value in cleared.items() if name not in driver
    } | mechanism.choices.get(mode, {})
    return solver.prepare(model(mechanism.model), inputs=driver, want=want, given=given), want


@cache
def answers_at(mechanism: Mechanism, mode: int, theta: float) -> list[dict[str, float]]:
    plan, want = prepared(mechanism, mode)
    return [dict(zip(want, answer, strict=True)) for answer in plan.all(theta, *RATES)]


def kind(name: str) -> str:
    """What a name stands for: capitals are points of the position diagram, small letters
    velocities."""
    for prefix in ("theta", "omega", "alpha"):
        if name.startswith(prefix):
            return prefix
    if name.startswith("a") or name.endswith("1"):
        return "acceleration"
    return (
        "velocity"
        if name.startswith("v") or name[:2] in {"xd", "yd", "xm", "ym", "xw", "yw"}
        else "length"
    )


def agrees(answer: dict[str, float], exact: dict[str, Any], rel: float) -> bool:
    """Within rel of the exact state, or of a hundredth of the largest quantity of the same kind.

    What is 0 in truth is so to 50 digits only, hence the least scale.
    """
    scale: dict[str, float] = {"theta": 180.0}
    for name in {*answer, *(rate for rate in exact if kind(rate) != "length")}:
        scale[kind(name)] = max(scale.get(kind(name), 1e-40), abs(float(exact[name])))
    return all(
        apart(name, value, float(exact[name]))
        <= rel * max(abs(float(exact[name])), 0.01 * scale[kind(name)])
        for name, value in answer.items()
    )


def apart(name: str, value: float, exact: float) -> float:
    """Distance, of angles the shorter way round."""
    return abs(remainder(value - exact, 360.0) if kind(name) == "theta" else value - exact)


@pytest.mark.parametrize("mechanism", MECHANISMS, ids=lambda mechanism: mechanism.model)
@pytest.mark.parametrize(
    "angles",
    [ANGLES, pytest.param(EVERY_DEGREE, marks=pytest.mark.slow)],
    ids=["coarse", "every degree"],
)
def test_full_turn_in_every_mode(mechanism: Mechanism, angles: list[float]) -> None:
    """A mode is an answer of the sheet, or where an input chooses it the only one."""
    for mode, theta in product(mechanism.modes, angles):
        answers = answers_at(mechanism, mode if mechanism.choices else 1, theta)
        assert len(answers) == (1 if mechanism.choices else len(mechanism.modes))
        exact = mechanism.state(theta, *RATES, mode)
        assert any(agrees(answer, exact, 1e-11) for answer in answers), (theta, mode, answers)


@cache
def drive_of(path: Path) -> tuple[Mechanism, Any]:
    name = path.parent.name
    sheet = read_variable_sheet(path, model(name))
    return BY_NAME[name], solver.solve(model(name), sheet.inputs, guesses=sheet.guesses)


@pytest.mark.parametrize("path", SHEETS, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_any_driver_leads_to_states_of_the_crank(path: Path) -> None:
    """Each answer, put back through the crank, is the same state."""
    mechanism, result = drive_of(path)
    assert str(result.status) == "solved"
    for solution in result.solutions:
        crank = [solution[f"{rate}{mechanism.crank}"] for rate in ("theta", "omega", "alpha")]
        states = [mechanism.state(*crank, mode) for mode in mechanism.modes]
        known = {name: value for name, value in solution.items() if name in states[0]}
        assert any(agrees(known, state, 1e-8) for state in states), dict(solution)


@pytest.mark.parametrize("path", SHEETS, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_any_driver_finds_the_shipped_state(path: Path) -> None:
    """One answer is near the crank-driven sheet's state, from which the driver's numbers were
    rounded."""
    _, result = drive_of(path)
    shipped = solver.solve(model(path.parent.name))
    mechanism = BY_NAME[path.parent.name]
    angles = [solution[f"theta{mechanism.crank}"] for solution in result.solutions]
    assert min(abs(angle - shipped[f"theta{mechanism.crank}"]) for angle in angles) < 4.0


@pytest.mark.parametrize("path", SHEETS, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_any_driver_finds_all_positions(path: Path) -> None:
    """As many as the driver's coordinate takes its value in a turn of the crank, and at those
    angles."""
    mechanism, result = drive_of(path)
    state = mechanism.state(ANGLES[0], *RATES, 1)
    (driver,) = (
        name
        for name in result.inputs
        if name in state and name not in mechanism.lengths and kind(name) in ("theta", "length")
    )
    modes = mechanism.modes[:1] if mechanism.choices else mechanism.modes
    brackets = [
        bracket
        for mode in modes
        for bracket in crossings(mechanism, driver, result.inputs[driver], mode)
    ]
    angles = [solution[f"theta{mechanism.crank}"] for solution in result.solutions]
    assert len(angles) == len(brackets) > 0
    assert all(any(low <= angle % 360.0 <= high for angle in angles) for low, high in brackets)


def crossings(
    mechanism: Mechanism, driver: str, value: float, mode: int
) -> list[tuple[float, float]]:
    """The degrees of crank angle between which a coordinate passes a value."""
    differences = [
        apart_signed(driver, mechanism.coordinate(float(degree), driver, mode), value)
        for degree in range(361)
    ]
    return [
        (degree, degree + 1.0)
        for degree, (one, other) in enumerate(pairwise(differences))
        if one * other <= 0.0 and abs(one - other) < 90.0 and other != 0.0
    ]


def apart_signed(name: str, value: float, target: float) -> float:
    return remainder(value - target, 360.0) if kind(name) == "theta" else value - target


@pytest.mark.parametrize(("velocity", "exact"), ENGINE_ANGLES.items())
def test_crank_angles_for_a_piston_velocity(velocity: float, exact: tuple[float, float]) -> None:
    result = solver.solve(
        model("piston_engine"), {"thetaOB": None, "vP": velocity}, want=["thetaOB"]
    )
    assert str(result.status) == "solved"
    found = sorted(solution["thetaOB"] for solution in result.solutions)
    assert found == pytest.approx(exact, rel=1e-12)


def test_crank_angles_for_an_acceleration_are_all_found() -> None:
    """A sweep of the crank passes the wanted acceleration as often as there are answers."""
    four_link = model("four_link_chain")
    wanted = solver.solve(four_link)["yr1"]
    found = solver.solve(four_link, {"yr1": wanted, "thetaPQ": None})
    turn = solver.sweep(four_link, {"thetaPQ": EVERY_DEGREE}, ["yr1"], all=True)
    passed = 0
    for branch in (1, 2):
        above = turn["yr1"][turn["answer"] == branch] > wanted
        passed += sum(above != [*above[1:], above[0]])
    assert found.complete and len(found.solutions) == passed == 8


def test_piston_velocity_of_the_drawing() -> None:
    """The unit reads 9.4 m/s off a drawing of 1 mm : 200 mm/s, good to half a millimetre."""
    assert abs(solver.solve(model("piston_engine"))["vP"]) == pytest.approx(9.4, abs=0.1)


def test_angular_acceleration_does_not_change_the_velocities() -> None:
    names = ["omegaUT", "omegaST", "xw", "yw"]
    with_it = solver.solve(model("rigid_link_chain"), want=names)
    without = solver.solve(model("rigid_link_chain"), {"alphaRU": None}, want=names)
    assert str(without.status) == "solved"
    assert [without[name] for name in names] == [with_it[name] for name in names]


def test_time_ratio_of_the_quick_return() -> None:
    result = solver.solve(model("whitworth_quick_return"))
    ends = result["theta1"], result["theta2"], result["ratio"]
    assert ends == pytest.approx((-30.0, 210.0, 2.0), rel=1e-14)


def test_quick_return_of_a_wanted_time_ratio() -> None:
    """OC = OB sin(90° (ratio - 1)/(ratio + 1)), which is half of OB for a ratio of 2."""
    result = solver.solve(model("whitworth_quick_return"), {"OC": None, "ratio": 2.0}, want=["OC"])
    assert str(result.status) == "solved"
    assert [solution["OC"] for solution in result.solutions] == pytest.approx([0.1], rel=1e-12)


INFEASIBLE = [
    ("four_link_chain", {"thetaPQ": None, "thetaSR": 70.0}),
    ("rigid_link_chain", {"thetaRU": None, "thetaST": 80.0}),
    ("piston_engine", {"thetaOB": None, "sP": 0.26}),
    ("two_cylinder_engine", {"thetaOB": None, "sC": 0.46}),
    ("slotted_link", {"thetaOB": None, "thetaCD": 55.0}),
    ("slotted_link", {"thetaOB": None, "CS": 0.61}),
    ("slider_outside_link", {"thetaOB": None, "CS": 0.61}),
    ("whitworth_quick_return", {"thetaOB": None, "sE": 0.66}),
    ("trunnion", {"thetaBC": None, "SC": 0.15}),
    ("trunnion", {"thetaBC": None, "thetaCD": 25.0}),
    ("rod_through_trunnion", {"thetaOB": None, "BE": 0.36}),
    ("rod_through_trunnion", {"thetaOB": None, "sC": 0.41}),
    ("oscillating_cylinder", {"thetaBO": None, "OC": 0.1}),
    ("oscillating_cylinder", {"thetaBO": None, "thetaOC": 15.0}),
]
"""Beyond the limits that the pages of the models state."""


@pytest.mark.parametrize(("name", "inputs"), INFEASIBLE, ids=str)
def test_beyond_the_limits_of_motion(name: str, inputs: dict[str, float | None]) -> None:
    result = solver.solve(model(name), inputs, want=[next(iter(inputs))])
    assert str(result.status) == "infeasible"


SINGULAR = [
    ("four_link_chain", {"PQ": 1, "QR": 4, "RS": 4, "PS": 3, "QM": 1, "thetaSR": 90, "omegaSR": 0}),
    ("rigid_link_chain", {"RU": 1, "UT": 4, "ST": 4, "RS": 3, "thetaST": 90, "omegaST": 0}),
    ("piston_engine", {"sP": 0.25, "vP": 0}),
    ("piston_engine", {"OB": 1, "BP": 3, "phi": 180, "sP": 4, "vP": 0}),
    ("piston_engine", {"OB": 1, "BP": 2, "thetaBP": -30, "omegaBP": 0}),
    ("two_cylinder_engine", {"OB": 1, "BC": 3, "OE": 1, "EF": 3, "sC": 4, "vC": 0}),
    ("slotted_link", {"thetaCD": 60, "omegaCD": 0}),
    ("slotted_link", {"CS": 0.6, "vSlide": 0}),
    ("slider_outside_link", {"OB": 2, "OC": 3, "gap": 3, "CS": 4, "vSlide": 0}),
    ("slider_outside_link", {"OB": 1, "OC": 4, "gap": 1, "thetaCD": 60, "omegaCD": 0}),
    ("whitworth_quick_return", {"OB": 2, "OC": 1, "CD": 1, "DE": 3, "sE": 4, "vE": 0}),
    ("whitworth_quick_return", {"OB": 2, "OC": 1, "CS": 3, "vSlide": 0}),
    ("trunnion", {"SC": 0.14, "vSlide": 0}),
    ("trunnion", {"BC": 1, "BE": 2, "thetaCD": -30, "omegaCD": 0}),
    ("rod_through_trunnion", {"OB": 1, "BC": 3, "xD": -3, "yD": 4, "BE": 6, "vSlide": 0}),
    ("rod_through_trunnion", {"OB": 1, "BC": 3, "xD": -3, "yD": 4, "sC": 4, "vC": 0}),
    ("rod_through_trunnion", {"OB": 1, "BC": 3, "xD": -2, "yD": 0, "thetaBF": -150, "omegaBF": 0}),
    ("oscillating_cylinder", {"OC": 0.25, "vSlide": 0}),
    ("oscillating_cylinder", {"BO": 1, "BC": 2, "thetaOC": -30, "omegaOC": 0}),
]
"""Dead points at which all numbers are exact: triangles of 3, 4 and 5 or with 30°, links in
line."""


@pytest.mark.parametrize(("name", "inputs"), sampled(SINGULAR, 3), ids=str)
def test_dead_points_are_singular(name: str, inputs: dict[str, float]) -> None:
    crank = BY_NAME[name].crank
    wanted = [f"theta{crank}", f"omega{crank}"]
    result = solver.solve(model(name), {**inputs, **dict.fromkeys(wanted)}, want=wanted)
    assert str(result.status) == "singular"
