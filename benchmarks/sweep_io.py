"""How fast sweeps of the slider crank reach the disk, and in how much memory.

    python benchmarks/sweep_io.py [ROWS…] [--csv] [--pipeline]

For each number of rows (1e6 and 1e7; 1e8 takes 4.5 GB of disk) three rates, each in a process of its own:
the sweep in memory, the sweep to a Parquet file (with --csv to CSV), and a plain write of the same
bytes. ``of bound`` is the rate to the file over the lower one of memory and disk; ``CPU`` is the time
of the processors, which other work on the machine does not stretch: that of the sweep to the file,
and its ratio to that of the other two together. With --pipeline the closed form by hand, in blocked
numpy, stands in for the solver: what is left is the way to the disk.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from fractions import Fraction
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))

import numpy as np

WANT = ("xB", "vB", "omegaAB", "aB", "alphaAB")
SIZES = (1_000_000, 10_000_000)
IN_MEMORY = 1_000_000
"""Rows by which the rate in memory is measured."""
PATIENCE = 300.0
"""Seconds that one measurement may take, judged by its first rows."""

HEAD = (
    f"{'rows':>12}{'memory':>9}{'file':>9}{'disk':>9}{'of bound':>10}"
    f"{'MB file':>9}{'MB memory':>11}{'CPU ns/row':>12}{'of both':>9}"
)


def closed_form(theta: np.ndarray) -> dict[str, np.ndarray]:
    """Position, velocity and acceleration of the slider crank of the paper, in blocks that fit the cache."""
    found = {name: np.empty(len(theta)) for name in WANT}
    for start in range(0, len(theta), 4096):
        block = slice(start, start + 4096)
        angle = np.deg2rad(theta[block])
        x, y = 3.0 * np.cos(angle), 3.0 * np.sin(angle)
        down = 2.0 - y
        along = np.sqrt(64.0 - down * down)
        omega = 15.0 * x / along
        ax, ay = 10.0 * y - 225.0 * x, -10.0 * x - 225.0 * y
        alpha = (omega * omega * down - ay) / along
        values = (x + along, 15.0 * y - omega * down, omega, ax - alpha * down - omega * omega * along, alpha)
        for name, value in zip(WANT, values, strict=True):
            found[name][block] = value
    return found


def rows(count: int):
    from solver.sweeps.grid import Grid, Stretch

    return Grid((Stretch(Fraction(0), Fraction(360, count), count),))


def work(csv: bool, count: int):
    import rulesheets
    import solver
    from solver.sweeping import work_of
    from solver.sweeps.chunks import grid_lessons

    plan = solver.prepare(rulesheets.load("offset_slider_crank"), ["thetaAO"], WANT)
    return work_of(plan, grid_lessons(rows(count)), tabled=not csv, texted=csv)


def by_hand(work, count: int) -> Iterator:
    """The pieces of the sweep, solved by the closed form instead of the sheet."""
    from solver.files.columns import Columns
    from solver.files.csv_table import csv_rows
    from solver.result import Status
    from solver.sweeps.chunks import grid_chunks
    from solver.sweeps.work import Solved

    words = tuple(map(str, Status))
    for (theta,) in grid_chunks(rows(count)):
        values = {"thetaAO": theta, **closed_form(theta)}
        table = Columns(values, np.zeros(len(theta), dtype=np.int8), words)
        counts = (len(theta),) + (0,) * (len(words) - 1)
        yield Solved(counts, table) if work.tabled else Solved(counts, None, csv_rows(table))


@dataclass(frozen=True)
class Took:
    """Seconds of the clock and of the processors."""

    wall: float
    cpu: float


class Timer:
    def __init__(self) -> None:
        self._wall, self._cpu = time.perf_counter(), time.process_time()

    def took(self) -> Took:
        return Took(time.perf_counter() - self._wall, time.process_time() - self._cpu)


def in_memory(count: int, pipeline: bool) -> Took:
    """A sweep of ``count`` rows that stays in memory, in pieces as large as those of a file."""
    import rulesheets
    import solver
    from solver.sweeps.chunks import LARGEST

    theta = np.arange(count) * (360.0 / count)
    plan = solver.prepare(rulesheets.load("offset_slider_crank"), ["thetaAO"], WANT)
    solved = closed_form if pipeline else plan.sweep
    timer = Timer()
    solved(theta[:2000])
    if timer.took().wall * count / 2000 > PATIENCE:
        raise SystemExit(f"{count:,} rows would take more than {PATIENCE:.0f} s")
    timer = Timer()
    for start in range(0, count, LARGEST):
        solved(theta[start : start + LARGEST])
    return timer.took()


def to_file(path: str, count: int, pipeline: bool) -> dict[str, float]:
    from solver.sweeps.chunks import grid_chunks
    from solver.sweeps.running import solved_pieces
    from solver.sweeps.sinks import FileSink
    from solver.sweeps.stream import run

    todo = work(path.endswith(".csv"), count)
    timer = Timer()
    pieces = by_hand(todo, count) if pipeline else solved_pieces(todo, grid_chunks(rows(count)), count)
    outcome = run(pieces, [FileSink(path, todo.names, ())])
    took = timer.took()
    assert outcome.rows == count and outcome.all_solved
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return {**asdict(took), "MB": os.path.getsize(path) / 1e6, "memory": memory}


def plain_write(path: str) -> Took:
    """The bytes of a file written again, a megabyte at a time."""
    size, block = os.path.getsize(path), os.urandom(2**20)
    timer = Timer()
    with open(path + ".plain", "wb") as file:
        for _ in range(size // 2**20 + 1):
            file.write(block)
    took = timer.took()
    os.unlink(path + ".plain")
    return took


def in_its_own_process(*words: object) -> dict[str, float]:
    command = [sys.executable, __file__, "--one", *map(str, words)]
    answer = subprocess.run(command, capture_output=True, text=True, check=False)
    if answer.returncode:
        raise SystemExit(answer.stderr)
    found: dict[str, float] = json.loads(answer.stdout)
    return found


def table(sizes: list[int], ending: str, pipeline: bool) -> None:
    print("millions of rows a second" + (", solved by the closed form by hand" if pipeline else ""))
    print(HEAD)
    memory = in_its_own_process("memory", IN_MEMORY, pipeline)
    for count in sizes:
        with tempfile.TemporaryDirectory(dir=".") as folder:
            path = os.path.join(folder, f"table{ending}")
            found = in_its_own_process("file", path, count, pipeline)
            disk = in_its_own_process("disk", path)
        each = [memory["wall"] / IN_MEMORY, found["wall"] / count, disk["wall"] / count]
        rates = "".join(f"{1e-6 / seconds:9.2f}" for seconds in each)
        cpu, alone = found["cpu"] / count, memory["cpu"] / IN_MEMORY + disk["cpu"] / count
        share = f"{max(each[0], each[2]) / each[1]:10.0%}{found['MB']:9.0f}{found['memory']:11.0f}"
        print(f"{count:>12,}{rates}{share}{cpu * 1e9:12.0f}{cpu / alone:9.2f}", flush=True)


def one(kind: str, *words: str) -> dict[str, float]:
    match kind:
        case "memory":
            tries = [in_memory(int(words[0]), words[1] == "True") for _ in range(3)]
            return asdict(min(tries, key=lambda took: took.wall))
        case "file":
            return to_file(words[0], int(words[1]), words[2] == "True")
        case _:
            return asdict(plain_write(words[0]))


if __name__ == "__main__":
    arguments = sys.argv[1:]
    if arguments[:1] == ["--one"]:
        print(json.dumps(one(*arguments[1:])))
    else:
        numbers = [int(float(word)) for word in arguments if not word.startswith("--")]
        ending = ".csv" if "--csv" in arguments else ".parquet"
        table(numbers or list(SIZES), ending, "--pipeline" in arguments)
