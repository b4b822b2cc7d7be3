"""A model, its answers and their derivations as the page shows them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from math import isfinite
from typing import Any

from rulesheets.diagnosis import Diagnosis, render
from rulesheets.model import Equation, Model, Value, Variable
from rulesheets.units.quantity import displaying
from solver.facts import Status
from solver.page.figures import geometry, outline
from solver.path.cases import activity, outcomes
from solver.path.steps import equations_of
from solver.report.derivation import Derivation, Together
from solver.report.path import Places, Plain, Tex, rule_text, told
from solver.report.why import Line, Page
from solver.result import Result

_SCOPE = re.compile(r"\\text\{[^{}]*\.\}")
"""The name of a call in front of a local, which the rule itself does not write."""

NO_CODE = (
    "a page runs no code of a sheet; if you trust the file, solve the sheet with --allow-python in the "
    "terminal, or load it with allow_python=True and show it in a notebook"
)


def described(model: Model) -> dict[str, Any]:
    """Variables in the order of the sheet, rules in the order of the text, outlines of the figures."""
    return {
        "name": model.name,
        "variables": [_variable(variable) for variable in model.variables.values()],
        "rules": [_rule(model, group) for group in rule_groups(model)],
        "figures": [outline(figure) for figure in model.figures],
    }


def _variable(variable: Variable) -> dict[str, Any]:
    return {
        "name": variable.name,
        "value": variable.value,
        "guess": variable.guess,
        "unit": variable.display_unit or variable.unit or "",
        "scale": list(displaying(variable)),
        "low": variable.low if isfinite(variable.low) else None,
        "high": variable.high if isfinite(variable.high) else None,
        "comment": variable.comment,
        "posted": variable.posted,
    }


def rule_groups(model: Model) -> list[list[Equation]]:
    """The equations of each rule, each rule once a call."""
    groups: dict[tuple[str, int, str], list[Equation]] = {}
    for equation in model.equations:
        key = equation.rule.file, equation.rule.start, equation.scope
        groups.setdefault(key, []).append(equation)
    return list(groups.values())


def _rule(model: Model, group: list[Equation]) -> dict[str, Any]:
    first = group[0]
    return {
        "text": rule_text(first.rule),
        "place": Places(model).of(first),
        "scope": first.scope,
        "names": sorted({name for equation in group for name in equation.names}),
    }


def typeset(model: Model) -> list[list[str]]:
    """Every rule as LaTeX, a line for each of its equations with the condition that selects it."""
    return [[_typeset(model, equation) for equation in group] for group in rule_groups(model)]


def _typeset(model: Model, equation: Equation) -> str:
    notation = Tex()
    body = f"{notation.expression(equation.left)} = {notation.expression(equation.right)}"
    if equation.guard:
        outcomes = [(model.conditions[premise.condition], premise.holds) for premise in equation.guard]
        body += rf"\quad \text{{if }} {notation.conditions(outcomes)}"
    return _SCOPE.sub("", body)


def complaint(diagnosis: Diagnosis) -> dict[str, Any]:
    """A diagnosis with its places, and as the terminal prints it."""
    return {
        "code": diagnosis.code,
        "severity": str(diagnosis.severity),
        "message": diagnosis.message,
        "notes": [NO_CODE] if diagnosis.code == "E313" else list(diagnosis.notes),
        "variables": list(diagnosis.variables),
        "places": [
            {
                "file": label.span.file,
                "start": label.span.start,
                "end": label.span.end,
                "line": label.span.line,
            }
            for label in diagnosis.labels
        ],
        "printed": render(diagnosis),
    }


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
    known = result.solutions[0] if result.solutions else result.partial
    decided = outcomes(result.model, known, result.inputs)
    place: dict[int, int] = {}
    for number, step in enumerate(told(result.path), 1):
        for index in equations_of(step):
            if activity(result.model.equations[index], decided):
                place.setdefault(index, number)
    blamed = {(label.span.file, label.span.start) for d in result.diagnoses for label in d.labels}
    rows = []
    for group in rule_groups(result.model):
        steps = [place[equation.index] for equation in group if equation.index in place]
        missing = sorted({name for equation in group for name in equation.names if name not in known})
        state = "used" if steps else "idle"
        if result.status is not Status.SOLVED and (group[0].rule.file, group[0].rule.start) in blamed:
            state = "broken"
        elif result.status is not Status.SOLVED and missing:
            state = "waiting"
        waits = missing if state == "waiting" else []
        rows.append({"state": state, "step": min(steps, default=0), "waits": waits})
    return rows


def derived(derivation: Derivation) -> dict[str, Any]:
    """The inputs that a number rests on, then every step with its formula, its rule and its conditions."""
    page = Page(derivation, Tex())
    given = [page.known(known) for known in (*derivation.inputs, *derivation.assumed)]
    lines = [
        _line_of(page, line, isinstance(link, Together))
        for link in derivation.links
        for line in page.lines(link)
    ]
    return {"head": page.head(), "given": given, "lines": lines}


def _line_of(page: Page, line: Line, within: bool) -> dict[str, Any]:
    shown = {"tex": line.formula, "unit": line.unit, "within": within}
    if line.equation is None:
        return shown
    place, rule = page.rule(line.equation)
    because = [f"{word} {said}" for word, said, _ in page.guards(line.guards, Plain())]
    return {**shown, "place": place, "rule": rule, "because": because}
