"""The direction of imports: downward only, one door for each heavy dependency, no cycles.

Imports inside functions count like those at the top; those for type checkers alone do not.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent

FLOORS = (
    (
        "solver.structure",
        "solver.numerics",
        "solver.facts",
        "solver.lane",
    ),
    ("solver.path", "solver.editor"),
    ("solver.ranking", "solver.accuracy", "solver.files"),
    ("solver.leaves", "solver.kernel", "solver.derivatives"),
    ("solver.solution", "solver.trace"),
    ("solver.sweeps",),
    ("solver.report", "solver.pictures"),
    ("solver.commands",),
    ("solver.page", "solver.__main__"),
)
"""Rooms of the solver, the lowest floor first. A module imports from its own room and from floors
below."""

ISLANDS = ("solver.structure", "solver.numerics")
"""Rooms that import nothing of ours but themselves."""

EVERYWHERE = ("rulesheets.deadline",)
"""What is at hand in every room, islands included, like a module of the standard library."""

DOORS = {
    "lark": ("rulesheets.parse",),
    "sympy": ("rulesheets.algebra",),
    "pint": ("rulesheets.library",),
    "matplotlib": ("solver.pictures",),
    "rich": ("solver.report",),
    "PIL": ("solver.pictures",),
    "distributed": ("solver.sweeps.workers",),
    "starlette": ("solver.page.server",),
    "anywidget": ("solver.page.widget",),
    "traitlets": ("solver.page.widget",),
    "uvicorn": ("solver.page.server",),
    "pygls": ("solver.editor.server",),
    "pygments": ("solver.editor.lexer",),
    "lsprotocol": ("solver.editor.server",),
    "llvmlite": ("solver.trace.llvm",),
    "flint": ("rulesheets.evaluate",),
    "mpmath": ("rulesheets.evaluate",),
    "scipy": ("solver.numerics", "solver.structure", "rulesheets.functions"),
}
"""The rooms through which a heavy dependency may come in."""


@cache
def modules() -> dict[str, Path]:
    """Every module of the two packages by its dotted name."""
    found = {}
    for package in ("rulesheets", "solver"):
        for file in sorted((ROOT / package).rglob("*.py")):
            parts = file.relative_to(ROOT).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = file
    return found


@cache
def imports(module: str) -> frozenset[str]:
    """Dotted names that a module imports, submodules of ours resolved."""
    tree = ast.parse(modules()[module].read_text(encoding="utf-8"))
    return frozenset(_resolved(name) for name in _imported(tree))


def _imported(node: ast.AST) -> Iterator[str]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.If) and "TYPE_CHECKING" in ast.dump(child.test):
            for rest in child.orelse:
                yield from _imported(rest)
        elif isinstance(child, ast.Import):
            yield from (alias.name for alias in child.names)
        elif isinstance(child, ast.ImportFrom):
            assert child.level == 0, "imports are absolute"
            yield from (f"{child.module}.{alias.name}" for alias in child.names)
        else:
            yield from _imported(child)


def _resolved(name: str) -> str:
    """``solver.facts.Status`` is the module ``solver.facts``."""
    if name.partition(".")[0] not in ("rulesheets", "solver"):
        return name
    while name not in modules():
        name = name.rpartition(".")[0]
    return name


def within(module: str, room: str) -> bool:
    return module == room or module.startswith(room + ".")


def floor(module: str) -> int | None:
    """The floor of a module of the solver; None for the front door ``solver`` itself."""
    for level, rooms in enumerate(FLOORS):
        if any(within(module, room) for room in rooms):
            return level
    return None


def ours(module: str) -> list[str]:
    return sorted(name for name in imports(module) if name in modules() and name != module)


def test_every_module_of_the_solver_has_a_floor() -> None:
    homeless = [m for m in modules() if within(m, "solver") and m != "solver" and floor(m) is None]
    assert homeless == []


def test_the_language_knows_nothing_of_solving() -> None:
    wrong = [
        (m, n) for m in modules() if within(m, "rulesheets") for n in ours(m) if within(n, "solver")
    ]
    assert wrong == []


def test_imports_run_downward() -> None:
    wrong = [(m, n) for m in modules() if m != "solver" for n in ours(m) if _upward(m, n)]
    assert wrong == []


def _upward(module: str, imported: str) -> bool:
    here, there = floor(module), floor(imported)
    if here is None or not within(imported, "solver"):
        return False
    return there is None or there > here


@pytest.mark.parametrize("room", ISLANDS)
def test_islands_import_nothing_of_ours(room: str) -> None:
    foreign = [(m, n) for m in modules() if within(m, room) for n in ours(m) if not within(n, room)]
    assert [(m, n) for m, n in foreign if n not in EVERYWHERE] == []


@pytest.mark.parametrize("dependency", DOORS)
def test_a_heavy_dependency_has_one_door(dependency: str) -> None:
    rooms = DOORS[dependency]
    wrong = [
        module
        for module in modules()
        if any(within(name, dependency) for name in imports(module))
        and not any(within(module, room) for room in rooms)
    ]
    assert wrong == []


def test_there_is_no_cycle() -> None:
    """A package may gather names of its modules in its ``__init__``: that way round is no cycle."""
    graph = {m: [n for n in ours(m) if not within(m, n)] for m in modules()}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as cycle:
        pytest.fail(" -> ".join(cycle.args[1]))


def test_the_reading_of_imports_sees_what_it_should() -> None:
    source = "import a.b\ndef f():\n    from c import d\nif TYPE_CHECKING:\n    import e\n"
    assert list(_imported(ast.parse(source))) == ["a.b", "c.d"]
