"""Sheets of strangers: what they write reaches no spreadsheet, no terminal, no other file."""

from __future__ import annotations

import csv
import io
import os
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import rulesheets
import solver
from rulesheets.diagnosis import RuleSheetError, render
from rulesheets.inputs import guarded, unguarded
from rulesheets.variables import read_variable_sheet
from solver.__main__ import main
from solver.commands import WRONG
from solver.report.derivation import code_span, why, why_markdown
from solver.report.sheet import result_csv

SECRET = "hunter2"
Capture = pytest.CaptureFixture[str]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of a stranger's sheets beside a file that is not theirs."""
    inner = tmp_path / "inner"
    inner.mkdir()
    (tmp_path / "secret.txt").write_text(f"root:{SECRET}:0\n= {SECRET}\n")
    (tmp_path / "outer.tk").write_text("function f(a; b)\n  b = 2*a\n")
    (inner / "good.tk").write_text("function f(a; b)\n  b = 2*a\n")
    (inner / "link.tk").symlink_to("../secret.txt")
    (inner / "escape.tk").symlink_to("../outer.tk")
    (inner / "folder").symlink_to("..")
    monkeypatch.chdir(inner)
    return inner


def code(text: str, **options: str) -> str:
    with pytest.raises(RuleSheetError) as caught:
        rulesheets.loads(text, **options)
    said = "\n".join(map(render, caught.value.diagnoses))
    assert SECRET not in said
    return caught.value.diagnoses[0].code


# --- spreadsheets ---------------------------------------------------------------

cells = st.text(st.characters(codec="utf-8", exclude_categories=("Cs",)), max_size=8)


starts = st.sampled_from(["", "=", "+", "-", "@", "'=", "''-", "\t", "\r"])


@given(st.builds(str.__add__, starts, cells))
def test_a_cell_is_no_formula_and_is_read_again(text: str) -> None:
    cell = guarded(text)
    assert unguarded(cell) == text
    if cell[:1] in ("=", "+", "-", "@", "\t", "\r") and cell:
        float(cell.replace(",", "."))


@pytest.mark.parametrize("text", ["-3", "+.5", "-1e-300", "3", "'open", "", "focal length"])
def test_numbers_and_words_stay(text: str) -> None:
    assert guarded(text) == text


def test_a_variable_sheet_holds_no_formula(tmp_path: Path) -> None:
    rows = 'a = -3 ± 0.1  " =HYPERLINK("http://e")', 'b  " +1+2', "kind = 'open"
    model = rulesheets.loads("variables\n  " + "\n  ".join(rows) + "\nrules\n  b = 2*a\n")
    text = result_csv(solver.solve(model))
    for row in csv.reader(io.StringIO(text)):
        for cell in row:
            assert cell[:1] not in ("=", "+", "@", "\t", "\r"), cell
            assert not cell.startswith("-") or float(cell) < 0
    path = tmp_path / "again.csv"
    path.write_text(text)
    again = read_variable_sheet(path, model)
    assert again.inputs == {"a": -3.0, "b": None, "kind": "open"}
    assert again.tolerances["a"].size == 0.1


# --- terminals and pages --------------------------------------------------------


def test_escape_characters_of_a_path_are_printed_escaped(tmp_path: Path, capsys: Capture) -> None:
    sheet = tmp_path / "a\x1b]0;title\x07\nb\u202e.tk"
    sheet.write_text("rules\n  a = 3\n  a = 4\n  b = c +\n")
    out = tmp_path / "o\x1b[31m.csv"
    for words in (("solve", sheet), ("check", sheet), ("format", "--check", sheet)):
        main(tuple(map(str, words)))
    sheet.write_text("rules\n  a = 3\n  a = 4\n  b = a\n")
    for words in (
        ("solve", sheet, "--explain"),
        ("why", sheet, "b"),
        ("check", sheet),
        ("path", sheet),
        ("format", "--check", sheet),
        ("solve", sheet, "--clear", "x\x1b[31m"),
        ("solve", f"{sheet}\x1b"),
        ("sweep", sheet, "--over", "c=1:2:1", "-o", out),
        ("sweep\x1b[31m",),
    ):
        main(tuple(map(str, words)))
    said = capsys.readouterr()
    assert r"a\x1b]0;title\x07\nb\u202e" in said.err + said.out
    for text in (said.out, said.err):
        assert all(line.isprintable() for line in text.split("\n")), text


def test_markdown_shows_the_words_of_a_sheet_as_they_are() -> None:
    rows = 'a = 3  " *x* <script>alert(1)</script> [y](http://e)', "b"
    model = rulesheets.loads("variables\n  " + "\n  ".join(rows) + "\nrules\n  b = 2*a\n")
    text = why_markdown(why(solver.solve(model), "b"))
    outside = re.sub("`[^`]*`", "", text)
    for mark in ("<", ">", "[y", "*x"):
        assert outside.count(mark) == outside.count("\\" + mark) > 0
    assert code_span("m_`_") == "``m_`_``"
    assert code_span("`m") == "`` `m ``"


# --- other files ----------------------------------------------------------------


@pytest.mark.parametrize("path", ["../secret.txt", "link.tk", "folder/secret.txt"])
def test_a_file_that_is_no_rule_sheet_is_not_quoted(folder: Path, path: str) -> None:
    assert code(f'use "{path}"\na = 3\n') == "E312"


def test_a_used_file_of_assignments_is_not_quoted(folder: Path) -> None:
    (folder / "settings.env").write_text(f"KEY = {SECRET}\n")
    assert code('use "settings.env"\na = 3\n') == "E308"
    (folder / "settings.env").write_bytes(f"KEY = {SECRET} \xff\n".encode("latin-1"))
    assert code('use "settings.env"\na = 3\n') == "E303"


@pytest.mark.parametrize(
    "words",
    [
        ("solve", "../secret.txt"),
        ("check", "../secret.txt"),
        ("format", "link.tk"),
        ("solve", "good.tk", "../secret.txt"),
        ("sweep", "offset_slider_crank", "--rows", "../secret.txt"),
    ],
)
def test_the_command_quotes_no_other_file(
    folder: Path, words: tuple[str, ...], capsys: Capture
) -> None:
    assert main(words) == WRONG
    said = capsys.readouterr()
    assert said.err.startswith("error[")
    assert SECRET not in said.err + said.out


@pytest.mark.parametrize(
    "path",
    [
        "../outer.tk",
        "escape.tk",
        "link.tk",
        "folder/outer.tk",
        "../missing.tk",
        "/etc/passwd",
        "inner/../../x.tk",
    ],
)
def test_a_sheet_uses_no_file_outside_its_folder(folder: Path, path: str) -> None:
    assert code(f'use "{path}"\na = 3\n', within=str(folder)) == "E311"
    (folder / "main.tk").write_text(f'use "{path}"\na = 3\n')
    for _ in range(2):  # what was kept of a sheet that was read without bounds is no way round them
        with pytest.raises(RuleSheetError) as caught:
            rulesheets.load("main.tk", within=folder)
        assert [one.code for one in caught.value.diagnoses] == ["E311"]
        if path in ("../outer.tk", "escape.tk"):
            assert rulesheets.load("main.tk").variables


def test_a_sheet_uses_the_files_of_its_folder(folder: Path) -> None:
    (folder / "main.tk").write_text('use "good.tk"\nb = f(3)\n')
    model = rulesheets.load(folder / "main.tk", within=folder)
    assert solver.solve(model)["b"] == 6.0
    assert main(("solve", "main.tk", "--within", ".")) == 0
    assert main(("check", "main.tk", "--within", "..")) == 0


def test_the_sheet_itself_lies_in_the_folder(folder: Path) -> None:
    for path in ("../outer.tk", "escape.tk", "link.tk"):
        with pytest.raises(RuleSheetError) as caught:
            rulesheets.load(path, within=folder)
        assert caught.value.diagnoses[0].code == "E311"


def test_a_folder_is_no_prefix_of_a_name(folder: Path) -> None:
    (folder.parent / "inner2").mkdir()
    (folder.parent / "inner2" / "x.tk").write_text("function g(a; b)\n  b = a\n")
    assert code('use "../inner2/x.tk"\na = 3\n', within=str(folder)) == "E311"


# --- what never ends ------------------------------------------------------------


def test_a_pipe_is_no_sheet(folder: Path, capsys: Capture) -> None:
    os.mkfifo("pipe.tk")
    os.mkfifo("pipe.csv")
    os.mkfifo("pipe.parquet")
    pytest.importorskip("pyarrow")
    (folder / "uses.tk").write_text('use "pipe.tk"\na = 3\n')
    for words in (
        ("solve", "pipe.tk"),
        ("check", "/dev/zero"),
        ("solve", "uses.tk"),
        ("format", "pipe.tk"),
        ("solve", "good.tk", "pipe.csv"),
        ("sweep", "offset_slider_crank", "--rows", "pipe.csv"),
        ("sweep", "offset_slider_crank", "--rows", "pipe.parquet"),
    ):
        assert main(words) == WRONG
        assert "it is a pipe or a device" in capsys.readouterr().err, words


def test_a_dash_is_standard_input(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    text = 'use "good.tk"\nb = f(a)\n'
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(text.encode())))
    assert main(("solve", "-", "--set", "a=4")) == 0
    assert "8" in capsys.readouterr().out
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(b"a = 3 +\n")))
    assert main(("solve", "-")) == WRONG
    assert "--> standard input:1:" in capsys.readouterr().err


# --- decimal commas -------------------------------------------------------------


@pytest.mark.parametrize("separator", [";", "\t"])
def test_commas_are_decimal_between_semicolons(folder: Path, separator: str) -> None:
    rows = (("Name", "Input"), ("f", "49,5"), ("u", "1,2e2 ± 0,5%"))
    path = folder / "filled.csv"
    path.write_text("".join(separator.join(row) + "\n" for row in rows))
    model = rulesheets.loads("1/f = 1/u + 1/v")
    found = read_variable_sheet(path, model)
    assert found.inputs == {"f": 49.5, "u": 120.0}
    assert found.tolerances["u"].size == 0.5
    lines = [("f", "u"), ("50,5", "200"), ("-,5", "1,0E2")]
    path.write_text("".join(separator.join(line) + "\n" for line in lines))
    from solver.files.tables import pieces

    ((f, u),) = pieces(str(path), ("f", "u"))
    assert f.tolist() == [50.5, -0.5]
    assert u.tolist() == [200.0, 100.0]


def test_thousands_are_no_decimals(folder: Path) -> None:
    (folder / "filled.csv").write_text("Name;Input\nf;1.234,5\n")
    with pytest.raises(RuleSheetError) as caught:
        read_variable_sheet("filled.csv", rulesheets.loads("1/f = 1/u + 1/v"))
    assert caught.value.diagnoses[0].code == "E406"


def test_a_value_that_cannot_be_read_is_told_what_to_write(folder: Path, capsys: Capture) -> None:
    assert main(("solve", "offset_slider_crank", "--set", "AO=0,25")) == WRONG
    assert "= help: write 0.25" in capsys.readouterr().err
