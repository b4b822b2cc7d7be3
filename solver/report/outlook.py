"""The path ahead of a solve as text: its steps, the cases that follow, and what it does not reach."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rulesheets.model import Model, Premise
from solver.path.outlook import Outlook, question
from solver.path.steps import Path
from solver.report.notation import Plain
from solver.report.path import path_table, told


def outlook_text(model: Model, outlook: Outlook, wanted: Sequence[str]) -> str:
    """A table for the path and one for each case under its conditions, then how many answers there can be."""
    parts = list(_parts(model, outlook, wanted, (), 1))
    if outlook.path.steps:
        parts.append(_answers(outlook))
    return "\n\n".join(parts) if outlook.cases else "\n".join(parts)


def reaches(outlook: Outlook, wanted: Sequence[str]) -> bool:
    """Whether some end of the outlook, as far as it is followed, leads to every wanted variable."""
    return any(end.open or not unreached(end.path, wanted) for end in outlook.ends())


def unreached(path: Path, wanted: Sequence[str]) -> tuple[str, ...]:
    """The wanted variables that a path does not lead to."""
    beyond = set(path.undetermined)
    return tuple(name for name in wanted if name in beyond)


def _parts(
    model: Model, outlook: Outlook, wanted: Sequence[str], outcomes: tuple[Premise, ...], first: int
) -> Iterator[str]:
    lines = [f"Where {_said(model, outcomes)}:"] if outcomes else []
    if outlook.path.steps:
        lines.append(path_table(model, outlook.path, first))
    else:
        lines.append("No rule gives anything more." if outcomes else "No rule gives anything.")
    missing = unreached(outlook.path, wanted)
    if missing and not question(outlook.path):
        lines.append(f"Not reached: {', '.join(missing)}.")
    yield "\n".join(lines)
    after = first + len(told(outlook.path))
    for case in outlook.cases:
        yield from _parts(model, case.outlook, wanted, (*outcomes, *case.outcomes), after)


def _said(model: Model, outcomes: tuple[Premise, ...]) -> str:
    """``x > 0 and not (y > 0)``."""
    return Plain().conditions((model.conditions[premise.condition], premise.holds) for premise in outcomes)


def _answers(outlook: Outlook) -> str:
    if any(end.open for end in outlook.ends()):
        return "What follows depends on how the conditions come out, and on how many answers there are then."
    if outlook.branches is None:
        return "Blocks can have any number of answers."
    return "One answer at most." if outlook.branches == 1 else f"At most {outlook.branches} answers."
