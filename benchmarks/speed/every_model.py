"""Every shipped model: compiled kernels, the step-by-step way, and fsolve on the rules that were
used."""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import rulesheets
import solver
from benchmarks.speed.closed_forms import Array
from benchmarks.speed.page import Claim, Section, figures
from benchmarks.speed.rules_as_equations import System, system_of
from rulesheets.model import Model, Value
from solver.facts import Status
from solver.files.tables import CODES
from solver.leaves import Asked
from solver.solution.verdict import explore_refined
from solver.sweeps import Plan
from solver.trace.llvm import available

ROOT = Path(__file__).parents[2] / "models"
ROWS, MANY = 16, 100_000
PATIENCE = 3.0
"""Seconds for the rows of one model that are solved step by step."""

EPSILON = 2.0**-52
NUDGE = 2.0**-24


@dataclass(frozen=True)
class Difference:
    """Rows of the same status as step by step and rows tried; the worst differences from what
    extended precision gives."""

    same: int
    tried: int
    relative: float
    apart: float


@dataclass(frozen=True)
class Compared:
    """Seconds a solve or a row (nan: none), and differences.

    ``fsolve_apart`` is relative, of the wanted numbers at the inputs of the sheet.
    """

    name: str
    driver: str
    prepared: float
    steps: float
    fsolve: float
    swept: float
    jit: float
    difference: Difference
    fsolve_apart: float


def measure() -> Section:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # fsolve warns of what it then reports
        compared = [
            c for path in sorted(ROOT.glob("*/model.tk")) if (c := compare(path)) is not None
        ]
    rows = [
        (
            c.name,
            c.driver,
            *(_number(t * 1e6) for t in (c.prepared, c.steps, c.fsolve)),
            *(_number(t * 1e9) for t in (c.swept, c.jit)),
            f"{c.difference.same}/{c.difference.tried}" if c.difference.tried else "–",
            *(_small(d) for d in (c.difference.apart, c.difference.relative, c.fsolve_apart)),
        )
        for c in compared
    ]
    head = (
        "model",
        "driver",
        "kernel, µs",
        "steps, µs",
        "fsolve, µs",
        "sweep, ns a row",
        "jit, ns a row",
    )
    found = [c.difference for c in compared if c.difference.tried]
    same = sum(d.same for d in found) / sum(d.tried for d in found)
    return Section(
        "models",
        "Every model",
        (*head, "statuses alike", "kernel, ulp × cond.", "kernel, relative", "fsolve, relative"),
        rows,
        (
            f"One solve at the inputs of the sheet, driven by one of them; sweeps are {MANY:,} "
            "rows within "
            f"1e-3 of it. Statuses and differences are of {ROWS} rows within 40 % (at any angle): "
            "statuses "
            "against the step-by-step way, numbers against the same path in extended precision. "
            "fsolve gets "
            "the rules that the path used, their exact Jacobian, and the answer 2 % away to start "
            "from. A "
            "dash: fsolve fails, or nothing is compiled.",
        ),
        [
            Claim(
                "rows whose status is the same by kernel and step by step",
                100,
                100 * same,
                "%",
                more=True,
            ),
            Claim(
                "worst difference of kernels", 4, max(d.apart for d in found), "ulp × conditioning"
            ),
        ],
    )


def _number(value: float) -> str:
    return figures(value) if value == value else "–"


def _small(value: float) -> str:
    return f"{value:.1g}" if value == value else "–"


def compare(path: Path) -> Compared | None:
    """One model, driven by an angle of the sheet or else its first number."""
    model = rulesheets.load(str(path))
    numbers = {n: v.value for n, v in model.variables.items() if isinstance(v.value, float)}
    want = [n for n, v in model.variables.items() if v.posted and v.value is None]
    driver = next((n for n in numbers if model.variables[n].unit == "deg"), None) or next(
        iter(numbers), None
    )
    if driver is None:
        return None
    value = numbers[driver]
    plan = solver.prepare(model, [driver], want)
    plan(value)
    reach = 1e-3 * (abs(value) or 1.0)
    near = np.linspace(value - reach, value + reach, MANY)
    sweeps = plan.records.programs and plan.sweep(near[:: MANY // 10]).solved.all()
    verdict, _ = plan.judged((value,))
    system = system_of(model, plan, verdict)
    difference = _differences(model, plan, driver, value)
    swept = _best(lambda: plan.sweep(near), 2) / MANY if sweeps else math.nan
    native = (
        _best(lambda: plan.sweep(near, jit=True), 2) / MANY if sweeps and available() else math.nan
    )
    return Compared(
        path.parent.name,
        driver,
        _best(lambda: plan(value), 5) if plan.records.programs else math.nan,
        _best(lambda: plan.judged((value,)), 2),
        math.nan if system is None else _fsolve_seconds(system, plan, value),
        swept,
        native,
        difference,
        math.nan if system is None else _fsolve_error(system, plan, value),
    )


def _rows(model: Model, driver: str, value: float) -> Array:
    rng = np.random.default_rng(len(driver))
    if model.variables[driver].unit == "deg":
        return rng.uniform(-180.0, 180.0, ROWS)
    return value * rng.uniform(0.6, 1.4, ROWS) if value else rng.uniform(-1.0, 1.0, ROWS)


def _differences(model: Model, plan: Plan, driver: str, value: float) -> Difference:
    if not plan.records.programs:
        return Difference(0, 0, math.nan, math.nan)
    rows = _rows(model, driver, value)
    plan.sweep(rows)
    tables = [
        plan.sweep(np.repeat(rows, 2), jit=jit)
        for jit in ((False, True) if available() else (False,))
    ]
    same = tried = 0
    apart = relative = 0.0
    began = time.perf_counter()
    for place, number in enumerate(rows):
        if time.perf_counter() - began > PATIENCE and tried:
            break
        verdict, _ = plan.judged((float(number),))
        tried += 1
        codes = {int(code) for table in tables for code in table.status[2 * place : 2 * place + 2]}
        same += codes == {CODES[verdict.status]}
        if verdict.status is not Status.SOLVED or any(codes):
            continue
        scales = _scales(model, plan, driver, float(number))
        inputs = {**plan.given, driver: float(number)}
        exact = explore_refined(
            Asked(model, inputs, plan.want, plan.guesses, plan.want), always=True
        )
        first = {name: float(tables[0][name][2 * place]) for name in scales}
        answer = min(
            (leaf.branch.values for leaf in exact.leaves), key=lambda v: _distance(first, v)
        )
        for name, scale in scales.items():
            expected = answer[name]
            if isinstance(expected, float):
                distance = max(abs(float(table[name][2 * place]) - expected) for table in tables)
                if distance:
                    relative = max(relative, distance / abs(expected) if expected else math.inf)
                    apart = max(apart, distance / (EPSILON * (abs(expected) + scale)))
    return Difference(same, tried, relative, apart)


def _distance(one: Mapping[str, float], other: Mapping[str, Value]) -> float:
    """From the first answer of a table to one of the list, which is in the order of the search."""
    return sum(abs(v - w) for n, v in one.items() if isinstance(w := other[n], float))


def _scales(model: Model, plan: Plan, driver: str, number: float) -> dict[str, float]:
    """Σ |x dy/dx| over all inputs x of the sheet for each wanted y."""
    result = solver.solve(model, {driver: number}, plan.want)
    slopes = result.sensitivity(plan.want)
    inputs = {n: abs(v) for n, v in result.inputs.items() if isinstance(v, float)}
    return {
        y: sum(size * abs(slopes[y, x] or 0.0) for x, size in inputs.items() if x in slopes.inputs)
        for y in plan.want
    }


def _fsolve_error(system: System, plan: Plan, value: float) -> float:
    """The worst relative difference of a wanted number at the inputs of the sheet, nan where fsolve
    fails."""
    exact = plan.judged((value,))[0].leaves[0].branch.values
    try:
        found = dict(
            zip(system.unknowns, system.fsolve()(value, _start(system, plan, value)), strict=True)
        )
    except (ArithmeticError, ValueError):
        return math.nan
    pairs = [(found[n], exact[n]) for n in plan.want if n in found]
    return max((abs(f - e) / abs(e) if e else abs(f) for f, e in pairs), default=0.0)  # type: ignore[arg-type,operator]


def _start(system: System, plan: Plan, value: float) -> Any:
    """The unknowns of a row 2 % away, or of this one moved by 2 % where that has no such answer."""
    verdict, _ = plan.judged((value * 0.98 if value else 0.02,))
    if verdict.status is Status.SOLVED and all(
        n in verdict.leaves[0].branch.values for n in system.unknowns
    ):
        return system.start(verdict.leaves[0].branch.values)
    return 0.98 * system.start(plan.judged((value,))[0].leaves[0].branch.values)


def _fsolve_seconds(system: System, plan: Plan, value: float) -> float:
    solve, start = system.fsolve(), _start(system, plan, value)
    try:
        return _best(lambda: solve(value, start), 3)
    except (ArithmeticError, ValueError):
        return math.nan


def _best(run: Callable[[], object], rounds: int) -> float:
    """Seconds of processor time of one call, at least 2 ms of them measured together."""
    run()
    best, calls = math.inf, 1
    while rounds:
        began = time.process_time()
        for _ in range(calls):
            run()
        took = time.process_time() - began
        if took < 0.002:
            calls *= 4
            continue
        best, rounds = min(best, took / calls), rounds - 1
    return best
