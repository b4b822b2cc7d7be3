"""A variable sheet as CSV, in the columns that ``backsolve solve`` reads."""

from __future__ import annotations

import csv
from io import StringIO

from solver.report.numbers import exact
from solver.report.sheet import COLUMNS, output_heads, sheet_rows
from solver.result import Result


def result_csv(result: Result, *, every: bool = False) -> str:
    """The variable sheet of a result; numbers read back as the same floats.

    Read as a variable sheet it gives the same inputs and guesses again: outputs are not inputs.
    """
    rows = sheet_rows(result, every=every)
    count = len(rows[0].outputs) if rows else 1
    status, given, name, _, unit, comment = COLUMNS
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow((status, given, name, *output_heads(count), unit, comment))
    for row in rows:
        outputs = (exact(value) for value in row.outputs)
        writer.writerow((row.status, exact(row.input), row.name, *outputs, row.unit, row.comment))
    return text.getvalue()
