"""A path that was found once is not looked for again in a later run, and answers do not depend on
it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from rulesheets import load, store
from solver import Result, Status
from solver.commands import Request
from solver.commands import solve as command
from solver.commands.solve import remembered
from solver.path import building
from solver.path.planner import planner

LOOP = "x^2 + y^2 = r^2\nx + y = s\nif s < 4 then z = 2*s else z = q + r\nq = 3*s\n"


@pytest.fixture
def sheet(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("BACKSOLVE_CACHE", str(tmp_path / "cache"))
    (tmp_path / "loop.tk").write_text(LOOP)
    return tmp_path / "loop.tk"


@pytest.fixture
def built(monkeypatch: pytest.MonkeyPatch) -> list[frozenset[str]]:
    """What is known to each path that is built."""
    seen: list[frozenset[str]] = []
    run = building.Building.run

    def counted(self: building.Building) -> object:
        names = zip(self.graph.names, self.frontier.known, strict=True)
        seen.append(frozenset(name for name, known in names if known))
        return run(self)

    monkeypatch.setattr(building.Building, "run", counted)
    return seen


def asked(sheet: Path, **inputs: float) -> Result:
    """Solved in what a new run knows."""
    return remembered(Request(load(sheet), inputs, {}, None))


def test_a_path_is_built_once_for_inputs_of_the_same_names(
    sheet: Path, built: list[object]
) -> None:
    first = asked(sheet, r=5.0, s=1.0)
    assert sorted((answer["x"], answer["y"]) for answer in first.solutions) == [
        (-3.0, 4.0),
        (4.0, -3.0),
    ]
    count = len(built)
    again = asked(sheet, r=5.0, s=1.0)
    assert again == first
    assert again.complete is first.complete
    other = asked(sheet, r=13.0, s=-7.0)
    assert sorted((answer["x"], answer["y"]) for answer in other.solutions) == [
        (-12.0, 5.0),
        (5.0, -12.0),
    ]
    assert len(built) == count


def test_numbers_that_lead_elsewhere_are_followed_there(sheet: Path, built: list[object]) -> None:
    """Beyond s = 4 the other arm of the rule counts: its path is built, and kept as well."""
    assert asked(sheet, r=5.0, s=1.0)["z"] == 2.0
    for _ in range(2):
        count = len(built)
        assert asked(sheet, r=5.0, s=7.0)["z"] == 26.0
    assert asked(sheet, r=5.0, s=1.0)["z"] == 2.0
    assert len(built) == count


def test_other_inputs_are_another_question(sheet: Path) -> None:
    asked(sheet, r=5.0, s=1.0)
    found = asked(sheet, r=5.0, x=3.0)
    assert sorted(answer["y"] for answer in found.solutions) == [-4.0, 4.0]


def test_what_a_sheet_and_the_sheets_that_it_uses_say_decides(sheet: Path) -> None:
    part, whole = sheet.parent / "part.tk", sheet.parent / "whole.tk"
    part.write_text("function f(a; b)\nrules\n  b + a = 3\n  b - a = c\n  c = 1\n")
    whole.write_text('use "part.tk"\ny = f(x)\n')
    assert (asked(whole)["x"], asked(whole)["y"]) == (1.0, 2.0)
    part.write_text("function f(a; b)\nrules\n  b + a = 3\n  b - 2*a = c\n  c = 0\n")
    assert (asked(whole)["x"], asked(whole)["y"]) == (1.0, 2.0)
    part.write_text("function f(a; b)\nrules\n  b + a = 7\n  b - 2*a = c\n  c = 1\n")
    assert (asked(whole)["x"], asked(whole)["y"]) == (2.0, 5.0)


def test_other_code_builds_its_own_paths(
    sheet: Path, built: list[object], monkeypatch: pytest.MonkeyPatch
) -> None:
    asked(sheet, r=5.0, s=1.0)
    count = len(built)
    monkeypatch.setattr(command, "stamp", lambda folder: b"other code")
    asked(sheet, r=5.0, s=1.0)
    assert len(built) > count


def test_a_damaged_entry_is_made_again(sheet: Path, built: list[object]) -> None:
    first = asked(sheet, r=5.0, s=1.0)
    count = len(built)
    (entry,) = (sheet.parent / "cache").glob("found-*")
    entry.write_bytes(entry.read_bytes()[:-1])
    assert asked(sheet, r=5.0, s=1.0) == first
    assert len(built) == 2 * count


def test_what_cannot_be_written_is_not_kept(sheet: Path) -> None:
    model = load(sheet)
    planner(model).graph.__dict__["unwritable"] = lambda: None
    assert remembered(Request(model, {"r": 5.0, "s": 1.0}, {}, None)).status is Status.SOLVED
    assert not list((sheet.parent / "cache").glob("found-*"))
    assert store.usage()[0]


def test_a_later_run_imports_nothing_that_builds(sheet: Path) -> None:
    code = (
        "import sys; from solver.__main__ import main; main(sys.argv[1:]); "
        "print({'solver.path.building', 'solver.path.elimination'}.isdisjoint(sys.modules))"
    )
    words = [
        sys.executable,
        "-c",
        code,
        "solve",
        str(sheet),
        "--set",
        "r=5",
        "--set",
        "s=1",
        "--all",
    ]
    runs = [
        subprocess.run(words, capture_output=True, text=True, check=True).stdout for _ in range(2)
    ]
    (first, builds), (second, builds_again) = (run.rstrip().rsplit("\n", 1) for run in runs)
    assert first == second
    assert (builds, builds_again) == ("False", "True")
