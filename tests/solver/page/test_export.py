"""Exported pages: what they hold is what a solve says, and no word of a sheet can run."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

import rulesheets
import solver
from solver.__main__ import main
from solver.page.description import STATES, export


def document(page: str) -> dict[str, Any]:
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)
    assert found is not None
    return dict(json.loads(found[1]))


def test_every_state_is_what_a_solve_gives() -> None:
    model = rulesheets.load("offset_slider_crank")
    angles: list[float | str] = [-170.0, -30.0, 5.0, 80.0]
    axes: dict[str, list[float | str]] = {"branch": ["open", "crossed"], "thetaAO": angles}
    data = document(export(model, {}, {}, axes)[0])
    names = [one["name"] for one in data["variables"]]
    states = [(branch, angle) for branch in axes["branch"] for angle in angles]
    for (branch, angle), values in zip(states, data["values"], strict=True):
        result = solver.solve(model, {"branch": branch, "thetaAO": angle})
        for name in ("xB", "vB", "aB", "omegaAB", "alphaAB"):
            assert values[names.index(name)] == pytest.approx(result[name], rel=1e-7)


def test_a_state_without_an_answer_holds_nothing() -> None:
    model = rulesheets.load("offset_slider_crank")
    page, states, solved = export(model, {"thetaAO": None}, {}, {"xB": [9.0, 10.0, 11.0, 12.0]})
    data = document(page)
    assert (states, solved) == (4, 2)
    assert [values is None for values in data["values"]] == [False, False, True, True]


def test_without_ranges_the_driver_of_the_figures_has_the_slider() -> None:
    data = document(export(rulesheets.load("offset_slider_crank"), {}, {}, {})[0])
    assert [axis["name"] for axis in data["axes"]] == ["thetaAO"]
    (axis,) = data["axes"]
    assert axis["values"][axis["at"]] == -30.0
    assert max(axis["values"]) - min(axis["values"]) == 360.0


def test_words_of_a_sheet_do_not_run() -> None:
    """A comment that closes the script is text; the policy allows the page's own script alone."""
    text = 'variables\n  a = 1  " </script><script>alert(1)</script><!--\n  b\nrules\n  b = 2*a\n'
    page = export(rulesheets.loads(text, name="<b>x</b>"), {}, {}, {"a": [1.0, 2.0]})[0]
    assert page.count("</script>") == 2 and "alert(1)</script>" not in page and "<b>" not in page
    assert "\\u003c/script>" in page
    assert re.search(r"script-src 'sha256-[\w+/=]{44}'", page)


@pytest.mark.parametrize(
    "axes",
    [
        {name: [1.0, 2.0] for name in ("AO", "AB", "offset", "thetaAO")},
        {"thetaAO": [k / 100 for k in range(STATES + 1)]},
    ],
)
def test_what_is_too_much_for_a_page_is_refused(axes: dict[str, list[float | str]]) -> None:
    with pytest.raises(rulesheets.RuleSheetError) as refused:
        export(rulesheets.load("offset_slider_crank"), {}, {}, axes)
    assert refused.value.diagnoses[0].code == "E445"


def test_the_command_writes_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "lens.tk"
    file.write_text("variables\n  f = 50\n  u = 200\n  v\nrules\n  1/f = 1/u + 1/v\n")
    page = tmp_path / "lens.html"
    assert main(["export", str(file), "--over", "u=40:60:5", "-o", str(page)]) == 0
    assert capsys.readouterr().out == f"{page}: 4 of 5 states solved\n"
    assert document(page.read_text())["given"] == ["f", "u"]


def test_values_are_exported_in_the_units_shown() -> None:
    sheet = "variables\n  Q = 0.01 [m^3/s -> L/s]\n  P [W -> kW]\nrules\n  P = 196200*Q\n"
    data = document(export(rulesheets.loads(sheet), {}, {}, {"Q": [0.01, 0.02]})[0])
    assert data["axes"][0]["values"] == [10, 20]
    assert [(one["name"], one["unit"]) for one in data["variables"]] == [("Q", "L/s"), ("P", "kW")]
    assert data["values"] == [[10, 1.962], [20, 3.924]]


def test_a_page_begins_at_the_values_of_the_sheet() -> None:
    sheet = "variables\n  a = 3\n  b = 4\n  r\nrules\n  r = a*b\n"
    for axis in document(export(rulesheets.loads(sheet), {}, {}, {})[0])["axes"]:
        assert axis["values"][axis["at"]] == {"a": 3, "b": 4}[axis["name"]]
