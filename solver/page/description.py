"""A model as the page shows it before anything is solved."""

from __future__ import annotations

import re
from math import isfinite
from typing import Any

from rulesheets.diagnosis import Diagnosis, render
from rulesheets.model import Equation, Model, Variable
from solver.page.figures import outline
from solver.report.notation import Tex
from solver.report.path import Places, rule_text

_SCOPE = re.compile(r"\\text\{[^{}]*\.\}")
"""The name of a call in front of a local, which the rule itself does not write."""


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
        "unit": variable.unit or "",
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
    return [[_line(model, equation) for equation in group] for group in rule_groups(model)]


def _line(model: Model, equation: Equation) -> str:
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
        "notes": list(diagnosis.notes),
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
