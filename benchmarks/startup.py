"""How long a command takes from its start to its end, beside what Python itself takes to start.

    python benchmarks/startup.py [REPETITIONS]

prints medians of whole processes, taken in turn so that all meet the same machine, and their ratios.
"First time" starts with nothing kept, "again" finds what the run before has kept. Bytecode is there for
all of them, as it is after an installation.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from shutil import rmtree
from statistics import median

ROOT = Path(__file__).parent.parent
COMMAND = "import sys; from solver.cli import main; sys.exit(main())"
CRANK = ("solve", "offset_slider_crank")
REPETITIONS = 15

YARDSTICKS = {"pass": "pass", "import numpy": "import numpy", "import sympy": "import sympy"}

MEASURED = (
    ("--help", ("--help",), False, "pass", 3.0),
    ("solve, first time", CRANK, True, "import sympy", 3.0),
    ("solve, again", CRANK, False, "import numpy", 1.0),
    ("solve at another angle, again", (*CRANK, "--set", "thetaAO=20"), False, "import numpy", 1.0),
    ("solve backward, again", (*CRANK, "--clear", "thetaAO", "--set", "xB=9.79"), False, "import numpy", 1.0),
)
"""Name, words, whether the store is emptied before, what it is held to, and to how many times that."""


def seconds(words: tuple[str, ...], store: Path) -> float:
    """Wall clock of one process."""
    environment = {**os.environ, "BACKSOLVE_CACHE": str(store), "PYTHONPATH": str(ROOT)}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    started = time.perf_counter()
    ran = subprocess.run([sys.executable, "-c", *words], capture_output=True, env=environment, check=False)
    took = time.perf_counter() - started
    if ran.returncode:
        raise SystemExit(ran.stderr.decode())
    return took


def measure(repetitions: int, store: Path) -> dict[str, float]:
    """The median of each, in seconds. One round before the first is not counted."""
    times: dict[str, list[float]] = {}
    for round_ in range(repetitions + 1):
        for name, code in YARDSTICKS.items():
            times.setdefault(name, []).append(seconds((code,), store))
        for name, words, emptied, _, _ in MEASURED:
            place = store / name
            if emptied:
                rmtree(place, ignore_errors=True)
            times.setdefault(name, []).append(seconds((COMMAND, *words), place))
        if round_ == 0:
            times.clear()
    return {name: median(taken) for name, taken in times.items()}


def table(found: dict[str, float]) -> None:
    print(f"{'':<32}{'ms':>8}  ratio")
    for name in YARDSTICKS:
        print(f"python -c {name!r:<22}{found[name] * 1e3:8.0f}")
    for name, _, _, yardstick, limit in MEASURED:
        ratio = found[name] / found[yardstick]
        print(f"{name:<32}{found[name] * 1e3:8.0f}  {ratio:.2f} × {yardstick} (held to {limit:g})")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        table(measure(int(sys.argv[1]) if len(sys.argv) > 1 else REPETITIONS, Path(folder)))
