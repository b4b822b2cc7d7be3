"""What machine code costs before its first row: compiled for the first time, and found again on
disk."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from benchmarks.speed.page import Claim, Section, figures

ROOT = Path(__file__).parents[2]
CODE = """
import json, sys, time
from benchmarks.speed.task import plan
found = {}
began = time.perf_counter(), time.process_time()
import numpy, llvmlite.binding
found["import llvmlite"] = time.perf_counter() - began[0], time.process_time() - began[1]
for direction in ("forward", "backward"):
    prepared = plan(direction)
    column = numpy.linspace(-30.0, -20.0, 2000) if direction == "forward" else numpy.linspace(9.7, 9.8, 2000)
    prepared.sweep(column)
    began = time.perf_counter(), time.process_time()
    assert prepared.sweep(column, jit=True).solved.all()
    found[direction] = time.perf_counter() - began[0], time.process_time() - began[1]
print(json.dumps(found))
"""


def measure(rounds: int) -> Section:
    first, again = {}, {}
    for _ in range(rounds):
        with tempfile.TemporaryDirectory() as store:
            for best in (first, again):
                for name, (wall, cpu) in _one(store).items():
                    before = best.get(name, (wall, cpu))
                    best[name] = min(before[0], wall), min(before[1], cpu)
    names = {
        "import llvmlite": "importing llvmlite",
        "forward": "forward",
        "backward": "slider-driven",
    }
    rows = [
        (words, *(figures(1e3 * t) for t in (*first[name], *again[name])))
        for name, words in names.items()
    ]
    return Section(
        "jit",
        "Compiling to machine code",
        ("ms", "first time, wall", "first time, cpu", "from disk, wall", "from disk, cpu"),
        rows,
        ("For a sweep of 2,000 rows, after the same sweep without machine code.",),
        [
            Claim(f"{words}, {when}", limit, 1e3 * best[name][1], "ms of processor time")
            for when, best, limit in (("first time", first, 300), ("from disk", again, 50))
            for name, words in list(names.items())[1:]
        ],
    )


def _one(store: str) -> dict[str, tuple[float, float]]:
    environment = {**os.environ, "BACKSOLVE_CACHE": store, "PYTHONPATH": str(ROOT)}
    ran = subprocess.run(
        [sys.executable, "-c", CODE],
        capture_output=True,
        text=True,
        env=environment,
        check=True,
        cwd=ROOT,
    )
    found: dict[str, tuple[float, float]] = json.loads(ran.stdout)
    return found
