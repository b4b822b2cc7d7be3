"""The command as a person and a script meet it: output, exit codes, and never a traceback."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

import pytest

from solver.__main__ import BROKEN_PIPE, COMMANDS, INTERRUPTED
from tests.solver.conftest import Run

ROOT = Path(__file__).parents[3]

TRIANGLE = """\
" A right triangle
variables
  a = 3 [mm]  " one leg
  b = 4 [mm]  " the other leg
  c > 0 [mm]  " hypotenuse
  kind = 'right
rules
  c^2 = a^2 + b^2
"""


@pytest.fixture
def sheet(tmp_path: Path) -> str:
    file = tmp_path / "triangle.tk"
    file.write_text(TRIANGLE)
    return str(file)


def value(out: str, name: str) -> str:
    """The word after the first mention of a name in a printed variable sheet."""
    line = next(line for line in out.splitlines() if name in line.split()[:3])
    words = line.split()
    return words[words.index(name) + 1]


# --- solving --------------------------------------------------------------------


def test_the_published_slider_crank(run: Run) -> None:
    code, out, err = run("solve", "offset_slider_crank")
    assert (code, err) == (0, "")
    published = {"xB": 9.79, "vB": -41.46, "omegaAB": 5.42, "aB": -709.1, "alphaAB": -29.03}
    for name, printed in published.items():
        digits = len(str(printed).partition(".")[2])
        assert round(float(value(out, name)), digits) == printed


def test_a_sheet_of_direct_steps_loads_no_heavy_package() -> None:
    code = (
        "import sys; from solver.__main__ import main; main(['solve', 'offset_slider_crank'])\n"
        "heavy = {'sympy', 'pint', 'rich', 'matplotlib'} & set(sys.modules)\n"
        "sys.exit(' '.join(heavy) or 0)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_any_number_is_the_crossed_branch(run: Run) -> None:
    code, out, _ = run("solve", "offset_slider_crank", "--set", "branch=0")
    assert code == 0
    assert float(value(out, "xB")) == pytest.approx(-4.595671074)


def test_a_sheet_solves_backwards(run: Run, sheet: str) -> None:
    code, out, _ = run("solve", sheet, "--clear", "a", "--set", "c=5", "--guess", "a=-1")
    assert code == 0
    assert value(out, "a") == "-3"
    assert "1 other answer: --all shows it" in out


def test_all_answers_side_by_side(run: Run, sheet: str) -> None:
    code, out, _ = run("solve", sheet, "--clear", "a", "--set", "c=5", "--all")
    assert code == 0
    assert "Output 1" in out and "Output 2" in out
    (row,) = (line for line in out.splitlines() if line.split()[:1] == ["a"])
    assert sorted(row.split()[1:3]) == ["-3", "3"]


def test_a_unit_that_is_the_variables_own(run: Run, sheet: str) -> None:
    assert value(run("solve", sheet, "--set", "a=2*2.5 [mm]", "--set", "b=12")[1], "c") == "13"


def test_want_asks_for_no_more(run: Run) -> None:
    code, out, _ = run("solve", "offset_slider_crank", "--want", "xB,position.yA")
    assert code == 0
    assert value(out, "position.yA") == "-1.5"
    assert "vB" not in out


def test_a_variable_sheet_fills_in(run: Run, sheet: str, tmp_path: Path) -> None:
    inputs = tmp_path / "inputs.csv"
    inputs.write_text("Name,Input\na,\nc,13\nb,12\n")
    code, out, _ = run("solve", sheet, str(inputs))
    assert code == 0
    assert abs(float(value(out, "a"))) == 5


def test_a_variable_sheet_beside_the_model_needs_no_path(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    code, out, _ = run(
        "solve", "offset_slider_crank", "slider_driven.csv", "--want", "thetaAO", "--all"
    )
    assert code == 0
    assert (
        abs(float(value(out, "thetaAO")) + 30) < 0.1
    )  # the slider at 9.79, two digits of where -30 puts it
    Path("slider_driven.csv").write_text("Name,Input\nthetaAO,90\n")
    code, out, _ = run("solve", "offset_slider_crank", "slider_driven.csv", "--want", "xB")
    assert (code, value(out, "xB")) == (0, "7.937253933")


def test_a_variable_sheet_that_is_nowhere(run: Run) -> None:
    code, _, err = run("solve", "offset_slider_crank", "slider_drive.csv")
    assert code == 2
    assert "error[E310]: there is no variable sheet slider_drive.csv" in err
    assert "did you mean slider_driven.csv?" in err
    _, _, err = run("sweep", "offset_slider_crank", "thetaAO=0:90:30")
    assert "did you mean --over thetaAO=0:90:30?" in err


def test_a_sheet_without_a_command_and_an_input_without_its_value(run: Run, sheet: str) -> None:
    code, _, err = run(sheet)
    assert code == 2
    assert f"did you mean backsolve solve {sheet}?" in err
    code, _, err = run("solve", "offset_slider_crank", "--set", "AO", "5")
    assert code == 2
    assert "write --set NAME=VALUE, such as --set AO=3" in err
    code, _, err = run("solve", "offset_slider_crank", "--want", "zzz")
    assert code == 2
    assert "its variables are branch, AO, AB, offset, " in err


def test_options_may_stand_anywhere(run: Run, sheet: str, tmp_path: Path) -> None:
    inputs = tmp_path / "inputs.csv"
    inputs.write_text("Name,Input\nb,12\n")
    assert value(run("solve", sheet, "--set", "a=5", str(inputs))[1], "c") == "13"


@pytest.mark.parametrize(
    ("words", "status"),
    [
        (["--clear", "a"], "partial"),
        (["--set", "c=5"], "solved"),
        (["--set", "c=6"], "inconsistent"),
        (["--clear", "a", "--set", "c=3"], "infeasible"),
    ],
)
def test_the_exit_code_says_whether_it_is_solved(
    run: Run, sheet: str, words: list[str], status: str
) -> None:
    code, out, _ = run("solve", sheet, *words, "--json")
    assert json.loads(out)["status"] == status
    assert code == (0 if status == "solved" else 1)
    assert run("solve", sheet, *words)[0] == code


def test_the_json_of_the_contract(run: Run, sheet: str) -> None:
    code, out, err = run("solve", sheet, "--json")
    found = json.loads(out)
    assert (code, err) == (0, "")
    assert found["solutions"] == [{"a": 3, "b": 4, "c": 5, "kind": "right"}]
    assert found["complete"] is True
    assert found["path"][0]["unknowns"] == ["c"]


def test_what_is_written_reads_back(run: Run, sheet: str, tmp_path: Path) -> None:
    file = tmp_path / "out.csv"
    words = ("--set", "a=0.1", "--set", "b=0.2")
    _, out, _ = run("solve", sheet, *words, "--csv", "-o", str(file))
    assert file.read_text() == out
    assert run("solve", sheet, str(file), "--csv")[1] == out


def test_explain_shows_locals_and_path(run: Run) -> None:
    out = run("solve", "offset_slider_crank", "--explain")[1]
    assert float(value(out, "position.yA")) == pytest.approx(-1.5)
    assert ["velocity.tk:10", "vB", "=", "xb"] in [line.split()[2:] for line in out.splitlines()]
    assert " rules." in out


def test_output_is_the_same_twice(run: Run) -> None:
    words = ("solve", "offset_slider_crank", "--explain", "--json")
    assert run(*words) == run(*words)


# --- what is wrong --------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        (["--set", "kindd='left"], "E407", "did you mean kind?"),
        (["--clear", "kindd"], "E407", "did you mean kind?"),
        (["--want", "a,kindd"], "E407", "did you mean kind?"),
        (["--guess", "kindd=1"], "E407", "did you mean kind?"),
        (["--set", "a=abc+"], "E406", "abc+"),
        (["--set", "a="], "E406", "value"),
        (["--set", "a=1e999"], "E4", "finite"),
        (["--set", "c=-1"], "E4", "c"),
        (["--set", "a"], "E420", "--set NAME=VALUE"),
        (["--set", "=3"], "E420", "--set NAME=VALUE"),
        (["--set", "a=1,c=2"], "E420", "write --set a=1 --set c=2"),
        (["--set", "a=1", "--set", "a=2"], "E421", "a is given twice"),
        (["--set", "a=1", "--clear", "a"], "E421", "a is given twice"),
        (["--set", "a=1 [kg]"], "E461", "give a in mm"),
        (["--set", "kind='left [mm]"], "E406", "a symbol has no unit"),
        (["--guess", "a=1"], "E423", "add --clear a"),
        (["--guess", "c='large"], "E423", "symbol"),
    ],
)
def test_a_wrong_option_is_shown_with_its_cure(
    run: Run, sheet: str, words: list[str], code: str, says: str
) -> None:
    exit_code, out, err = run("solve", sheet, *words)
    assert (exit_code, out) == (2, "")
    assert f"error[{code}" in err
    assert says in err


def test_a_local_is_named_in_full(run: Run) -> None:
    code, _, err = run("solve", "offset_slider_crank", "--want", "yB")
    assert code == 2
    assert "position.yB" in err


def test_every_mistake_is_told_at_once(run: Run, sheet: str) -> None:
    _, _, err = run("solve", sheet, "--set", "x=1", "--want", "y")
    assert "--set x=1" in err and "--want y" in err


def test_a_wrong_sheet_in_json_is_an_object_too(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "wrong.tk"
    file.write_text("a = (b\n")
    code, out, err = run("solve", str(file), "--json")
    assert code == 2
    assert json.loads(out)["status"] == "error"
    assert json.loads(out)["diagnoses"][0]["rules"][0]["line"] == 1
    assert "wrong.tk:1:" in err


@pytest.mark.parametrize("command", ["solve", "check", "path", "format"])
def test_a_sheet_that_cannot_be_read(run: Run, command: str, tmp_path: Path) -> None:
    binary = tmp_path / "binary.tk"
    binary.write_bytes(bytes(range(256)))
    for path in (str(tmp_path / "missing.tk"), str(tmp_path), str(binary), "no_such_model"):
        code, out, err = run(command, path)
        assert (code, out) == (2, "")
        assert err.startswith("error[E3")


def test_a_file_that_cannot_be_written(run: Run, sheet: str, tmp_path: Path) -> None:
    code, _, err = run("solve", sheet, "-o", str(tmp_path / "missing" / "out.csv"))
    assert code == 2
    assert "E416" in err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("solve", "--wnat", "c"), "there is no option --wnat\n  did you mean --want?"),
        (("sweep", "--ovr=a=1:2:1"), "there is no option --ovr\n  did you mean --over?"),
        (("solve", "--set", "a=6cmm"), "no unit is called cmm"),
        (("solve", "--set", "a=-2.5e3 rad/s"), "rad/s measures something else"),
        (("solve", "--set", "a=2b*3"), "2b*3 is not a value: a product needs a `*`"),
    ],
)
def test_a_slip_of_the_pen_comes_with_its_cure(
    run: Run, sheet: str, words: tuple[str, ...], said: str
) -> None:
    code, out, err = run(words[0], sheet, *words[1:])
    assert (code, out) == (2, "")
    assert said in err


def test_unknown_commands_and_options(run: Run, sheet: str) -> None:
    assert run("solv", sheet)[0] == 2
    assert "did you mean solve?" in run("solv", sheet)[2]
    assert run("solve", sheet, "--al")[0] == 2
    assert run("solve")[0] == 2
    assert run()[0] == 2


# --- the other commands ---------------------------------------------------------


def test_check_says_what_a_sheet_has(run: Run, sheet: str) -> None:
    assert run("check", sheet) == (0, "triangle: 4 variables, 1 rule; nothing wrong\n", "")
    assert "c^2 = a^2 + b^2" in run("check", sheet, "--equations")[1]
    assert "c^{2}" in run("check", sheet, "--latex")[1]


def test_path_shows_rules_with_their_places(run: Run, sheet: str) -> None:
    code, out, _ = run("path", sheet)
    assert code == 0
    assert "triangle.tk:8  c^2 = a^2 + b^2" in out
    code, out, _ = run("path", sheet, "--clear", "a")
    assert code == 1
    assert "Not reached: a, c." in out


def test_format_prints_checks_and_writes(run: Run, sheet: str) -> None:
    code, canonical, _ = run("format", sheet)
    assert code == 0
    assert run("format", sheet, "--check")[0] == 1
    assert run("format", sheet, "-i") == (0, "", "")
    assert Path(sheet).read_text() == canonical
    assert run("format", sheet, "--check") == (0, "", "")


def test_sweep_prints_a_row_a_value(run: Run, sheet: str, tmp_path: Path) -> None:
    words = ("sweep", sheet, "--over", "a=0:1:0.25", "--set", "b=0", "--want", "c")
    code, out, err = run(*words)
    rows = [line.split(",") for line in out.splitlines()]
    assert rows[0] == ["a", "c", "answers", "status"]
    assert [row[0] for row in rows[1:]] == ["0", "0.25", "0.5", "0.75", "1"]
    assert rows[-1] == ["1", "1", "1", "solved"]
    assert rows[1][2:] == ["0", "infeasible"]  # c > 0
    assert code == 1
    assert err.startswith("5 rows: 4 solved")
    file = tmp_path / "table.csv"
    assert run(*words, "-o", str(file))[1] == ""
    assert file.read_text() == out


def test_ranges_of_a_sweep_are_decimal(run: Run, sheet: str) -> None:
    out = run("sweep", sheet, "--over", "a=0.1:0.3:0.1", "--over", "b=2:1:-1", "--want", "c")[1]
    pairs = [tuple(line.split(",")[:2]) for line in out.splitlines()[1:]]
    assert pairs == [(a, b) for a in ("0.1", "0.2", "0.3") for b in ("2", "1")]


@pytest.mark.parametrize(
    "stretch",
    [
        "a",
        "a=",
        "a=1:2",
        "a=1,",
        "a=1:2:0",
        "a=1:2:-1",
        "a=0:1:1e-13",
        "a=0:1e309:1e308",
        "z=1:2:1",
    ],
)
def test_a_wrong_range_of_a_sweep(run: Run, sheet: str, stretch: str) -> None:
    code, out, err = run("sweep", sheet, "--over", stretch)
    assert (code, out) == (2, "")
    assert err.startswith("error[E4")


def test_models_are_listed_with_their_titles(run: Run) -> None:
    code, out, _ = run("models")
    assert code == 0
    assert "offset_slider_crank " in out
    assert "Offset slider crank (Boyle & Liu 1996)" in out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("solve",), "backsolve solve: the following arguments are required: SHEET"),
        (("solve", "a.tk", "b.csv", "c"), "backsolve solve: unrecognized arguments: c"),
        (("solve", "a.tk", "--want"), "backsolve solve: argument --want: expected one argument"),
        (("solve", "a.tk", "--version"), "backsolve solve: there is no option --version"),
    ],
)
def test_misused_words_are_told_in_a_line(run: Run, words: tuple[str, ...], said: str) -> None:
    hint = "  `backsolve solve --help` lists the options\n"
    assert run(*words) == (2, "", f"{said}\n{hint}")


def test_an_option_spelt_wrong_is_guessed_by_its_letters(run: Run) -> None:
    assert "  did you mean --want?\n" in run("solve", "a.tk", "--wnat", "v")[2]


@pytest.mark.parametrize(
    ("name", "note"),
    [
        ("cranc.tk", "did you mean crank.tk?"),
        ("crank", "did you mean crank.tk?"),
        ("nowhere/crank.tk", "there is no folder nowhere either"),
        (".", "name a file in it; a folder is a sheet where it holds a model.tk"),
    ],
)
def test_a_sheet_that_is_not_there(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, note: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("crank.tk").write_text("x = 1\n", encoding="utf-8")
    code, out, err = run("solve", name)
    assert (code, out) == (2, "")
    assert err.endswith(f"\n  = help: {note}\n")


# --- the process ----------------------------------------------------------------


@pytest.mark.parametrize(
    ("helped", "heavy"), [([], {"numpy", "sympy"}), (COMMANDS, {"sympy", "matplotlib"})]
)
def test_help_waits_for_no_heavy_library(helped: Iterable[str], heavy: set[str]) -> None:
    """That of the whole does not wait for numpy, those of the commands not for sympy."""
    asked = [[name, "--help"] for name in helped] or [["--help"]]
    code = f"import sys; from solver.__main__ import main; [main(words) for words in {asked!r}]"
    code += f"; print({heavy!r} & {{*sys.modules}})"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[-1] == "set()"
    assert done.stdout.count("usage: backsolve") == len(asked)


def test_a_reader_that_leaves_is_no_error() -> None:
    process = subprocess.Popen(
        [sys.executable, "-m", "solver", "models"],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )
    assert process.stdout is not None and process.stderr is not None
    process.stdout.close()
    assert process.stderr.read() == b""
    process.stderr.close()
    assert process.wait() == BROKEN_PIPE


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is full")
def test_a_full_disk_is_told() -> None:
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "solver", "models"],
            cwd=ROOT,
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert done.returncode == 2
    assert done.stderr.startswith("error: the output cannot be written: ")
    assert len(done.stderr.splitlines()) == 1


def test_an_interrupt_ends_quietly(run: Run, sheet: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("solver.commands.solve.solve", interrupted)
    assert run("solve", sheet) == (INTERRUPTED, "", "interrupted\n")


def test_a_terminal_without_the_characters_shows_marks(tmp_path: Path) -> None:
    file = tmp_path / "a.tk"
    file.write_text('variables\n  a = 1 " größe\nrules\n  a = b\n', encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "solver", "solve", str(file)],
        cwd=ROOT,
        capture_output=True,
        env={**os.environ, "PYTHONIOENCODING": "ascii"},
        check=True,
    )
    assert b"gr??e" in done.stdout
    assert done.stderr == b""
