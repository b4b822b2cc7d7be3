"""The result of a solve as the page shows it."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite
from typing import Any

from rulesheets.evaluate import Undefined, holds
from rulesheets.model import Equation, Value
from solver.page.description import complaint, rule_groups
from solver.page.figures import geometry
from solver.path.steps import equations_of
from solver.report.path import told
from solver.result import Result, Status


def answered(result: Result) -> dict[str, Any]:
    """Status, every answer with its figures, messages, and the state of every rule."""
    shown = [finite(answer) for answer in result.solutions]
    return {
        "status": str(result.status),
        "complete": result.complete,
        "inputs": dict(result.inputs),
        "guesses": dict(result.guesses),
        "undetermined": list(result.undetermined),
        "solutions": shown,
        "partial": finite(result.partial),
        "figures": [geometry(result.model, answer) for answer in result.solutions],
        "residual": max((answer.worst_residual for answer in result.solutions), default=0.0),
        "diagnoses": [complaint(diagnosis) for diagnosis in result.diagnoses],
        "rules": _rules(result),
    }


def finite(values: Mapping[str, Value]) -> dict[str, Value]:
    """The values that JSON can carry."""
    return {name: value for name, value in values.items() if isinstance(value, str) or isfinite(value)}


def _rules(result: Result) -> list[dict[str, Any]]:
    """Of each rule its state and the number of the step of the path that uses it (0: none)."""
    place: dict[int, int] = {}
    for number, step in enumerate(told(result.path), 1):
        for index in equations_of(step):
            place.setdefault(index, number)
    blamed = {(label.span.file, label.span.start) for d in result.diagnoses for label in d.labels}
    return [_state(result, group, place, blamed) for group in rule_groups(result.model)]


def _state(
    result: Result, group: list[Equation], place: Mapping[int, int], blamed: set[tuple[str, int]]
) -> dict[str, Any]:
    known = result.solutions[0] if result.solutions else result.partial
    active = [equation for equation in group if _active(result, equation, known)]
    steps = [place[equation.index] for equation in active if equation.index in place]
    missing = sorted({name for equation in group for name in equation.names if name not in known})
    if result.status is not Status.SOLVED and (group[0].rule.file, group[0].rule.start) in blamed:
        state = "broken"
    elif result.status is not Status.SOLVED and missing:
        state = "waiting"
    else:
        state = "used" if steps else "idle"
    return {"state": state, "step": min(steps, default=0), "waits": missing if state == "waiting" else []}


def _active(result: Result, equation: Equation, known: Mapping[str, Value]) -> bool:
    """Whether the conditions of an equation hold at the values that are known."""
    try:
        return all(
            holds(result.model.conditions[premise.condition], known, result.inputs) is premise.holds
            for premise in equation.guard
        )
    except (KeyError, Undefined):
        return False
