"""Tables as CSV: every number reads back as the same float, nothing is a blank cell."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from io import StringIO
from typing import Any

from solver.files.columns import Array, Columns, free_name


def csv_head(names: Sequence[str]) -> bytes:
    """The first line: the names, and ``status``."""
    text = StringIO()
    csv.writer(text, lineterminator="\n").writerow((*names, free_name("status", names)))
    return text.getvalue().encode("utf-8")


def csv_rows(table: Columns) -> bytes:
    """One line a row, the status last. Numbers are written shortest, symbols with their apostrophe."""
    if not len(table):
        return b""
    words = [table.words[code] for code in table.status.tolist()]
    columns = table.values.values()
    if any(column.dtype == object for column in columns):
        cells = [map(_cell, column.tolist()) for column in columns]
        return (_lines(cells, words)).encode("utf-8")
    text = _lines([_numbers(column) for column in columns], words)
    return text.replace(".0,", ",").replace("nan,", ",").encode("ascii")


def _lines(cells: Sequence[Iterable[str]], words: Iterable[str]) -> str:
    return "\n".join(map(",".join, zip(*cells, words, strict=True))) + "\n"


def _numbers(column: Array) -> Iterable[str]:
    """Texts of a column; those of floats still end in ``.0`` where they are whole, and may be ``nan``."""
    if column.dtype.kind == "f":
        return map(repr, (column + 0.0).tolist())
    return map(str, column.tolist())


def _cell(value: Any) -> str:
    if isinstance(value, str):
        return f"'{value}"
    if value is None or value != value:
        return ""
    return repr(float(value) + 0.0).removesuffix(".0")
