"""A program to a model: checked, its values evaluated, its calls expanded."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import replace

from rulesheets.checks import check
from rulesheets.checks.marks import check_figures
from rulesheets.diagnosis import Diagnosis, Label, RuleSheetError, Severity, refuse
from rulesheets.expand import Expansion
from rulesheets.inputs import declared, valued
from rulesheets.library import Library
from rulesheets.model import Model, Variable
from rulesheets.syntax.nodes import (
    Call,
    CallRule,
    Condition,
    Equality,
    Expression,
    Function,
    Name,
    RuleSheet,
    children,
    names,
    numbers,
)
from rulesheets.syntax.program import Program, bodies, components, rules_of, walk
from rulesheets.units import differences, library_of, unit_named

_MEASURE = re.compile(r"[\d.]\[")
_PI = re.compile("Pi|PI")


def build(program: Program, name: str, files: tuple[str, ...] = ()) -> Model:
    """Check a program and expand it. Raises RuleSheetError with every complaint found."""
    check(program)
    units = library_of(program.units)
    variables = declared(program.rows, units)
    refuse(_wrong_units(program, units))
    expansion = Expansion(program)
    passed = _passed(program)
    for local in (False, True):  # rows of the sheet, then names of its rules, then locals of the calls
        for full in expansion.names:
            if ("." in full) is local and full not in variables:
                variables[full] = Variable(full, posted=not local, passed=full in passed)
    python = tuple(map(os.path.abspath, program.python))
    model = Model(
        name=name,
        variables=variables,
        equations=tuple(expansion.equations),
        conditions=tuple(expansion.conditions),
        figures=program.sheet.figures,
        requirements=tuple(expansion.requirements),
        limits=program.limits,
        notes=tuple(_respelt(program)),
        files=(*files, *python),
        python=python,
        units=units,
    )
    if found := differences(model):  # of temperatures, which are converted as such
        rows = (row for row in program.rows if row.name in found)
        changed = {row.name: valued(replace(model.variables[row.name], difference=True), row) for row in rows}
        model = replace(model, variables={**model.variables, **changed})
    refuse(check_figures(program, model.variables))
    return model


def _rule_parts(program: Program, said: re.Pattern[str]) -> list[Expression | Condition]:
    """The expressions of all rules, where a source of the program has what the pattern matches."""
    owners: list[RuleSheet | Function] = [program.sheet, *program.functions.values()]
    sources = dict.fromkeys(owner.span.source for owner in owners if owner.span is not None)
    if not any(said.search(source.text) for source in sources):
        return []
    rules = (rule for owner in owners for rule in rules_of(owner))
    return [part for rule in rules for body in bodies(rule.body) for part in children(body)]


def _wrong_units(program: Program, units: Library) -> Iterator[Diagnosis]:
    """Numbers of rules, and figures, whose units are unknown."""
    for figure in program.sheet.figures:
        try:
            unit_named(figure.unit or "", figure.span and figure.span.part(0, len("figure")), units)
        except RuleSheetError as wrong:
            yield from wrong.diagnoses
    for part in _rule_parts(program, _MEASURE):
        for number in numbers(part):
            try:
                if number.unit is not None:
                    unit_named(number.unit, number.span, units)
            except RuleSheetError as wrong:
                yield from wrong.diagnoses


def _respelt(program: Program) -> Iterator[Diagnosis]:
    """A note on the first ``Pi``, which is read as the number."""
    parts = _rule_parts(program, _PI)
    if not parts:
        return
    parts += [row.value for row in program.rows if row.value is not None]
    for node in (node for part in parts for node in walk(part)):
        if isinstance(node, Call) and node.function == "pi" and node.span is not None:
            name = node.span.text[:2]
            if name != "pi":
                message = f"{name} is read as pi, the number 3.14159…"
                yield Diagnosis("E219", Severity.NOTE, message, (Label(node.span),))
                return


def _passed(program: Program) -> set[str]:
    """Names that the sheet's own rules only pass from the results of one call to the arguments of another."""
    if not program.functions:
        return set()
    results: set[str] = set()
    arguments: set[str] = set()
    used: set[str] = set()
    for rule in rules_of(program.sheet):
        for body in bodies(rule.body):
            parts = components(body, program.functions) if isinstance(body, Equality) else (body,)
            for part in parts:
                is_call = isinstance(part, CallRule) and part.function.lower() in program.functions
                if isinstance(part, CallRule):
                    results.update(n.name for n in part.results if isinstance(n, Name))
                    arguments.update(n.name for n in part.arguments if isinstance(n, Name))
                rest = (n for n in children(part) if not (is_call and isinstance(n, Name)))
                used.update(name for node in rest for name in names(node))
    return (results & arguments) - used
