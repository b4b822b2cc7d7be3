"""One line that says what a solve has done."""

from __future__ import annotations

from collections.abc import Sequence

from rulesheets.spelling import plural
from solver.path.steps import Evaluate, Path, Select, SolveBlock
from solver.report.numbers import magnitude
from solver.result import Result, Status


def work_line(result: Result) -> str:
    """``29 rules: 27 direct, 1 block of 2; all satisfied, worst residual 1e-16``.

    Rules are counted by equation: a tuple counts for each of its halves, a rule function
    once a call. The last part is there where there is an answer, or a part of one.
    """
    rules = plural(len(result.model.equations), "rule")
    line = f"{rules}: {', '.join(_parts(result))}"
    if not result.solutions or not result.solutions[0].checked:
        return line
    answer = result.solutions[0]
    satisfied = "all" if result.status is Status.SOLVED else str(answer.checked)
    return f"{line}; {satisfied} satisfied, worst residual {magnitude(answer.worst_residual)}"


def used(path: Path) -> int:
    """How many equations the path solves with."""
    return direct(path) + sum(block_sizes(path))


def direct(path: Path) -> int:
    return sum(isinstance(step, Evaluate | Select) for step in path.steps)


def block_sizes(path: Path) -> tuple[int, ...]:
    """Number of unknowns of each simultaneous block, in order."""
    return tuple(len(step.unknowns) for step in path.steps if isinstance(step, SolveBlock))


def _parts(result: Result) -> list[str]:
    path, total = result.path, len(result.model.equations)
    sizes = block_sizes(path)
    parts = [f"{direct(path)} direct"] if direct(path) or not sizes else []
    if sizes:
        parts.append(_blocks(sizes))
    if not result.solutions:
        return parts
    active = result.solutions[0].checked
    checks, idle = active - used(path), total - max(active, used(path))
    if checks > 0:
        parts.append(plural(checks, "check"))
    if idle > 0:
        parts.append(f"{idle} idle")
    return parts


def _blocks(sizes: Sequence[int]) -> str:
    low, high = min(sizes), max(sizes)
    size = f"{low}" if low == high else f"{low} to {high}"
    return f"{plural(len(sizes), 'block')} of {size}"
