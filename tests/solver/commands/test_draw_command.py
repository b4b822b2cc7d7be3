"""``backsolve draw``: pictures and films as files, and every refusal."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import pytest

from solver.__main__ import main
from solver.pictures import PICTURES, picture_kind

pytest.importorskip("matplotlib")

CRANK = """\
variables
  r = 2 > 0
  l = 5 > 0
  theta = 40
  x
  w
rules
  (x - r*cosd(theta))^2 + (r*sind(theta))^2 = l^2
figure position
  pin O = (0, 0)
  point A = (r*cosd(theta), r*sind(theta))
  point B = (x, 0)
  line (O, A, B)
  slider (B, 0)
figure speed
  pole o = (0, 0)
  point b = (w, 0)
  vector (o, b)
"""

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """``backsolve draw crank.tk …`` in an empty folder: exit code, standard output, standard
    error."""
    monkeypatch.chdir(tmp_path)
    Path("crank.tk").write_text(CRANK)

    def run(*words: str, sheet: str = "crank.tk") -> tuple[int, str, str]:
        code = main(["draw", sheet, *words])
        out, err = capsys.readouterr()
        return code, out, err

    return run


def pictures() -> set[str]:
    return {file.name for file in Path().iterdir()} - {"crank.tk"}


@pytest.mark.parametrize(
    ("kind", "begin"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")]
)
def test_a_picture(run: Run, kind: str, begin: bytes) -> None:
    assert run("--figure", "position", "-o", f"a.{kind}") == (0, f"a.{kind}: position\n", "")
    first = Path(f"a.{kind}").read_bytes()
    assert first.startswith(begin)
    run("--figure", "position", "-o", f"a.{kind}")
    assert Path(f"a.{kind}").read_bytes() == first


def test_without_a_name_it_has_that_of_the_sheet(run: Run) -> None:
    assert run("--set", "w=3")[:2] == (0, "crank.png: position, speed\n")
    assert pictures() == {"crank.png"}


def test_a_figure_without_a_value_is_left_out_and_said(run: Run) -> None:
    code, out, err = run("-o", "a.png")
    assert (code, out) == (1, "a.png: position\n")
    assert "partial: the inputs do not determine every variable" in err
    assert "the figure speed is left out: w has no value" in err


def test_states_and_answers_side_by_side(run: Run) -> None:
    code, out, _ = run(
        "--over", "theta=0,90", "--over", "l=4,5", "--figure", "position", "-o", "a.png"
    )
    assert (code, out) == (0, "a.png: position; 4 side by side\n")
    code, out, _ = run("--all", "--figure", "position", "-o", "b.png")
    assert (code, out) == (0, "b.png: position; 2 side by side\n")


def test_a_film(run: Run) -> None:
    """At l = 1 the rod is too short for some angles."""
    image = pytest.importorskip("PIL.Image")
    words = ("--over", "theta=0:90:30", "--set", "l=1.5", "--figure", "position", "--dpi", "40")
    code, out, err = run(*words, "-o", "a.gif")
    assert (code, out) == (1, "a.gif: 2 frames\n")
    assert err == "not drawn, infeasible: theta = 60; theta = 90\n"
    with image.open(io.BytesIO(Path("a.gif").read_bytes())) as film:
        assert film.n_frames == 2


def test_a_range_overrides_the_variable_sheet(run: Run) -> None:
    Path("inputs.csv").write_text("Name,Input\ntheta,40\n")
    code, out, _ = run("inputs.csv", "--over", "theta=0,90", "--figure", "position", "-o", "a.png")
    assert (code, out) == (0, "a.png: position; 2 side by side\n")


def test_a_film_of_every_answer(run: Run) -> None:
    words = (
        "--over",
        "theta=0:90:45",
        "--over",
        "l=4,5",
        "--figure",
        "position",
        "--dpi",
        "40",
        "--all",
    )
    code, out, _ = run(*words, "-o", "a.gif")
    assert (code, out) == (0, "a.gif: 3 frames\n")


def test_a_film_shows_an_only_answer_that_is_not_the_first(run: Run) -> None:
    """The first branch ends at y = 2, and the second goes on alone."""
    sheet = (
        "variables\ny = 0\nx\nrules\ny = x^3 - 3*x\nfigure f\npoint A = (x, 0)\npoint O = (y, 1)\n"
    )
    Path("cubic.tk").write_text(sheet)
    words = ("--over", "y=-3:3:1", "--dpi", "40", "--all", "-o", "a.gif")
    assert run(*words, sheet="cubic.tk")[:2] == (0, "a.gif: 7 frames\n")


@pytest.mark.parametrize("words", [(), ("--all",)])
def test_a_film_of_inputs_alone(run: Run, words: tuple[str, ...]) -> None:
    """Nothing is solved for; a variable may be called as the column of the numbers of answers
    is."""
    crank = CRANK.replace("point B = (x, 0)", "point B = (l, 0)").replace(
        "  w\n", "  w\n  answer\n", 1
    )
    Path("inputs.tk").write_text(crank.replace("= l^2\n", "= l^2\n  answer = r\n"))
    film = ("--over", "theta=0:90:45", "--figure", "position", "--dpi", "40", "-o", "a.gif")
    assert run(*film, *words, sheet="inputs.tk")[:2] == (0, "a.gif: 3 frames\n")


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["-o", "a.jpg"], "E433", "a picture ends in .png, .svg or .pdf"),
        (["-o", "a"], "E433", "a picture ends in"),
        (["-o", "a.gif"], "E433", "give --over NAME=START:STOP:STEP to make a film"),
        (["-o", "a.png", "--over", "theta=0:90:45"], "E433", "a film ends in .gif"),
        (["--figure", "positon"], "E431", "did you mean position?"),
        (["--over", "theta"], "E424", "--over needs a name and a range or a list"),
        (["--over", "tetha=1,2"], "E407", "did you mean theta?"),
        (["--over", "theta=1,"], "E406", "nothing is not a value"),
        (["--over", "theta=1,2", "--set", "theta=3"], "E421", "theta is given twice"),
        (["--over", "theta=1,2", "--over", "theta=0:9:3"], "E421", "theta is given twice"),
        (["--over", "theta=0:9:3", "--over", "l=0:9:3"], "E424", "a film runs over one range"),
        (["--over", "l=-1,2"], "E403", "outside its range"),
        (["--dpi", "0"], "E434", "--dpi"),
        (["--dpi", "nan"], "E434", "--dpi"),
    ],
)
def test_refusals(run: Run, words: list[str], code: str, said: str) -> None:
    exit_code, out, err = run(*words)
    assert (exit_code, out) == (2, "")
    assert f"error[{code}]" in err and said in err
    assert pictures() == set()


def test_without_an_answer_nothing_is_written(run: Run) -> None:
    code, out, err = run("--figure", "position", "--set", "l=1", "-o", "a.png")
    assert (code, out) == (1, "")
    assert "infeasible: there is no real solution" in err and "error[S" in err
    assert pictures() == set()
    code, out, err = run(
        "--over", "theta=40:50:5", "--figure", "position", "--set", "l=1", "-o", "a.gif"
    )
    assert (code, out, err) == (
        1,
        "",
        "not drawn, infeasible: theta = 40; theta = 45; theta = 50\n",
    )
    assert pictures() == set()


def test_a_sheet_without_figures(run: Run) -> None:
    code, _, err = run(sheet="loan")
    assert code == 2 and "error[E430]: loan has no figure to draw" in err


def test_without_matplotlib(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("solver.files.find_spec", lambda name: None)
    code, out, err = run("--figure", "position")
    assert (code, out) == (2, "")
    assert "error[E432]: drawing needs matplotlib" in err and "pip install 'backsolve[plot]'" in err


def test_the_place_must_be_writable(run: Run) -> None:
    code, _, err = run("--figure", "position", "-o", "no/such/a.png")
    assert code == 2 and "error[E416]" in err


def test_the_ending_counts_in_any_case() -> None:
    assert picture_kind("a.PNG", PICTURES) == ".png"
