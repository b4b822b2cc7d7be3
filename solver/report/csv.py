"""A variable sheet as CSV, in the columns that ``backsolve solve`` reads."""

from __future__ import annotations

import csv
from io import StringIO
from math import isnan
from typing import TYPE_CHECKING

from rulesheets.model import Value
from rulesheets.variables import Row
from solver.report.numbers import exact
from solver.report.sheet import COLUMNS, output_heads, sheet_rows
from solver.result import Result

if TYPE_CHECKING:
    from solver.table import Table


def csv_rows(result: Result) -> tuple[Row, ...]:
    """The variable sheet with the primary answer; numbers read back as the same floats.

    Read as a variable sheet it gives the same inputs and guesses again: outputs are not inputs.
    """
    return tuple(
        Row(row.status, exact(row.input), row.name, exact(row.outputs[0]), row.unit, row.comment)
        for row in sheet_rows(result)
    )


def result_csv(result: Result, *, every: bool = False) -> str:
    """The variable sheet as a text; ``every`` gives each answer a column ``Output 1``, ``Output 2``, …"""
    rows = sheet_rows(result, every=every)
    status, given, name, _, unit, comment = COLUMNS
    heads = output_heads(len(rows[0].outputs) if rows else 1)
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow((status, given, name, *heads, unit, comment))
    for row in rows:
        outputs = map(exact, row.outputs)
        writer.writerow((row.status, exact(row.input), row.name, *outputs, row.unit, row.comment))
    return text.getvalue()


def table_csv(table: Table) -> str:
    """The columns of a sweep and the status of every row; blank where a row has no value."""
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow((*table, "status"))
    columns = [table[name].tolist() for name in table]
    statuses = [str(table.STATUSES[code]) for code in table.status.tolist()]
    for *values, status in zip(*columns, statuses, strict=True):
        writer.writerow((*(_cell(value) for value in values), status))
    return text.getvalue()


def _cell(value: Value | None) -> str:
    return "" if isinstance(value, float) and isnan(value) else exact(value)
