"""A notebook with everything that shows itself, executed by a kernel, and what its cells hold then."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

import pytest

import solver
from rulesheets import RuleSheetError

nbformat = pytest.importorskip("nbformat")
pytest.importorskip("nbclient")
pytest.importorskip("ipykernel")
pytest.importorskip("anywidget")

ROOT = Path(__file__).parents[2]

CELLS = (
    "import solver\nmodel = solver.load('offset_slider_crank')\nmodel",
    "result = solver.solve(model, {'thetaAO': None, 'xB': 9.79})\nresult",
    "solver.sweep(model, {'thetaAO': range(0, 720, 5)}, want=['xB'])",
    "solver.why(result, 'thetaAO')",
    "result.path",
    "result.sensitivity(['thetaAO'], ['xB', 'AO'])",
    "solver.loads('x = 2\\ny = = x')",
    "result['thetaBO']",
    "solver.interact(model, {'thetaAO': [-30.0, -20.0, -10.0]})",
    "solver.solve(model, {'xB': 9.0})",
)


@pytest.fixture(scope="module")
def outputs() -> list[dict[str, Any]]:
    """The one output of each cell: its data by type, or the error."""
    nbclient = pytest.importorskip("nbclient")
    cells = [nbformat.v4.new_code_cell(source) for source in CELLS]
    notebook = nbformat.v4.new_notebook(cells=cells)
    os.environ["PYTHONPATH"] = str(ROOT)
    nbclient.NotebookClient(notebook, timeout=120, allow_errors=True, kernel_name="python3").execute()
    return [dict(cell.outputs[-1]) for cell in notebook.cells]


def html(output: dict[str, Any]) -> str:
    text = str(output["data"]["text/html"])
    assert "<script" not in text and text.count("<table") == text.count("</table>")
    return text


def plain(output: dict[str, Any]) -> str:
    return re.sub(r"\x1b\[[\d;]*m", "", "\n".join(output["traceback"]))


def test_a_model_shows_its_variables_and_its_rules(outputs: list[dict[str, Any]]) -> None:
    page = html(outputs[0])
    assert "angular velocity of link AO" in page and "position.tk:" in page and "position.yB" in page
    assert r"\begin{align*}" in outputs[0]["data"]["text/latex"]


def test_a_result_shows_its_variable_sheet_and_its_outputs_typeset(outputs: list[dict[str, Any]]) -> None:
    assert "-30.03778545" in html(outputs[1]) and "53.12995837" in html(outputs[1])
    assert r"\theta_{AO} &= -30.03778545\ \text{deg}" in outputs[1]["data"]["text/latex"]


def test_a_table_shows_its_first_rows(outputs: list[dict[str, Any]]) -> None:
    assert html(outputs[2]).count("<tr>") == 61 and "84 more rows" in html(outputs[2])
    assert outputs[2]["data"]["text/latex"].startswith(r"\begin{array}{rrrr}")


def test_a_derivation_shows_inputs_steps_and_rules(outputs: list[dict[str, Any]]) -> None:
    page = html(outputs[3])
    assert "thetaAO = -30.03778545 deg" in page and "AB = 8" in page and "position.tk:" in page
    assert outputs[3]["data"]["text/latex"].startswith(r"\begin{align*}")


def test_a_path_and_sensitivities_are_tables(outputs: list[dict[str, Any]]) -> None:
    assert "together" in html(outputs[4])
    assert "thetaAO [deg]" in html(outputs[5])
    assert all(r"\hline" in outputs[k]["data"]["text/latex"] for k in (4, 5))


def test_a_mistake_shows_its_line_and_a_caret(outputs: list[dict[str, Any]]) -> None:
    said = plain(outputs[6])
    assert re.search(r"^2 \| y = = x\n +\| +\^", said, re.MULTILINE) and "Traceback" not in said


def test_a_misspelt_name_is_told(outputs: list[dict[str, Any]]) -> None:
    assert "did you mean thetaAO?" in plain(outputs[7]) or "did you mean thetaAB?" in plain(outputs[7])


def test_the_widget_is_one(outputs: list[dict[str, Any]]) -> None:
    assert "application/vnd.jupyter.widget-view+json" in outputs[8]["data"]


def test_a_refusal_shows_the_rule_with_a_caret(outputs: list[dict[str, Any]]) -> None:
    page = html(outputs[9])
    assert "inconsistent" in page and "S520" in page and "^" in page


def test_a_state_of_the_widget_is_what_a_solve_gives() -> None:
    model = solver.load("offset_slider_crank")
    cell = solver.interact(model, {"thetaAO": [-30.0, -20.0], "AB": [8.0, 9.0]})
    sent: list[Any] = []
    cell.send = sent.append
    cell._moved(None, {"places": [1, 1]}, None)
    names = [one["name"] for one in cell.data["variables"]]
    expected = solver.solve(model, {"thetaAO": -20.0, "AB": 9.0})["xB"]
    assert sent[0]["state"]["values"][names.index("xB")] == pytest.approx(expected, rel=1e-7)
    cell.send = sent.append
    unreachable = solver.interact(model, {"AB": [8.0, 0.5]})
    assert unreachable.data["state"] is not None and unreachable._state([1]) is None


def test_more_sliders_than_there_is_room_for_are_refused() -> None:
    model = solver.load("offset_slider_crank")
    with pytest.raises(RuleSheetError, match="3 sliders at most, and 4"):
        solver.interact(model, {name: [1.0, 2.0] for name in ("thetaAO", "AO", "AB", "offset")})
