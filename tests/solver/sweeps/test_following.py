"""Sweeps that follow the curve: against closed forms of linkages and of a van der Waals gas."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import rulesheets
import solver
from rulesheets.diagnosis import RuleSheetError
from rulesheets.variables import read_variable_sheet
from solver.__main__ import main
from solver.sweeps.curves import CurveTable

MODELS = Path(__file__).parents[3] / "models"


def followed(
    sheet: str, name: str, values: object, want: list[str], given: dict | None = None
) -> CurveTable:
    model = rulesheets.loads(sheet) if "\n" in sheet else rulesheets.load(sheet)
    table = solver.sweep(model, {name: values}, want, given=given, follow=True)
    assert isinstance(table, CurveTable)
    return table


def test_the_slider_drives_the_crank_through_a_full_turn() -> None:
    """Offset slider crank: ends of stroke at √((AB ± AO)² − offset²), the answers θ = ψ ±
    acos(…)."""
    table = followed(
        "offset_slider_crank",
        "xB",
        np.linspace(3.0, 12.0, 37),
        ["thetaAO", "vB"],
        {"thetaAO": None},
    )
    (branch,) = table.branches
    assert branch.closed
    assert [(limit.value, limit.greatest) for limit in branch.limits] == [
        (pytest.approx(math.sqrt(121 - 4), rel=1e-12), True),
        (pytest.approx(math.sqrt(25 - 4), rel=1e-12), False),
    ]
    theta, x = table["thetaAO"], table["xB"]
    reach = 3 * np.cos(np.radians(theta)) + np.sqrt(64 - (2 - 3 * np.sin(np.radians(theta))) ** 2)
    np.testing.assert_allclose(reach, x, rtol=1e-13)
    turned = np.unwrap(theta, period=360.0)
    assert turned[-1] - turned[0] == pytest.approx(360.0, rel=1e-12)
    assert (np.diff(turned) > 0).all()
    assert (np.diff(table.arc) > 0).all()
    tilt = np.arcsin((2 - 3 * np.sin(np.radians(theta))) / 8)
    speed = 45 * np.sin(np.radians(theta) - tilt) / np.cos(tilt)
    np.testing.assert_allclose(table["vB"], speed, atol=1e-9)
    limits = {limit.row for limit in branch.limits}
    assert [table.STATUSES[code] is solver.Status.SINGULAR for code in table.status] == [
        row in limits for row in range(len(theta))
    ]


@pytest.mark.parametrize(
    ("crank", "coupler", "rocker", "frame"),
    [(0.2, 0.5, 0.4, 0.5), (1.0, 3.0, 2.5, 3.2), (0.1, 0.9, 0.5, 1.0)],
)
def test_the_rocker_drives_a_four_bar_through_both_limits(
    crank: float, coupler: float, rocker: float, frame: float
) -> None:
    """The rocker turns back where crank and coupler lie in line: the law of cosines gives its
    angle."""
    lengths = {"PQ": crank, "QR": coupler, "RS": rocker, "PS": frame, "thetaPQ": None}
    table = followed(
        "four_link_chain", "thetaSR", np.arange(0.0, 181.0, 15.0), ["thetaPQ", "thetaQR"], lengths
    )

    def limit(reach: float) -> float:
        cosine = (rocker**2 + frame**2 - reach**2) / (2 * rocker * frame)
        return 180 - math.degrees(math.acos(cosine))

    limits = sorted((limit(coupler + crank), limit(coupler - crank)))
    assert len(table.branches) == 1
    assert table.branches[0].closed
    assert sorted(at.value for at in table.branches[0].limits) == pytest.approx(limits, rel=1e-12)
    turned = np.unwrap(table["thetaPQ"], period=360.0)
    assert abs(turned[-1] - turned[0]) == pytest.approx(360.0, rel=1e-12)
    assert (np.diff(turned) * np.sign(turned[-1] - turned[0]) > 0).all()
    p, q, r = (np.radians(table[name]) for name in ("thetaPQ", "thetaQR", "thetaSR"))
    np.testing.assert_allclose(
        crank * np.cos(p) + coupler * np.cos(q), frame + rocker * np.cos(r), atol=1e-13
    )
    np.testing.assert_allclose(
        crank * np.sin(p) + coupler * np.sin(q), rocker * np.sin(r), atol=1e-13
    )


def test_an_isotherm_of_van_der_waals_turns_at_its_spinodal() -> None:
    """dP/dV = 0: 2 a (V − b)² = R T V³, of which two roots lie right of b."""
    a, b, gas, temperature = 3.592, 0.04267, 0.0820573661, 290.0
    table = followed("van_der_waals", "P", np.linspace(20.0, 70.0, 11), ["Vm"], {"T": temperature})
    (branch,) = table.branches
    roots = np.roots([gas * temperature, -2 * a, 4 * a * b, -2 * a * b * b])
    volumes = sorted(root.real for root in roots if abs(root.imag) < 1e-12 and root.real > b)
    pressures = [gas * temperature / (v - b) - a / v**2 for v in volumes]
    assert sorted(at.value for at in branch.limits) == pytest.approx(sorted(pressures), rel=1e-12)
    assert not branch.closed
    assert (branch.start, branch.end) == ("P reaches 20", "P reaches 70")
    assert (np.diff(table["Vm"]) < 0).all()


CRANK = (
    "variables\n theta\n x\n AO = 3\n AB = {}\nrules\n (x - AO*cosd(theta))^2 + "
    "(AO*sind(theta))^2 = AB^2"
)


def test_a_change_point_ends_the_branches_that_meet_in_it() -> None:
    """AO = AB without offset: x = 6 cos θ, and x = 0 at any θ, cross at θ = ±90."""
    table = followed(CRANK.format(3), "x", np.linspace(-1.0, 7.0, 9), ["theta"])
    assert {branch.end for branch in table.branches} == {"branches meet or cross"}
    np.testing.assert_allclose(table["x"], 6 * np.cos(np.radians(table["theta"])), atol=1e-7)
    assert [at.value for branch in table.branches for at in branch.limits] == [
        pytest.approx(6.0, rel=1e-13)
    ]


@pytest.mark.parametrize("gap", [1e-3, 1e-6])
def test_near_a_change_point_the_branches_are_kept_apart(gap: float) -> None:
    """The roots are x = 3 cos θ ± √(AB² − 9 sin² θ): the curve never leaves the sign that it began
    with."""
    table = followed(CRANK.format(3 + gap), "x", np.linspace(-1.0, 7.0, 9), ["theta"])
    for branch in table.branches:
        rows = slice(branch.first, branch.last)
        side = table["x"][rows] - 3 * np.cos(np.radians(table["theta"][rows]))
        assert (side > 0).all() or (side < 0).all()
    limits = sorted(at.value for branch in table.branches for at in branch.limits)
    assert limits == pytest.approx([-gap, gap, 6 + gap], abs=1e-12)


def test_a_branch_goes_on_where_rules_take_over_from_one_another() -> None:
    table = followed(
        "if x >= 1 then y = x^2 else y = 2*x - 1\nvariables\nx\ny", "y", [-1.0, 0.5, 4.0], ["x"]
    )
    assert len(table.branches) == 1
    assert table["x"].tolist() == pytest.approx([0.0, 0.75, 2.0])


def test_a_branch_ends_where_the_rules_jump() -> None:
    table = followed(
        "if x > 1 then y = x^2 + 1 else y = x^2\nvariables\nx > 0\ny", "y", [0.5, 3.0], ["x"]
    )
    assert [(branch.start, branch.end) for branch in table.branches] == [
        ("y reaches 0.5", "other rules hold beyond"),
        ("other rules hold beyond", "y reaches 3"),
    ]


def test_a_branch_ends_at_the_range_of_a_variable() -> None:
    table = followed("variables\nx in [-0.5, 2]\ny\nrules\nx^2 = y", "y", [1.0, 3.0], ["x"])
    (branch,) = table.branches
    assert {branch.start, branch.end} == {"y reaches 1", "y reaches 3"}
    wider = followed("variables\nx in [-0.5, 2]\ny\nrules\nx^2 = y", "y", [0.0, 1.0, 9.0], ["x"])
    assert {wider.branches[0].start, wider.branches[0].end} == {"x reaches 2", "x reaches -0.5"}
    assert [at.value for at in wider.branches[0].limits] == [pytest.approx(0.0, abs=1e-13)]


def test_answers_that_differ_in_what_does_not_move_are_branches_of_their_own() -> None:
    table = followed("variables\nx\ny\nz\nrules\nx^2 = 9\ny = x + z", "z", [0.0, 1.0], ["x", "y"])
    assert len(table.branches) == 2
    assert set(zip(table["x"], table["y"] - table["z"], strict=True)) == {(3.0, 3.0), (-3.0, -3.0)}


def test_cases_that_are_assumed_are_branches_of_their_own() -> None:
    """x = 3 - s beyond 1 holds for s < 2, x = s/2 - 1 before 1 for s up to 4."""
    rule = "if x > 1 then x = 3 - s else x = s/2 - 1"
    table = followed(f"variables\nx\ns\nrules\n{rule}", "s", np.linspace(0.0, 6.0, 7), ["x"])
    ends = sorted((branch.start, branch.end) for branch in table.branches)
    assert ends == [("s reaches 0", "other rules hold beyond")] * 2
    upper, lower = (table["x"][branch.first : branch.last] for branch in table.branches)
    assert upper.tolist()[:2] == pytest.approx([3.0, 2.0])
    assert upper.min() == pytest.approx(1.0)
    assert lower.tolist()[:4] == pytest.approx([-1.0, -0.5, 0.0, 0.5])
    assert lower.max() == pytest.approx(1.0)


def test_rules_that_change_at_the_first_value_are_left_at_once() -> None:
    sheet = "variables\nx > 0\ns\nrules\nif s > 1 then x^2 = s else x^2 = 4*s"
    table = followed(sheet, "s", [1.0, 2.0, 3.0], ["x"])
    at, beyond = sorted(table.branches, key=lambda branch: branch.last - branch.first)
    assert table["x"][at.first : at.last] == pytest.approx(2.0)
    assert table["x"][beyond.first : beyond.last].tolist() == pytest.approx(
        [1.0, math.sqrt(2), math.sqrt(3)]
    )


def test_where_every_step_has_one_value_the_rows_part_where_there_is_no_answer() -> None:
    sheet = "variables\nx\ny\nrules\ny = sqrt(x*(x - 2)*(x - 4))"
    table = followed(sheet, "x", np.arange(-1.0, 6.0), ["y"])
    rows = [table["x"][branch.first : branch.last].tolist() for branch in table.branches]
    assert rows == [[0.0, 1.0, 2.0], [4.0, 5.0]]
    assert table.branches[0].end == "the rules have no value beyond"
    assert table.solved.all()


def test_a_branch_that_ends_in_a_cusp_shows_no_row_that_does_not_hold() -> None:
    table = followed("variables\nx\ns\nrules\nsqrt(abs(x)) = s + 0.3", "s", [-1.0, 0.0, 1.0], ["x"])
    assert sorted(table["x"].tolist()) == pytest.approx([-1.69, -0.09, 0.09, 1.69])
    assert table.solved.all()
    assert "s reaches 1" in {branch.end for branch in table.branches}


def test_columns_keep_out_of_the_way_of_variables_of_their_name() -> None:
    table = followed("variables\nbranch\narc\nrules\nbranch^2 = arc", "arc", [1.0, 4.0], ["branch"])
    assert list(table) == ["arc", "branch", "branch_", "arc_"]
    assert set(table.branch.tolist()) == {1, 2}
    assert sorted(table["branch"].tolist()) == [-2.0, -1.0, 1.0, 2.0]


def test_what_cannot_be_followed_is_refused() -> None:
    model = rulesheets.loads("x^2 = y + z")
    with pytest.raises(ValueError, match="one swept variable"):
        solver.sweep(model, {"y": [1.0], "z": [1.0]}, follow=True)
    with pytest.raises(ValueError, match="finite"):
        solver.sweep(model, {"y": [math.nan]}, given={"z": 1.0}, follow=True)
    with pytest.raises(RuleSheetError):
        solver.sweep(model, {"w": [1.0]}, follow=True)


def test_the_command_writes_rows_and_tells_limits(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sheet, file = tmp_path / "circle.tk", tmp_path / "circle.csv"
    sheet.write_text("variables\nx\ny\nrules\nx^2 + y^2 = 25", encoding="utf-8")
    assert main(["sweep", str(sheet), "--over", "x=-6:6:3", "--follow"]) == 0
    said = capsys.readouterr()
    assert said.out.splitlines()[0] == "x,y,branch,arc,status"
    assert "x turns back at 5 (greatest), -5 (least); it is closed" in said.err
    assert main(["sweep", str(sheet), "--over", "x=-6:6:3", "--follow", "-o", str(file)]) == 0
    assert file.read_text(encoding="utf-8") == said.out
    assert main(["sweep", str(sheet), "--over", "x=6:9:1", "--follow"]) == 1
    assert "no value of x has an answer to begin at" in capsys.readouterr().err
    assert main(["sweep", str(sheet), "--over", "x=6:9:1", "--follow", "--all"]) == 2


@pytest.mark.parametrize(
    ("sheet", "file", "driver", "span", "crank", "reach"),
    [
        ("piston_engine", "piston_driven.csv", "sP", (0.1, 0.325), "thetaOB", (0.15, 0.25)),
        ("trunnion", "slide_driven.csv", "SC", (0.02, 0.2), "thetaBC", (0.06, 0.14)),
        ("slotted_link", "slide_driven.csv", "CS", (0.1, 0.7), "thetaOB", (0.2, 0.6)),
        ("whitworth_quick_return", "ram_driven.csv", "sE", (0.2, 0.8), "thetaOB", (0.35, 0.65)),
    ],
)
def test_a_driven_mechanism_closes_and_turns_back_at_its_reach(
    sheet: str,
    file: str,
    driver: str,
    span: tuple[float, float],
    crank: str,
    reach: tuple[float, float],
) -> None:
    """The reach is the sum and the difference of two links; there the driver stands while the crank
    turns."""
    model = rulesheets.load(sheet)
    given = dict(read_variable_sheet(MODELS / sheet / file, model).inputs)
    given.pop(driver)
    table = solver.sweep(model, {driver: np.linspace(*span, 7)}, [crank], given=given, follow=True)
    assert isinstance(table, CurveTable)
    (branch,) = table.branches
    assert branch.closed
    assert sorted(at.value for at in branch.limits) == pytest.approx(reach, rel=1e-12)
    assert table.solved.sum() == len(table.status) - 2
    for at in branch.limits:
        angle = float(table[crank][at.row])
        there = solver.solve(
            model, {**given, driver: None, crank: angle}, [driver], {driver: at.value}
        )
        assert there[driver] == pytest.approx(at.value, rel=1e-12)
        assert there.sensitivity([driver], [crank])[driver, crank] == pytest.approx(0.0, abs=1e-10)


@pytest.mark.parametrize(
    ("rules", "over", "branches"),
    [
        ("y = 1/x", (-1, 1, 8), 2),
        ("y = 1/(x - 0.3)^2", (-1, 1, 40), 2),
        ("y = tand(x)", (0, 360, 12), 3),
        ("y = int(x)", (0.2, 2.9, 8), 3),
        ("y = tanh(1000*x)", (-1, 1, 8), 1),
        ("y = abs(x)", (-1, 1, 8), 1),
        ("y = atan2d(sind(x), cosd(x))", (0, 360, 8), 1),
        ("y = x^3 - x", (-2, 2, 9), 1),
    ],
)
def test_what_is_only_computed_is_parted_at_poles_and_jumps(
    rules: str, over: tuple[float, float, int], branches: int
) -> None:
    """None of the swept values is the pole itself, or the place of the jump."""
    table = solver.sweep(rulesheets.loads(rules), {"x": np.linspace(*over)}, follow=True)
    assert len(table["x"]) == over[2]
    assert len(table.branches) == branches
    told = [branch.end for branch in table.branches[:-1]]
    assert told == ["a value jumps or grows without bound"] * (branches - 1)


def test_a_branch_of_symbols_alone_ends_where_there_is_no_answer() -> None:
    """The gap lies between two swept values."""
    sheet = (
        "variables\n  x\n  y\n  kind\nrules\n  y = sqrt((x - 1)*(x - 2))\n  if y >= 0 then kind = "
        "'up\n"
    )
    table = solver.sweep(
        rulesheets.loads(sheet), {"x": [0.0, 0.5, 2.5, 3.0]}, ["kind"], follow=True
    )
    assert [(branch.first, branch.last) for branch in table.branches] == [(0, 2), (2, 4)]
