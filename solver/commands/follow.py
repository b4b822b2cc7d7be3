"""``backsolve sweep --follow``: the branches of answers, each followed through its turning points."""

from __future__ import annotations

import sys
from argparse import Namespace
from collections.abc import Iterator
from dataclasses import replace

from rulesheets.deadline import expired
from rulesheets.diagnosis import Diagnosis, RuleSheetError, error
from rulesheets.model import Model, Variable
from rulesheets.spelling import plural
from rulesheets.units.quantity import shown
from solver.commands.inputs import read_request
from solver.commands.option import Option
from solver.commands.over import read_axes
from solver.curves.following import follow_sweep
from solver.curves.table import Branch, CurveTable
from solver.files.columns import Columns
from solver.files.csv_table import csv_head, csv_rows
from solver.files.tables import write_table
from solver.sweeps.shown import heads, shown_columns

ALONE = ("rows", "zip", "all", "plot", "jobs", "scheduler", "resume")
"""Options of a sweep row by row, which say nothing of a curve."""


def follow(arguments: Namespace) -> int:
    """Follow, write and tell. The exit code is 0 where there are branches and only limits are singular."""
    request = read_request(arguments)
    request.expect_output(arguments.output)
    others = [option for option in ALONE if getattr(arguments, option)]
    if len(arguments.over) != 1 or others:
        raise RuleSheetError(_one_range(others))
    ((name, axis),) = read_axes(arguments.over, request.model).items()
    if request.inputs.get(name) is not None:
        raise RuleSheetError(Option("over", name).repeated(name))
    values = axis.cut(0, len(axis))
    given = {n: value for n, value in request.inputs.items() if n != name}
    table = follow_sweep(request.model, name, values, request.want, given, request.guesses)
    _write(table, request.model, arguments.output)
    late = expired()
    if late:
        print("the time was up: there may be branches that were not found", file=sys.stderr)
    if table.branches or not late:
        print("\n".join(_summary(table, request.model)), file=sys.stderr)
    return 0 if len(table.status) and _only_limits(table) else 1


def _one_range(others: list[str]) -> Diagnosis:
    said = f"; --{others[0]} does not go with it" if others else ""
    return error("E447", f"a curve is followed over one range{said}", notes=("give one --over, and --want",))


def _write(table: CurveTable, model: Model, path: str | None) -> None:
    found = Columns(dict(table), table.status, tuple(map(str, table.STATUSES)))
    names = heads(tuple(table), model)
    values = dict(zip(names, shown_columns(found, model).values.values(), strict=True))
    columns = replace(found, values=values)
    if path:
        write_table(path, columns)
    else:
        sys.stdout.write((csv_head(names) + csv_rows(columns)).decode("utf-8"))


def _only_limits(table: CurveTable) -> bool:
    limits = {limit.row for branch in table.branches for limit in branch.limits}
    return all(solved or row in limits for row, solved in enumerate(table.solved.tolist()))


def _summary(table: CurveTable, model: Model) -> Iterator[str]:
    """How many rows and branches there are; of each branch its ends and where it turns back."""
    if not table.branches:
        yield f"no value of {table.swept} has an answer to begin at"
        return
    yield f"{plural(len(table.status), 'row')} on {_branches(len(table.branches))}"
    for branch in table.branches:
        yield f"branch {branch.number}: {'; '.join(_told(model.variables[table.swept], branch))}"


def _branches(count: int) -> str:
    return "1 branch" if count == 1 else f"{count} branches"


def _told(swept: Variable, branch: Branch) -> Iterator[str]:
    yield f"rows {branch.first + 1} to {branch.last}"
    if branch.limits:
        limits = (
            f"{shown(limit.value, swept):.12g} ({'greatest' if limit.greatest else 'least'})"
            for limit in branch.limits
        )
        yield f"{swept.name} turns back at {', '.join(limits)}"
    if branch.closed:
        yield "it is closed"
    else:
        yield f"it begins where {branch.start}, and ends where {branch.end}"
