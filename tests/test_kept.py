"""What is kept between runs changes how fast an answer comes, never the answer: the same bytes either way."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy
import pytest

import rulesheets
import solver
from rulesheets import store
from solver.cli import main
from solver.path.build import build_path
from solver.plan import Plan

MODELS = rulesheets.shipped_models()
CRANK = "solve offset_slider_crank"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    place = tmp_path / "store"
    monkeypatch.setenv("BACKSOLVE_CACHE", str(place))
    return place


Printed = tuple[int, str, str]


def printed(line: str, capsys: pytest.CaptureFixture[str]) -> Printed:
    code = main(line.split())
    out, err = capsys.readouterr()
    return code, out, err


def without_and_twice(line: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> Iterator[Printed]:
    """What a command prints with nothing kept, when it keeps for the first time, and when it finds that."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("BACKSOLVE_CACHE", "")
        yield printed(line, capsys)
    for _ in range(2):
        yield printed(line, capsys)


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("words", ["solve {} --all --explain", "path {}"])
def test_every_model_prints_the_same_bytes(
    name: str, words: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fresh, first, second = without_and_twice(words.format(name), folder, capsys)
    assert fresh == first == second
    assert fresh[1]


@pytest.mark.parametrize(
    "line",
    [
        "check offset_slider_crank",
        "check offset_slider_crank --equations",
        "why offset_slider_crank vB",
        f"{CRANK} --csv",
        f"{CRANK} --json --explain",
        f"{CRANK} --clear thetaAO --set xB=9.79 --all --digits",
        f"{CRANK} --clear thetaAO --set xB=99",  # infeasible
        f"{CRANK} --set xB=9",  # inconsistent
        f"{CRANK} --clear thetaAO --json",  # partial
        f"{CRANK} --clear branch",  # cases left open
        "solve tax_brackets --clear income --set tax=5000",  # cases that are settled
        f"{CRANK} --set nothing=1",  # a mistake
        "sweep offset_slider_crank --over thetaAO=0:40:20 --want vB",
        "sweep offset_slider_crank --over thetaAO=0:360:0.5 --want vB,aB",
        "sweep offset_slider_crank --over xB=4:11:0.02 --clear thetaAO --want thetaAO,vB --all",
    ],
)
def test_every_outcome_prints_the_same_bytes(
    line: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fresh, first, second = without_and_twice(line, folder, capsys)
    assert fresh == first == second


@pytest.mark.parametrize("damage", ["cut", "flipped", "empty"])
def test_damaged_entries_do_no_harm(damage: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    whole = printed(CRANK, capsys)
    for entry in folder.iterdir():
        data = bytearray(entry.read_bytes())
        data[len(data) // 2] ^= 1
        entry.write_bytes({"cut": data[: len(data) // 2], "flipped": data, "empty": b""}[damage])
    assert printed(CRANK, capsys) == whole


@pytest.fixture
def planned(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many variables were known each time that a path had to be found."""
    runs: list[int] = []

    def noted(*question: object) -> object:
        runs.append(len(question[1]))  # type: ignore[arg-type]
        return build_path(*question)  # type: ignore[arg-type]

    monkeypatch.setattr("solver.path.build.build_path", noted)
    return runs


def test_other_values_follow_the_kept_path(folder: Path, planned: list[int]) -> None:
    fresh = solver.solve(rulesheets.load("offset_slider_crank"))
    count = len(planned)
    assert count > 0
    again = solver.solve(rulesheets.load("offset_slider_crank"), {"thetaAO": 20.0})
    assert len(planned) == count
    assert again.path == fresh.path
    assert solver.solve(rulesheets.load("offset_slider_crank")).solutions == fresh.solutions


def test_a_sweep_seen_before_solves_nothing_step_by_step(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def swept(first: float) -> solver.Table:
        rows = numpy.linspace(first, 11.5, 400)
        model = rulesheets.load("offset_slider_crank")
        return solver.sweep(model, {"xB": rows}, ["thetaAO", "vB"], given={"thetaAO": None})

    before = swept(4.5)
    assert len(set(before.status.tolist())) > 1
    judged: list[object] = []
    plainly = Plan.judged
    monkeypatch.setattr(Plan, "judged", lambda plan, row: (judged.append(row), plainly(plan, row))[1])
    again = swept(4.5)
    assert judged == []
    assert again.status.tobytes() == before.status.tobytes()
    assert all(again[name].tobytes() == before[name].tobytes() for name in before)
    swept(4.25)  # other rows teach what they teach
    assert judged


def test_other_inputs_and_other_wants_are_other_paths(folder: Path, planned: list[int]) -> None:
    for inputs, want in (
        ({}, None),
        ({}, ["vB"]),
        ({}, ["xB"]),
        ({"thetaAO": None, "xB": 9.79}, None),
        ({"thetaAO": None, "xB": 9.79}, ["thetaAO"]),
    ):
        before = len(planned)
        first = solver.solve(rulesheets.load("offset_slider_crank"), inputs, want=want)
        between = len(planned)
        second = solver.solve(rulesheets.load("offset_slider_crank"), inputs, want=want)
        assert before < between == len(planned)
        assert (first.path, first.solutions) == (second.path, second.solutions)


def test_cases_that_come_up_later_are_added(tmp_path: Path, folder: Path, planned: list[int]) -> None:
    sheet = tmp_path / "abs.tk"
    sheet.write_text("x = a\nif x > 0 then y = x^2 + 1 else y = -x\nz = y + 1\n")

    def solved(a: float) -> object:
        return solver.solve(rulesheets.load(sheet), {"a": a})["z"]

    assert [solved(2.0), solved(-2.0)] == [6.0, 3.0]
    before = len(planned)
    assert [solved(3.0), solved(-3.0)] == [11.0, 4.0]
    assert len(planned) == before


def test_texts_in_no_file_keep_no_paths(folder: Path) -> None:
    solver.solve(rulesheets.loads("V = I*R"), {"V": 12.0, "R": 6.0})
    assert store.usage() == (0, 0)


def test_no_cache_neither_reads_nor_keeps(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("BACKSOLVE_CACHE", str(folder))  # what the command changes is put back
    fresh = printed(f"{CRANK} --no-cache", capsys)
    assert not folder.exists()
    assert fresh[0] == 0


def test_the_cache_command(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert printed("cache", capsys) == (0, f"{folder}: no entries, 0.0 kB\n", "")
    printed(CRANK, capsys)
    code, out, _ = printed("cache", capsys)
    assert code == 0
    count = len(list(folder.iterdir()))
    assert count >= 2
    assert out.startswith(f"{folder}: {count} entries, ")
    assert printed("cache --clear", capsys) == (0, f"{folder}: {count} entries removed\n", "")
    assert list(folder.iterdir()) == []
    folder.chmod(0o777)
    assert "not used" in printed("cache", capsys)[2]
    monkeypatch.setenv("BACKSOLVE_CACHE", "")
    assert printed("cache", capsys) == (0, "nothing is kept: BACKSOLVE_CACHE is empty\n", "")
