"""A notebook with everything that shows itself, executed by a kernel, and what its cells hold
then."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any
from unittest.mock import patch

import pytest

import solver
from rulesheets import RuleSheetError

nbformat = pytest.importorskip("nbformat")
pytest.importorskip("nbclient")
pytest.importorskip("ipykernel")
pytest.importorskip("anywidget")

ROOT = Path(__file__).parents[3]

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
def notebook() -> Any:
    """The notebook, executed."""
    nbclient = pytest.importorskip("nbclient")
    cells = [nbformat.v4.new_code_cell(source) for source in CELLS]
    notebook = nbformat.v4.new_notebook(cells=cells)
    os.environ["PYTHONPATH"] = str(ROOT)
    nbclient.NotebookClient(
        notebook, timeout=120, allow_errors=True, kernel_name="python3"
    ).execute()
    return notebook


@pytest.fixture(scope="module")
def outputs(notebook: Any) -> list[dict[str, Any]]:
    """The one output of each cell: its data by type, or the error."""
    return [dict(cell.outputs[-1]) for cell in notebook.cells]


def html(output: dict[str, Any]) -> str:
    text = str(output["data"]["text/html"])
    assert "<script" not in text and text.count("<table") == text.count("</table>")
    return text


def plain(output: dict[str, Any]) -> str:
    return re.sub(r"\x1b\[[\d;]*m", "", "\n".join(output["traceback"]))


def test_a_model_shows_its_variables_and_its_rules(outputs: list[dict[str, Any]]) -> None:
    page = html(outputs[0])
    assert (
        "angular velocity of link AO" in page and "position.tk:" in page and "position.yB" in page
    )
    assert r"\begin{align*}" in outputs[0]["data"]["text/latex"]


def test_a_result_shows_its_variable_sheet_and_its_outputs_typeset(
    outputs: list[dict[str, Any]],
) -> None:
    assert "-30.03778545" in html(outputs[1]) and "53.12995837" in html(outputs[1])
    assert r"\theta_{AO} &= -30.03778545\ \text{deg}" in outputs[1]["data"]["text/latex"]


def test_a_table_shows_its_first_rows(outputs: list[dict[str, Any]]) -> None:
    assert html(outputs[2]).count("<tr>") == 61 and "84 more rows" in html(outputs[2])


def test_a_derivation_shows_inputs_steps_and_rules(outputs: list[dict[str, Any]]) -> None:
    page = html(outputs[3])
    assert "thetaAO = -30.03778545 deg" in page and "AB = 8" in page and "position.tk:" in page
    assert outputs[3]["data"]["text/latex"].startswith(r"\begin{align*}")


def test_a_path_and_sensitivities_are_tables(outputs: list[dict[str, Any]]) -> None:
    assert "together" in html(outputs[4])
    assert "thetaAO [deg]" in html(outputs[5])


def test_a_mistake_shows_its_line_and_a_caret(outputs: list[dict[str, Any]]) -> None:
    said = plain(outputs[6])
    assert re.search(r"^2 \| y = = x\n +\| +\^", said, re.MULTILINE) and "Traceback" not in said


def test_a_misspelt_name_is_told(outputs: list[dict[str, Any]]) -> None:
    assert "did you mean thetaAO?" in plain(outputs[7]) or "did you mean thetaAB?" in plain(
        outputs[7]
    )


def test_the_widget_is_one(outputs: list[dict[str, Any]]) -> None:
    assert "application/vnd.jupyter.widget-view+json" in outputs[8]["data"]


def test_a_refusal_shows_the_rule_with_a_caret(outputs: list[dict[str, Any]]) -> None:
    page = html(outputs[9])
    assert "inconsistent" in page and "S520" in page and "^" in page


def test_the_widget_holds_the_page_and_the_sheet(notebook: Any) -> None:
    """What the notebook keeps of it: the page's script, and what the page shows at first."""
    states = notebook.metadata["widgets"]["application/vnd.jupyter.widget-state+json"][
        "state"
    ].values()
    (state,) = [one["state"] for one in states if "opened" in one["state"]]
    assert state["_esm"] == (ROOT / "solver/page/static/widget.js").read_text(encoding="utf-8")
    assert [one["name"] for one in state["opened"]["sliders"]] == ["thetaAO"]
    assert len(state["opened"]["rules"]) > 30 and "call position" in state["opened"]["text"]


def asked(cell: Any, do: str, **more: object) -> dict[str, Any]:
    """What the kernel sends when the page asks."""
    sent: list[dict[str, Any]] = []
    with patch.object(cell, "send", sent.append):
        cell._heard(None, {"id": 7, "do": do, **more}, None)
    assert sent[0].pop("id") == 7
    return sent[0]


def test_the_widget_answers_as_a_solve_does() -> None:
    model = solver.load("offset_slider_crank")
    cell = solver.interact(model, {"thetaAO": range(-30, 31, 10)}, {"AB": 9})
    assert cell.inputs == {"AB": 9.0}
    expected = solver.solve(model, {"thetaAO": -20.0, "AB": 9.0})["xB"]
    reply = asked(cell, "solve", inputs={"thetaAO": -20.0, "AB": 9.0})
    assert reply["solutions"][0]["xB"] == expected
    frame = asked(cell, "frame", name="thetaAO", value=-20.0, inputs={"AB": 9.0}, near={})
    assert frame["values"]["xB"] == pytest.approx(expected, rel=1e-15)
    assert "values" not in asked(cell, "frame", name="AB", value=0.5, inputs={}, near={})


def test_the_widget_remembers_what_was_changed_in_it() -> None:
    cell = solver.interact(solver.loads("y = 2*x", name="double"), {"x": [1, 2, 3]})
    assert cell.inputs == {"x": 2.0}, "an unknown begins in the middle of its slider"
    doc = {"text": cell.text, "inputs": {"x": 3.0}, "guesses": {}, "near": None}
    assert asked(cell, "keep", state={"doc": doc, "view": {}}) == {}
    assert cell.inputs == {"x": 3.0} and cell.opened["kept"]["doc"] == doc


def test_a_text_can_be_changed_in_the_widget() -> None:
    cell = solver.interact(solver.loads("y = 2*x", name="double"))
    assert asked(cell, "check", text="y = = x")["wrong"][0]["code"] == "E104"
    assert asked(cell, "edit", text="y = = x")["wrong"] and cell.text == "y = 2*x"
    assert asked(cell, "edit", text="y = 3*x")["variables"] and cell.text == "y = 3*x"
    assert asked(cell, "solve", inputs={"x": 2.0})["solutions"] == [{"y": 6.0, "x": 2.0}]


def test_the_widget_refuses_what_it_does_not_know() -> None:
    cell = solver.interact(solver.loads("y = 2*x"))
    assert "failed" in asked(cell, "save") and "wrong" in asked(cell, "why", name="nobody")


def test_names_and_values_are_checked_before_there_is_a_widget() -> None:
    model = solver.load("offset_slider_crank")
    for over, inputs in (({"nobody": [1]}, {}), ({"AO": ["three"]}, {}), ({}, {"AO": "three"})):
        with pytest.raises(RuleSheetError):
            solver.interact(model, over, inputs)
