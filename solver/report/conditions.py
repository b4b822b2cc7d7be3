"""How well the blocks of a solve determine their unknowns: rank and condition at the answer."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite

from solver.report.table import table
from solver.result import Result

NAMES = 6
"""Unknowns of a block that a row names at most."""


def conditions_text(result: Result) -> Iterator[str]:
    """A table of the blocks of the primary answer, where it has any.

    The condition is that of the Jacobian of the block by its unknowns, rules and unknowns scaled: how
    many times larger a rounding error comes out than it went in.
    """
    if not result.solutions or not (blocks := result.solutions[0].accuracy.blocks):
        return
    rows = []
    for block in blocks.values():
        rest = "" if len(block.unknowns) <= NAMES else ", …"
        names = ", ".join(block.unknowns[:NAMES]) + rest
        condition = f"{block.condition:.1e}" if isfinite(block.condition) else "infinite"
        rows.append((names, f"{block.rank} of {len(block.unknowns)}", condition))
    yield "Blocks\n" + table(("Unknowns", "Rank", "Condition"), rows)
