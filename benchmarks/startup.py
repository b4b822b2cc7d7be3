"""How long a command takes from its start to its end, beside what Python itself takes to start.

    python benchmarks/startup.py [REPETITIONS]
    python benchmarks/startup.py --imports

prints medians of whole processes, taken in turn so that all meet the same machine, and their ratios.
"First time" starts with nothing kept, "again" finds what the run before has kept. Bytecode is there for
all of them, as it is after an installation. ``--imports`` prints what libraries a solve imports the second
time, of every model with each of its variable files.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from shutil import rmtree
from statistics import median

ROOT = Path(__file__).parent.parent
COMMAND = "import sys; from solver.cli import main; sys.exit(main())"
CRANK = ("solve", "offset_slider_crank")
REPETITIONS = 15

LIBRARIES = frozenset({"sympy", "lark", "scipy", "numpy", "mpmath", "matplotlib", "flint", "pint", "rich"})
YARDSTICKS = {"pass": "pass", "import numpy": "import numpy", "import sympy": "import sympy"}

SEARCHED = ("colebrook", "kepler", "loan", "projectile", "rachford_rice", "two_circles", "van_der_waals")
"""Models with a block that is searched."""

MEASURED = (
    ("--help", ("--help",), False, "pass", 3.0),
    ("solve, first time", CRANK, True, "import sympy", 3.0),
    ("solve, again", CRANK, False, "import numpy", 1.0),
    ("solve at another angle, again", (*CRANK, "--set", "thetaAO=20"), False, "import numpy", 1.0),
    ("solve backward, again", (*CRANK, "--clear", "thetaAO", "--set", "xB=9.79"), False, "import numpy", 1.0),
    *((f"solve {model}, again", ("solve", model), False, "import numpy", 1.0) for model in SEARCHED),
)
"""Name, words, whether the store is emptied before, what it is held to, and to how many times that."""


INSTALLED = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
"""Bytecode is there, as it is after an installation."""

EACH = """
import os, sys
for name in sys.argv[1:]:
    __import__(name)
from solver.cli import main
for line in sys.stdin:
    names, out = os.pipe()
    if not os.fork():
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        code = main(line.split())
        os.write(out, " ".join([str(code), *sys.modules]).encode())
        os._exit(0)
    os.close(out)
    with open(names) as found:
        print(found.read(), flush=True)
    os.wait()
"""
"""Every line in a process of its own, which has imported no more than the command, and the modules named."""


def seconds(words: tuple[str, ...], store: Path) -> float:
    """Wall clock of one process."""
    environment = {**INSTALLED, "BACKSOLVE_CACHE": str(store), "PYTHONPATH": str(ROOT)}
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


def each_imported(
    lines: Sequence[str], store: Path, at_hand: Sequence[str] = (), code: int = 0
) -> dict[str, set[str]]:
    """Names of the modules that each line of words for the command has imported in a process of its own,
    which forks from one that has imported the command and what is ``at_hand``, and ends with that code."""
    environment = {**INSTALLED, "BACKSOLVE_CACHE": str(store), "PYTHONPATH": str(ROOT)}
    call, text = [sys.executable, "-c", EACH, *at_hand], "".join(f"{line}\n" for line in lines)
    ran = subprocess.run(
        call, input=text, capture_output=True, text=True, env=environment, timeout=120, check=True, cwd=ROOT
    )
    found = [answer.split() for answer in ran.stdout.splitlines()]
    assert [ended for ended, *_ in found] == [str(code)] * len(lines), ran.stderr
    return {line: set(names) for line, (_, *names) in zip(lines, found, strict=True)}


def libraries(store: Path) -> None:
    """What a solve of each model imports the second time, with each of its variable files."""
    sheets = sorted((ROOT / "models").glob("*/model.tk"))
    cases = [(sheet, case) for sheet in sheets for case in (None, *sorted(sheet.parent.glob("*.csv")))]
    lines = {
        f"solve {s}" + (f" {c}" if c else ""): f"{s.parent.name} {c.stem if c else ''}" for s, c in cases
    }
    each_imported(list(lines), store, at_hand=("sympy", "lark", "mpmath", "numpy"))
    for line, names in each_imported(list(lines), store).items():
        print(f"{lines[line]:<50}{', '.join(sorted(names & LIBRARIES)) or '-'}")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        if sys.argv[1:] == ["--imports"]:
            libraries(Path(folder))
        else:
            table(measure(int(sys.argv[1]) if len(sys.argv) > 1 else REPETITIONS, Path(folder)))
