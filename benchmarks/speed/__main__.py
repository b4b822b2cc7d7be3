"""Speed beside hand-written code and other libraries, measured in one run.

    python -m benchmarks.speed [PART…] [--rounds N] [--rows N] [--to-disk N] [--write]

prints a table for each part (all where none is named) and says what it is held to. ``--write`` puts the
tables into docs/speed.md and README.md and the bars into docs/pictures/speed.png. Peers that are not
installed are left out, and named (``pip install numba cffi casadi jax``).
"""

from __future__ import annotations

import argparse
import os
import platform
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

from benchmarks.pages import markdown_table, place
from benchmarks.speed import compiling, every_model, many_rows, one_solve, solvers, whole_commands
from benchmarks.speed.page import Section
from benchmarks.speed.picture import draw

ROOT = Path(__file__).parents[2]
PAGES = (ROOT / "docs" / "speed.md", ROOT / "README.md")
PICTURE = ROOT / "docs" / "pictures" / "speed.png"


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.speed", description=__doc__.splitlines()[0])
    parser.add_argument("parts", nargs="*", metavar="PART", help="one rows jit disk startup rules models")
    parser.add_argument("--rounds", type=int, default=9, help="times that each is measured; the best counts")
    parser.add_argument("--rows", type=int, default=1_000_000, help="rows of the sweeps")
    parser.add_argument("--to-disk", type=int, default=10_000_000, help="rows of the sweep to a file")
    parser.add_argument("--write", action="store_true", help="put the tables and the picture into the pages")
    options = parser.parse_args()
    parts: dict[str, Callable[[], Iterator[Section]]] = {
        "one": lambda: iter((one_solve.measure(options.rounds),)),
        "rows": lambda: iter(many_rows.measure(options.rounds, options.rows)),
        "jit": lambda: iter((compiling.measure(3),)),
        "disk": lambda: iter((whole_commands.to_disk(options.to_disk),)),
        "startup": lambda: iter((whole_commands.starting(options.rounds),)),
        "rules": lambda: iter((whole_commands.many_rules(32_000),)),
        "models": lambda: iter((every_model.measure(),)),
    }
    unknown = [name for name in options.parts if name not in parts]
    if unknown:
        parser.error(f"there is no part {unknown[0]!r}; there are {', '.join(parts)}")
    print(f"{machine()}\n", flush=True)
    sections = []
    for name in options.parts or parts:
        for section in parts[name]():
            print(f"## {section.title}\n\n{section.markdown()}\n", flush=True)
            sections.append(section)
    if options.write:
        write(sections)


def machine() -> str:
    """What it ran on, and what was left out."""
    missing = f"; not installed: {', '.join(solvers.absent())}" if solvers.absent() else ""
    return f"Python {platform.python_version()}, {platform.machine()}, {os.cpu_count()} processors{missing}"


def write(sections: list[Section]) -> None:
    for section in sections:
        if not place(PAGES[0], f"speed: {section.name}", section.markdown()):
            sys.exit(f"docs/speed.md has no place for {section.name}: <!-- speed: {section.name} -->")
    if {"one", "rows"} <= {section.name for section in sections}:  # the tables that peers stand in
        place(PAGES[0], "speed: machine", machine())
        place(PAGES[1], "speed: summary", summary(sections))
        draw(sections, PICTURE)


def summary(sections: list[Section]) -> str:
    """The times of a few contestants, for the first page."""
    bars = {title: {name: number for name, number, _ in each} for s in sections for title, _, each in s.bars}
    columns = list(bars.values())
    rows = [(words, *(one_or_none(column, names) for column in columns)) for words, names in IN_SHORT.items()]
    head = (
        "processor time",
        "one solve, µs",
        "both answers backward, µs",
        "a row of 1e6, ns",
        "a row backward, ns",
    )
    return markdown_table(head, rows)


IN_SHORT = {
    "Backsolve, every answer checked": (one_solve.OURS, many_rows.OURS),
    "Backsolve, machine code": (many_rows.JIT,),
    "closed form by hand, Python; blocked numpy": (one_solve.HAND, many_rows.NUMPY),
    "closed form by hand, numba, parallel": (many_rows.PARALLEL,),
    "sympy.lambdify with cse": ("sympy.lambdify with cse", "sympy.lambdify with cse, numpy"),
    "scipy fsolve with Jacobian, five equations": (one_solve.FIVE, "scipy fsolve with Jacobian, a loop"),
    "scipy fsolve with Jacobian, the rules of the sheet": (one_solve.RULES,),
}


def one_or_none(column: dict[str, float], names: tuple[str, ...]) -> str:
    from benchmarks.speed.page import figures

    return next((figures(column[name]) for name in names if name in column), "–")


if __name__ == "__main__":
    main()
