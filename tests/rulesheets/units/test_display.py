"""Display units chosen for a solve: one by one, or a system."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

import rulesheets
from rulesheets import RuleSheetError
from rulesheets.library import convert, library
from rulesheets.units import SYSTEMS, with_display_unit, with_display_units
from solver.__main__ import main

SHEET = (
    "variables\n v = 10 [m/s]\n T = 20 [degC]\n M = 5 [N-m]\n E = 3 [kJ]\n n = 2\nrules\n x = v*n\n"
)


@pytest.mark.parametrize("system", SYSTEMS)
@pytest.mark.parametrize("name", ["m", "bar", "degF", "K", "W", "mi/h", "lbf-in", "cal", "rad"])
def test_a_system_shows_a_unit_of_the_same_kind(system: str, name: str) -> None:
    model = rulesheets.loads(f"variables\n x = 3 [{name}]\nrules\n y = 2*x")
    shown = with_display_units(model, system, {}).variables["x"].display_unit or name
    assert library().unit(shown).bases == library().unit(name).bases
    assert shown in SYSTEMS[system].split() or name == "rad"


def test_torques_and_energies_have_units_of_their_own() -> None:
    shown = with_display_units(rulesheets.loads(SHEET), "us", {"v": "km/h"}).variables
    units = {name: shown[name].display_unit for name in ("v", "T", "M", "E", "n")}
    assert units == {"v": "km/h", "T": "degF", "M": "lbf-ft", "E": "Btu", "n": None}


def test_a_solve_shows_what_is_asked_for(tmp_path, capsys: pytest.CaptureFixture[str]) -> None:
    sheet = tmp_path / "sheet.tk"
    sheet.write_text(SHEET)
    assert main(["solve", str(sheet), "--unit", "v=km/h", "--units", "us"]) == 0
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["36", "v", "km/h"] in rows
    assert ["68", "T", "degF"] in rows
    assert main(["solve", str(sheet), "--unit", "v=km/h", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["solutions"][0]["v"], found["units"]["v"]) == (10.0, "m/s")
    assert "n" not in found["units"]


@pytest.mark.parametrize(
    ("name", "unit", "code"), [("v", "kg", "E461"), ("v", "smoot", "E460"), ("n", "m", "E461")]
)
def test_a_unit_that_cannot_show_a_variable_is_told(name: str, unit: str, code: str) -> None:
    with pytest.raises(RuleSheetError) as wrong:
        with_display_unit(rulesheets.loads(SHEET).variables[name], unit)
    assert wrong.value.diagnoses[0].code == code


def test_the_zero_of_a_scale_is_kept() -> None:
    variable = with_display_unit(rulesheets.loads(SHEET).variables["T"], "K")
    assert variable.display_unit == "K"
    assert convert(20.0, library().unit("degC"), library().unit("K")) == 293.15


def test_a_solve_warns_of_units_and_keeps_its_status(
    tmp_path, capsys: pytest.CaptureFixture[str]
) -> None:
    sheet = tmp_path / "sheet.tk"
    rules = "".join(f" x{k} = N + A/{k}\n" for k in range(2, 7))
    sheet.write_text(f"variables\n N = 3 [N]\n A = 4 [mm^2]\nrules\n{rules}")
    assert main(["solve", str(sheet)]) == 0
    out = capsys.readouterr().out
    assert (out.count("warning[W601]"), "2 more such warnings" in out) == (3, True)
    assert main(["solve", str(sheet), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["status"] == "solved"
    assert [d["severity"] for d in found["diagnoses"]] == ["warning"] * 5


CAR = """variables
  s = 100 [m -> ft]
  t [s]
  v = 20 [m/s -> km/h]
  T = 20 ± 1 [degC -> degF]
  Q [degC]
rules
  v = s/t
  Q = 2*T - 20
"""


@pytest.fixture
def car(tmp_path: Path) -> str:
    sheet = tmp_path / "car.tk"
    sheet.write_text(CAR)
    return str(sheet)


def test_a_sweep_is_shown_in_display_units_and_read_again(
    car: str, capsys: pytest.CaptureFixture[str]
) -> None:
    swept = [car, "--want", "t,s", "--unit", "t=min"]
    assert main(["sweep", *swept, "--over", "v=36:72:18km/h"]) == 0
    table = capsys.readouterr().out
    assert table.splitlines()[:2] == [
        "v [km/h],t [min],s [ft],answers,status",
        "36,0.16666666666666666,328.0839895013123,1,solved",
    ]
    rows = Path(car).with_name("rows.csv")
    rows.write_text(table)
    assert main(["sweep", *swept, "--rows", str(rows), "--columns", "v"]) == 0
    assert capsys.readouterr().out == table
    assert main(["sweep", *swept, "--over", "v=36,72 km/h", "--follow"]) == 0
    assert capsys.readouterr().out.startswith("v [km/h],t [min],s [ft],branch,arc,status\n36,")
    assert main(["sweep", *swept, "--over", "v=36:72:18km/h", "--resume", "-o", str(rows)]) == 2
    assert "E448" in capsys.readouterr().err


def test_a_column_of_another_kind_is_told(car: str, capsys: pytest.CaptureFixture[str]) -> None:
    rows = Path(car).with_name("rows.csv")
    rows.write_text("v [kg]\n3\n")
    assert main(["sweep", car, "--rows", str(rows)]) == 2
    assert "E461" in capsys.readouterr().err


def test_a_plot_names_the_units_that_it_shows(car: str) -> None:
    pytest.importorskip("matplotlib")
    picture = Path(car).with_name("plot.svg")
    over = ["--over", "v=36:72:18km/h", "--want", "t", "--unit", "t=min", "--plot", str(picture)]
    assert main(["sweep", car, *over]) == 0
    said = picture.read_text()
    assert "v [km/h]" in said
    assert "t [min]" in said
    assert {"0.10", "0.14", "40", "70"} <= set(re.findall(r"<text[^>]*>([0-9.]+)</text>", said))


def test_a_derivation_shows_both_units(car: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["why", car, "t", "--unit", "t=min"]) == 0
    said = capsys.readouterr().out
    assert "v = 20 m/s = 72 km/h" in said
    assert "t = s/v = 100/20 = 5 s = 0.08333333333 min" in said


def test_slopes_and_tolerances_are_shown_in_display_units(
    car: str, capsys: pytest.CaptureFixture[str]
) -> None:
    given = ["--unit", "Q=degF", "--tolerances", "--sensitivity", "--monte-carlo", "20"]
    assert main(["solve", car, *given]) == 0
    lines = capsys.readouterr().out.splitlines()
    rows = [line.split() for line in lines]
    assert ["68", "±", "1.8", "T", "degF"] in rows
    assert ["Q", "[degF]", "0", "0", "2"] in rows
    assert ["Q", "68", "±", "3.6", "±", "3.6", "degF", "T", "100", "%"] in rows
    assert rows[-1][-3:] == ["64.4", "to", "71.6"]
