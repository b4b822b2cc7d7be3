"""How long a command takes from its start to its end, beside what Python itself takes to start.

    python benchmarks/startup.py [REPETITIONS]

prints medians of whole processes, taken in turn so that all meet the same machine, and their
ratios. Bytecode is there for all of them, as it is after an installation.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

ROOT = Path(__file__).parent.parent
COMMAND = "import sys; from solver.__main__ import main; sys.exit(main())"
CRANK = ("solve", "offset_slider_crank")
REPETITIONS = 15

YARDSTICKS = {"pass": "pass", "import numpy": "import numpy", "import sympy": "import sympy"}

SEARCHED = (
    "colebrook",
    "kepler",
    "loan",
    "projectile",
    "rachford_rice",
    "two_circles",
    "van_der_waals",
)
"""Models with a block that is searched."""

MEASURED = (
    ("--help", ("--help",), "pass", 3.0),
    ("solve", CRANK, "import numpy", 2.0),
    ("solve backward", (*CRANK, "--clear", "thetaAO", "--set", "xB=9.79"), "import numpy", 2.0),
    *((f"solve {model}", ("solve", model), "import numpy", 3.0) for model in SEARCHED),
)
"""Name, words, what it is held to, and to how many times that."""


INSTALLED = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
"""Bytecode is there, as it is after an installation."""


def seconds(words: tuple[str, ...], store: Path) -> float:
    """Wall clock of one process."""
    environment = {**INSTALLED, "BACKSOLVE_CACHE": str(store), "PYTHONPATH": str(ROOT)}
    started = time.perf_counter()
    ran = subprocess.run(
        [sys.executable, "-c", *words], capture_output=True, env=environment, check=False
    )
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
        for name, words, _, _ in MEASURED:
            times.setdefault(name, []).append(seconds((COMMAND, *words), store))
        if round_ == 0:
            times.clear()
    return {name: median(taken) for name, taken in times.items()}


def table(found: dict[str, float]) -> None:
    print(f"{'':<32}{'ms':>8}  ratio")
    for name in YARDSTICKS:
        print(f"python -c {name!r:<22}{found[name] * 1e3:8.0f}")
    for name, _, yardstick, limit in MEASURED:
        ratio = found[name] / found[yardstick]
        print(f"{name:<32}{found[name] * 1e3:8.0f}  {ratio:.2f} × {yardstick} (held to {limit:g})")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        table(measure(int(sys.argv[1]) if len(sys.argv) > 1 else REPETITIONS, Path(folder)))
