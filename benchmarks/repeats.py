"""Whether a question costs more when it is asked again.

    python -m benchmarks.repeats [--model NAME]… [--each]

Each shipped model is solved ten times at its own numbers, and twice at ten numbers of one input
next to its own; a plan of that input is called at these twice as well. Printed are the tenth time
beside the first, and the second round beside the first. Processor time.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import rulesheets
import solver

MODELS = Path(__file__).parent.parent / "models"
NAMES = sorted(path.parent.name for path in MODELS.glob("*/model.tk"))
TIMES = 10


def seconds(ask: Callable[[], Any]) -> float:
    started = time.process_time()
    with suppress(solver.Unsolved):
        ask()
    return time.process_time() - started


def series(name: str) -> Iterator[tuple[str, float, float]]:
    """What is asked, the seconds of the first time or round, and those of the last."""
    model = rulesheets.load(MODELS / name / "model.tk")
    times = [seconds(partial(solver.solve, model)) for _ in range(TIMES)]
    yield "solve", times[0], times[-1]
    numbers = [(n, v.value) for n, v in model.variables.items() if isinstance(v.value, float)]
    if not numbers:
        return
    given, number = numbers[0]
    near = [number * (1.0 + 1e-3 * k) for k in range(TIMES)]
    plan: Any = solver.prepare(model, [given], timeout=30.0)
    rounds: dict[str, Callable[[float], Any]] = {
        "solves nearby": lambda x: solver.solve(model, {given: x}),
        "calls nearby": plan,
    }
    for asked, ask in rounds.items():
        one, other = ([seconds(partial(ask, x)) for x in near] for _ in range(2))
        yield asked, sum(one), sum(other)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--model", choices=NAMES, action="append", help="several can be named")
    parser.add_argument("--each", action="store_true")
    options = parser.parse_args()
    ratios: dict[str, list[tuple[float, str]]] = {}
    for name in options.model or NAMES:
        for asked, first, last in series(name):
            ratios.setdefault(asked, []).append((last / first, name))
            if options.each:
                print(
                    f"{name:<32}{asked:<16}{1e3 * first:10.2f} ms, then{1e3 * last:10.2f} ms",
                    flush=True,
                )
    for asked, found in ratios.items():
        middle, (most, name) = statistics.median(ratio for ratio, _ in found), max(found)
        print(f"{asked:<16}last / first {middle:.3f} in the median, at most {most:.3f} ({name})")


if __name__ == "__main__":
    main()
