"""Display units chosen for a solve: one by one, or a system."""

from __future__ import annotations

import json

import pytest

import rulesheets
from rulesheets import RuleSheetError
from rulesheets.units import convert, library
from rulesheets.units.display import SYSTEMS, with_display_unit, with_display_units
from solver.cli import main

SHEET = "variables\n v = 10 [m/s]\n T = 20 [degC]\n M = 5 [N-m]\n E = 3 [kJ]\n n = 2\nrules\n x = v*n\n"


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


def test_a_solve_warns_of_units_and_keeps_its_status(tmp_path, capsys: pytest.CaptureFixture[str]) -> None:
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
