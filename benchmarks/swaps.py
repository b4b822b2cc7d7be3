"""Prepared calls over every single swap of the shipped models: one output given, one input wanted.

    python -m benchmarks.swaps [--model NAME]… [--rows N] [--each] [--agree]

Each swap that leads back to the state of its sheet is prepared once; then it is called at numbers next to
that state, and swept over rows of them. The figures are distributions over the swaps. ``--agree`` compares
every call with a full solve: statuses, number of answers, and values beside their error bars.
"""

from __future__ import annotations

import argparse
import math
import random
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import rulesheets
import solver

MODELS = Path(__file__).parent.parent / "models"
NAMES = sorted(path.parent.name for path in MODELS.glob("*/model.tk"))
SPREAD = 1e-2
"""How far from the state, relative to its number, a swap is asked."""
CALLS = 30
SLOW = 2e-3
"""Seconds a call from which on fewer are timed."""
RETURNED = 1e-6


@dataclass
class Swap:
    """One output given instead of one input. Times in microseconds."""

    model: str
    given: str
    wanted: str
    call: float = math.nan
    worst: float = math.nan
    row: float = math.nan
    differs: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        return f"{self.model:<32}{self.given + ' -> ' + self.wanted:<28}"


def swaps(name: str) -> Iterator[tuple[Swap, Any, float]]:
    """The swaps of a model that lead back to its state, with their plans and the number given."""
    model = rulesheets.load(MODELS / name / "model.tk")
    state: Any = solver.solve(model).solutions[0]
    posted = [n for n, v in model.variables.items() if v.posted and isinstance(state.get(n), float)]
    inputs = [n for n in posted if model.variables[n].value is not None]
    for given in (n for n in posted if n not in inputs):
        for wanted in inputs:
            number = state[given]
            result: Any = solver.solve(model, {wanted: None, given: number}, want=[wanted])
            if str(result.status) != "solved":
                continue
            if any(abs(s[wanted] - state[wanted]) <= RETURNED * abs(state[wanted]) for s in result.solutions):
                plan = solver.prepare(model, [given], [wanted], {wanted: None})
                yield Swap(name, given, wanted), plan, number


def measure(swap: Swap, plan: Any, number: float, rows: int, agree: bool) -> Swap:
    draw = random.Random(str(swap))
    points = [number * (1 + SPREAD * draw.uniform(-1, 1)) for _ in range(CALLS)]
    for point in (number, *points[:3]):  # what there is to learn next to the state is learned
        asked(plan, point)
    started = time.perf_counter()
    asked(plan, number)
    if time.perf_counter() - started > SLOW:
        points = points[:2]
    times = []
    for point in points:
        best = math.inf
        for _ in range(3):
            started = time.perf_counter()
            asked(plan, point)
            best = min(best, time.perf_counter() - started)
            if best > SLOW:
                break
        times.append(best * 1e6)
    swap.call, swap.worst = float(np.median(times)), max(times)
    if rows:
        swap.row = timed_rows(plan, number, rows, swap.call)
    if agree:
        swap.differs = [text for point in points if (text := difference(plan, point))]
    return swap


def asked(plan: Any, point: float) -> Any:
    try:
        return plan(point)
    except solver.Unsolved as error:
        return str(error.status)


def timed_rows(plan: Any, number: float, rows: int, call: float) -> float:
    """Microseconds a row; of fewer rows where a call of each takes long."""
    count = rows if call < 200 else max(int(1e6 / call), 20)
    column = number * (1 + SPREAD * np.linspace(-1, 1, count))
    plan.sweep(column[: min(count, 1000)])
    best = math.inf
    for _ in range(3):
        started = time.perf_counter()
        plan.sweep(column)
        best = min(best, (time.perf_counter() - started) / count * 1e6)
        if best * count > 1e6:
            break
    return best


def difference(plan: Any, point: float) -> str:
    """What a prepared call says otherwise than a full solve; empty where they agree."""
    given = {plan.inputs[0]: point}
    stated = (n for n, v in plan.model.variables.items() if v.value is not None)
    cleared = {name: None for name in stated if name not in plan.given}
    result: Any = solver.solve(plan.model, {**cleared, **plan.given, **given}, want=plan.want)
    try:
        rows = plan.all(point)
    except solver.Unsolved as error:
        return "" if error.status == result.status else f"{point!r}: {error.status}, not {result.status}"
    if str(result.status) != "solved":
        return f"{point!r}: solved, not {result.status}"
    name = plan.want[0]
    wanted = list(dict.fromkeys(s[name] for s in result.solutions))
    bars = [s.error[name] for s in result.solutions]
    found = [row[0] for row in rows]
    if len(found) != len(wanted):
        return f"{point!r}: {len(found)} answers, not {len(wanted)}"
    bar = max(bars, default=0.0)
    for one, other in zip(found, wanted, strict=True):
        if abs(one - other) > 4 * bar + 8 * math.ulp(other):
            return f"{point!r}: {one!r}, not {other!r} (± {bar:.1e})"
    return ""


LIMITS = {"a prepared call": (5.0, 100.0, 5000.0), "a row of a sweep": (0.5, 2.0, 100.0)}
"""Microseconds of which the share of swaps below them is shown."""


def summary(found: list[Swap], rows: bool) -> str:
    """A table: the distribution of the times over the swaps."""
    times = {"a prepared call": [s.call for s in found]}
    if rows:
        times["a row of a sweep"] = [s.row for s in found]
    lines = [
        f"| {len(found)} single swaps, µs | median | 90 % | 97 % | worst | swaps within |",
        "| --- | ---: | ---: | ---: | ---: | --- |",
    ]
    for name, values in times.items():
        figures = [f"{np.quantile(values, q):,.2f}" for q in (0.5, 0.9, 0.97, 1.0)]
        within = ", ".join(
            f"{limit:g} µs: {sum(v <= limit for v in values) / len(values):.1%}" for limit in LIMITS[name]
        )
        lines.append(f"| {' | '.join((name, *figures, within))} |")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--model", choices=NAMES, action="append", help="several can be named")
    parser.add_argument("--rows", type=int, default=100_000)
    parser.add_argument("--each", action="store_true")
    parser.add_argument("--agree", action="store_true")
    options = parser.parse_args()
    found = []
    for name in options.model or NAMES:
        for swap, plan, number in swaps(name):
            found.append(measure(swap, plan, number, options.rows, options.agree))
            if options.each or swap.differs:
                times = f"{swap.call:12.2f}{swap.worst:12.2f}{swap.row:12.3f}"
                print(f"{swap}{times}", *swap.differs[:3], flush=True)
    print(summary(found, bool(options.rows)))


if __name__ == "__main__":
    main()
