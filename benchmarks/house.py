"""The structure of the code: lines a room, modules, floors, cycles, and the walk of one question.

    python -m benchmarks.house

prints what ``docs/architecture.md`` quotes. A *room* is a folder, or a module that stands beside
the folders. *Floors* are the rooms on the longest chain of imports, with rooms that import each
other on one floor; *cycles* are groups of modules that import each other. Every import counts:
those inside functions, and those that only annotations need. The *walk* runs a command in a process
of its own and counts which of our files and functions it enters: first with an empty cache, as
after a change of the source, and then again.
"""

from __future__ import annotations

import ast
import os
import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Iterator, Mapping
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

ROOT = Path(__file__).parent.parent
PACKAGES = ("rulesheets", "solver")
QUESTION = "solve offset_slider_crank --clear thetaAO --set xB=9.79 --want thetaAO,omegaAB --all"

WALK = """
import sys
entered, calls = set(), 0
def enter(frame, event, argument):
    global calls
    if event == "call":
        code = frame.f_code
        if code.co_filename.startswith(FOLDERS) and not code.co_name.startswith("<"):
            entered.add(code)
            calls += 1
from solver.__main__ import main
sys.setprofile(enter)
main(sys.argv[1:])
sys.setprofile(None)
functions = {code for code in entered if code.co_flags & 1}  # the body of a class is none
for kind in (entered, functions):
    print(len({code.co_filename for code in kind}), len(kind), file=sys.stderr)
print(calls, file=sys.stderr)
"""


@cache
def modules() -> Mapping[str, Path]:
    """Every module of the two packages by its dotted name."""
    found = {}
    for package in PACKAGES:
        for file in sorted((ROOT / package).rglob("*.py")):
            parts = file.relative_to(ROOT).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = file
    return found


def imports(file: Path) -> Iterator[str]:
    """Modules of ours that a file imports anywhere."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        else:
            continue
        for name in names:
            while name and name not in modules():
                name = name.rpartition(".")[0]
            if name:
                yield name


def graph() -> dict[str, set[str]]:
    """Module → the modules that it imports. A package may gather names of its own modules."""
    return {
        module: {
            name for name in imports(file) if name != module and not name.startswith(module + ".")
        }
        for module, file in modules().items()
    }


def cycles(edges: Mapping[str, set[str]]) -> list[list[str]]:
    """Groups of modules that import each other, the largest first."""
    names = list(edges)
    number = {name: place for place, name in enumerate(names)}
    pairs = np.array([(number[a], number[b]) for a in names for b in edges[a]]).reshape(-1, 2)
    matrix = csr_array((np.ones(len(pairs)), pairs.T), shape=(len(names), len(names)))
    _, groups = connected_components(matrix, directed=True, connection="strong")
    members = defaultdict(list)
    for name, group in zip(names, groups, strict=True):
        members[group].append(name)
    return sorted((group for group in members.values() if len(group) > 1), key=len, reverse=True)


def room_of(module: str) -> str:
    """``solver.path`` for ``solver.path.graph``; a module beside the folders is a room of its
    own."""
    return ".".join(module.split(".")[:2])


def floors(edges: Mapping[str, set[str]]) -> int:
    """The rooms on the longest chain of imports, those of a cycle counted as one."""
    between: dict[str, set[str]] = defaultdict(set)
    for name, below in edges.items():
        between[room_of(name)] |= {room_of(other) for other in below} - {room_of(name)}
    home = {room: room for room in between}
    for group in cycles(between):
        home.update(dict.fromkeys(group, group[0]))
    joined: dict[str, set[str]] = {place: set() for place in home.values()}
    for name, below in between.items():
        joined[home[name]] |= {home[other] for other in below} - {home[name]}
    level: dict[str, int] = {}
    for name in TopologicalSorter(joined).static_order():
        level[name] = 1 + max((level[other] for other in joined[name]), default=0)
    return max(level.values())


def rooms() -> dict[str, tuple[int, int]]:
    """Room → lines and modules."""
    found: dict[str, tuple[int, int]] = defaultdict(lambda: (0, 0))
    for module, file in modules().items():
        nested = module.count(".") > 1 or file.name == "__init__.py"
        room = room_of(module) if nested else module.partition(".")[0]
        lines, count = found[room]
        found[room] = lines + file.read_text(encoding="utf-8").count("\n"), count + 1
    return dict(sorted(found.items()))


def walk(words: str, cache: str) -> list[int]:
    """Files and functions of ours that a command enters, with bodies of classes and without; calls.

    ``cache`` is the folder of its cache.
    """
    folders = tuple(str(ROOT / package) for package in PACKAGES)
    code = f"FOLDERS = {folders!r}\n{WALK}"
    ran = subprocess.run(
        [sys.executable, "-c", code, *words.split()],
        cwd=ROOT,
        env=os.environ | {"BACKSOLVE_CACHE": cache},
        capture_output=True,
        text=True,
        check=False,
    )
    return [int(word) for word in ran.stderr.split()[-5:]]


def main() -> None:
    edges, found = graph(), rooms()
    print(f"{'room':<28}{'lines':>8}{'modules':>9}")
    for room, (lines, count) in found.items():
        print(f"{room:<28}{lines:>8,}{count:>9}")
    total, circles = sum(lines for lines, _ in found.values()), cycles(edges)
    print(f"{'together':<28}{total:>8,}{len(edges):>9}")
    print(f"\nfloors {floors(edges)}, cycles {len(circles)}")
    for group in circles:
        print("  " + ", ".join(group))
    print(f"\nbacksolve {QUESTION}")
    with tempfile.TemporaryDirectory() as cache:
        for run in ("first run (empty cache)", "second run (cached)"):
            files, functions, own_files, own, calls = walk(QUESTION, cache)
            print(f"{run}: {files} files, {functions} functions, {calls:,} calls;")
            print(f"    without the bodies of classes {own_files} files, {own} functions")


if __name__ == "__main__":
    main()
