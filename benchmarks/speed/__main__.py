"""Speed beside hand-written code and other libraries, measured in one run.

    python -m benchmarks.speed [PART…] [--rounds N] [--rows N] [--to-disk N] [--write]

prints a table for each part (all where none is named) and says what it is held to. ``--write`` puts
the tables into docs/speed.md and the bars into docs/pictures/speed.png. Peers that are not
installed are left out, and named (``pip install numba cffi casadi jax``).
"""

from __future__ import annotations

import argparse
import os
import platform
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

from benchmarks.pages import place
from benchmarks.speed import compiling, every_model, many_rows, one_solve, solvers, whole_commands
from benchmarks.speed.page import Section
from benchmarks.speed.picture import draw

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "speed.md"
PICTURE = ROOT / "docs" / "pictures" / "speed.png"


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.speed", description=__doc__.splitlines()[0]
    )
    parser.add_argument(
        "parts", nargs="*", metavar="PART", help="one rows jit disk startup rules models"
    )
    parser.add_argument(
        "--rounds", type=int, default=9, help="times that each is measured; the best counts"
    )
    parser.add_argument("--rows", type=int, default=1_000_000, help="rows of the sweeps")
    parser.add_argument(
        "--to-disk", type=int, default=10_000_000, help="rows of the sweep to a file"
    )
    parser.add_argument(
        "--write", action="store_true", help="put the tables and the picture into the pages"
    )
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
        if not place(PAGE, f"speed: {section.name}", section.markdown()):
            sys.exit(
                f"docs/speed.md has no place for {section.name}: <!-- speed: {section.name} -->"
            )
    if {"one", "rows"} <= {section.name for section in sections}:  # the tables that peers stand in
        place(PAGE, "speed: machine", machine())
        draw(sections, PICTURE)


if __name__ == "__main__":
    main()
