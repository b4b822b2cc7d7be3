"""What other benchmarks measure, in the same run: starting up, reaching the disk, sheets of many rules."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from benchmarks import scale, startup, sweep_io
from benchmarks.speed.page import Claim, Section, figures

GIGABYTE = 1024.0


def starting(repetitions: int) -> Section:
    """Whole processes (``benchmarks/startup.py``)."""
    with tempfile.TemporaryDirectory() as folder:
        found = startup.measure(repetitions, Path(folder))
    rows = [(f"python -c '{name}'", figures(found[name] * 1e3)) for name in startup.YARDSTICKS]
    rows += [(f"backsolve {name}", figures(found[name] * 1e3)) for name, *_ in startup.MEASURED]
    claims = [
        Claim(f"{name}, of {yardstick}", limit, found[name] / found[yardstick])
        for name, _, _, yardstick, limit in startup.MEASURED
    ]
    remark = f"Medians of {repetitions} whole processes, wall clock, taken in turn."
    return Section("startup", "Starting", ("ms", "wall"), rows, (remark,), claims)


def to_disk(rows: int) -> Section:
    """A sweep to Parquet (``benchmarks/sweep_io.py``)."""
    memory = sweep_io.in_its_own_process("memory", sweep_io.IN_MEMORY, False)
    with tempfile.TemporaryDirectory(dir=".") as folder:
        path = os.path.join(folder, "table.parquet")
        found = sweep_io.in_its_own_process("file", path, rows, False)
        disk = sweep_io.in_its_own_process("disk", path)
    runs = (
        (f"in memory, {sweep_io.IN_MEMORY:,} rows", memory, sweep_io.IN_MEMORY),
        (f"to a file of {found['MB']:,.0f} MB", found, rows),
        ("plain write of as many bytes", disk, rows),
    )
    walls = [took["wall"] / count for _, took, count in runs]
    return Section(
        "disk",
        f"{rows:,} rows to Parquet",
        ("", "millions of rows a second", "ns a row, cpu"),
        [
            (name, figures(1e-6 * count / took["wall"]), figures(1e9 * took["cpu"] / count))
            for name, took, count in runs
        ],
        ("Rates are by the clock, each measured in a process of its own, one after the other.",),
        [
            Claim(
                "rate, of the lower of memory and disk",
                80,
                100 * max(walls[0], walls[2]) / walls[1],
                "%",
                True,
            ),
            Claim("memory at its peak", GIGABYTE, found["memory"], "MB"),
        ],
    )


def many_rules(rules: int) -> Section:
    """A chain of rules, loaded a second time (``benchmarks/scale.py``)."""
    with tempfile.TemporaryDirectory() as store:
        first, again = (scale.in_its_own_process("chain", rules, store) for _ in range(2))
    rows = [
        (stage, *(f"{found[stage]:.2f}" for found in (first, again))) for stage in ("load", "path", "solve")
    ]
    return Section(
        "rules",
        f"A chain of {rules:,} rules",
        ("seconds", "first time", "again"),
        rows,
        (),
        [Claim("loaded again", 1, again["load"], "s")],
    )
