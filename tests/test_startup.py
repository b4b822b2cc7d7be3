"""What a command imports: a process that has nothing to do with a library does not pay for it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.startup import INSTALLED, SEARCHED, each_imported

ROOT = Path(__file__).parent.parent
MODULES = (
    "import sys; from solver.cli import main; code = main(sys.argv[1:]); print(*sys.modules, file=sys.stderr)"
)

DRIVEN = (
    "offset_slider_crank/model.tk models/offset_slider_crank/slider_driven.csv",
    "offset_slider_crank/model.tk models/offset_slider_crank/rod_driven.csv",
    "offset_slider_crank_slope_free/model.tk models/offset_slider_crank_slope_free/rod_driven.csv",
    "oscillating_cylinder/model.tk models/oscillating_cylinder/cylinder_driven.csv",
)
SMALL = {
    "implicit": "x*exp(x) = 3\n",
    "wave": "sin(3*x) = x/4\n",
    "hyperbola": "x^2 + y^2 = 5\nx*y = 2\n",
    "inner_guard": "if x > 2 then y = x^2 + 1 else y = 3*x - 1\ny + exp(-x) = 7\n",
    "error_function": "erf(x) = 0.3 + x/9\n",
}
"""Sheets of one line or a few, most of them with several answers."""

SCIENCE = {"sympy", "lark", "scipy", "numpy", "mpmath", "matplotlib", "numba", "pint"}
SLOW = {"argparse", "dataclasses", "inspect", "typing", "re", "tempfile", "json", "csv", "hashlib"}
"""Modules of the standard library that cost a millisecond or more (``rulesheets.record`` spares two)."""
FIRST = {"lark", "rulesheets.parse", "rulesheets.checks", "rulesheets.build", "solver.path.build"}
"""Rooms that a sheet goes through once, and what was kept of it never again."""


def imported(line: str, store: Path) -> set[str]:
    """Names of the modules that a command has imported in a process of its own, site customisation apart."""
    environment = {**INSTALLED, "BACKSOLVE_CACHE": str(store), "PYTHONPATH": str(ROOT)}
    call = [sys.executable, "-c", MODULES, *line.split()]
    ran = subprocess.run(call, capture_output=True, text=True, env=environment, timeout=120, check=False)
    bare = [sys.executable, "-c", "import sys; print(*sys.modules)"]
    own = subprocess.run(bare, capture_output=True, text=True, env=environment, timeout=60, check=True)
    assert ran.returncode == 0, ran.stderr
    return set(ran.stderr.split()) - set(own.stdout.split())


def test_a_warm_solve_imports_no_more_than_it_needs(tmp_path: Path) -> None:
    line = "solve offset_slider_crank --set thetaAO=-30"
    assert imported(line, tmp_path / "store") & FIRST == FIRST
    assert imported(line, tmp_path / "store") & (SCIENCE | SLOW | FIRST) == set()


def test_a_warm_backward_solve_imports_no_science(tmp_path: Path) -> None:
    line = "solve offset_slider_crank --clear thetaAO --set xB=9.79 --all"
    imported(line, tmp_path / "store")
    assert imported(line, tmp_path / "store") & (SCIENCE | FIRST | {"argparse", "dataclasses"}) == set()


def test_a_warm_solve_by_search_imports_no_library(tmp_path: Path) -> None:
    """Blocks with one tear and with several answers, guards inside them, and ends of domains: nothing but
    numbers to many digits, where rounding would decide, takes a library. (``benchmarks/startup.py`` tells of
    every model.)"""
    for name, text in SMALL.items():
        (tmp_path / f"{name}.tk").write_text(text)
    lines = [f"solve {model}" for model in SEARCHED]
    lines += [f"solve {ROOT / 'models' / case}" for case in DRIVEN]
    lines += [f"solve {tmp_path / name}.tk --all" for name in SMALL]
    store = tmp_path / "store"
    each_imported(lines, store, at_hand=("sympy", "lark", "mpmath", "numpy"))
    found = each_imported(lines, store)
    for line, names in found.items():
        digits = {"mpmath"} if line.endswith(("loan", ".csv")) else set()
        assert (line, names & (SCIENCE | FIRST) - digits) == (line, set())


def test_what_is_free_is_told_without_a_library(tmp_path: Path) -> None:
    """A stretch of answers, and an unknown that its rule loses at these numbers."""
    sheets = {
        "stretch": "int(x) = 3\n",
        "lost": "y*(z - z)*y = 0\nz = 3\n",
    }
    for name, text in sheets.items():
        (tmp_path / f"{name}.tk").write_text(text)
    lines = [f"solve {tmp_path / name}.tk" for name in sheets]
    store = tmp_path / "store"
    each_imported(lines, store, at_hand=("sympy", "lark", "mpmath", "numpy"), code=1)
    for line, names in each_imported(lines, store, code=1).items():
        assert (line, names & SCIENCE - {"mpmath"}) == (line, set())


@pytest.mark.parametrize("line", ["--help", "models", "cache"])
def test_other_commands_import_next_to_nothing(line: str, tmp_path: Path) -> None:
    assert imported(line, tmp_path / "store") & (SCIENCE | FIRST | SLOW) == set()


def test_the_packages_import_nothing_by_themselves(tmp_path: Path) -> None:
    call = [sys.executable, "-c", "import sys, rulesheets, solver; print(*sys.modules)"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    ran = subprocess.run(call, capture_output=True, text=True, env=environment, timeout=60, check=True)
    assert set(ran.stdout.split()) & (SCIENCE | FIRST | {"dataclasses", "argparse"}) == set()


def test_an_expression_for_an_input_is_read_without_lark_the_second_time(tmp_path: Path) -> None:
    line = "solve offset_slider_crank --set thetaAO=-60/2"
    imported(line, tmp_path / "store")
    assert imported(line, tmp_path / "store") & SCIENCE == set()


def test_a_sheet_whose_lines_are_shaped_like_others_is_read_without_lark(tmp_path: Path) -> None:
    for name, text in (("one", "y = 2*x + 1\nx = 3\n"), ("two", "b = 7*a + 5\na = 1\n")):
        (tmp_path / f"{name}.tk").write_text(text)
    assert "lark" in imported(f"solve {tmp_path / 'one.tk'}", tmp_path / "store")
    again = imported(f"solve {tmp_path / 'two.tk'}", tmp_path / "store")
    assert "rulesheets.parse" in again
    assert again & SCIENCE == set()


def test_processes_at_the_same_time_share_a_store(tmp_path: Path) -> None:
    """Each has an order of sets of its own, and all print the same as one that keeps nothing."""
    call = [sys.executable, "-m", "solver", "solve", "offset_slider_crank", "--explain"]
    store = str(tmp_path / "store")

    def started(seed: int, store: str) -> subprocess.Popen[bytes]:
        own = {"BACKSOLVE_CACHE": store, "PYTHONPATH": str(ROOT), "PYTHONHASHSEED": str(seed)}
        return subprocess.Popen(call, stdout=subprocess.PIPE, env={**os.environ, **own})

    running = [started(seed, store) for seed in range(1, 5)] + [started(5, "")]
    printed = {process.communicate(timeout=120)[0] for process in running}
    printed.add(started(6, store).communicate(timeout=120)[0])
    assert len(printed) == 1
    assert printed.pop().startswith(b"St  Input")
    assert [process.returncode for process in running] == [0] * 5
    names = sorted(path.name.partition("-")[0] for path in (tmp_path / "store").iterdir())
    assert names == ["grammar", "model", "paths"]
