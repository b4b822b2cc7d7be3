"""The rule sheet's status column: rules that are not satisfied, and why."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from rulesheets.model import Equation, Requirement
from rulesheets.source import Span
from solver.report.places import Places, rule_text
from solver.report.sheet import answers
from solver.report.table import table
from solver.result import Result, Status

WAITING, BLAMED = "*", ">"

LIMIT = 12
"""Rows shown; the rest is counted."""

LONGEST = 72
"""Characters of a rule shown; its place tells where to read on."""


@dataclass(frozen=True, slots=True)
class RuleStatus:
    """``mark`` is ``>`` for a rule that a diagnosis points at, ``*`` for one that waits for unknowns.

    Rules wait where the inputs do not determine everything; where a solve has ended otherwise,
    what comes after it is not worth telling.
    """

    mark: str
    equation: Equation | Requirement
    waits_for: tuple[str, ...]


def rule_statuses(result: Result) -> tuple[RuleStatus, ...]:
    """The rules that are not satisfied, those blamed first and once, others once a call."""
    if result.status is Status.SOLVED:
        return ()
    found: dict[tuple[Span, str], RuleStatus] = {}
    for status in _statuses(result):
        scope = "" if status.mark == BLAMED else status.equation.scope
        found.setdefault((status.equation.rule, scope), status)
    return tuple(sorted(found.values(), key=lambda status: status.mark != BLAMED))


def rule_status_table(result: Result) -> str:
    """The statuses as a table, empty where every rule is satisfied."""
    statuses = rule_statuses(result)
    if not statuses:
        return ""
    places = Places(result.model)
    shown = statuses[:LIMIT]
    rows = ((s.mark, places.of(s.equation), _clipped(s.equation), _waiting(s)) for s in shown)
    head = ("St", "Place", "Rule", "Waits for" if any(s.waits_for for s in shown) else "")
    text = table(head, rows, soft=(2, 3))
    hidden = len(statuses) - len(shown)
    return f"{text}\n… and {hidden} more" if hidden else text


def _statuses(result: Result) -> Iterator[RuleStatus]:
    blamed = {(label.span.file, label.span.start) for d in result.diagnoses for label in d.labels}
    (known,) = answers(result, every=False)
    partial = result.status is Status.PARTIAL
    rules: tuple[Equation | Requirement, ...] = (*result.model.equations, *result.model.requirements)
    for equation in rules:
        waits_for = tuple(name for name in equation.names if name not in known)
        if (equation.rule.file, equation.rule.start) in blamed:
            yield RuleStatus(BLAMED, equation, waits_for)
        elif partial and waits_for:
            yield RuleStatus(WAITING, equation, waits_for)


def _clipped(equation: Equation | Requirement) -> str:
    text = rule_text(equation.rule)
    return text if len(text) <= LONGEST else text[: LONGEST - 2] + " …"


def _waiting(status: RuleStatus) -> str:
    names = status.waits_for
    return ", ".join(names[:4]) + (", …" if len(names) > 4 else "")
