"""Results and tables as self-contained HTML, for notebooks: text and one scoped style, no script."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape

import numpy as np
from numpy.typing import NDArray

from solver.report.numbers import readable
from solver.report.sheet import COLUMNS, displayed, output_heads, sheet_rows
from solver.result import Result, Status

ROWS = 60
"""Rows of a table that are shown."""

_STYLE = (
    "border-collapse:collapse;font-variant-numeric:tabular-nums",
    "padding:2px 10px;text-align:left",
    "padding:2px 10px;text-align:right",
)


def result_html(result: Result) -> str:
    """The variable sheet of a result and what there is to say of it."""
    rows = displayed(result, sheet_rows(result))
    status, given, name, _, unit, comment = COLUMNS
    heads = (
        status,
        given,
        name,
        *output_heads(max((len(r.outputs) for r in rows), default=1)),
        unit,
        comment,
    )
    cells = (
        (row.status, readable(row.input), row.name, *map(readable, row.outputs), row.unit, row.comment)
        for row in rows
    )
    numeric = {1, *range(3, len(heads) - 2)}
    said = "" if result.status is Status.SOLVED else f"<p><b>{escape(str(result.status))}</b></p>"
    notes = "".join(f"<pre>{escape(diagnosis.message)}</pre>" for diagnosis in result.diagnoses)
    return f"<div>{_table(heads, cells, numeric)}{said}{notes}</div>"


def table_html(columns: Mapping[str, NDArray[np.generic]], status: Sequence[str]) -> str:
    """The first rows of a table, and how many more there are."""
    heads = (*columns, "status")
    count = len(status)
    shown = [column[:ROWS].tolist() for column in columns.values()]
    cells = ((*map(readable, row), said) for *row, said in zip(*shown, status[:ROWS], strict=True))
    more = f"<p>… {count - ROWS:,} more rows</p>" if count > ROWS else ""
    return f"<div>{_table(heads, cells, set(range(len(heads) - 1)))}{more}</div>"


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]], numeric: set[int]) -> str:
    whole, left, right = _STYLE
    top = "".join(_cell("th", head, right if at in numeric else left) for at, head in enumerate(heads))
    lines = (
        "".join(_cell("td", text, right if at in numeric else left) for at, text in enumerate(row))
        for row in rows
    )
    body = "".join(f"<tr>{line}</tr>" for line in lines)
    return f'<table style="{whole}"><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>'


def _cell(kind: str, text: str, style: str) -> str:
    return f'<{kind} style="{style}">{escape(text)}</{kind}>'
