"""A result as one JSON object."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from math import isfinite

from rulesheets.diagnosis import Diagnosis
from rulesheets.format import format_condition
from rulesheets.model import Model, Value
from rulesheets.syntax.source import Span
from solver.path.steps import Assume, Check, Decide, Evaluate, Select, SolveBlock, Step
from solver.report.path import rule_text, told
from solver.report.sheet import named
from solver.result import Result, Solution
from solver.solution.proof import Proof

Json = dict[str, object]


def result_json(
    result: Result, *, explain: bool = False, digits: bool = False, also: Mapping[str, object] | None = None
) -> str:
    """The object of a solve; ``explain`` adds the locals under their dotted names, ``digits`` the errors.

    ``also`` are further members, put at its end.
    """
    solutions = [_solution(result, answer, explain) for answer in result.solutions]
    return _dump(
        {
            "status": str(result.status),
            "solutions": solutions,
            **({"errors": list(map(_errors, result.solutions, solutions))} if digits else {}),
            **_proofs(result, solutions),
            **_unlikely(result),
            "complete": result.complete,
            "undetermined": list(result.undetermined),
            "diagnoses": [diagnosis_json(diagnosis) for diagnosis in result.diagnoses],
            "path": [_step(result.model, step) for step in told(result.path)],
            **_units(result, solutions),
            **(also or {}),
        }
    )


def error_json(diagnoses: Iterable[Diagnosis]) -> str:
    """The object of a sheet or a command that is wrong: status ``error`` and the diagnoses."""
    return _dump({"status": "error", "diagnoses": [diagnosis_json(diagnosis) for diagnosis in diagnoses]})


def _dump(document: Json) -> str:
    return json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False)


def _solution(result: Result, answer: Mapping[str, Value], explain: bool) -> Json:
    rows = named(result)
    return {
        name: answer[name]
        for name in result.model.variables
        if name in answer and (explain or name in rows) and _finite(answer[name])
    }


def _units(result: Result, shown: list[Json]) -> Json:
    """The unit of each value: that in which the rules compute, whatever a table shows."""
    variables = result.model.variables
    found = {name: variables[name].unit for name in variables if any(name in some for some in shown)}
    units = {name: unit for name, unit in found.items() if unit}
    return {"units": units} if units else {}


def _proofs(result: Result, shown: list[Json]) -> Json:
    """What was proved of every answer, where that was asked for."""
    if not any(answer.proof for answer in result.solutions):
        return {}
    found = [
        {
            "proved": answer.proof.proved,
            "radius": {n: answer.radius[n] for n in some if n in answer.radius},
            **_beside(answer.proof, some),
        }
        for answer, some in zip(result.solutions, shown, strict=True)
        if answer.proof is not None
    ]
    return {"proofs": found}


def _beside(proof: Proof, shown: Json) -> Json:
    """What is next to a double root that is not there."""
    if proof.beside is None:
        return {}
    apart = {name: distance for name, distance in proof.beside.apart.items() if name in shown}
    return {"beside": {"roots": proof.beside.roots, "apart": apart}}


def _unlikely(result: Result) -> Json:
    """The names of unlikely size of every answer, where there are any."""
    names = [list(answer.unlikely) for answer in result.solutions]
    return {"unlikely": names} if any(names) else {}


def _errors(answer: Solution, shown: Json) -> Json:
    """The error bars of the numbers shown, null where nothing can be said."""
    bars = {name: answer.error.get(name) for name in shown}
    return {name: bar if isfinite(bar) else None for name, bar in bars.items() if bar is not None}


def _finite(value: Value) -> bool:
    return isinstance(value, str) or isfinite(value)


def diagnosis_json(diagnosis: Diagnosis) -> Json:
    return {
        "code": diagnosis.code,
        "severity": str(diagnosis.severity),
        "message": diagnosis.message,
        "notes": list(diagnosis.notes),
        "rules": [_place(label.span) for label in diagnosis.labels],
        "variables": list(diagnosis.variables),
    }


def _place(span: Span) -> Json:
    return {"file": span.file, "line": span.line, "text": rule_text(span)}


def _step(model: Model, step: Step) -> Json:
    match step:
        case Evaluate(equation, unknown, branches):
            found: Json = {"step": "evaluate", "unknowns": [unknown], "branches": branches}
            return found | _rules(model, (equation,))
        case Select(equations, unknown, branches):
            found = {"step": "select", "unknowns": [unknown], "branches": branches}
            return found | _rules(model, equations)
        case SolveBlock(equations, unknowns, tears):
            found = {"step": "block", "unknowns": list(unknowns), "tears": list(tears)}
            return found | _rules(model, equations)
        case Decide(conditions):
            return {"step": "decide", "conditions": [_condition(model, index) for index in conditions]}
        case Assume(condition):
            return {"step": "assume", "conditions": [_condition(model, condition)]}
        case Check(equation):
            return {"step": "check"} | _rules(model, (equation,))


def _rules(model: Model, equations: Iterable[int]) -> Json:
    return {"rules": [_place(model.equations[index].rule) for index in equations]}


def _condition(model: Model, index: int) -> str:
    return format_condition(model.conditions[index])
