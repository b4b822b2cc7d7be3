"""Tolerances: read and written, carried to the outputs, and compared with samples."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rulesheets
import solver
from rulesheets.diagnosis import RuleSheetError
from rulesheets.format import format_sheet
from rulesheets.inputs import parse_input
from rulesheets.model import Tolerance
from rulesheets.parse.sections import parse
from rulesheets.syntax import Source
from rulesheets.variables import read_variable_sheet
from solver.__main__ import main

OHM = "variables\n  I = 2 ± 0.1\n  R = 6 +- 5%\n  V\n  P\nrules\n  V = I*R\n  P = V*I\n"

sizes = st.floats(0.0, 1e6, allow_nan=False)


# --- in the language ------------------------------------------------------------------


@pytest.mark.parametrize(
    ("written", "tolerance"),
    [
        ("3 ± 0.01", Tolerance(0.01)),
        ("3±0.01", Tolerance(0.01)),
        ("3 +- 1/4", Tolerance(0.25)),
        ("3 +/- 1 %", Tolerance(1.0, percent=True)),
        ("2 + 1 ± 1%", Tolerance(1.0, percent=True)),
    ],
)
def test_a_tolerance_follows_the_value_of_an_input(written: str, tolerance: Tolerance) -> None:
    model = rulesheets.loads(f"variables\n x = {written} [mm]\n y\nrules\n y = x")
    assert (model.variables["x"].value, model.variables["x"].tolerance) == (3.0, tolerance)
    assert parse_input(written) == (3.0, tolerance)


def test_in_a_rule_plus_minus_is_a_sign() -> None:
    assert solver.solve(rulesheets.loads("y = 3 +-2"))["y"] == 1.0


@given(value=st.floats(allow_nan=False, allow_infinity=False), size=sizes, percent=st.booleans())
def test_a_tolerance_reads_back_as_it_is_written(value: float, size: float, percent: bool) -> None:
    from rulesheets.inputs import exact
    from solver.report.sheet import tolerated

    text = tolerated(exact(value), Tolerance(size, percent))
    assert parse_input(text) == (value, Tolerance(size, percent))
    sheet = parse(Source("s", f"variables\n x = {text}\n y\nrules\n y = x"))
    assert parse(Source("s", format_sheet(sheet))) == sheet


def test_a_variable_sheet_carries_tolerances(tmp_path: Path) -> None:
    sheet, filled = tmp_path / "ohm.tk", tmp_path / "ohm.csv"
    sheet.write_text(OHM, encoding="utf-8")
    assert main(["solve", str(sheet), "--set", "I=3 ± 2%", "-o", str(filled), "--json"]) == 0
    read = read_variable_sheet(filled, rulesheets.load(sheet))
    assert read.inputs == {"I": 3.0, "R": 6.0, "V": None, "P": None}
    assert read.tolerances == {"I": Tolerance(2.0, percent=True), "R": Tolerance(5.0, percent=True)}


def test_a_guess_has_no_tolerance(tmp_path: Path) -> None:
    (tmp_path / "v.csv").write_text("St,Input,Name\nG,3 ± 1,V\n", encoding="utf-8")
    with pytest.raises(RuleSheetError) as wrong:
        read_variable_sheet(tmp_path / "v.csv", rulesheets.loads(OHM))
    assert wrong.value.diagnoses[0].code == "E405"


# --- to first order -------------------------------------------------------------------


def test_worst_case_root_sum_square_and_contributions() -> None:
    """V = I R and P = I² R with I = 2 ± 0.1, R = 6 ± 0.3."""
    bands = solver.solve(rulesheets.loads(OHM)).tolerance_bands()
    assert bands.tolerances == {"I": 0.1, "R": pytest.approx(0.3)}
    voltage, power = bands["V"], bands["P"]
    assert voltage is not None and power is not None
    assert (voltage.worst, voltage.rss) == (
        pytest.approx(0.6 + 0.6),
        pytest.approx(math.hypot(0.6, 0.6)),
    )
    assert (power.worst, power.rss) == (
        pytest.approx(2.4 + 1.2),
        pytest.approx(math.hypot(2.4, 1.2)),
    )
    assert [part.input for part in power.contributions] == ["I", "R"]
    assert [part.share for part in power.contributions] == [pytest.approx(0.8), pytest.approx(0.2)]


def test_tolerances_work_backwards() -> None:
    result = solver.solve(rulesheets.loads(OHM), {"R": None, "P": 24.0})
    band = result.tolerance_bands({"P": Tolerance(1.0, percent=True)})["R"]
    assert band is not None
    assert band.worst == pytest.approx(2 * 6 * 0.05 + 6 * 0.01)  # R = P/I²


def test_a_missing_derivative_leaves_its_band_unknown() -> None:
    result = solver.solve(rulesheets.loads("y = sqrt(x)\nz = 2*x"), {"x": 0.0})
    bands = result.tolerance_bands({"x": 0.1}, ["y", "z"])
    assert bands["y"] is None
    assert bands["z"] is not None and bands["z"].worst == 0.2
    assert [diagnosis.code for diagnosis in bands.diagnoses] == ["S592"]


def test_tolerances_that_cannot_be_are_refused() -> None:
    result = solver.solve(rulesheets.loads(OHM))
    for wrong, code in (({"I": -1.0}, "E405"), ({"I": math.inf}, "E405"), ({"J": 1.0}, "E407")):
        with pytest.raises(RuleSheetError) as refused:
            result.tolerance_bands(wrong)
        assert refused.value.diagnoses[0].code == code


# --- Monte Carlo ----------------------------------------------------------------------


@pytest.mark.parametrize(("distribution", "spread"), [("uniform", 3**-0.5), ("normal", 1 / 3)])
def test_samples_spread_as_first_order_says_where_rules_are_linear(
    distribution: str, spread: float
) -> None:
    result = solver.solve(rulesheets.loads("y = 3*a - 4*b"), {"a": 5.0, "b": 1.0})
    samples = solver.monte_carlo(result, 2000, 7, distribution, {"a": 0.1, "b": 0.1})
    column = samples.solved("y")
    assert column.std() == pytest.approx(
        0.5 * spread, rel=0.06
    )  # 4 standard errors of 2000 samples
    assert column.mean() == pytest.approx(11.0, abs=4 * 0.5 * spread / 2000**0.5)
    np.testing.assert_allclose(
        samples.table["y"], 3 * samples.table["a"] - 4 * samples.table["b"], rtol=1e-14
    )
    if distribution == "uniform":
        assert np.abs(column - 11.0).max() <= 0.7


def test_the_seed_makes_the_samples() -> None:
    result = solver.solve(rulesheets.loads(OHM))
    one, same, other = (solver.monte_carlo(result, 5, seed).table["V"] for seed in (1, 1, 2))
    assert (one == same).all()
    assert (one != other).any()


def test_samples_stay_with_the_answer_they_began_with() -> None:
    result = solver.solve(rulesheets.loads("x^2 = a"), {"a": 4.0}, guesses={"x": -1.0})
    assert (solver.monte_carlo(result, 20, 0, "uniform", {"a": 0.5}).table["x"] < 0).all()


def test_samples_without_an_answer_are_counted_and_left_out() -> None:
    result = solver.solve(rulesheets.loads("x = sqrt(a)"), {"a": 1.0})
    samples = solver.monte_carlo(result, 400, 0, "uniform", {"a": 2.0})
    drawn = samples.table["a"]
    assert samples.counts == {
        solver.Status.SOLVED: int((drawn >= 0).sum()),
        solver.Status.INFEASIBLE: int((drawn < 0).sum()),
    }
    assert samples.solved("x").size == (drawn >= 0).sum()


def test_what_cannot_be_sampled_is_refused() -> None:
    result = solver.solve(rulesheets.loads(OHM))
    with pytest.raises(ValueError, match="distributions are"):
        solver.monte_carlo(result, distribution="lognormal")
    with pytest.raises(ValueError, match="two samples"):
        solver.monte_carlo(result, 1)
    with pytest.raises(ValueError, match="no answer"):
        solver.monte_carlo(solver.solve(rulesheets.loads("x = sqrt(a)"), {"a": -1.0}))


# --- the command ----------------------------------------------------------------------


def test_the_command_prints_and_tells_json(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sheet = tmp_path / "ohm.tk"
    sheet.write_text(OHM, encoding="utf-8")
    assert main(["solve", str(sheet), "--json", "--monte-carlo", "10", "--seed", "3"]) == 0
    members = json.loads(capsys.readouterr().out)
    assert [band["output"] for band in members["tolerances"]] == ["V", "P"]
    assert members["tolerances"][0]["worst"] == pytest.approx(1.2)
    assert members["monte_carlo"]["statuses"] == {"solved": 10}
    assert main(["solve", str(sheet)]) == 0
    said = capsys.readouterr().out
    assert "2 ± 0.1" in said and "6 ± 5%" in said
    assert "V     12     ± 1.2       ± 0.8485               I 50 %, R 50 %" in said
    assert main(["solve", str(sheet), "--monte-carlo", "1"]) == 2
    capsys.readouterr()
    assert main(["solve", str(sheet), "--csv", "--tolerances"]) == 0
    said = capsys.readouterr()
    assert said.out.splitlines()[1] == ",2 ± 0.1,I,,,"
    assert "Tolerances, to first order" in said.err
