"""Reports on a terminal: they keep within its columns, and set off words where it can."""

from __future__ import annotations

import io
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import rulesheets
import solver
from rulesheets.diagnosis import render
from solver.__main__ import main
from solver.report import PLAIN, SCREEN, Screen, screen_of, table, width
from solver.report.derivation import why, why_text
from solver.report.sheet import result_text

SHEET = """\
variables
  a = 3 [mm]  " a comment that goes on and on until it reaches far beyond the last column of the screen
  x1    [mm]  " the first unknown
  x2
  x3
  x4
rules
  x1^2 = a
  x2^2 = a + 1
  x3^2 = a + 2
  x4^2 = x1 + 5
"""


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture(params=[40, 60, 80, 120])
def columns(request: pytest.FixtureRequest) -> Iterator[int]:
    before = SCREEN.set(Screen(request.param))
    yield request.param
    SCREEN.reset(before)


def lines(text: str) -> list[str]:
    return text.split("\n")


@pytest.mark.parametrize("every", [False, True])
@pytest.mark.parametrize(
    "sheet", [SHEET, SHEET.replace("a = 3", "a = -3"), SHEET.replace("a = 3", "a")]
)
def test_a_report_keeps_within_the_columns(columns: int, sheet: str, every: bool) -> None:
    result = solver.solve(rulesheets.loads(sheet))
    text = result_text(result, every=every)
    assert max(map(width, lines(text))) <= max(columns, 60)


def test_every_answer_is_there_on_a_narrow_screen(columns: int) -> None:
    result = solver.solve(rulesheets.loads(SHEET))
    assert len(result.solutions) == 16
    text = result_text(result, every=True)
    for name in ("x1", "x2", "x3", "x4"):
        (place,) = {line.index(name) for line in lines(text) if name in line and "Answer" in line}
        block = text[text.index(f" {name}") :].split("\n\n")[0].split("\n")[2:18]
        head = next(line for line in lines(text) if "Answer" in line and name in line)
        assert head[place : place + 2] == name
        assert len(block) == 16
    signs = {tuple(s[n] > 0 for n in ("x1", "x2", "x3", "x4")) for s in result.solutions}
    assert len(signs) == 16


def test_a_file_has_no_last_column() -> None:
    assert SCREEN.get() is PLAIN
    text = result_text(solver.solve(rulesheets.loads(SHEET)), every=True)
    assert "Output 16" in text
    assert "last column of the screen" in text


def test_sentences_are_folded(columns: int) -> None:
    (diagnosis,) = solver.solve(rulesheets.loads(SHEET.replace("a = 3", "a"))).diagnoses
    folded = render(diagnosis, width=columns)
    assert max(map(len, lines(folded))) <= columns
    assert re.sub(r"\s+", " ", folded) == re.sub(r"\s+", " ", render(diagnosis))


def test_cells_that_are_cut_say_so() -> None:
    before = SCREEN.set(Screen(20))
    text = table(("Name", "Comment"), [("a", "one two three four five")])
    SCREEN.reset(before)
    assert lines(text)[2] == "a     one two three…"


def test_a_terminal_sets_off_words(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("rich")
    monkeypatch.setenv("COLUMNS", "72")
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.delenv("NO_COLOR", raising=False)
    screen = screen_of(Terminal())
    assert screen.width == 72
    assert screen.paint("x", "bold") == "\x1b[1mx\x1b[0m"
    monkeypatch.setenv("NO_COLOR", "")
    assert screen_of(Terminal()).paint("x", "bold") == "x"
    monkeypatch.delenv("NO_COLOR")
    monkeypatch.setitem(sys.modules, "rich.style", None)
    assert screen_of(Terminal()).paint("x", "bold") == "x"


def test_a_pipe_has_the_columns_it_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("COLUMNS", raising=False)
    assert screen_of(io.StringIO()).width is None
    monkeypatch.setenv("COLUMNS", "80")
    assert screen_of(io.StringIO()).width == 80


def test_words_that_are_set_off_are_the_same_words() -> None:
    pytest.importorskip("rich")
    result = solver.solve(rulesheets.loads(SHEET))
    plain = result_text(result)
    before = SCREEN.set(Screen(None, True))
    painted = result_text(result)
    SCREEN.reset(before)
    assert "\x1b[1m1.732050808\x1b[0m" in painted
    assert re.sub(r"\x1b\[[0-9;]*m", "", painted) == plain


def test_a_chain_that_is_too_long_has_a_line_for_each_equal() -> None:
    sheet = rulesheets.loads("a = 3\nb = 4\nhypotenuse = sqrt(a^2 + b^2) + a*b/(a + b)")
    chain = why(solver.solve(sheet), "hypotenuse")
    assert (
        "sqrt(a^2 + b^2) + a*b/(a + b) = sqrt(3^2 + 4^2) + 3*4/(3 + 4) = 6.714285714"
        in why_text(chain)
    )
    before = SCREEN.set(Screen(60))
    text = why_text(chain)
    SCREEN.reset(before)
    assert "hypotenuse = sqrt(a^2 + b^2) + a*b/(a + b)\n              = sqrt(3^2" in text
    assert max(map(len, lines(text))) <= 60


def test_a_sweep_on_a_terminal_has_aligned_columns(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    sheet = tmp_path / "root.tk"
    sheet.write_text("y^2 = x\n")
    monkeypatch.setenv("NO_COLOR", "1")
    monkeypatch.setattr(sys, "stdout", terminal := Terminal())
    assert main(["sweep", str(sheet), "--over", "x=-1,2,4", "--want", "y"]) == 1
    assert lines(terminal.getvalue()) == [
        "x   y            answers  status",
        "--  -----------  -------  ----------",
        "-1               0        infeasible",
        "2   1.414213562  2        solved",
        "4   2            2        solved",
        "",
    ]
