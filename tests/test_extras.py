"""The plain install: extras are imported in guarded places alone, and what needs one says so."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
EXTRAS = (
    *("flint", "matplotlib", "PIL", "llvmlite", "pyarrow", "distributed", "dask", "rich", "pint"),
    *(
        "starlette",
        "uvicorn",
        "websockets",
        "pygls",
        "lsprotocol",
        "pygments",
        "anywidget",
        "traitlets",
    ),
)

GUARDS = {
    "solver.solution.solving": "require_proof",
    "solver.pictures": "require_matplotlib",
    "solver.trace.llvm": "available",
    "solver.commands.chart": "require_matplotlib",
    "solver.commands.draw": "require_matplotlib",
    "solver.commands.sweep": "require_matplotlib",
    "solver.page.serving": "require_extra",
    "solver.files.tables": "require_extra",
}
"""Rooms whose functions import extras, and what whoever enters asks before; elsewhere the import
itself is tried, and ImportError is caught."""


def modules() -> dict[str, Path]:
    files = [file for room in ("rulesheets", "solver") for file in (ROOT / room).rglob("*.py")]
    return {
        ".".join(f.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): f
        for f in files
    }


MODULES = modules()


@cache
def tree(module: str) -> ast.Module:
    return ast.parse(MODULES[module].read_text())


def imported(node: ast.AST) -> list[str]:
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if isinstance(node, ast.ImportFrom) and node.module and not node.level:
        return [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    return []


def statements(body: list[ast.stmt], tried: bool = False) -> Iterator[tuple[ast.stmt, bool]]:
    """Statements that run when a body does, each with whether ImportError is caught there."""
    for node in body:
        yield node, tried
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            continue
        catches = isinstance(node, ast.Try) and any(
            "ImportError" in ast.unparse(h.type or node) for h in node.handlers
        )
        for name in ("body", "orelse", "handlers", "finalbody"):
            if isinstance(node, ast.If | ast.For | ast.While | ast.With | ast.Try):
                parts = getattr(node, name, [])
                inner = [
                    part
                    for h in parts
                    for part in (h.body if isinstance(h, ast.ExceptHandler) else [h])
                ]
                yield from statements(inner, tried or (catches and name == "body"))


@cache
def bodies(module: str) -> list[tuple[bool, list[tuple[ast.stmt, bool]]]]:
    """The module's own statements, and those of each of its functions; True for the former."""
    parts = [n for n in ast.walk(tree(module)) if isinstance(n, ast.ClassDef | ast.FunctionDef)]
    return [
        (not isinstance(node, ast.FunctionDef), list(statements(node.body)))
        for node in (tree(module), *parts)
    ]


@cache
def needing() -> set[str]:
    """The modules that cannot be imported without an extra: those that import one, and theirs."""
    needed = {
        module: {
            name
            for whole, found in bodies(module)
            if whole
            for node, tried in found
            if not tried
            for name in imported(node)
        }
        for module in MODULES
    }
    found: set[str] = set()
    while True:
        more = {
            m for m, names in needed.items() if any(extra(n) or n in found for n in names)
        } - found
        if not more:
            return found
        found |= more


def extra(name: str) -> bool:
    return name.split(".")[0] in EXTRAS


def test_extras_are_imported_in_guarded_places_alone() -> None:
    wrong = [
        f"{module}:{node.lineno} imports {name}"
        for module in sorted(set(MODULES) - needing())
        for whole, found in bodies(module)
        for node, tried in found
        for name in imported(node)
        if (extra(name) or name in needing())
        and not tried
        and (whole or not any(f"{module}.".startswith(f"{room}.") for room in GUARDS))
    ]
    assert wrong == []


def test_each_guard_is_asked() -> None:
    """Somebody calls it, in the room or where the room is entered."""
    calls = (
        node.func
        for module in MODULES
        for node in ast.walk(tree(module))
        if isinstance(node, ast.Call)
    )
    called = {
        func.attr if isinstance(func, ast.Attribute) else getattr(func, "id", "") for func in calls
    }
    assert set(GUARDS.values()) <= called


def without_extras(code: str, *words: str) -> subprocess.CompletedProcess[str]:
    """Python code in a process to which no extra is installed."""
    blocked = f"import sys\nfor name in {EXTRAS!r}: sys.modules[name] = None\n"
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "BACKSOLVE_CACHE": ""}
    return subprocess.run(
        [sys.executable, "-c", blocked + code, *words],
        capture_output=True,
        text=True,
        env=environment,
    )


def test_all_other_modules_are_imported_without_extras() -> None:
    names = sorted(set(MODULES) - needing() - {"solver.__main__"})
    code = (
        f"import importlib\nfor name in {names!r}: "
        f"importlib.import_module(name)\nprint(len({names!r}))"
    )
    done = without_extras(code)
    assert (done.returncode, done.stderr, done.stdout) == (0, "", f"{len(names)}\n")


COMMAND = "from solver.__main__ import main\nsys.exit(main(sys.argv[1:]))"
CRANK = "offset_slider_crank"


@pytest.mark.parametrize(
    ("words", "extra"),
    [
        (["solve", CRANK, "--prove"], "proof"),
        (["draw", CRANK, "-o", "x.png"], "plot"),
        (["sweep", CRANK, "--over", "thetaAO=0:9:3", "--want", "xB", "--plot", "x.png"], "plot"),
        (["sweep", CRANK, "--over", "thetaAO=0:9:3", "--want", "xB", "-o", "x.parquet"], "parquet"),
        (["chart", CRANK, "-o", "x.png"], "plot"),
    ],
)
def test_what_needs_an_extra_names_it(tmp_path: Path, words: list[str], extra: str) -> None:
    done = without_extras(f"import os; os.chdir({str(tmp_path)!r})\n{COMMAND}", *words)
    assert done.returncode == 2
    assert f"pip install 'backsolve[{extra}]'" in done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("rules", "status"),
    [
        ("erfc(u) = 2", "infeasible"),
        ("exp(w) = 0", "infeasible"),
        ("R1/R2 = 1.4\nR1*cosd(p) = 2\np + 30*R2 = 60", "solved"),
        ("Q = w*d/n*(w*d/(w + 2*d))^(2/3)*sqrt(s)\nQ = 5\nd = 1.2\nn = 0.013\ns = 0.001", "solved"),
    ],
)
def test_sheets_are_solved_alike_without_extras(tmp_path: Path, rules: str, status: str) -> None:
    sheet = tmp_path / "sheet.tk"
    sheet.write_text(f"rules\n{rules}\n")
    done = without_extras(COMMAND, "solve", str(sheet), "--json")
    assert f'"status": "{status}"' in done.stdout, done.stderr
    assert done.stderr == ""
