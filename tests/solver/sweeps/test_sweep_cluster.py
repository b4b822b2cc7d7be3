"""A sweep on a dask cluster: the same bytes as in one process, a killed worker included."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest

import rulesheets
import solver
from rulesheets.diagnosis import RuleSheetError
from solver.__main__ import main
from solver.files.tables import column_of
from solver.sweeps.sweep import Grid, followed, grid_chunks, work_of
from solver.sweeps.workers import solved_pieces

pytest.importorskip("distributed")

ROOT = Path(__file__).parents[3]


@dataclass(frozen=True)
class Cluster:
    address: str
    workers: list[subprocess.Popen[bytes]]


def started(stack: ExitStack, *words: str) -> subprocess.Popen[bytes]:
    """A process of the cluster, ended with the test."""
    process = subprocess.Popen(
        [sys.executable, "-m", *words],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    stack.callback(process.wait)
    stack.callback(process.kill)
    return process


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    """A scheduler and two workers of one thread, as `dask scheduler` and `dask worker` start
    them."""
    file = tmp_path_factory.mktemp("dask") / "scheduler.json"
    where = ("--scheduler-file", str(file))
    local = ("--host", "127.0.0.1", "--no-dashboard")
    with ExitStack() as stack:
        started(stack, "distributed.cli.dask_scheduler", *where, *local, "--port", "0")
        worker = (
            "distributed.cli.dask_worker",
            *where,
            "--nthreads",
            "1",
            "--no-nanny",
            "--no-dashboard",
        )
        workers = [started(stack, *worker) for _ in range(2)]
        while not (file.exists() and file.read_text().endswith("}")):
            time.sleep(0.05)
        yield Cluster(json.loads(file.read_text())["address"], workers)


def test_a_cluster_writes_the_same_bytes(cluster: Cluster, tmp_path: Path) -> None:
    over = ("--over", "thetaAO=0:360:0.6", "--over", "branch=open,crossed", "--want", "xB,aB")
    alone, shared = (str(tmp_path / f"{name}.csv") for name in ("alone", "shared"))
    assert main(["sweep", "offset_slider_crank", *over, "-o", alone, "--jobs", "1"]) == 0
    assert (
        main(["sweep", "offset_slider_crank", *over, "-o", shared, "--scheduler", cluster.address])
        == 0
    )
    assert Path(alone).read_bytes() == Path(shared).read_bytes()
    assert len(Path(alone).read_text().splitlines()) == 1203


def test_a_worker_that_is_killed_costs_no_rows(cluster: Cluster) -> None:
    model = rulesheets.load("offset_slider_crank")
    work = work_of(solver.prepare(model, ["thetaAO"], ["xB", "vB", "aB"]))
    rows = Grid((column_of(np.linspace(-180, 180, 1500)),), zipped=True)
    alone = list(followed(work, solved_pieces(work, grid_chunks(rows), 1500, 1)))
    shared = []
    there = solved_pieces(work, grid_chunks(rows), 1500, scheduler=cluster.address)
    for piece in followed(work, there):
        if not shared:
            cluster.workers[0].kill()
        shared.append(piece)
    assert cluster.workers[0].wait(10) != 0
    assert len(alone) == len(shared) > 4
    for one, other in zip(alone, shared, strict=True):
        assert one.status.tobytes() == other.status.tobytes()
        for name, column in one.items():
            assert column.tobytes() == other[name].tobytes()


def test_a_scheduler_that_is_not_there(monkeypatch: pytest.MonkeyPatch) -> None:
    from solver.sweeps import workers

    monkeypatch.setattr(workers, "ANSWER_WITHIN", 0.3)
    with pytest.raises(RuleSheetError) as caught:
        solver.sweep(rulesheets.loads("y = 2*x"), {"x": [1.0]}, scheduler="tcp://127.0.0.1:1")
    (diagnosis,) = caught.value.diagnoses
    assert diagnosis.code == "E444"
    assert "no scheduler answers at tcp://127.0.0.1:1" in diagnosis.message


def test_a_wrong_address(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sweep", "ohms_law", "--over", "I=1,2", "--scheduler", "nowhere at all"]) == 2
    assert "error[E444]" in capsys.readouterr().err


def test_dask_that_is_not_there_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(RuleSheetError) as caught:
        solver.sweep(rulesheets.loads("y = 2*x"), {"x": [1.0]}, scheduler="tcp://127.0.0.1:1")
    assert caught.value.diagnoses[0].code == "E441"
    assert "pip install 'backsolve[dask]'" in caught.value.diagnoses[0].notes


def test_workers_of_another_version_are_refused() -> None:
    from solver.sweeps.workers import solve_piece

    work = work_of(solver.prepare(rulesheets.loads("y = 2*x"), ["x"]))
    with pytest.raises(RuleSheetError) as caught:
        solve_piece(work.packed(), "0.0.0", (np.ones(1),))
    assert (
        f"Backsolve {version('backsolve')}, and this is 0.0.0" in caught.value.diagnoses[0].message
    )
