"""Sweeps: rows from ranges and files, a status for each, and every answer with a number that
stays."""

from __future__ import annotations

import csv
import io
import math
from fractions import Fraction
from itertools import pairwise, product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rulesheets
import solver
from solver.files.tables import WORDS, column_of, csv_head
from solver.sweeps.sweep import LARGEST, Grid, Stretch, file_chunks, grid_chunks, size
from solver.sweeps.work import Follower
from tests.solver.conftest import Run

ROOT = Path(__file__).parents[3]

TRIANGLE = """\
variables
  a = 3 [mm]  " one leg
  b = 4 [mm]  " the other leg
  c > 0 [mm]  " hypotenuse
  kind = 'right
rules
  if kind = 'right then c^2 = a^2 + b^2 else c = a + b
"""


@pytest.fixture
def sheet(tmp_path: Path) -> str:
    file = tmp_path / "triangle.tk"
    file.write_text(TRIANGLE)
    return str(file)


def table(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


# --- rows ------------------------------------------------------------------------


@given(
    st.fractions(-1000, 1000, max_denominator=10_000),
    st.fractions(-10, 10, max_denominator=10_000),
    st.integers(1, 10**9),
    st.data(),
)
def test_a_value_of_a_range_is_the_float_nearest_to_it(
    start: Fraction, step: Fraction, count: int, data: st.DataObject
) -> None:
    axis = Stretch(start, step, count)
    for place in data.draw(st.lists(st.integers(0, count - 1), min_size=1)):
        end = min(count, place + 3)
        assert axis[place:end].tolist() == [float(start + step * k) for k in range(place, end)]


def test_a_range_of_long_decimals_is_exact_too() -> None:
    start, step = Fraction("0.1234567890123456789"), Fraction("1e-19")
    found = Stretch(start, step, 5)[0:5]
    assert found.tolist() == [float(start + k * step) for k in range(5)]


def test_a_grid_is_every_combination_and_is_not_held() -> None:
    grid = Grid(
        (
            column_of([1.0, 2.0]),
            column_of(["open", "crossed"]),
            Stretch(Fraction(0), Fraction(1, 4), 3),
        )
    )
    whole = list(zip(*grid.at(np.arange(len(grid))), strict=True))
    assert whole == [(a, b, c) for a in (1, 2) for b in ("open", "crossed") for c in (0, 0.25, 0.5)]
    assert list(zip(*grid.at(np.arange(5, 8)), strict=True)) == whole[5:8]
    vast = Grid(
        (Stretch(Fraction(0), Fraction(1), 10**6), Stretch(Fraction(0), Fraction(1), 10**6))
    )
    outer, inner = vast.at(np.arange(10**12 - 2, 10**12))
    assert (outer.tolist(), inner.tolist()) == ([999_999, 999_999], [999_998, 999_999])


@given(st.lists(st.integers(1, 7), min_size=1, max_size=4), st.data())
def test_any_rows_of_a_grid_are_those_of_the_whole(lengths: list[int], data: st.DataObject) -> None:
    axes = [np.arange(length) + 10.0 * place for place, length in enumerate(lengths)]
    whole = list(product(*axes))
    first = data.draw(st.integers(0, len(whole)))
    last = data.draw(st.integers(first, len(whole)))
    columns = Grid(tuple(map(column_of, axes))).at(np.arange(first, last))
    assert list(zip(*columns, strict=True)) == whole[first:last]


def test_a_grid_without_rows_has_its_columns() -> None:
    columns = Grid((column_of([1.0, 2.0]), column_of([]))).at(np.arange(0))
    assert [len(column) for column in columns] == [0, 0]


@settings(max_examples=30)
@given(st.integers(1, 300_000), st.lists(st.integers(1, 40_000), max_size=30))
def test_pieces_hold_every_row_once_in_order(count: int, cuts: list[int]) -> None:
    rows = Grid((Stretch(Fraction(0), Fraction(1), count),), zipped=True)
    made = [chunk[0] for chunk in grid_chunks(rows)]
    assert np.array_equal(np.concatenate(made), np.arange(count))
    assert max(map(len, made)) <= LARGEST
    ends = [0, *np.minimum(np.cumsum(cuts or [count]), count).tolist(), count]
    read = ((np.arange(one, other),) for one, other in pairwise(ends) if other > one)
    again = [chunk[0] for chunk in file_chunks(read, count)]
    assert [len(chunk) for chunk in again] == [len(chunk) for chunk in made]
    assert np.array_equal(np.concatenate(again), np.arange(count))


def test_pieces_grow_to_their_largest() -> None:
    assert size(0, None) == size(0, 10) == size(500, None) == 256
    assert size(10**6, None) == size(10**6, 10**8) == LARGEST
    assert size(10**6, 16 * 1000) == 1000


def test_ranges_side_by_side(run: Run, sheet: str) -> None:
    words = ("sweep", sheet, "--over", "a=1:3:1", "--over", "b=2,3,4", "--zip", "--want", "c")
    code, out, _ = run(*words)
    assert code == 0
    assert [(row["a"], row["b"]) for row in table(out)] == [("1", "2"), ("2", "3"), ("3", "4")]
    code, _, err = run(*words[:-2], "--over", "kind=right")
    assert code == 2
    assert "a has 3, kind has 1" in err


def test_a_list_may_hold_symbols(run: Run, sheet: str) -> None:
    code, out, _ = run("sweep", sheet, "--over", "kind=right,'flat", "--want", "c")
    assert code == 0
    assert [(row["kind"], row["c"]) for row in table(out)] == [("'right", "5"), ("'flat", "7")]


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_rows_of_a_file(run: Run, sheet: str, tmp_path: Path, separator: str) -> None:
    rows = [
        ["b", "kind", "c"],
        ["4", "right", "5"],
        ["", "'right", "5"],
        ["4", "flat", "5.5"],
        ["4", "right", "-5"],
    ]
    file = tmp_path / "rows.csv"
    file.write_text("\ufeff" + "\r\n".join(map(separator.join, rows)) + "\r\n\r\n")
    code, out, err = run("sweep", sheet, "--clear", "a", "--rows", str(file), "--want", "a")
    assert code == 1
    found = [(row["b"], row["a"], row["status"]) for row in table(out)]
    assert found == [
        ("4", found[0][1], "solved"),
        ("", "", "partial"),
        ("4", "1.5", "solved"),
        ("4", "", "infeasible"),
    ]
    assert float(found[0][1]) == 3  # and not -3, which is negative
    several = "1 of 4 rows has several answers; the first of each is shown"
    reason = "kind = 'right, c = 5: the inputs do not determine a; give b"
    assert err == f"4 rows: 2 solved, 1 partial, 1 infeasible\n{several}\n{reason}\n"


def test_some_columns_of_a_file(run: Run, sheet: str, tmp_path: Path) -> None:
    file = tmp_path / "rows.csv"
    file.write_text("run,a,c\none,6,0\ntwo,8,0\n")
    code, _, err = run("sweep", sheet, "--rows", str(file))
    assert code == 2
    assert "column run" in err and "--columns" in err
    code, out, _ = run(
        "sweep", sheet, "--rows", str(file), "--columns", "a", "--set", "b=8", "--want", "c"
    )
    assert code == 0
    assert [float(row["c"]) for row in table(out)] == [10.0, math.hypot(8, 8)]


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "empty"),
        ("a,b\n1\n", "line 2"),
        ("a,b\n1,2\n1,2*\n", "line 3"),
        ("a,a\n1,2\n", "two columns a"),
        ("a\n\xff\n", "cannot be read"),
        ('a\n"1\n', "cannot be read"),
    ],
)
def test_a_wrong_file_of_rows(
    run: Run, sheet: str, tmp_path: Path, text: str, complaint: str
) -> None:
    file = tmp_path / "rows.csv"
    file.write_bytes(text.encode("latin-1"))
    code, _, err = run("sweep", sheet, "--rows", str(file), "--want", "c")
    assert code == 2
    assert err.startswith("error[E440]")
    assert complaint in err


def test_a_file_without_rows_makes_a_table_without_rows(
    run: Run, sheet: str, tmp_path: Path
) -> None:
    file, out = tmp_path / "rows.csv", tmp_path / "out.csv"
    file.write_text("a\n")
    assert run("sweep", sheet, "--rows", str(file), "--want", "c") == (
        0,
        "a,c,answers,status\n",
        "no rows\n",
    )
    for every in ([], ["--all"]):
        words = ("sweep", sheet, "--rows", str(file), "--want", "c", "-o", str(out), *every)
        assert run(*words) == (0, "", "no rows\n")
        assert out.read_text() == ("a,answer,c,status\n" if every else "a,c,answers,status\n")


@pytest.mark.parametrize("name", ["missing.csv", "missing.parquet", "."])
def test_a_missing_file_of_rows(run: Run, sheet: str, tmp_path: Path, name: str) -> None:
    if name.endswith(".parquet"):
        pytest.importorskip("pyarrow")
    code, out, err = run("sweep", sheet, "--rows", str(tmp_path / name))
    assert (code, out) == (2, "")
    assert err.startswith("error[E440]")


@pytest.mark.parametrize("words", [[], ["--over", "a=1:2:1", "--rows", "rows.csv"]])
def test_either_ranges_or_rows(run: Run, sheet: str, words: list[str]) -> None:
    code, _, err = run("sweep", sheet, *words)
    assert code == 2
    assert err.startswith("error[E443]")


def test_columns_that_are_not_there(run: Run, sheet: str, tmp_path: Path) -> None:
    file = tmp_path / "rows.csv"
    file.write_text("kind\nright\n")
    _, _, err = run("sweep", sheet, "--rows", str(file), "--columns", "kin")
    assert "no column kin" in err and "kind" in err.partition("help")[2]


# --- statuses ----------------------------------------------------------------------


def test_a_bad_row_spoils_no_neighbour() -> None:
    model = rulesheets.loads(TRIANGLE)
    sides = np.array([5.0, np.nan, -5.0, np.inf, 3.0, 5.0])
    found = solver.sweep(model, {"c": sides}, ["a"], given={"a": None})
    words = [str(found.STATUSES[code]) for code in found.status]
    assert words == ["solved", "partial", "infeasible", "partial", "infeasible", "solved"]
    assert np.array_equal(np.isnan(found["a"]), [False, True, True, True, True, False])
    assert np.abs(found["a"][found.solved]).tolist() == [3.0, 3.0]
    assert found["c"][1:4].tolist() == pytest.approx([math.nan, -5.0, math.inf], nan_ok=True)


def test_symbols_sweep_beside_numbers() -> None:
    model = rulesheets.loads(TRIANGLE)
    found = solver.sweep(model, {"kind": ["right", "'flat", None]}, ["c"])
    assert found["c"][:2].tolist() == [5.0, 7.0]
    assert [str(found.STATUSES[code]) for code in found.status] == ["solved", "solved", "partial"]
    assert found["kind"].tolist() == ["right", "flat", None]


def test_an_empty_sweep_has_its_columns() -> None:
    model = rulesheets.loads(TRIANGLE)
    for every in (False, True):
        found = solver.sweep(model, {"a": []}, ["c"], all=every)
        assert [*found] == (["a", "answer", "c"] if every else ["a", "c", "answers"])
        assert len(found.status) == len(found["c"]) == 0


# --- all answers -------------------------------------------------------------------


def crank_angles(x: np.ndarray, sign: int) -> np.ndarray:
    """The angle for a place of the slider (AO 3, AB 8, offset 2), by the law of cosines."""
    away = np.hypot(x, 2.0)
    half = np.degrees(np.arccos((9 + away**2 - 64) / (6 * away)))
    return np.degrees(np.arctan2(2.0, x)) + sign * half


def test_every_answer_keeps_its_number() -> None:
    model = rulesheets.load("offset_slider_crank")
    places = np.linspace(4.5, 10.9, 25)
    found = solver.sweep(model, {"xB": places}, ["thetaAO"], given={"thetaAO": None}, all=True)
    within = (np.hypot(places, 2) > 5) & (np.hypot(places, 2) < 11)
    assert found["xB"].tolist() == np.repeat(places, np.where(within, 2, 1)).tolist()
    numbered = {number: found["answer"] == number for number in (0, 1, 2)}
    for number, sign in ((1, -1), (2, 1)):
        rows = numbered[number]
        assert found["thetaAO"][rows] == pytest.approx(
            crank_angles(found["xB"][rows], sign), abs=1e-9
        )
    assert np.isnan(found["thetaAO"][numbered[0]]).all()
    assert np.array_equal(found.solved, ~numbered[0])


@settings(max_examples=30)
@given(st.lists(st.permutations([0, 1, 2]), min_size=40, max_size=40), st.integers(0, 2**32 - 1))
def test_branches_that_cross_are_followed(orders: list[list[int]], seed: int) -> None:
    """Three lines that start apart and cross, angles past ±180, their answers shuffled in every
    row."""
    draw = np.random.default_rng(seed)
    starts = np.array([-120.0, 0.0, 120.0]) + draw.uniform(-20, 20, 3)
    lines = starts + np.outer(np.arange(40), draw.uniform(-6, 6, 3))
    without_turns = (lines + 180) % 360 - 180
    shuffled = np.array([row[order] for row, order in zip(without_turns, orders, strict=True)])
    points, counts, follow = (
        shuffled.reshape(1, -1),
        np.full(40, 3),
        Follower(np.array([360.0]), 10**9),
    )
    numbers = [follow(points[:, :33], counts[:11]), follow(points[:, 33:], counts[11:])]
    labels = {line: place + 1 for place, line in enumerate(orders[0])}
    expected = [labels[line] for order in orders for line in order]
    assert np.concatenate(numbers).tolist() == expected


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), st.integers(1, 700))
def test_branches_in_the_order_of_their_values_are_followed_through_crossings(
    seed: int, cut: int
) -> None:
    """Answers may come sorted: where two lines cross they change places, and the numbers follow."""
    draw = np.random.default_rng(seed)
    starts = np.array([-60.0, 0.0, 60.0]) + draw.uniform(-20, 20, 3)
    lines = starts + np.outer(np.arange(250), draw.uniform(-1, 1, 3))
    orders = np.argsort(lines, axis=1)
    points, counts = np.sort(lines, axis=1).reshape(1, -1), np.full(250, 3)
    follow, cut = Follower(np.array([np.inf]), 10**9), cut // 3
    numbers = [
        follow(points[:, : 3 * cut], counts[:cut]),
        follow(points[:, 3 * cut :], counts[cut:]),
    ]
    assert np.concatenate(numbers).tolist() == (orders + 1).ravel().tolist()


def test_numbers_start_anew_on_each_line_and_after_a_gap() -> None:
    points, counts = np.array([[0.0, 9, 9, 0, 0, 9, 0]]), np.array([2, 2, 0, 2])
    for line, expected in ((100, [1, 2, 2, 1, 0, 1, 2]), (1, [1, 2, 1, 2, 0, 1, 2])):
        assert Follower(np.array([np.inf]), line)(points, counts).tolist() == expected


def test_every_answer_of_a_grid_on_the_command_line(run: Run, sheet: str) -> None:
    words = ("--clear", "a", "--over", "b=0,3", "--over", "c=4:5:1", "--want", "a", "--all")
    code, out, err = run("sweep", sheet, *words)
    found = [(row["b"], row["c"], abs(float(row["a"]))) for row in table(out)]
    assert [row[:2] for row in found[::2]] == [("0", "4"), ("0", "5"), ("3", "4"), ("3", "5")]
    assert [row["answer"] for row in table(out)] == ["1", "2"] * 4
    assert [row[2] for row in found[1::2]] == [4.0, 5.0, math.sqrt(7), 4.0]
    assert (code, err) == (0, "4 rows: 4 solved\n")


def test_columns_of_ours_give_way_to_variables() -> None:
    model = rulesheets.loads(
        "variables\n  x\n  status\n  answer\nrules\n  status = x + 1\n  answer^2 = x\n"
    )
    found = solver.sweep(model, {"x": [4.0]}, ["status", "answer"], all=True)
    assert [*found] == ["x", "answer_", "status", "answer"]
    assert found["answer"].tolist() in ([2.0, -2.0], [-2.0, 2.0])
    assert csv_head([*found]) == b"x,answer_,status,answer,status_\n"


def test_a_symbol_is_no_value_of_what_is_measured(run: Run, tmp_path: Path) -> None:
    rows = tmp_path / "rows.csv"
    rows.write_text("thetaAO,branch\n30,open\nabc,crossed\n")
    code, out, err = run("sweep", "offset_slider_crank", "--rows", str(rows), "--want", "xB")
    assert (code, out) == (2, "")
    assert "error[E440]" in err and "line 3 of" in err and "not a valid value for thetaAO" in err
    code, out, err = run("sweep", "offset_slider_crank", "--over", "thetaAO=30,abc", "--want", "xB")
    assert (code, out) == (2, "")
    assert "error[E406]" in err and "thetaAO is a number in [deg], and 'abc is a symbol" in err
    code, out, err = run("solve", "offset_slider_crank", "--set", "omegaAO=abc")
    assert (code, out) == (2, "")
    assert "error[E406]" in err


def test_rows_and_calls_beyond_reach_have_the_status_of_their_solves() -> None:
    """From 14 rad/s down no size of the link gives the speed that is asked for."""
    model = rulesheets.load(ROOT / "models" / "oscillating_cylinder" / "model.tk")
    given = {"xs": solver.solve(model).solutions[0]["xs"], "BO": None}
    speeds = np.array([16.0, 12.0, 5.0, 15.0])
    plan = solver.prepare(model, ["omegaBO"], given=given)
    table = plan.sweep(speeds)
    alone = [
        str(solver.solve(model, {**given, "omegaBO": speed}).status) for speed in speeds.tolist()
    ]
    expected = ["solved", "infeasible", "infeasible", "solved"]
    assert [WORDS[code] for code in table.status] == alone == expected
    with pytest.raises(solver.Unsolved) as refused:
        plan(9.5)
    assert str(refused.value.status) == "infeasible"
    assert plan(14.5) == pytest.approx(plan.all(14.5)[0])


def test_a_call_after_one_without_an_answer_tells_a_contradiction() -> None:
    """At other phases than that of its two frequencies a low pass has no quality: it contradicts
    them."""
    text = "r = f/f0\nphase = -atan2d(r/Q, 1 - r^2)\ngain = 1/sqrt((1 - r^2)^2 + (r/Q)^2)"
    model = rulesheets.loads(text)
    plan = solver.prepare(model, ["f0"], given={"f": 2000.0, "phase": -143.47114463301483})
    for f0 in (2000.0, 3000.0, 2000.0, -1000.0, 1400.0, 2500.0):
        alone = solver.solve(model, {"f": 2000.0, "phase": -143.47114463301483, "f0": f0})
        try:
            plan(f0)
            status = "solved"
        except solver.Unsolved as refused:
            status = str(refused.status)
        assert status == str(alone.status)


def test_a_sweep_tells_of_units_that_do_not_fit(run: Run, tmp_path: Path) -> None:
    sheet = tmp_path / "motor.tk"
    sheet.write_text("variables\n  P = 5 [kW]\n  T [N-m]\n  w = 10 [rad/s]\nrules\n  P = T*w\n")
    code, _, err = run("sweep", str(sheet), "--over", "w=10,20")
    told = "1 warning of units (backsolve check): P is in kW, T*w in W: a factor of 1000 is missing"
    assert (code, err) == (0, f"2 rows: 2 solved\n{told}\n")
