"""Answers where floats lose digits, against 50 digits: every number is the nearest float, or nearly
so."""

from __future__ import annotations

import math
from fractions import Fraction
from pathlib import Path
from typing import Any

import mpmath
import pytest

import rulesheets
import solver
from solver.leaves import Asked
from solver.solution.solving import posted
from solver.solution.verdict import Verdict, explore_refined, judge
from tests.oracles import slider_crank as oracle
from tests.oracles.slider_crank import Crank

MODELS = Path(__file__).parents[3] / "models"
AS_PRINTED, SLOPE_FREE = "offset_slider_crank", "offset_slider_crank_slope_free"
RATES = {"vB": -4.0, "aB": -70.0}
DRIVEN = ("thetaAO", "omegaAO", "alphaAO")
QUANTITIES = ("xB", "vB", "omegaAB", "aB", "alphaAB")
LAST_PLACE = 2.0**-52


def model(name: str) -> Any:
    return rulesheets.load(MODELS / name / "model.tk")


def slider(offset: float, side: int, outer: bool, distance: float) -> dict[str, Any]:
    """The slider near an end of its stroke, inside it for a positive relative distance."""
    with mpmath.workdps(50):
        reach = mpmath.sqrt(mpmath.mpf(11 if outer else 5) ** 2 - mpmath.mpf(offset) ** 2)
        xB = float(side * reach * (1 - mpmath.mpf(distance) * (1 if outer else -1)))
    cleared: dict[str, Any] = dict.fromkeys(DRIVEN)
    return {"xB": xB, "offset": offset, "branch": "open" if side > 0 else 0.0, **RATES, **cleared}


ENDS = [
    (offset, side, outer) for offset in (0.0, 2.0) for side in (1, -1) for outer in (True, False)
]
QUICK = {(AS_PRINTED, 15), (SLOPE_FREE, 9)}
APPROACHES = [
    pytest.param(name, k, id=f"{name}-1e-{k}", marks=() if (name, k) in QUICK else pytest.mark.slow)
    for name in (AS_PRINTED, SLOPE_FREE)
    for k in range(1, 16)
]


@pytest.mark.parametrize(("offset", "side", "outer"), ENDS)
@pytest.mark.parametrize(("name", "exponent"), APPROACHES)
def test_slider_near_dead_centre(
    name: str, exponent: int, offset: float, side: int, outer: bool
) -> None:
    given = slider(offset, side, outer, 10.0**-exponent)
    result = solver.solve(model(name), given)
    exact = [
        (angle, *oracle.crank_rates(3.0, offset, given["xB"], angle, RATES["vB"], RATES["aB"]))
        for angle in oracle.crank_angles(3.0, 8.0, offset, given["xB"])
    ]
    assert str(result.status) == "solved"
    assert len(exact) == len(result.solutions) == 2
    tolerance = LAST_PLACE if exponent > 2 else 1e-13
    for solution, truth in zip(
        sorted(result.solutions, key=lambda s: s["thetaAO"]), exact, strict=True
    ):
        for quantity, number in zip(DRIVEN, truth, strict=True):
            assert abs(solution[quantity] - number) <= tolerance * abs(number), quantity
            assert abs(solution[quantity] - number) <= solution.error[quantity], quantity


def judged(name: str, given: dict[str, Any]) -> Verdict:
    """The verdict alone: what would cure a refusal is not asked."""
    sheet = model(name)
    own = {n: v.value for n, v in sheet.variables.items() if v.value is not None}
    inputs = {n: v for n, v in {**own, **given}.items() if v is not None}
    asked = Asked(sheet, inputs, None, {}, posted(sheet))
    return judge(asked, explore_refined(asked))


@pytest.mark.parametrize(("offset", "side", "outer"), ENDS[::3])
@pytest.mark.parametrize("exponent", [8, 15])
def test_slider_just_out_of_reach_is_proven_infeasible(
    exponent: int, offset: float, side: int, outer: bool
) -> None:
    given = slider(offset, side, outer, -(10.0**-exponent))
    assert not oracle.crank_angles(3.0, 8.0, offset, given["xB"])
    assert str(judged(SLOPE_FREE, given).status) == "infeasible"


@pytest.mark.parametrize(("offset", "side", "outer"), ENDS[::3])
@pytest.mark.parametrize("name", [AS_PRINTED, SLOPE_FREE])
def test_dead_centre_names_the_angle_and_what_is_free(
    name: str, offset: float, side: int, outer: bool
) -> None:
    """With offset 2 the end of the stroke is no float: nothing tells the nearest one from it."""
    result = solver.solve(model(name), {**slider(offset, side, outer, 0.0), "vB": 0.0})
    assert str(result.status) == "singular"
    named = {variable for diagnosis in result.diagnoses for variable in diagnosis.variables}
    assert {"thetaAO", "omegaAO", "alphaAO"} <= named
    assert {"omegaAO", "alphaAO"} <= set(result.undetermined)
    assert "two answers coincide" in result.diagnoses[0].message
    assert not any("omegaAO" in solution for solution in result.solutions)


@pytest.mark.parametrize("exponent", range(1, 16, 2))
@pytest.mark.parametrize("base", [0.0, 180.0])
@pytest.mark.parametrize("name", [AS_PRINTED, SLOPE_FREE])
def test_rod_nearly_horizontal(name: str, base: float, exponent: int) -> None:
    crank = Crank(3.0, 8.0, 0.0, -15.0, -10.0, base + 10.0**-exponent)
    assert_right(name, crank, 1e-14)


@pytest.mark.parametrize(("side", "exponent"), [(1, 6), (-1, 9), (1, 12)])
def test_rod_a_hair_below_the_backward_direction(side: int, exponent: int) -> None:
    """A direction that would round to -180 is 180 in floats, in many digits, and to the proof."""
    pytest.importorskip("flint")
    crank = Crank(1.0, 4.0, 1.0, -15.0, -10.0, 90.0 + side * 10.0**-exponent)
    exact = oracle.forward(crank)
    result = solver.solve(
        model(AS_PRINTED), crank.inputs, want=(*QUANTITIES, "thetaAB"), prove=True
    )
    assert str(result.status) == "solved"
    assert result["thetaAB"] == 180.0
    assert [result[name] for name in QUANTITIES] == [float(exact[name]) for name in QUANTITIES]
    proof = result.solutions[0].proof
    assert proof is not None and proof.nearest


@pytest.mark.parametrize("exponent", range(1, 16, 2))
@pytest.mark.parametrize("name", [AS_PRINTED, SLOPE_FREE])
def test_rod_nearly_vertical(name: str, exponent: int) -> None:
    crank = Crank(3.0, 8.0, 8 * (1 - 10.0**-exponent) + 1.5, -15.0, -10.0, 30.0)
    assert_right(name, crank, 1e-13)


def assert_right(name: str, crank: Crank, tolerance: float) -> None:
    """Relative to the number itself: no digit is lost."""
    exact = oracle.forward(crank)
    result = solver.solve(model(name), crank.inputs)
    assert str(result.status) == "solved"
    for quantity in QUANTITIES:
        assert abs(result[quantity] - exact[quantity]) <= tolerance * abs(exact[quantity]), quantity


@pytest.mark.parametrize("name", [AS_PRINTED, SLOPE_FREE])
def test_repeated_solves_are_as_right_as_the_first(name: str) -> None:
    """What earlier solves taught is not used where it loses digits."""
    sheet = model(name)
    for angle in (-30.0, -31.0, -32.0, 40.0):
        solver.solve(sheet, {"thetaAO": angle, "offset": 0.0})
    for angle in (1e-3, 1e-9, 1e-13):
        exact = oracle.forward(Crank(3.0, 8.0, 0.0, -15.0, -10.0, angle))
        result = solver.solve(sheet, {"thetaAO": angle, "offset": 0.0})
        for quantity in QUANTITIES:
            assert abs(result[quantity] - exact[quantity]) <= 1e-14 * abs(exact[quantity]), quantity


def test_a_prepared_plan_is_as_right() -> None:
    given = slider(2.0, 1, True, 1e-13)
    fixed = {name: value for name, value in given.items() if name != "xB"}
    plan = solver.prepare(model(SLOPE_FREE), ["xB"], ["thetaAO", "omegaAO"], given=fixed)
    exact = oracle.crank_angles(3.0, 8.0, 2.0, given["xB"])
    found = sorted(plan.all(given["xB"]))
    assert [angle for angle, _ in found] == [float(angle) for angle in exact]
    for angle, rate in zip(exact, (rate for _, rate in found), strict=True):
        truth = oracle.crank_rates(3.0, 2.0, given["xB"], angle, RATES["vB"], RATES["aB"])[0]
        assert abs(rate - truth) <= LAST_PLACE * abs(truth)


@pytest.mark.parametrize("exponent", [9, 11, 12, 15])
def test_a_plan_leaves_to_more_digits_what_is_equal_by_a_hair(exponent: int) -> None:
    """Next to in-line dead centre the direction of the rod is within the comparison tolerance of
    180."""
    plan = solver.prepare(model(AS_PRINTED), ["thetaAO"], QUANTITIES, given={"offset": 0.0})
    angles = [0.0, 10.0**-exponent, -(10.0**-exponent)]
    for angle in angles * 2:
        exact = oracle.forward(Crank(3.0, 8.0, 0.0, -15.0, -10.0, angle))
        assert plan(angle) == pytest.approx(
            [float(exact[name]) for name in QUANTITIES], rel=1e-14, abs=0.0
        )
    swept = plan.sweep(angles)
    for row, angle in enumerate(angles):
        assert tuple(swept[name][row] for name in QUANTITIES) == plan(angle)


@pytest.mark.parametrize("angle", [41.810314895778596, 138.1896851042214, 41.81031489577862])
def test_a_slope_near_infinity_is_no_slope_that_may_vanish(angle: float) -> None:
    """The rod is horizontal to the last place of the angle, which leaves open the sign of its
    slope."""
    exact = oracle.forward(Crank(3.0, 8.0, 2.0, -15.0, -10.0, angle, open=False))
    result = solver.solve(
        model(AS_PRINTED), {"thetaAO": angle, "branch": "crossed"}, want=QUANTITIES
    )
    assert str(result.status) == "solved"
    for quantity in QUANTITIES:
        assert result[quantity] == pytest.approx(float(exact[quantity]), rel=1e-13), quantity


def test_an_angle_next_to_nothing_is_not_lost_beside_a_right_angle() -> None:
    """The printed rules add 90 degrees to it."""
    angle = 1e-20
    result = solver.solve(model(AS_PRINTED), {"thetaAO": angle})
    assert str(result.status) == "solved"
    across = 45.0 * math.radians(angle)
    assert result.solutions[0]["velocity.xa"] == pytest.approx(across, rel=1e-14, abs=0.0)


def test_rod_past_vertical_is_infeasible() -> None:
    inputs = Crank(3.0, 8.0, 8 * (1 + 1e-15) + 1.5, -15.0, -10.0, 30.0).inputs
    for name in (AS_PRINTED, SLOPE_FREE):
        assert str(judged(name, inputs).status) == "infeasible"


# --- other sheets ----------------------------------------------------------------------


@pytest.mark.parametrize("exponent", [2, 8, 14])
def test_circles_that_nearly_touch(exponent: int) -> None:
    apart = 2.0 * (1.0 - 10.0**-exponent)
    text = f"x^2 + y^2 = 1\n(x - {apart!r})^2 + y^2 = 1"
    result = solver.solve(rulesheets.loads(text))
    with mpmath.workdps(50):
        height = mpmath.sqrt(1 - (mpmath.mpf(apart) / 2) ** 2)
    assert str(result.status) == "solved"
    found = sorted((s["x"], s["y"]) for s in result.solutions)
    assert [x for x, _ in found] == pytest.approx([apart / 2] * 2, rel=LAST_PLACE)
    assert sorted(y for _, y in found) == pytest.approx(
        [-float(height), float(height)], rel=LAST_PLACE
    )


def test_circles_that_touch_are_singular() -> None:
    result = solver.solve(rulesheets.loads("x^2 + y^2 = 1\n(x - 2)^2 + y^2 = 1"))
    assert str(result.status) == "singular"


def test_circles_just_apart_are_infeasible() -> None:
    text = f"x^2 + y^2 = 1\n(x - {2 * (1 + 1e-15)!r})^2 + y^2 = 1"
    assert str(solver.solve(rulesheets.loads(text)).status) == "infeasible"


@pytest.mark.parametrize("gap", [1e-5, 1e-8, 3e-8])
def test_roots_that_floats_merge_are_both_found(gap: float) -> None:
    """A cubic (a simultaneous block of one rule) with two roots that lie closer than floats can
    tell."""
    one, other = Fraction(1.0), Fraction(1.0 + gap)
    c2, c1, c0 = (
        float(c) for c in (-(one + other + 3), one * other + 3 * (one + other), -3 * one * other)
    )
    result = solver.solve(rulesheets.loads(f"x^3 + {c2!r}*x^2 + {c1!r}*x + {c0!r} = 0"))
    with mpmath.workdps(60):
        roots = mpmath.polyroots([1, c2, c1, c0], maxsteps=200, extraprec=200)
    exact = sorted(mpmath.re(root) for root in roots if abs(mpmath.im(root)) < 1e-40)
    found = sorted(solution["x"] for solution in result.solutions)
    assert str(result.status) == "solved"
    assert len(found) == len(exact)
    assert all(abs(a - b) <= LAST_PLACE * b for a, b in zip(found, exact, strict=True))


def test_an_ill_conditioned_linear_system_has_all_its_digits() -> None:
    size = 9
    rows = [[1.0 / (i + j + 1) for j in range(size)] for i in range(size)]
    rhs = [float(i % 3) for i in range(size)]
    lines = [
        " + ".join(f"{c!r}*x{j}" for j, c in enumerate(row)) + f" = {b!r}"
        for row, b in zip(rows, rhs, strict=True)
    ]
    solution = solver.solve(rulesheets.loads("\n".join(lines))).solutions[0]
    with mpmath.workdps(60):
        exact = mpmath.lu_solve(mpmath.matrix(rows), mpmath.matrix(rhs))
        assert [solution[f"x{k}"] for k in range(size)] == [float(x) for x in exact]


def test_decimals_that_are_meant_to_be_equal_are() -> None:
    """0.1 + 0.2 and 0.3 are two floats, but the last places of the decimals explain that."""
    text = (
        "variables\n a = 0.1\n b = 0.2\n c = 0.3\n s\n y\nrules\n s = a + b\n if s = c then y = 1 "
        "else y = 2"
    )
    result = solver.solve(rulesheets.loads(text))
    assert result["y"] == 1.0


def test_well_conditioned_sheets_stay_in_floats() -> None:
    result = solver.solve(model(SLOPE_FREE))
    assert 0.0 < max(result.solutions[0].error.values()) <= 1e-11
    assert result.solutions[0].error["vB"] > abs(result["vB"]) * 2.0**-53


@pytest.mark.parametrize("E", ["0.5", "2", "4.75", "60"])
def test_a_redundant_way_that_loses_digits_contradicts_nothing(E: str) -> None:
    """Kepler's true anomaly gives r, and r gives E by its cosine, badly near the apsis."""
    with mpmath.workdps(50):
        e, angle = mpmath.mpf("0.13"), mpmath.radians(mpmath.mpf(E))
        nu = float(
            mpmath.degrees(
                mpmath.atan2(mpmath.sqrt(1 - e**2) * mpmath.sin(angle), mpmath.cos(angle) - e)
            )
        )
    result = solver.solve(model("kepler"), {"e": 0.13, "a": 1.37, "M": None, "nu": nu})
    assert str(result.status) == "solved"
    assert [s["E"] for s in result.solutions] == pytest.approx([float(E)], rel=1e-14)


def test_redundant_inputs_agree_to_their_last_places() -> None:
    """The rod's angular velocity follows from its angle and the crank's; given, it is a check."""
    engine, sizes = model("piston_engine"), {"OB": 0.0576, "BP": 0.2743, "phi": 0.0}
    for angle in (97.0, 101.3, 127.01, 133.7, 152.9):
        forward = solver.solve(engine, {**sizes, "thetaOB": angle, "omegaOB": 300.55})
        given = {name: forward[name] for name in ("thetaBP", "omegaBP")}
        cleared: dict[str, Any] = {"thetaOB": None, "alphaOB": None}
        result = solver.solve(engine, {**sizes, "omegaOB": 300.55, **cleared, **given})
        assert str(result.status) == "partial"
        assert {n for n in result.undetermined if not engine.variables[n].passed} == {
            "alphaOB",
            "alphaBP",
            "aP",
            "xp1",
            "yp1",
        }
        assert result["thetaOB"] == pytest.approx(angle, rel=1e-12)


def test_angles_that_sums_tie_are_turned_together_or_not_at_all() -> None:
    """cos(a)·cos(x) = k with a + x = s, that is cos(a - x) = 2·k - cos(s): x is millions of radians
    away."""
    s, k = 7690763.9, -0.04523041584122171
    result = solver.solve(
        rulesheets.loads(f"z - a = -1e8\ncos(a)*cos(x) = {k!r}\nz + x = {s!r} - 1e8")
    )
    assert result.status is solver.Status.SOLVED
    apart = math.acos(2 * k - math.cos(s))
    for solution in result.solutions:
        assert solution["a"] + solution["x"] == pytest.approx(s, rel=1e-14)
        assert math.cos(solution["a"] - solution["x"]) == pytest.approx(math.cos(apart), abs=1e-7)


def test_a_root_next_to_nothing_is_not_lost_beside_the_other() -> None:
    """y and -w are the roots of t² + 6e226 t - 4e155: their sum alone tells nothing of the small
    one."""
    text = "(y/y^3)*(w*z - sind(w)) = 1e285\nw*y = -4e155\ny - w = -6e226"
    result = solver.solve(rulesheets.loads(text))
    assert str(result.status) == "solved"
    small, large = 4e155 / 6e226, 6e226
    solution = result.solutions[0]
    assert solution["y"] == pytest.approx(-small, rel=1e-14)
    assert solution["w"] == pytest.approx(large, rel=1e-14)
    assert solution["z"] == pytest.approx(1e285 * small * small / large, rel=1e-12)


def test_a_coefficient_without_a_value_ends_its_branch_alone() -> None:
    """(1 + r)^12 gives a second r, at which a power of no whole exponent has no value."""
    loan = rulesheets.loads(
        "pay = P*r/(1 - (1 + r)^(-n))\ninterest = pay*n - P\near = (1 + r)^12 - 1\n"
    )
    forward = solver.solve(loan, {"P": 20000.0, "r": 0.00252, "n": 43.9})
    given = {name: forward[name] for name in ("interest", "ear", "n")}
    result = solver.solve(loan, given)
    assert [s["r"] for s in result.solutions] == pytest.approx([0.00252])
    assert [s["P"] for s in result.solutions] == pytest.approx([20000.0])


def test_what_is_only_rounding_in_many_digits_is_0() -> None:
    """Where the rod is not accelerated, its digits cancel to as many as are computed."""
    model = rulesheets.load(MODELS / "rod_through_trunnion" / "model.tk")
    result = solver.solve(model, {"yc": 0.0, "phi": None})
    assert sorted(abs(s["alphaBC"]) for s in result.solutions)[:2] == [0.0, 0.0]
    assert all(s.error["alphaBC"] < 1e-12 for s in result.solutions)
