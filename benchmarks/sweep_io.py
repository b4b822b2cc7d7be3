"""How fast sweeps of the slider crank reach the disk, and in how much memory.

    python benchmarks/sweep_io.py [ROWS…] [--csv] [--pipeline] [--times=N]

For each number of rows (1e6 and 1e7; 1e8 takes 4.5 GB of disk), by numpy and by machine code (the
extra ``jit``), each measurement in a process of its own and the two sides of a ratio in turns, best
of N (3):

- ``memory``: 1e6 rows that stay in memory, in pieces as large as those of a file;
- ``file``: the sweep to a Parquet file (with --csv to CSV), from its first lesson to the file in
  its place;
- ``disk``: a write of as many bytes, through the memory of the system or past it, whichever is the
  quicker;
- ``of memory``, ``of disk``: the rate to the file over each of these; 80 % of either is asked for;
- ``synced``: ``of disk`` once more, where both wait until the bytes are on the disk (fsync);
- ``CPU``: time of the processors, which other work on the machine does not stretch: that of the
  sweep to the file, and its ratio to that of the other two together.

With --pipeline the closed form by hand, in blocked numpy, stands in for the solver: what is left is
the way to the disk.
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
from importlib.util import find_spec
from mmap import mmap
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))

import numpy as np

WANT = ("xB", "vB", "omegaAB", "aB", "alphaAB")
SIZES = (1_000_000, 10_000_000)
IN_MEMORY = 1_000_000
"""Rows by which the rate in memory is measured."""
PATIENCE = 300.0
"""Seconds that one measurement may take, judged by its first rows."""

BLOCK = 2**24
"""Bytes of a write: larger ones are no faster."""
DISKS = ("through memory", "past memory") if hasattr(os, "O_DIRECT") else ("through memory",)
ROW = 48
"""Bytes of a row in a Parquet file, nearly."""
TIMES = 3

HEAD = (
    f"{'rows':>12}{'by':>7}{'memory':>9}{'file':>9}{'disk':>9}{'of memory':>11}{'of disk':>9}{'synced':>8}"
    f"{'MB file':>9}{'MB memory':>11}{'CPU ns/row':>12}{'of both':>9}"
)


def closed_form(theta: np.ndarray) -> dict[str, np.ndarray]:
    """Position, velocity and acceleration of the slider crank of the paper, in blocks that fit the
    cache."""
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
        values = (
            x + along,
            15.0 * y - omega * down,
            omega,
            ax - alpha * down - omega * omega * along,
            alpha,
        )
        for name, value in zip(WANT, values, strict=True):
            found[name][block] = value
    return found


def rows(count: int):
    from solver.sweeps.sweep import Grid, Stretch

    return Grid((Stretch(Fraction(0), Fraction(360, count), count),))


def work(count: int, jit: bool):
    import rulesheets
    import solver
    from solver.sweeps.sweep import grid_warmup, work_of

    plan = solver.prepare(rulesheets.load("offset_slider_crank"), ["thetaAO"], WANT)
    return work_of(plan, grid_warmup(rows(count)), jit=jit)


def by_hand(count: int) -> Iterator:
    """The pieces of the sweep, solved by the closed form instead of the sheet."""
    from solver.files.tables import Table
    from solver.sweeps.sweep import grid_chunks

    for (theta,) in grid_chunks(rows(count)):
        values = {
            "thetaAO": theta,
            **closed_form(theta),
            "answers": np.ones(len(theta), dtype=np.int64),
        }
        yield Table(values, np.zeros(len(theta), dtype=np.int8))


@dataclass(frozen=True)
class Took:
    """Seconds of the clock and of the processors, and of the clock until everything is on the
    disk."""

    wall: float
    cpu: float
    synced: float = 0.0


class Timer:
    def __init__(self) -> None:
        self._wall, self._cpu = time.perf_counter(), time.process_time()

    def took(self, file: str | None = None) -> Took:
        wall, cpu = time.perf_counter() - self._wall, time.process_time() - self._cpu
        if file is not None:
            with open(file, "rb") as written:
                os.fsync(written.fileno())
        return Took(wall, cpu, time.perf_counter() - self._wall)


def in_memory(count: int, way: str) -> Took:
    """A sweep of ``count`` rows that stays in memory, in pieces as large as those of a file."""
    import rulesheets
    import solver
    from solver.sweeps.sweep import LARGEST

    theta = np.arange(count) * (360.0 / count)
    plan = solver.prepare(rulesheets.load("offset_slider_crank"), ["thetaAO"], WANT)

    def solved(column: np.ndarray) -> object:
        return closed_form(column) if way == "hand" else plan.sweep(column, jit=way == "jit")

    solved(theta[:2000])  # learns
    timer = Timer()
    solved(theta[:2000])
    if timer.took().wall * count / 2000 > PATIENCE:
        raise SystemExit(f"{count:,} rows would take more than {PATIENCE:.0f} s")
    timer = Timer()
    for start in range(0, count, LARGEST):
        solved(theta[start : start + LARGEST])
    return timer.took()


def to_file(path: str, count: int, way: str) -> dict[str, float]:
    from solver.files.tables import table_file
    from solver.sweeps.sweep import followed, grid_chunks, run
    from solver.sweeps.workers import solved_pieces

    todo = work(count, way == "jit")
    timer = Timer()
    solved = by_hand(count) if way == "hand" else None
    solved = solved or followed(todo, solved_pieces(todo, grid_chunks(rows(count)), count))
    outcome = run(solved, [table_file(path, todo.names, ())])
    took = timer.took(path)
    assert outcome.rows == count and outcome.all_solved
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return {**asdict(took), "MB": os.path.getsize(path) / 1e6, "memory": memory}


def plain_write(path: str, size: int, way: str) -> Took:
    """So many bytes, rounded up to whole blocks, written to a new file."""
    block = mmap(-1, BLOCK)
    block.write(os.urandom(BLOCK))
    timer = Timer()
    past = os.O_DIRECT if way == "past memory" else 0
    file = os.open(path, os.O_WRONLY | os.O_CREAT | past, 0o600)
    for _ in range(0, size, BLOCK):
        assert os.write(file, block) == BLOCK
    os.close(file)
    return timer.took(path)


def in_its_own_process(*words: object) -> dict[str, float]:
    command = [sys.executable, __file__, "--one", *map(str, words)]
    answer = subprocess.run(command, capture_output=True, text=True, check=False)
    if answer.returncode:
        raise SystemExit(answer.stderr)
    found: dict[str, float] = json.loads(answer.stdout)
    return found


def ways() -> list[str]:
    """Blocks of numpy; machine code where its extra is there."""
    return ["numpy", "jit"] if find_spec("llvmlite") else ["numpy"]


def of_memory(memory: dict[str, float], file: dict[str, float], count: int) -> float:
    """The rate of a sweep to a file over that of the sweep in memory."""
    return memory["wall"] / IN_MEMORY / (file["wall"] / count)


def of_disk(disk: dict[str, float], file: dict[str, float]) -> float:
    """The rate of a sweep to a file over that of writing as many bytes."""
    return disk["wall"] / file["wall"]


def measured(count: int, ending: str, ways: list[str], times: int) -> dict[str, dict[str, float]]:
    """The best of each way to the file, and of plain writes (``disk``), taken in turns.

    A write before them that is not counted lets all find the memory of the system in the same
    state: where the machine is a guest of another, memory not used for a while has to be had back
    from its host.
    """
    tries: dict[str, list[dict[str, float]]] = {}
    with tempfile.TemporaryDirectory(dir=".") as folder:
        in_its_own_process("disk", os.path.join(folder, "plain"), ROW * count, DISKS[0])
    for _ in range(times):
        for way in ways:
            with tempfile.TemporaryDirectory(dir=".") as folder:
                path = os.path.join(folder, f"table{ending}")
                tries.setdefault(way, []).append(in_its_own_process("file", path, count, way))
            size = int(tries[way][-1]["MB"] * 1e6)
            for disk in DISKS:
                with tempfile.TemporaryDirectory(dir=".") as folder:
                    plain = in_its_own_process("disk", os.path.join(folder, "plain"), size, disk)
                tries.setdefault("disk", []).append(plain)
    return {
        way: {key: min(one[key] for one in found) for key in found[0]}
        for way, found in tries.items()
    }


def table(sizes: list[int], ending: str, ways: list[str], times: int) -> None:
    print(f"millions of rows a second, best of {times}")
    print(HEAD)
    alone = {way: in_its_own_process("memory", IN_MEMORY, way) for way in ways}
    for count in sizes:
        found = measured(count, ending, ways, times)
        disk = found["disk"]
        for way in ways:
            file, memory = found[way], alone[way]
            each = [memory["wall"] / IN_MEMORY, file["wall"] / count, disk["wall"] / count]
            rates = "".join(f"{1e-6 / seconds:9.2f}" for seconds in each)
            shares = f"{of_memory(memory, file, count):11.0%}{of_disk(disk, file):9.0%}"
            shares += f"{disk['synced'] / file['synced']:8.0%}"
            cpu, both = file["cpu"] / count, memory["cpu"] / IN_MEMORY + disk["cpu"] / count
            room = f"{file['MB']:9.0f}{file['memory']:11.0f}"
            print(
                f"{count:>12,}{way:>7}{rates}{shares}{room}{cpu * 1e9:12.0f}{cpu / both:9.2f}",
                flush=True,
            )


def one(kind: str, *words: str) -> dict[str, float]:
    match kind:
        case "memory":
            tries = [in_memory(int(words[0]), words[1]) for _ in range(5)]
            return asdict(min(tries, key=lambda took: took.wall))
        case "file":
            return to_file(words[0], int(words[1]), words[2])
        case _:
            return asdict(plain_write(words[0], int(words[1]), words[2]))


def main(arguments: list[str]) -> None:
    numbers = [int(float(word)) for word in arguments if not word.startswith("--")]
    times = [int(word.partition("=")[2]) for word in arguments if word.startswith("--times=")]
    ending = ".csv" if "--csv" in arguments else ".parquet"
    by_hand = "--pipeline" in arguments
    table(numbers or list(SIZES), ending, ["hand"] if by_hand else ways(), *(times or [TIMES]))


if __name__ == "__main__":
    if sys.argv[1:2] == ["--one"]:
        print(json.dumps(one(*sys.argv[2:])))
    else:
        main(sys.argv[1:])
