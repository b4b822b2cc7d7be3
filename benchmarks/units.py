"""What units cost: loading and checking large sheets with and without them, and solving.

    python -m benchmarks.units

Prints seconds of processor time to load and check sheets of 1,000 and 5,000 rules without units,
and how many more it takes with them, pint's import for one rare unit included: the first time
nothing is kept of earlier runs. Then calls of a prepared plan and rows of a sweep a second.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from time import perf_counter, process_time

import numpy as np

import rulesheets
import solver
from rulesheets.units.check import check_units

RULES = (
    "F{k} = m*a{k}",
    "E{k} = F{k}*s + E{last}",
    "v{k} = sqrt(2*E{k}/m)",
    "P{k} = F{k}*v{k}",
    "a{next} = a{k} + P{k}/(m*v{k})/10",
)
DECLARED = """variables
  m  = 2   [kg]
  s  = 3   [m]
  a0 = 9.8 [m/s^2]
  E_ = 0   [J]
  L  = 1[furlong] [m]
"""


def sheet(rules: int, units: bool) -> str:
    """A chain of rules; every second group declares the units of what it computes."""
    groups = rules // len(RULES)
    rows = [f"  F{k} [N]\n  v{k} [m/s]\n  P{k} [W]\n" for k in range(0, groups, 2)]
    lines = [
        "  " + rule.format(k=k, last=k - 1 if k else "_", next=k + 1)
        for k in range(groups)
        for rule in RULES
    ]
    text = f"{DECLARED}{''.join(rows)}rules\n" + "\n".join(lines) + "\n"
    return text if units else re.sub(r"\[.*?\]", "", text)


def loaded(rules: int, units: bool) -> float:
    """Seconds to load and check such a sheet."""
    text = sheet(rules, units)
    start = process_time()
    model = rulesheets.loads(text)
    assert not check_units(model)
    assert units or "pint" not in sys.modules
    return process_time() - start


def fresh(rules: int, units: bool, kept: bool) -> float:
    """The least of three runs, each in a process of its own; ``kept``: with what earlier ones have
    left."""
    environment = os.environ if kept else {**os.environ, "BACKSOLVE_CACHE": ""}
    code = f"from benchmarks.units import loaded; print(loaded({rules}, {units}))"
    command = [sys.executable, "-c", code]
    return min(
        float(subprocess.check_output(command, text=True, env=environment)) for _ in range(3)
    )


def speed(units: bool) -> tuple[float, float]:
    """Calls of a plan, and rows of a sweep, in a second."""
    model = rulesheets.loads(sheet(20, units))
    plan = solver.prepare(model, inputs=["a0"], want=["v3", "P3"])
    values = np.linspace(1.0, 10.0, 100_000)
    plan(2.0), plan.sweep(values[:100])
    calls = min(_seconds(lambda: [plan(9.0) for _ in range(2000)]) for _ in range(5))
    rows = min(_seconds(lambda: plan.sweep(values)) for _ in range(5))
    return 2000 / calls, len(values) / rows


def _seconds(run: object) -> float:
    start = perf_counter()
    run()  # type: ignore[operator]
    return perf_counter() - start


def main() -> None:
    for rules in (1000, 5000):
        for kept in (False, True):
            without, with_units = fresh(rules, False, kept), fresh(rules, True, kept)
            of = "later" if kept else "the first time"
            print(
                f"{rules:,} rules {of}: {without:.2f} s without units, {with_units - without:.2f} "
                "s more with"
            )
    for units in (False, True):
        calls, rows = speed(units)
        print(
            f"{'with' if units else 'without'} units: {calls:,.0f} calls, {rows:,.0f} rows a second"
        )


if __name__ == "__main__":
    main()
