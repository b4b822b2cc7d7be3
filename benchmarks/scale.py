"""How loading, planning and solving grow with the number of rules.

    python benchmarks/scale.py [RULES…]

prints seconds (of the processor) and peak memory, each size in a process of its own. ``growth`` is
the total time over that of the smallest size, divided by the growth of n log n: 1 or less is as
good as n log n. ``reload`` and ``replan`` are the first two stages in a second process, which finds
what the first has kept.
"""

from __future__ import annotations

import json
import math
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))

from benchmarks.sheets import SHAPES

SIZES = (1_000, 4_000, 16_000, 32_000, 100_000)
HEAD = (
    f"{'shape':<16}{'rules':>8}{'load':>8}{'path':>8}{'solve':>8}{'total':>8}{'MB':>7}{'growth':>8}"
)
AGAIN = f"{'reload':>8}{'replan':>8}"


def measure(shape: str, rules: int) -> dict[str, float]:
    """Seconds of each stage of a first solve, and the peak memory of this process in MB."""
    text, expected = SHAPES[shape](rules)
    started = time.process_time()
    import rulesheets
    import solver
    from solver.path.planner import planner

    model = rulesheets.loads(text)
    loaded = time.process_time()
    known = frozenset(n for n, v in model.variables.items() if v.value is not None)
    planner(model).path(known, {})
    planned = time.process_time()
    result = solver.solve(model)
    solved = time.process_time()
    if str(result.status) != "solved" or not all(_close(result[n], v) for n, v in expected.items()):
        raise SystemExit(f"{shape} of {rules} rules: {result.status}, or a wrong value")
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return {
        "load": loaded - started,
        "path": planned - loaded,
        "solve": solved - planned,
        "MB": memory,
    }


def _close(found: object, expected: float) -> bool:
    return isinstance(found, float) and math.isclose(found, expected, rel_tol=1e-6, abs_tol=1e-6)


def in_its_own_process(shape: str, rules: int, store: str) -> dict[str, float]:
    command = [sys.executable, __file__, "--one", shape, str(rules)]
    environment = {**os.environ, "BACKSOLVE_CACHE": store}
    answer = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    if answer.returncode:
        raise SystemExit(answer.stderr)
    found: dict[str, float] = json.loads(answer.stdout)
    return found


def table(sizes: list[int]) -> None:
    print(HEAD + AGAIN)
    for shape in SHAPES:
        first: tuple[int, float] | None = None
        for rules in sizes:
            with tempfile.TemporaryDirectory() as store:
                found, again = (in_its_own_process(shape, rules, store) for _ in range(2))
            total = found["load"] + found["path"] + found["solve"]
            first = first or (rules, total)
            growth = (total / first[1]) / (
                rules * math.log(rules) / (first[0] * math.log(first[0]))
            )
            times = "".join(f"{seconds:8.2f}" for seconds in (*list(found.values())[:3], total))
            second = f"{again['load']:8.2f}{again['path']:8.2f}"
            print(
                f"{shape:<16}{rules:>8}{times}{found['MB']:7.0f}{growth:8.2f}{second}", flush=True
            )


if __name__ == "__main__":
    if sys.argv[1:2] == ["--one"]:
        print(json.dumps(measure(sys.argv[2], int(sys.argv[3]))))
    else:
        table([int(argument) for argument in sys.argv[1:]] or list(SIZES))
