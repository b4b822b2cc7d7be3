"""Sweeps: nanoseconds a row for five outputs, every row checked, beside peers that check
nothing."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.speed import closed_forms, solvers, symbols
from benchmarks.speed.by_c import CCrank
from benchmarks.speed.closed_forms import Array
from benchmarks.speed.page import Claim, Section, figures
from benchmarks.speed.stopwatch import Contestant, Time, race
from benchmarks.speed.task import BACKWARD, DIRECTIONS, FORWARD, column, plan
from solver.trace.llvm import available

SAMPLE = 200
FEW, SOME = 1_000, 100_000
"""Rows of contestants that take too long for all of them."""

OURS, JIT = "backsolve", "backsolve, jit"
NUMPY, OWN = "by hand, blocked numpy", "by hand, numba, own sincos"
PARALLEL = "by hand, numba, parallel"
KINDS = {
    OURS: "ours",
    JIT: "ours",
    "writing the outputs": "floor",
    "writing the outputs, 2 threads": "floor",
    "by hand, C, own functions": "hand",
    "by hand, C, own functions, 2 threads": "hand",
    "by hand, C, libm": "hand",
    OWN: "hand",
    f"{OWN}, parallel": "hand",
    "by hand, numba": "hand",
    PARALLEL: "hand",
    NUMPY: "hand",
    "jax": "peer",
    "sympy.lambdify with cse, numpy": "peer",
    "casadi map": "peer",
    "scipy fsolve with Jacobian, a loop": "peer",
    "scipy fsolve, a loop": "peer",
}


def measure(rounds: int, rows: int) -> tuple[Section, Section]:
    """The section of times, and that of errors."""
    times: dict[str, dict[str, Time]] = {}
    worst: dict[str, dict[str, float]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for direction in DIRECTIONS:
            racers = contestants(direction, rows, Path(folder))
            times[direction] = race(racers, rounds)
            worst[direction] = errors(direction, racers)
    shown = [name for name in KINDS if any(name in found for found in times.values())]
    table = [(name, *_cells(times, name)) for name in shown]
    heads = [f"{d}, {clock}" for d in ("forward", "slider-driven") for clock in ("cpu", "wall")]
    section = Section(
        "rows",
        f"A sweep of {rows:,} rows",
        ("ns a row", *heads),
        table,
        (
            "All allocate their outputs in each run, from memory that the system has to hand out "
            "anew. *cpu* "
            "adds up the processors; *wall* is the clock, which others who use the machine slow "
            "down. casadi "
            f"runs {SOME:,} rows; fsolve {FEW:,}, each from the answer of the row before.",
        ),
        claims(times),
        tuple(
            (title, "ns", [(n, times[d][n].cpu * 1e9, KINDS[n]) for n in shown if n in times[d]])
            for d, title in (
                ("forward", "A row of a sweep, forward"),
                ("backward", "A row of a sweep, slider-driven"),
            )
        ),
    )
    return section, accuracy(worst)


def _cells(times: dict[str, dict[str, Time]], name: str) -> list[str]:
    cells = []
    for direction in DIRECTIONS:
        found = times[direction].get(name)
        cells += (
            ["–", "–"] if found is None else [figures(found.cpu * 1e9), figures(found.wall * 1e9)]
        )
    return cells


def contestants(direction: str, rows: int, folder: Path) -> list[Contestant]:
    ahead = direction == "forward"
    prepared = plan(direction)
    form = closed_forms.forward_rows if ahead else closed_forms.backward_rows
    runs: dict[str, Callable[[Array], Any]] = {
        OURS: prepared.sweep,
        NUMPY: partial(filled, form),
        "sympy.lambdify with cse, numpy": symbols.function(direction, "numpy"),
        "scipy fsolve with Jacobian, a loop": partial(_loop, solvers.fsolve(direction, True)),
        "scipy fsolve, a loop": partial(_loop, solvers.fsolve(direction, False)),
        "writing the outputs": partial(_written, 1),
        "writing the outputs, 2 threads": partial(_written, 2),
    }
    if available():
        runs[JIT] = partial(prepared_again(direction).sweep, jit=True)
    if find_spec("numba"):
        from benchmarks.speed import by_numba

        runs["by hand, numba"] = by_numba.rows(f"{direction}, library")
        runs[PARALLEL] = by_numba.rows(f"{direction}, library", parallel=True)
        if ahead:
            runs[OWN] = by_numba.rows("forward, own")
            runs[f"{OWN}, parallel"] = by_numba.rows("forward, own", parallel=True)
    try:
        crank = CCrank(folder)
        runs["by hand, C, libm"] = crank.rows(f"{direction}_rows_library")
        runs["by hand, C, own functions"] = crank.rows(f"{direction}_rows_own")
        runs["by hand, C, own functions, 2 threads"] = crank.rows(
            f"{direction}_rows_own", threads=2
        )
    except OSError:
        pass
    if find_spec("jax"):
        runs["jax"] = solvers.jax_function(direction)
    if find_spec("casadi"):
        runs["casadi map"] = solvers.casadi_map(direction, min(rows, SOME))
    few = {name: FEW for name in KINDS if "fsolve" in name} | {"casadi map": SOME}
    out = []
    for name in KINDS:
        if name in runs:
            count = min(rows, few.get(name, rows))
            out.append(Contestant(name, runs[name], column(direction, count), count))
    return out


def prepared_again(direction: str) -> Any:
    """A plan of its own for machine code: a plan keeps the kernels of one kind."""
    return plan(direction)


def filled(form: Callable[[Array, list[Array]], None], numbers: Array) -> list[Array]:
    out = [np.empty(len(numbers)) for _ in range(5)]
    form(numbers, out)
    return out


def _written(threads: int, numbers: Array) -> list[Array]:
    out = [np.empty(len(numbers)) for _ in range(5)]

    def write(part: int) -> None:
        rows = slice(len(numbers) * part // threads, len(numbers) * (part + 1) // threads)
        for array in out:
            np.copyto(array[rows], numbers[rows])

    if threads == 1:
        write(0)
    else:
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(write, range(threads)))
    return out


def _loop(solve: Callable[..., Any], numbers: Array) -> list[Array]:
    """Row after row, each from the answer of the one before; a row that fails is NaN."""
    found = np.full((len(numbers), 5), np.nan)
    start = None
    for row, number in enumerate(numbers):
        try:
            found[row] = start = solve(number) if start is None else solve(number, start)
        except ArithmeticError:
            start = None
    return list(found.T)


def errors(direction: str, racers: list[Contestant]) -> dict[str, float]:
    """The worst error of each in a sample of its rows, in ulp × conditioning."""
    from benchmarks.speed import reference

    worst = {}
    for racer in racers:
        if KINDS[racer.name] == "floor":
            continue
        numbers = np.asarray(racer.argument)
        outputs = columns(direction, racer.run(racer.argument))
        sample = np.random.default_rng(50).integers(0, len(numbers), SAMPLE)
        worst[racer.name] = max(
            max(reference.errors(direction, float(numbers[k]), [float(c[k]) for c in outputs]))
            for k in sample
        )
    return worst


def columns(direction: str, found: Any) -> list[Any]:
    if hasattr(found, "solved"):
        assert found.solved.all()
        return [found[name] for name in (FORWARD if direction == "forward" else BACKWARD)]
    return [np.asarray(values) for values in found]


def claims(times: dict[str, dict[str, Time]]) -> list[Claim]:
    def ratio(direction: str, one: str, other: str, clock: str = "cpu") -> float:
        found = times[direction]
        if one not in found or other not in found:
            return float("nan")
        return getattr(found[one], clock) / getattr(found[other], clock)

    lambdify = "sympy.lambdify with cse, numpy"
    both = (("cpu", "processor time"), ("wall", "clock"))
    out = [
        Claim("forward, of blocked numpy by hand", 1.5, ratio("forward", OURS, NUMPY)),
        Claim("slider-driven, of blocked numpy by hand", 2, ratio("backward", OURS, NUMPY)),
        Claim("jit, forward, of numba with own sincos", 2, ratio("forward", JIT, OWN)),
        *(
            Claim(
                f"jit, forward, of the same in parallel, {n}",
                2,
                ratio("forward", JIT, f"{OWN}, parallel", c),
            )
            for c, n in both
        ),
        Claim(
            "jit, forward, of writing the outputs", 4, ratio("forward", JIT, "writing the outputs")
        ),
        *(
            Claim(
                f"jit, forward, faster than jax, {n}", 5, ratio("forward", "jax", JIT, c), more=True
            )
            for c, n in both
        ),
        Claim("jit, forward, faster than lambdify", 12, ratio("forward", lambdify, JIT), more=True),
        *(
            Claim(
                f"jit, slider-driven, of numba in parallel, {n}",
                1.5,
                ratio("backward", JIT, PARALLEL, c),
            )
            for c, n in both
        ),
    ]
    return [claim for claim in out if claim.measured == claim.measured]


def accuracy(worst: dict[str, dict[str, float]]) -> Section:
    shown = [name for name in KINDS if any(name in found for found in worst.values())]
    rows = [
        (n, *(f"{worst[d][n]:.2g}" if n in worst[d] else "–" for d in DIRECTIONS)) for n in shown
    ]
    by_us = [(name, d) for name in (OURS, JIT) for d in DIRECTIONS if name in worst[d]]
    words = {"forward": "forward", "backward": "slider-driven"}
    return Section(
        "accuracy",
        f"Worst errors in {SAMPLE} rows of the sweep, beside 50 digits",
        ("ulp × conditioning", "forward", "slider-driven"),
        rows,
        (
            "The unit is 2⁻⁵² (|y| + |x dy/dx|) for an output y and the input x: a last digit of "
            "either.",
        ),
        [Claim(f"{name}, {words[d]}", 4, worst[d][name], "ulp") for name, d in by_us],
    )
