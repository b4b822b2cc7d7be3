"""What a question without an answer costs beside another one, as a row and as a call.

    python -m benchmarks.refusals

The oscillating cylinder at speeds that no size of its link gives: each asked by itself, as rows of
a sweep, and as calls of a plan, which search briefly after the first. Processor time, in one run.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

import rulesheets
import solver

MODEL = Path(__file__).parent.parent / "models" / "oscillating_cylinder" / "model.tk"
LEAST = 2.0
"""The least factor by which rows and calls are to be cheaper than solves."""


def seconds(ask: Callable[[], Any]) -> float:
    started = time.process_time()
    ask()
    return time.process_time() - started


def main() -> None:
    model = rulesheets.load(MODEL)
    given = {"xs": solver.solve(model).solutions[0]["xs"], "BO": None}
    speeds = np.linspace(12.0, 5.0, 16)

    def calls() -> None:
        plan = solver.prepare(model, ["omegaBO"], given=given)
        for speed in speeds.tolist():
            with suppress(solver.Unsolved):
                plan(speed)

    alone = seconds(
        lambda: [solver.solve(model, {**given, "omegaBO": one}) for one in speeds.tolist()]
    )
    rows = seconds(lambda: solver.prepare(model, ["omegaBO"], given=given).sweep(speeds))
    for what, taken in (("solves", alone), ("rows", rows), ("calls", seconds(calls))):
        held = "" if taken is alone else "held" if LEAST * taken <= alone else "not held"
        print(f"{what:8}{taken / len(speeds):8.3f} s each{alone / taken:8.1f} x  {held}".rstrip())


if __name__ == "__main__":
    main()
