"""What a notebook shows of a model: tables as self-contained HTML, without script."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from html import escape
from math import isfinite
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rulesheets.model import Model, Variable

ROWS = 60
"""Rows of a table that are shown."""

_CELL = "padding:2px 10px;vertical-align:top;text-align:"


def html_table(heads: Sequence[str], rows: Iterable[Sequence[str]], numeric: Collection[int] = ()) -> str:
    """A table of texts; the columns ``numeric`` are aligned to the right."""
    styles = [_CELL + ("right" if at in numeric else "left") for at in range(len(heads))]
    top = "".join(map(_head, heads, styles))
    body = "".join(f"<tr>{''.join(map(_datum, row, styles))}</tr>" for row in rows)
    whole = "border-collapse:collapse;font-variant-numeric:tabular-nums"
    return f'<table style="{whole}"><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>'


def more(count: int, noun: str = "rows") -> str:
    """How many rows are not shown."""
    return f"<p>… {count - ROWS:,} more {noun}</p>" if count > ROWS else ""


def model_html(model: Model) -> str:
    """Name, variables with their values, and the rules with their places."""
    from rulesheets.algebra import listing

    variables = [v for v in model.variables.values() if v.posted]
    rows = [(v.name, _written(v), v.unit or "", v.comment) for v in variables[:ROWS]]
    rules = listing(model).splitlines()
    shown = escape("\n".join(rules[:ROWS]))
    table = html_table(("Name", "Value", "Unit", "Comment"), rows, {1})
    tail = f"<pre>{shown}</pre>{more(len(rules), 'rules')}"
    return f"<div><b>{escape(model.name)}</b>{table}{more(len(variables), 'variables')}{tail}</div>"


def _written(variable: Variable) -> str:
    """The value, or the guess after ``~``, or the range."""
    value = variable.value
    if value is not None:
        return f"'{value}" if isinstance(value, str) else f"{value:.10g}"
    if variable.guess is not None:
        return f"~ {variable.guess:.10g}"
    low, high = variable.low, variable.high
    return f"in [{low:.6g}, {high:.6g}]" if isfinite(low) and isfinite(high) else ""


def _head(text: str, style: str) -> str:
    return f'<th style="{style}">{escape(text)}</th>'


def _datum(text: str, style: str) -> str:
    return f'<td style="{style}">{escape(text)}</td>'
