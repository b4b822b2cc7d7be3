"""A limit in time: what is known when it is met, and nothing that is not."""

from __future__ import annotations

import json
import os
import random
import subprocess
import sys
from collections.abc import Iterator
from itertools import count
from pathlib import Path

import numpy as np
import pytest

import rulesheets
import solver
from rulesheets import deadline
from rulesheets.deadline import TimeIsUp, expect_time, expired, grace, time_limit
from rulesheets.model import Model
from solver.__main__ import main
from solver.commands import WRONG
from solver.commands import solve as solve_command
from solver.facts import Status
from solver.solution.solving import Result
from solver.trace.records import Records

ROOT = Path(__file__).parent.parent.parent


def endless(n: int = 40) -> str:
    """A dense block whose tears alone take hours to choose."""
    draw = random.Random(n)
    sums = (
        " + ".join(f"sin({draw.uniform(0.5, 2.0):.3f}*x{j}*x{(i + j) % n})" for j in range(n))
        for i in range(n)
    )
    return "".join(
        f"{terms} + exp(x{i}/5) = {draw.uniform(-1, 3):.3f}\n" for i, terms in enumerate(sums)
    )


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> None:
    """A clock that goes on by a second whenever it is looked at: a limit is a number of looks."""
    ticks = count()
    monkeypatch.setattr(deadline, "monotonic", lambda: float(next(ticks)))
    for module in ("solution.solving", "solution.explore", "solution.verdict"):
        monkeypatch.setattr(f"solver.{module}.GRACE", 1e9)


# --- the clock ------------------------------------------------------------------


def test_no_limit_is_none() -> None:
    expect_time()
    with time_limit(None):
        expect_time()
    assert not expired()


@pytest.mark.usefixtures("clock")
def test_the_earlier_limit_counts() -> None:
    with time_limit(5), pytest.raises(TimeIsUp), time_limit(100):
        for _ in range(10):
            expect_time()
    with time_limit(3):
        for _ in range(9):
            assert expired() or True
        with grace(5):
            expect_time()
        assert expired()


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("nan")])
def test_a_limit_is_positive(seconds: float) -> None:
    with pytest.raises(ValueError, match="positive number of seconds"):
        solver.solve(rulesheets.loads("a = 3"), timeout=seconds)


# --- solves that are cut off ----------------------------------------------------


def test_what_would_run_for_hours_ends(tmp_path: Path) -> None:
    sheet = tmp_path / "endless.tk"
    sheet.write_text(f"y = 2*z\nz = 3\n{endless()}")
    words = [
        sys.executable,
        "-m",
        "solver",
        "solve",
        sheet,
        "--timeout",
        "1",
        "--json",
        "--no-cache",
    ]
    done = subprocess.run(
        words,
        capture_output=True,
        text=True,
        timeout=120,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    assert done.returncode == 1, done.stderr
    told = json.loads(done.stdout)
    assert told["status"] == "failed"
    assert not told["complete"]
    (diagnosis,) = told["diagnoses"]
    assert diagnosis["code"] == "S553"
    assert diagnosis["notes"][1].startswith("until then ")


SHEETS = {
    "several answers": "x^2 = 2\ny^2 = x + 3\n",
    "a block": "x + y = 3\nx*y = 2\nx^2 + y^2 = 5\n",
    "starts": "sin(x*y) + exp(x/3) = 1.2\ncos(x) + x*y^2 = 0.7\n",
    "cases": "if x > 2 then y = x^2 else y = 4*x\ny = x + 6\n",
    "infeasible": "a = 3\nx^2 = -a\n",
    "contradiction": "a = 3\na = 4\nb = a\n",
    "many digits": "x = 1e8\ny^2 - 2*y*x + x^2 = 1e-8\n",
    "nothing": "x + y = z\n",
}


@pytest.mark.usefixtures("clock")
@pytest.mark.parametrize("text", SHEETS.values(), ids=SHEETS)
def test_nothing_false_is_said_wherever_a_solve_is_cut_off(text: str) -> None:
    whole = solver.solve(rulesheets.loads(text), timeout=1e12)
    statuses: set[Status] = set()
    for looks in _limits():
        found = solver.solve(rulesheets.loads(text), timeout=looks)
        codes = {one.code for one in found.diagnoses}
        if "S553" not in codes:
            assert (found.status, found.solutions) == (whole.status, whole.solutions)
            break
        statuses.add(found.status)
        assert found.status in (Status.FAILED, whole.status)
        assert not found.complete or found.status is Status.INFEASIBLE
        if found.status is Status.SOLVED:
            assert all(
                any(_alike(one, other) for other in whole.solutions) for one in found.solutions
            )
        if found.status is Status.FAILED:
            assert not found.solutions
            for name, value in found.partial.items():
                assert all(
                    other[name] == pytest.approx(value, rel=1e-9) for other in whole.solutions
                ), name
    assert statuses


def _limits() -> Iterator[float]:
    """Every number of looks at first, then ever wider apart."""
    looks = 1.0
    while True:
        yield looks
        looks = max(looks + 1.0, float(int(looks * 1.1)))


def _alike(one: solver.Solution, other: solver.Solution) -> bool:
    return all(value == pytest.approx(other[name], rel=1e-9) for name, value in one.items())


@pytest.mark.usefixtures("clock")
def test_answers_found_in_time_are_listed() -> None:
    """Eight answers, each of which takes some looks."""
    text = "x^2 = 2\ny^2 = 3\nz^2 = 5\n"
    counts = {len(_cut(text, looks).solutions) for looks in range(2, 60)}
    assert counts >= {0, 2, 4, 8}
    found = next(r for looks in range(2, 60) if len((r := _cut(text, looks)).solutions) == 4)
    assert found.status is Status.SOLVED
    messages = [one.message for one in found.diagnoses]
    assert messages == ["the time was up: 4 answers found, and there may be others"]


def _cut(text: str, looks: int) -> Result:
    return solver.solve(rulesheets.loads(text), timeout=looks)


# --- prepared calls and sweeps --------------------------------------------------


def model() -> Model:
    return rulesheets.loads("sin(x*y) + exp(x/3) = c\ncos(x) + x*y^2 = 0.7\n")


@pytest.mark.usefixtures("clock")
def test_a_prepared_call_that_meets_the_limit_is_unsolved() -> None:
    plan = solver.prepare(model(), ["c"], ["x", "y"], timeout=3)
    with pytest.raises(solver.Unsolved) as caught:
        plan(1.2)
    assert caught.value.status is Status.FAILED
    assert [one.code for one in caught.value.diagnoses] == ["S553"]
    patient = solver.prepare(model(), ["c"], ["x", "y"], timeout=1e12)
    assert patient(1.2) == solver.prepare(model(), ["c"], ["x", "y"])(1.2)


def test_a_sweep_keeps_the_rows_that_were_solved_in_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """The system's clock, which the processes of a sweep share, jumps after two rows."""
    values = np.array([1.2, 1.21, 1.22, 1.23])
    whole = solver.sweep(model(), {"c": values}, ["x"])
    solved = []

    def judged(plan: solver.sweeps.Plan, numbers: object) -> object:
        solved.append(numbers)
        if len(solved) > 2:
            monkeypatch.setattr(deadline, "monotonic", lambda: 1e12)
        return before(plan, numbers)

    before = solver.sweeps.Plan.judged
    monkeypatch.setattr(solver.sweeps.Plan, "judged", judged)
    monkeypatch.setattr(Records, "add", lambda *given: False)
    table = solver.sweep(model(), {"c": values}, ["x"], timeout=1e6)
    done = np.flatnonzero(table.solved)
    assert 0 < len(done) < 4
    assert np.allclose(table["x"][done], whole["x"][done], rtol=1e-12, atol=0.0)
    rest = np.setdiff1d(np.arange(4), done)
    assert {str(table.STATUSES[code]) for code in table.status[rest]} == {"failed"}
    assert np.isnan(table["x"][rest]).all()


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_rows_that_take_too_long_fail(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], jobs: str
) -> None:
    (tmp_path / "endless.tk").write_text(endless().replace("exp(x0/5)", "exp(x0/5) + c"))
    words = (
        "sweep",
        str(tmp_path / "endless.tk"),
        "--over",
        "c=1:3:1",
        "--want",
        "x1",
        "--jobs",
        jobs,
    )
    assert main((*words, "--timeout", "1")) == 1
    said = capsys.readouterr()
    assert said.out == "c,x1,answers,status\n1,,0,failed\n2,,0,failed\n3,,0,failed\n"
    assert (
        said.err.splitlines()[0] == "the time was up: rows that were not solved by then are failed"
    )


def test_a_curve_that_takes_too_long_is_not_said_to_be_none(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "endless.tk").write_text(endless().replace("exp(x0/5)", "exp(x0/5) + c"))
    words = ("sweep", str(tmp_path / "endless.tk"), "--follow", "--over", "c=1:3:1", "--want", "x1")
    assert main((*words, "--timeout", "1")) == 1
    assert capsys.readouterr().err == "the time was up: there may be branches that were not found\n"


# --- the command ----------------------------------------------------------------


@pytest.mark.parametrize("text", ["0", "-1", "soon", "nan"])
@pytest.mark.parametrize("words", [("solve", "offset_slider_crank"), ("open", "loan"), ("lsp",)])
def test_a_limit_that_is_none_is_refused(
    words: tuple[str, ...], text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main((*words, f"--timeout={text}")) == WRONG
    assert "no number of seconds" in capsys.readouterr().err


def test_a_command_that_meets_the_limit_elsewhere_says_so(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def run(arguments: object) -> int:
        raise TimeIsUp

    command = solve_command.COMMANDS["solve"]._replace(run=run)
    monkeypatch.setitem(solve_command.COMMANDS, "solve", command)
    assert main(("solve", "offset_slider_crank", "--timeout", "1")) == 1
    assert capsys.readouterr().err == "error[S553]: the time was up\n"
