"""How the simultaneous blocks of an answer were solved: every method that was tried, and what it found."""

from __future__ import annotations

from collections.abc import Iterator

from rulesheets.spelling import plural
from solver.attempts import Attempt
from solver.path.steps import SolveBlock
from solver.report.table import table
from solver.result import Result

NAMED = 4
"""Unknowns of a block that name it."""


def attempts_text(result: Result) -> str:
    """A table of blocks and methods; nothing where no block was solved."""
    rows = [row for block, attempts in result.attempts.items() for row in _rows(block, attempts)]
    return "Methods\n" + table(("Block", "Method", "Found"), rows) if rows else ""


def _rows(block: SolveBlock, attempts: tuple[Attempt, ...]) -> Iterator[tuple[str, ...]]:
    names = ", ".join(block.unknowns[:NAMED]) + (", …" if len(block.unknowns) > NAMED else "")
    for place, attempt in enumerate(attempts):
        method = attempt.method.told.format(tear=", ".join(block.tears))
        if attempt.iterations:
            method += f", {plural(attempt.iterations, 'iteration')}"
        yield ("" if place else names, method, _found(attempt))


def _found(attempt: Attempt) -> str:
    found = plural(attempt.found, "answer") if attempt.found else "nothing"
    return f"{found}, proven to be all" if attempt.complete else found
