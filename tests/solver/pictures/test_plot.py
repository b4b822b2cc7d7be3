"""Sweeps as pictures: what is drawn is what was solved, gaps included."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("matplotlib")

import rulesheets
import solver
from rulesheets.diagnosis import RuleSheetError
from solver.__main__ import main
from solver.files.tables import Table
from solver.pictures.plot import Curves, Maps, arranged, broken, colored, panels, titled


def columns(values: dict[str, object], answers: list[int] | None = None) -> Table:
    arrays = {name: np.asarray(column) for name, column in values.items()}
    status = np.zeros(len(next(iter(arrays.values()))), dtype=np.int8)
    return Table(arrays, status, answers=None if answers is None else np.array(answers))


def test_a_grid_makes_a_curve_for_each_value_of_the_shorter_input() -> None:
    x, k = (grid.ravel() for grid in np.meshgrid(np.arange(20.0), [1.0, 2.0, 3.0], indexing="ij"))
    shown = arranged(columns({"x": x, "k": k, "y": k * x}), ("x", "k"), (20, 3))
    assert isinstance(shown, Curves)
    assert (shown.along, shown.abscissa.tolist()) == ("x", list(range(20)))
    assert shown.labels == ("k = 1", "k = 2", "k = 3")
    assert np.array_equal(shown.heights["y"], np.outer([1, 2, 3], np.arange(20)))


def test_answers_are_curves_with_gaps_where_they_are_not() -> None:
    x, answer = [0.0, 1.0, 1.0, 2.0, 3.0, 3.0], [0, 1, 2, 1, 1, 2]
    y = [np.nan, 1.0, -1.0, 2.0, 3.0, -3.0]
    table = columns({"x": x, "answer": answer, "y": y}, [0, 2, 2, 1, 2, 2])
    shown = arranged(table, ("x",), (4,), "answer")
    assert isinstance(shown, Curves)
    assert shown.labels == ("answer 1", "answer 2")
    expected = [[np.nan, 1, 2, 3], [np.nan, -1, np.nan, -3]]
    assert np.array_equal(shown.heights["y"], expected, equal_nan=True)


def test_an_only_answer_that_is_not_the_first_has_a_place_of_its_own() -> None:
    sheet = rulesheets.loads("variables\ny = 0\nx\nrules\ny = x^3 - 3*x")
    table = solver.sweep(sheet, {"y": np.arange(-3.0, 4.0)}, ["x"], all=True)
    assert table["answer"].tolist()[-3:] == [
        2,
        3,
        2,
    ]  # of y = 2, where two branches end, and of y = 3
    shown = arranged(table, ("y",), (7,), "answer")
    assert isinstance(shown, Curves)
    assert shown.abscissa.tolist() == list(range(-3, 4))
    assert shown.heights["x"][1].tolist()[-2:] == pytest.approx([2.0, 2.1038034])
    assert np.isnan(shown.heights["x"][0][-1])


def test_two_inputs_of_many_values_make_maps() -> None:
    a, b = (grid.ravel() for grid in np.meshgrid(np.arange(30.0), np.arange(40.0), indexing="ij"))
    shown = arranged(columns({"a": a, "b": b, "y": a - b}), ("a", "b"), (30, 40))
    assert isinstance(shown, Maps)
    assert (shown.up, shown.across) == ("a", "b")
    assert np.array_equal(shown.fields["y"], np.subtract.outer(np.arange(30), np.arange(40)))


def test_rows_of_a_file_run_along_their_first_number() -> None:
    kind = np.array(["open", "crossed"], dtype=object)
    shown = arranged(columns({"kind": kind, "x": [1.0, 2.0], "y": [3.0, 4.0]}), ("kind", "x"), (2,))
    assert isinstance(shown, Curves)
    assert (shown.along, shown.abscissa.tolist(), shown.heights["y"].tolist()) == (
        "x",
        [1, 2],
        [[3, 4]],
    )


@pytest.mark.parametrize(
    ("values", "inputs", "shape"),
    [
        ({"x": [1.0], "s": np.array(["on"], dtype=object)}, ("x",), (1,)),
        ({"k": np.array(["on"], dtype=object), "y": [1.0]}, ("k",), (1,)),
        (dict.fromkeys("abcy", np.zeros(1000)), ("a", "b", "c"), (10, 10, 10)),
    ],
)
def test_what_cannot_be_drawn(
    values: dict[str, object], inputs: tuple[str, ...], shape: tuple[int, ...]
) -> None:
    with pytest.raises(RuleSheetError) as caught:
        arranged(columns(values), inputs, shape)
    assert caught.value.diagnoses[0].code == "E445"


def test_an_angle_does_not_run_back_through_the_picture() -> None:
    x, y = broken(np.arange(4.0), np.array([170.0, 179.0, -179.0, -170.0]), 360.0)
    assert x.tolist() == [0, 1, 2, 2, 3]
    assert np.array_equal(y, [170, 179, np.nan, -179, -170], equal_nan=True)


def test_a_pole_leaves_colours_for_the_rest() -> None:
    field = np.linspace(-1.0, 1.0, 10_000)
    assert colored(field) == (-1.0, 1.0, "neither")
    field[0] = -1e9
    low, high, extend = colored(field)
    assert low == pytest.approx(-0.98, abs=1e-3)
    assert (high, extend) == (1.0, "min")
    assert colored(np.full(3, np.nan)) == (None, None, "neither")


def test_variables_of_one_unit_share_a_panel() -> None:
    model = rulesheets.loads(
        "variables\n a [mm]\n b [mm]\n c\n d\n e [s]\nrules\n a + b + c + d + e = 1\n"
    )
    assert panels(list("abcde"), model, families=False) == [["a", "b"], ["c"], ["d"], ["e"]]
    assert panels(list("ab"), model, families=True) == [["a"], ["b"]]
    assert titled(["a", "b"], model) == "a, b [mm]"


@pytest.mark.parametrize("ending", ["png", "svg"])
def test_a_picture_of_a_sweep(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], ending: str
) -> None:
    pytest.importorskip("matplotlib")
    files = [tmp_path / f"{name}.{ending}" for name in ("one", "two")]
    for file in files:
        over = ["--over", "I=0:2:0.5", "--over", "R=1,2", "--clear", "V"]
        words = ["sweep", "ohms_law", *over, "--want", "V,P", "--plot", str(file)]
        assert main(words) == 0
    assert capsys.readouterr() == ("", "10 rows: 10 solved\n" * 2)
    assert files[0].read_bytes() == files[1].read_bytes()
    signature = {"png": b"\x89PNG", "svg": b"<?xml"}[ending]
    assert files[0].read_bytes().startswith(signature)


def test_a_picture_of_answers_names_them(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    file = tmp_path / "crank.svg"
    words = [
        "--over",
        "xB=4:11:0.5",
        "--clear",
        "thetaAO",
        "--want",
        "thetaAO,vB",
        "--all",
        "--plot",
        str(file),
    ]
    assert main(["sweep", "offset_slider_crank", *words]) == 1
    text = file.read_text()
    assert all(label in text for label in ("answer 1", "answer 2", "thetaAO [deg]", "vB", "xB"))


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (["--over", "I=0:1:0.5", "--plot", "x.bmp"], "E433"),
        (["--over", "I=0:1:1e-7", "--plot", "x.png"], "E445"),
        (["--over", "I=1,2", "--plot", "missing/x.png"], "E416"),
    ],
)
def test_a_wrong_picture(capsys: pytest.CaptureFixture[str], words: list[str], code: str) -> None:
    pytest.importorskip("matplotlib")
    assert main(["sweep", "ohms_law", "--set", "R=2", "--want", "V", *words]) == 2
    assert capsys.readouterr().err.startswith(f"error[{code}]")


DOLLARS = """\
variables
  x = 1 [$/h]
  k = 1
  y [$*$/h]
rules
  y = x^2 + k
figure f [$] " a $caption^{$ of 5$
  pin O = (0, 0)
  point A = (x, y)
  vector v = (O, A)
"""


@pytest.mark.parametrize(
    "words",
    [
        ["sweep", "--over", "x=0:3:1", "--plot"],
        ["sweep", "--over", "x=0:3:1", "--over", "k=1:3:1", "--want", "y", "--plot"],
        ["draw", "-o"],
        ["draw", "--over", "x=1,2", "-o"],
    ],
)
def test_a_dollar_is_one(tmp_path: Path, words: list[str]) -> None:
    """In matplotlib a pair of them begins and ends a formula, and what stands between must be
    one."""
    pytest.importorskip("matplotlib")
    sheet, file = tmp_path / "dollars.tk", tmp_path / "dollars.svg"
    sheet.write_text(DOLLARS)
    main([words[0], str(sheet), *words[1:], str(file)])
    assert "$" in file.read_text()
