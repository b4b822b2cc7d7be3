"""A variable sheet as CSV, in the columns that ``backsolve solve`` reads."""

from __future__ import annotations

import csv
from io import StringIO

from rulesheets.cells import guarded
from solver.report.numbers import exact, tolerated
from solver.report.sheet import COLUMNS, SheetRow, output_heads, sheet_rows
from solver.result import Result


def result_csv(result: Result, *, every: bool = False) -> str:
    """The variable sheet as a text; ``every`` gives each answer a column ``Output 1``, ``Output 2``, …

    Numbers read back as the same floats. Read as a variable sheet, the text of the primary answer gives the
    same inputs and guesses again: outputs are not inputs.
    """
    rows = sheet_rows(result, every=every)
    status, given, name, _, unit, comment = COLUMNS
    heads = output_heads(len(rows[0].outputs) if rows else 1)
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow((status, given, name, *heads, unit, comment))
    for row in rows:
        outputs = map(exact, row.outputs)
        texts = map(guarded, (row.status, _given(row), row.name, *outputs, row.unit, row.comment))
        writer.writerow(texts)
    return text.getvalue()


def _given(row: SheetRow) -> str:
    return tolerated(exact(row.input), row.tolerance)
