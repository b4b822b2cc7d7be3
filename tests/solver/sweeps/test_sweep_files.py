"""Tables on disk: exact, whole or not there, and the same bytes whoever solved the rows."""

from __future__ import annotations

import csv
import io
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import closing
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rulesheets
import solver
from rulesheets.diagnosis import RuleSheetError
from rulesheets.inputs import symbolic
from solver.__main__ import INTERRUPTED, main
from solver.commands import sweep as progress
from solver.commands.sweep import progress_line
from solver.files.tables import (
    CODES,
    ParquetFile,
    Table,
    column_of,
    csv_head,
    csv_rows,
    heading,
    pieces,
    stacked,
)
from solver.ranking.branches import Answers
from solver.sweeps import Plan, workers
from solver.sweeps import sweep as sweeping
from solver.sweeps.sweep import Grid, Outcome, followed, grid_chunks, grid_warmup, run, work_of
from solver.sweeps.work import Rows, Solver, Work, unpacked
from solver.sweeps.workers import in_order, solved_pieces
from solver.trace.records import Records

ROOT = Path(__file__).parents[3]

LENS = """\
variables
  f = 50  [mm]
  u = 200 [mm]
  v       [mm]
  kind
rules
  1/f = 1/u + 1/v
  if u > f then kind = 'real else kind = 'virtual
"""


@pytest.fixture
def sheet(tmp_path: Path) -> Path:
    file = tmp_path / "lens.tk"
    file.write_text(LENS)
    return file


def columns(values: dict[str, list[object]], status: list[int]) -> Table:
    arrays = {
        name: np.array(column, dtype=None if name != "s" else object)
        for name, column in values.items()
    }
    return Table(arrays, np.array(status, dtype=np.int8))


# --- CSV ------------------------------------------------------------------------


@given(st.lists(st.tuples(st.floats(), st.sampled_from(["open", None, 2.5, 3.0])), min_size=1))
def test_csv_reads_back_as_the_same_floats(rows: list[tuple[float, object]]) -> None:
    numbers, others = (list(column) for column in zip(*rows, strict=True))
    table = columns({"x": numbers, "y": numbers, "s": others}, [0] * len(rows))
    for part in (table, Table({"x": table["x"], "y": table["y"]}, table.status)):
        text = (csv_head([*part]) + csv_rows(part)).decode()
        read = list(csv.DictReader(io.StringIO(text, newline="")))
        assert [row["status"] for row in read] == ["solved"] * len(rows)
        for name in ("x", "y"):
            found = np.array([float(row[name]) if row[name] else np.nan for row in read])
            assert np.array_equal(found, numbers, equal_nan=True)
        if "s" in part:
            assert [row["s"] for row in read] == [
                {"open": "'open", None: "", 2.5: "2.5", 3.0: "3"}[v] for v in others
            ]


@pytest.mark.parametrize("plain", [False, True])
def test_csv_is_short_with_pyarrow_and_without(
    plain: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if plain:
        monkeypatch.setitem(sys.modules, "pyarrow", None)
    numbers = [1.0, -0.0, 0.1, np.nan, 1e22, 100.5]
    table = columns({"x": numbers, "s": ["open", None, 2.5, 3.0, None, None]}, [0, 0, 0, 3, 0, 0])
    lines = [
        "1,'open,solved",
        "0,,solved",
        "0.1,2.5,solved",
        ",3,infeasible",
        "1e+22,,solved",
        "100.5,,solved",
    ]
    assert csv_rows(table).decode().splitlines() == lines


def test_pieces_of_numbers_and_of_symbols_are_one_column() -> None:
    joined = stacked([np.array([1.0, np.nan]), np.array(["open", None], dtype=object)])
    assert joined.tolist() == [1.0, None, "open", None]


# --- Parquet --------------------------------------------------------------------


def test_parquet_has_doubles_texts_and_nulls(tmp_path: Path) -> None:
    read = pytest.importorskip("pyarrow.parquet").read_table
    model = rulesheets.loads(LENS)
    table = solver.sweep(model, {"u": [100.0, 50.0, 25.0, np.nan]}, ["v", "kind"])
    table.write(str(tmp_path / "table.parquet"))
    found = read(tmp_path / "table.parquet").to_pydict()
    assert found["u"] == [100.0, 50.0, 25.0, None]
    assert found["v"][::2] == [100.0, -50.0]
    assert found["kind"][::2] == ["real", "virtual"]
    assert found["status"][0] == "solved"
    assert found["status"][3] == "partial"
    assert found["v"][3] is found["kind"][3] is None


def test_row_groups_do_not_depend_on_the_pieces(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    arrow = pytest.importorskip("pyarrow.parquet")
    monkeypatch.setattr("solver.files.tables.ROW_GROUP", 100)
    files = []
    for cuts in ([0, 1000], [0, 10, 250, 255, 999, 1000]):
        files.append(tmp_path / f"{len(cuts)}.parquet")
        whole = columns({"x": list(np.arange(1000.0))}, [0] * 1000)
        table = ParquetFile(str(files[-1]), ["x"], [])
        for one, other in pairwise(cuts):
            table.add(whole.rows(one, other))
        table.close()
    assert files[0].read_bytes() == files[1].read_bytes()
    assert arrow.ParquetFile(files[0]).metadata.num_row_groups == 10


def test_rows_come_from_parquet_as_from_csv(
    sheet: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("pyarrow")
    values = {"u": [100.0, np.nan, 50.0], "f": [50.0, 50.0, 25.0]}
    outputs = []
    for ending in ("csv", "parquet"):
        rows, out = (str(tmp_path / f"{name}.{ending}") for name in ("rows", "out"))
        columns(values, [0, 0, 0]).write(rows)
        words = ("sweep", str(sheet), "--rows", rows, "--columns", "u,f", "--want", "v", "-o", out)
        assert main(words) == 1
        reason = "f = 50: the inputs do not determine v; give u"
        assert capsys.readouterr().err == f"3 rows: 2 solved, 1 partial\n{reason}\n"
        outputs.append(out)
    assert Path(outputs[0]).read_text().splitlines()[3] == "50,25,50,1,solved"
    found = pytest.importorskip("pyarrow.parquet").read_table(outputs[1]).to_pydict()
    assert found["v"] == [100.0, None, 50.0]


def test_a_variable_that_may_hold_symbols_is_known_beforehand() -> None:
    assert symbolic(rulesheets.loads(LENS)) == {"kind"}
    assert symbolic(rulesheets.load("offset_slider_crank")) == {"branch"}
    tied = rulesheets.loads(
        "variables\n  k\n  m\n  x\nrules\n  k = m\n  if or(x > 1, m = 'on) then x = 2\n"
    )
    assert symbolic(tied) == {"k", "m"}


def test_parquet_without_pyarrow_names_the_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(RuleSheetError) as caught:
        columns({"x": [1.0]}, [0]).write(str(tmp_path / "x.parquet"))
    assert caught.value.diagnoses[0].code == "E441"
    assert "pip install 'backsolve[parquet]'" in caught.value.diagnoses[0].notes
    assert list(tmp_path.iterdir()) == []


# --- whole or not at all ---------------------------------------------------------


@pytest.mark.parametrize(
    ("path", "code"),
    [("missing/table.csv", "E416"), ("table.xlsx", "E442"), ("missing/table.parquet", "E416")],
)
def test_a_file_that_cannot_be_written(
    sheet: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], path: str, code: str
) -> None:
    if path.endswith(".parquet"):
        pytest.importorskip("pyarrow")
    assert main(["sweep", str(sheet), "--over", "u=100:200:50", "-o", str(tmp_path / path)]) == 2
    assert capsys.readouterr().err.startswith(f"error[{code}]")
    assert list(tmp_path.iterdir()) == [sheet]


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_a_full_disk_leaves_the_old_file(sheet: Path, tmp_path: Path, ending: str) -> None:
    if ending == "parquet":
        pytest.importorskip("pyarrow")
    file = tmp_path / f"table.{ending}"
    file.write_text("old")
    # -B: compiled modules would be cut off as well, and read by others
    limit = "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (3000, 3000)); "
    code = limit + "from solver.__main__ import main; sys.exit(main(sys.argv[1:]))"
    words = ["sweep", str(sheet), "--over", "u=100:130:0.1", "-o", str(file), "--want", "v"]
    done = subprocess.run(
        [sys.executable, "-B", "-c", code, *words],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 2
    assert done.stderr.startswith("error[E416]")
    assert "File too large" in done.stderr
    assert file.read_text() == "old"
    assert sorted(tmp_path.iterdir()) == [sheet, file]


def test_what_is_no_file_is_written_directly(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = subprocess.Popen(["cat", str(pipe)], stdout=subprocess.PIPE, text=True)
    columns({"x": [1.0]}, [0]).write(str(pipe))
    assert reader.communicate(timeout=10)[0] == "x,status\n1,solved\n"


@pytest.mark.parametrize(
    ("jobs", "ending", "sent"), [(1, "parquet", signal.SIGINT), (2, "csv", signal.SIGTERM)]
)
def test_an_interrupt_leaves_what_is_done(
    sheet: Path, tmp_path: Path, ending: str, jobs: int, sent: signal.Signals
) -> None:
    if ending == "parquet":
        pytest.importorskip("pyarrow")
    file = tmp_path / f"table.{ending}"
    words = ("sweep", sheet, "--over", "u=100:1000:1e-4", "--want", "v", "-o", file, "--jobs", jobs)
    process = subprocess.Popen(
        [sys.executable, "-m", "solver", *map(str, words)],
        cwd=ROOT,
        stderr=subprocess.PIPE,
        text=True,
    )
    while process.poll() is None and not any(
        f.stat().st_size > 20_000 for f in tmp_path.glob("*.backsolve-unfinished")
    ):
        time.sleep(0.05)
    process.send_signal(sent)
    err = process.communicate(timeout=30)[1]
    assert process.returncode == INTERRUPTED, err
    rows = int(err.splitlines()[0].partition(" ")[0].replace(",", ""))
    assert f"interrupted after {rows:,} of 9,000,001 rows; {file} is whole, with these rows" in err
    assert 0 < rows < 9_000_001
    found = _rows_of(file)
    assert len(found) == rows
    assert found[-1] == float(100 + Fraction(rows - 1, 10_000))
    assert sorted(tmp_path.iterdir()) == [sheet, file]


def _rows_of(file: Path, name: str = "u") -> np.ndarray:
    if file.suffix == ".csv":
        with file.open() as text:
            return np.array([float(row[name]) for row in csv.DictReader(text)])
    read = pytest.importorskip("pyarrow.parquet").read_table
    return np.asarray(read(file, columns=[name]).column(name))


def test_a_failure_discards_the_file_and_ends_the_sweep(tmp_path: Path) -> None:
    kept: list[str] = []

    class Broken:
        def add(self, table: Table) -> None:
            raise RuntimeError("broken")

        def close(self) -> None:
            kept.append("closed")

        def discard(self) -> None:
            kept.append("discarded")

    with pytest.raises(RuntimeError):
        run(iter([Table({}, np.zeros(1, np.int8))]), [Broken()])
    assert kept == ["discarded"]


# --- several processes -----------------------------------------------------------


def test_workers_give_the_same_table(sheet: Path) -> None:
    model = rulesheets.load("offset_slider_crank")
    angles = np.linspace(-180, 180, 700)
    alone, shared = (
        solver.sweep(model, {"thetaAO": angles}, ["xB", "aB"], jobs=jobs) for jobs in (1, 2)
    )
    for name in alone:
        assert alone[name].tobytes() == shared[name].tobytes()
    assert alone.status.tobytes() == shared.status.tobytes()


@pytest.mark.parametrize(
    ("name", "axes", "given", "want"),
    [
        ("offset_slider_crank", {"thetaAO": np.linspace(-180, 180, 500)}, {}, ["xB", "vB", "aB"]),
        (
            "offset_slider_crank",
            {"xB": np.linspace(4, 11, 300)},
            {"thetaAO": None},
            ["thetaAO", "omegaAB"],
        ),
        (
            "offset_slider_crank",
            {"branch": ["open", "crossed"], "thetaAO": np.linspace(0, 360, 181)},
            {"offset": 5.5},
            ["xB", "alphaAB"],
        ),
        ("tax_brackets", {"income": np.linspace(-1e4, 3e5, 400)}, {}, None),
    ],
)
@pytest.mark.parametrize("every", [False, True])
def test_a_piece_comes_out_alike_whatever_was_solved_before(
    name: str, axes: dict[str, object], given: dict[str, None], want: list[str] | None, every: bool
) -> None:
    plan = solver.prepare(rulesheets.load(name), axes, want, given)
    rows = Grid(tuple(map(column_of, axes.values())))
    work = work_of(plan, grid_warmup(rows), every=every)
    cuts = [0, 40, 41, 90, len(rows) // 2, len(rows)]
    pieces = [rows.at(np.arange(one, other)) for one, other in pairwise(cuts)]
    forward, backward = Solver(work), Solver(unpacked(work.packed()))
    there = [forward(piece) for piece in pieces]
    back = [backward(piece) for piece in reversed(pieces)][::-1]
    tables = (list(followed(work, iter(found))) for found in (there, back))
    for one, other in zip(*tables, strict=True):
        assert one.status.tobytes() == other.status.tobytes()
        for column in one:
            assert repr(one[column].tolist()) == repr(other[column].tolist())
    assert any((rows.codes == 0).any() for rows in there)


def test_machine_code_gives_the_same_rows(sheet: Path, tmp_path: Path) -> None:
    pytest.importorskip("llvmlite")
    words = ["sweep", str(sheet), "--over", "u=0:200:0.5", "--want", "v"]
    files = [tmp_path / f"{name}.csv" for name in ("plain", "jit")]
    for file, extra in zip(files, ([], ["--jit"]), strict=True):
        assert main([*words, "-o", str(file), *extra]) == 1
    plain, jit = (file.read_text().splitlines()[1:] for file in files)
    for one, other in zip(plain, jit, strict=True):
        (u, v, *status), (again, found, *verdict) = one.split(","), other.split(",")
        assert (u, status) == (again, verdict)
        assert (v == found == "") or float(found) == pytest.approx(float(v), rel=1e-15)


def test_machine_code_that_is_not_there_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("solver.files.find_spec", lambda name: None)
    with pytest.raises(RuleSheetError) as caught:
        solver.sweep(rulesheets.loads(LENS), {"u": [100.0]}, jit=True)
    assert caught.value.diagnoses[0].code == "E441"
    assert "pip install 'backsolve[jit]'" in caught.value.diagnoses[0].notes


def work(model: rulesheets.Model) -> Work:
    return Work(model, ("u",), ("v",), {"f": 50.0}, {})


def pieces_of(rows: int) -> Iterator[tuple[np.ndarray, ...]]:
    return grid_chunks(Grid((column_of(np.linspace(100, 200, rows)),), zipped=True))


def test_a_worker_that_is_killed_loses_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[subprocess.Popen[bytes]] = []
    popen = subprocess.Popen

    def remembered(*words: object, **options: object) -> subprocess.Popen[bytes]:
        started.append(popen(*words, **options))  # type: ignore[call-overload]
        return started[-1]

    model = rulesheets.loads(LENS)
    alone = list(solved_pieces(work(model), pieces_of(2000), 2000, 1))
    monkeypatch.setattr(workers.subprocess, "Popen", remembered)
    shared = []
    for piece in solved_pieces(work(model), pieces_of(2000), 2000, 2):
        if not shared:
            started[0].kill()
        shared.append(piece)
    assert len(started) == 3
    for one, other in zip(alone, shared, strict=True):
        assert [c.tobytes() for c in one.answers.planes[0]] == [
            c.tobytes() for c in other.answers.planes[0]
        ]
    assert all(process.poll() is not None for process in started)


def test_workers_that_keep_ending_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workers, "_START", "import sys; sys.exit(1)")
    with pytest.raises(RuleSheetError) as caught:
        list(solved_pieces(work(rulesheets.loads(LENS)), pieces_of(300), 300, 2))
    assert caught.value.diagnoses[0].code == "E446"


def test_workers_start_where_they_pay(monkeypatch: pytest.MonkeyPatch) -> None:
    from solver.sweeps import workers as running

    asked: list[int] = []

    def noted(work: Work, chunks: Iterator[object], jobs: int) -> Iterator[object]:
        asked.append(sum(len(chunk[0]) for chunk in chunks))  # type: ignore[index]
        return iter(())

    monkeypatch.setattr(running, "processors", lambda: 2)
    monkeypatch.setattr(running, "solved_by_workers", noted)
    lens = work(rulesheets.loads(LENS))
    assert len(list(solved_pieces(lens, pieces_of(600), 600))) == 3
    assert asked == []
    monkeypatch.setattr(running, "WORTH", 1e-6)
    monkeypatch.setattr(running, "ENOUGH", 0.0)
    assert len(list(solved_pieces(lens, pieces_of(600), 600))) == 2
    assert asked == [88]


def test_a_row_that_goes_step_by_step_starts_no_workers(monkeypatch: pytest.MonkeyPatch) -> None:
    from solver.sweeps import workers as running

    clock = iter(range(1000))
    spent = [0.5, 0.001, 0.9, *[0.001] * 60]  # the first piece learns, the third has an odd row
    monkeypatch.setattr(running, "thread_time", lambda: sum(spent[: (next(clock) + 1) // 2]))
    monkeypatch.setattr(running, "processors", lambda: 2)
    monkeypatch.setattr(
        running, "solved_by_workers", lambda *_: pytest.fail("workers were started")
    )
    lens = work(rulesheets.loads(LENS))
    assert sum(len(rows.codes) for rows in solved_pieces(lens, pieces_of(9000), 9000)) == 9000


# --- progress --------------------------------------------------------------------


def test_the_line_of_progress() -> None:
    line = progress_line(1_200_000, 4_000_000, 2.0)
    assert line == "1,200,000 of 4,000,000 rows  600,000.0 rows/s  0:00:05 left"
    assert progress_line(3, None, 2.0) == "3 rows  1.5 rows/s"
    assert progress_line(0, 10, 1.0) == "0 of 10 rows"


def test_progress_moves_within_a_piece_and_leaves_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress, "PAUSE", 0.0)
    stream = io.StringIO()
    monkeypatch.setattr(stream, "isatty", lambda: True)
    shown = progress.Progress(stream, 100)
    for done, within, text in ((0, 0, "0 of 100 rows"), (0, 3, "3 of 100"), (30, 0, "30 of 100")):
        shown(done)
        shown.within(within)
        assert text in stream.getvalue()
    shown.end()
    assert stream.getvalue().endswith("\r\x1b[K")  # which erases the line


SLOW = "x^2 - 5*x*y + exp(y/7) = c\nsin(x) + x*y^2 = 2\n"


@pytest.mark.parametrize("every", [False, True])
@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_an_interrupt_keeps_the_rows_of_a_piece(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ending: str, every: bool
) -> None:
    """The rows go one by one; the interrupt comes while the sixth is solved."""
    pytest.importorskip("pyarrow")
    (tmp_path / "slow.tk").write_text(SLOW)
    monkeypatch.chdir(tmp_path)
    words = [
        "sweep",
        "slow.tk",
        "--over",
        "c=1:2:0.1",
        "--want",
        "x,y",
        "--jobs",
        "1",
        "-o",
        f"out.{ending}",
    ]
    words += ["--all"] if every else []
    main((*words, "-o", f"whole.{ending}"))
    monkeypatch.setattr(Records, "add", lambda *given: False)
    before, asked = Plan.judged, []

    def judged(plan: Plan, numbers: tuple[float, ...]) -> object:
        asked.append(numbers)
        if len(asked) == 6:
            os.kill(os.getpid(), signal.SIGINT)
        return before(plan, numbers)

    with monkeypatch.context() as patch:
        patch.setattr(Plan, "judged", judged)
        assert main(words) == INTERRUPTED
    read, whole = ({*_rows_of(Path(f"{name}.{ending}"), "c")} for name in ("out", "whole"))
    assert len(read) == 5
    assert read == set(sorted(whole)[:5])
    assert sorted(item.name for item in tmp_path.iterdir()) == [
        f"out.{ending}",
        "slow.tk",
        f"whole.{ending}",
    ]


class Piece:
    """A piece under way, which comes to an end once workers are interrupted."""

    def __init__(self, codes: np.ndarray, told: list[str]) -> None:
        self.codes, self.told = codes, told

    def result(self, patience: float) -> Rows:
        if not self.told:
            raise TimeoutError
        return Rows((), self.codes, Answers(self.codes, []))


def test_an_interrupt_keeps_the_rows_of_pieces_under_way_with_workers(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The first piece comes to its end, the second is cut short; what comes after it is no use."""
    failed, told = CODES[solver.Status.FAILED], list[str]()
    codes = [np.zeros(256), np.repeat([0, failed], [100, 156]), np.zeros(256)]
    pieces = iter([Piece(some.astype(np.int8), told) for some in codes])
    asked = work_of(solver.prepare(rulesheets.loads("y = 2"), [], ["y"]))
    found = in_order(
        lambda chunk: next(pieces), [(), (), ()], lambda: 4, lambda: told.append("stop")
    )
    waits = iter([False] * 5)
    monkeypatch.setattr(workers, "interrupted", lambda: next(waits, True))
    monkeypatch.setattr(sweeping, "interrupted", lambda: bool(told))
    tables = list(followed(asked, found))
    assert [len(table.status) for table in tables] == [256, 100]
    assert told


def _processor_time(process: int) -> float:
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@pytest.mark.skipif(
    not Path("/proc/self/stat").exists(), reason="asks Linux for the time of a process"
)
def test_a_worker_sends_what_it_has_of_a_piece() -> None:
    """Rows of a block that no record is good for take milliseconds: an interrupt comes among
    them."""
    model = rulesheets.loads(
        "variables\n  c\n  x in [0, 9]\nrules\n  x + 0.1*sgn(sin(9*x)) + mod(x, 0.3) = c\n"
    )
    work = work_of(solver.prepare(model, ["c"], ["x"]))
    with closing(workers._Workers(work.packed(), 1)) as some:
        future = some.submit((np.linspace(1.0, 8.0, 60_000),))
        while not some._all or _processor_time(some._all[0].pid) < 1.5:
            assert not future.done()
            time.sleep(0.05)
        some.interrupt()
        piece = future.result(20.0)
    solved = piece.codes != CODES[solver.Status.FAILED]
    assert len(piece.codes) == 60_000
    assert 0 < solved.sum() < 60_000


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_a_sweep_goes_on_where_it_was_cut_off(sheet: Path, tmp_path: Path, ending: str) -> None:
    pytest.importorskip("pyarrow")
    over = ("sweep", str(sheet), "--over", "u=20:200:1", "--want", "v,kind", "-o")
    whole, cut = (str(tmp_path / f"{name}.{ending}") for name in ("whole", "cut"))
    code = main((*over, whole))
    lines = tmp_path / "rows.csv"
    lines.write_text("u\n" + "".join(f"{u}\n" for u in range(20, 120)))
    main(("sweep", str(sheet), "--rows", str(lines), "--want", "v,kind", "-o", cut))
    for _ in range(2):  # the second time nothing is left
        assert main((*over, cut, "--resume")) == code
        assert _table_of(cut) == _table_of(whole)


def test_rows_that_are_there_are_not_solved_again(sheet: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.csv"
    out.write_text("u,v,answers,status\n100,12345,1,solved\n101,,0,infeasible\n")
    assert (
        main(
            (
                "sweep",
                str(sheet),
                "--over",
                "u=100:102:1",
                "--want",
                "v",
                "-o",
                str(out),
                "--resume",
            )
        )
        == 1
    )
    lines = out.read_text().splitlines()
    assert lines[:3] == ["u,v,answers,status", "100,12345,1,solved", "101,,0,infeasible"]
    assert lines[3].startswith("102,98.07")


def test_only_the_same_sweep_goes_on(
    sheet: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = str(tmp_path / "out.csv")
    main(("sweep", str(sheet), "--over", "u=100:110:1", "--want", "v", "-o", out))
    text = Path(out).read_text()
    for over, options in (
        ("u=100:105:1", ("--want", "v", "-o", out)),
        ("u=101:120:1", ("--want", "v", "-o", out)),
        ("u=100:120:1", ("--want", "v,f", "-o", out)),
        ("f=100:120:1", ("--want", "v", "-o", out)),
        ("u=100:120:1", ("--want", "v", "-o", out, "--all")),
        ("u=100:120:1", ("--want", "v")),
    ):
        capsys.readouterr()
        assert main(("sweep", str(sheet), "--over", over, *options, "--resume")) == 2
        assert capsys.readouterr().err.startswith("error[E448]")
        assert Path(out).read_text() == text
    new = str(tmp_path / "new.csv")
    assert (
        main(("sweep", str(sheet), "--over", "u=100:110:1", "--want", "v", "-o", new, "--resume"))
        == 0
    )
    assert Path(new).read_text() == text


def test_rows_that_failed_at_the_end_are_solved_again(sheet: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.csv"
    words = ("sweep", str(sheet), "--over", "u=100:105:1", "--want", "v", "-o", str(out))
    main(words)
    text = out.read_text().splitlines()
    out.write_text(
        "\n".join([*text[:4], *(f"{line.split(',')[0]},,0,failed" for line in text[4:])]) + "\n"
    )
    assert main((*words, "--resume")) == 0
    assert out.read_text().splitlines() == text


def _table_of(path: str) -> list[tuple[object, ...]]:
    found = [tuple(column) for column in read_all(path)]
    return list(zip(*found, strict=True))


def read_all(path: str) -> list[list[object]]:
    names, _ = heading(path)
    pieces_ = list(pieces(path, names))
    columns = (stacked(column).tolist() for column in zip(*pieces_, strict=True))
    return [[None if value != value else value for value in column] for column in columns]


def test_an_outcome_counts_its_rows() -> None:
    assert str(Outcome((1_340, 0, 0, 21, 0, 0))) == "1,361 rows: 1,340 solved, 21 infeasible"
    assert str(Outcome((0,) * 6)) == "no rows"
