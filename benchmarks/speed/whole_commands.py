"""What other benchmarks measure, in the same run: starting up, reaching the disk, sheets of many
rules."""

from __future__ import annotations

import tempfile
from pathlib import Path

from benchmarks import scale, startup, sweep_io
from benchmarks.speed.page import Claim, Section, figures

GIGABYTE = 1024.0
MANY = 10_000_000
"""Rows beyond which one run says enough."""


def starting(repetitions: int) -> Section:
    """Whole processes (``benchmarks/startup.py``)."""
    with tempfile.TemporaryDirectory() as folder:
        found = startup.measure(repetitions, Path(folder))
    rows = [(f"python -c '{name}'", figures(found[name] * 1e3)) for name in startup.YARDSTICKS]
    rows += [(f"backsolve {name}", figures(found[name] * 1e3)) for name, *_ in startup.MEASURED]
    claims = [
        Claim(f"{name}, of {yardstick}", limit, found[name] / found[yardstick])
        for name, _, yardstick, limit in startup.MEASURED
    ]
    remark = f"Medians of {repetitions} whole processes, wall clock, taken in turn."
    return Section("startup", "Starting", ("ms", "wall"), rows, (remark,), claims)


def to_disk(rows: int) -> Section:
    """Sweeps to Parquet (``benchmarks/sweep_io.py``)."""
    ways = sweep_io.ways()
    alone = {way: sweep_io.in_its_own_process("memory", sweep_io.IN_MEMORY, way) for way in ways}
    found = sweep_io.measured(rows, ".parquet", ways, 1 if rows > MANY else sweep_io.TIMES)
    disk = found["disk"]
    runs = [
        (f"in memory, {sweep_io.IN_MEMORY:,} rows, {way}", alone[way], sweep_io.IN_MEMORY)
        for way in ways
    ]
    runs += [(f"to a file of {found[way]['MB']:,.0f} MB, {way}", found[way], rows) for way in ways]
    runs.append(("writing as many bytes, the quicker way", disk, rows))
    claims: list[Claim] = []
    for way in ways:
        share = max(
            sweep_io.of_memory(alone[way], found[way], rows), sweep_io.of_disk(disk, found[way])
        )
        claims.append(
            Claim(f"{way}: rate, of the lower of memory and disk", 80, 100 * share, "%", True)
        )
        claims.append(Claim(f"{way}: memory at its peak", GIGABYTE, found[way]["memory"], "MB"))
    return Section(
        "disk",
        f"{rows:,} rows to Parquet",
        ("", "millions of rows a second", "ns a row, cpu"),
        [
            (name, figures(1e-6 * count / took["wall"]), figures(1e9 * took["cpu"] / count))
            for name, took, count in runs
        ],
        ("Rates are by the clock, each measured in a process of its own, one after the other.",),
        claims,
    )


def many_rules(rules: int) -> Section:
    """A chain of rules (``benchmarks/scale.py``)."""
    with tempfile.TemporaryDirectory() as store:
        found = scale.in_its_own_process("chain", rules, store)
    rows = [(stage, f"{found[stage]:.2f}") for stage in ("load", "path", "solve")]
    return Section(
        "rules",
        f"A chain of {rules:,} rules",
        ("seconds", ""),
        rows,
        (),
        [Claim("load, path and solve", 15, sum(found[s] for s in ("load", "path", "solve")), "s")],
    )
