"""A program to a model: checked, its values evaluated, its calls expanded."""

from __future__ import annotations

from collections.abc import Mapping

from rulesheets.checks import check, check_figures
from rulesheets.declarations import declared
from rulesheets.diagnosis import RuleSheetError
from rulesheets.expand import Expansion, expand
from rulesheets.model import Model, Variable
from rulesheets.program import Program


def build(program: Program, name: str, files: tuple[str, ...] = ()) -> Model:
    """Check a program and expand it. Raises RuleSheetError with every complaint found."""
    check(program)
    variables = declared(program.rows)
    expansion = expand(program)
    model = Model(
        name=name,
        variables=_variables(program, variables, expansion),
        equations=expansion.equations,
        conditions=expansion.conditions,
        figures=program.sheet.figures,
        files=files,
    )
    complaints = tuple(check_figures(program, model.variables))
    if complaints:
        raise RuleSheetError(*complaints)
    return model


def _variables(
    program: Program, rows: Mapping[str, Variable], expansion: Expansion
) -> Mapping[str, Variable]:
    """Rows of the sheet, then names of its rules, then locals of the calls."""
    posted = program.sheet.variables is None
    variables = dict(rows)
    for local in (False, True):
        for name in expansion.names:
            if ("." in name) is local and name not in variables:
                variables[name] = Variable(name, posted=posted and not local)
    return variables
