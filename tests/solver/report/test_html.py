"""What a notebook shows, and tables as data frames."""

from __future__ import annotations

from collections.abc import Callable
from html.parser import HTMLParser

import numpy as np
import pytest

import rulesheets
import solver
from solver.report.sheet import result_text

MODEL = solver.loads(
    'variables\n f = 50 [mm] " <b>focal</b>\n u = 200 [mm]\n v [mm -> cm]\nrules\n 1/f = 1/u + 1/v'
)


class Cells(HTMLParser):
    """The texts of a page, tag by tag; whatever is not closed shows."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.texts: list[str] = []
        self.open: list[str] = []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        assert tag != "script"
        self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


def test_a_result_is_its_variable_sheet() -> None:
    texts = Cells(solver.solve(MODEL)._repr_html_()).texts
    assert "6.666666667" in texts
    assert "cm" in texts
    assert "<b>focal</b>" in texts


def test_a_refusal_says_why() -> None:
    texts = Cells(solver.solve(MODEL, {"v": 60.0})._repr_html_()).texts
    assert "inconsistent" in texts
    assert any("contradict" in text for text in texts)


def test_a_table_shows_its_first_rows() -> None:
    table = solver.sweep(MODEL, {"u": np.linspace(100.0, 200.0, 100)}, want=["v"])
    texts = Cells(table._repr_html_()).texts
    assert texts.count("solved") == 60
    assert "… 40 more rows" in texts


def test_tables_become_data_frames_and_come_back() -> None:
    pytest.importorskip("pandas")
    table = solver.sweep(MODEL, {"u": [100.0, 200.0]}, want=["v"])
    frame = table.to_pandas()
    assert list(frame["status"]) == ["solved", "solved"]
    again = solver.sweep(MODEL, frame[["u"]], want=["v"])
    assert again["v"].tolist() == frame["v"].tolist() == table["v"].tolist()


def test_polars_too() -> None:
    polars = pytest.importorskip("polars")
    table = solver.sweep(MODEL, polars.DataFrame({"u": [100.0, 200.0]}), want=["v"])
    assert table.to_polars()["v"].to_list() == table["v"].tolist()


@pytest.mark.parametrize("there", [solver.solve(MODEL), solver.solve(MODEL).solutions[0]])
def test_a_slip_in_a_name_says_what_may_be_meant(there: object) -> None:
    model = solver.loads("eta = 0.5*x\nx = 1")
    with pytest.raises(KeyError, match="did you mean eta"):
        solver.solve(model)["etaa"]
    with pytest.raises(KeyError, match="there is no variable w"):
        there["w"]  # type: ignore[index]


def test_print_shows_what_the_command_shows() -> None:
    model = rulesheets.loads("variables\n  a = 3\n  b\nrules\n  b = 2*a")
    result = solver.solve(model)
    assert str(result) == result_text(result)
    assert repr(result) == "<Result solved, 1 answer: b = 6>"
    assert str(solver.why(result, "b")).startswith("b = 6, from 1 input by 1 of 1 rule")
    assert str(result.path).splitlines()[2].split() == ["1", "b", "1"]
    assert str(result.sensitivity()).splitlines()[-1].split() == ["b", "2"]
    bands = result.tolerance_bands({"a": 0.1})
    assert "± 0.2" in str(bands) and "± 0.2" in bands._repr_html_()
    table = str(solver.sweep(model, {"a": range(100)})).splitlines()
    assert table[2].split() == ["0", "0", "1", "solved"]
    assert table[-1] == "… 40 more rows"


@pytest.mark.parametrize(
    "call", [lambda one: solver.why(one, "b"), solver.monte_carlo, solver.draw]
)
def test_a_model_is_no_result(call: Callable[[object], object]) -> None:
    with pytest.raises(TypeError, match=r"which solver\.solve gives"):
        call(rulesheets.loads("b = 2*a"))
