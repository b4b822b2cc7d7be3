"""Tables in files: rows of inputs read from CSV or Parquet a piece at a time, and columns written."""

from __future__ import annotations

import csv
import os
from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import islice
from typing import Any

import numpy as np

from rulesheets.diagnosis import RuleSheetError
from rulesheets.input_messages import expect_regular
from rulesheets.inputs import decimal_point, delimiter, parse_value
from solver.files.columns import (
    Array,
    Columns,
    ParquetFile,
    csv_head,
    csv_rows,
    parquet_columns,
    parquet_pieces,
)
from solver.files.replacing import Replacement, uneven_row, unknown_form, unreadable_rows, wrong_cell

PIECE = 8192
"""Rows of a CSV file that are read at once."""


def is_parquet(path: str) -> bool:
    return path.lower().endswith((".parquet", ".pq"))


def heading(path: str) -> tuple[tuple[str, ...], int | None]:
    """The names of the columns, and the number of rows where the file tells it.

    Raises RuleSheetError (E440) for a file that is missing, unreadable, or has no heading.
    """
    if is_parquet(path):
        return parquet_columns(path)
    for _, cells in _lines(path):
        return tuple(cell.strip() for cell in cells), None
    raise RuleSheetError(unreadable_rows(path, "it is empty"))


def pieces(
    path: str, names: Sequence[str], numbers: Collection[str] = frozenset()
) -> Iterator[tuple[Array, ...]]:
    """Some columns of the file in the order of ``names``: floats, NaN for nothing; or objects with symbols.

    Raises RuleSheetError (E440) at the first cell that is neither a number nor a symbol, or is a symbol in a
    column of ``numbers``.
    """
    if is_parquet(path):
        found: Iterable[tuple[Sequence[int] | None, Sequence[Any]]] = (
            (None, [batch[name] for name in names]) for batch in parquet_pieces(path, names)
        )
    else:
        found = _csv_pieces(path, names)
    for lines, columns in found:
        cells = zip(names, columns, strict=True)
        yield tuple(_column(column, path, name, lines, name in numbers) for name, column in cells)


def _csv_pieces(path: str, names: Sequence[str]) -> Iterator[tuple[Sequence[int], Sequence[Any]]]:
    """The lines of some rows, and their cells by columns."""
    lines = _lines(path)
    head = [cell.strip() for cell in next(lines)[1]]
    places = [head.index(name) for name in names]
    while piece := list(islice(lines, PIECE)):
        for number, cells in piece:
            if len(cells) != len(head):
                raise RuleSheetError(uneven_row(path, number, len(cells), len(head)))
        yield [number for number, _ in piece], [[cells[place] for _, cells in piece] for place in places]


def _lines(path: str) -> Iterator[tuple[int, list[str]]]:
    """The lines that are not blank, with their numbers."""
    expect_regular(path)
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            first = file.readline()
            file.seek(0)
            separator = delimiter(first)
            reader = csv.reader(file, delimiter=separator, strict=True)
            for cells in reader:
                if cells:
                    yield reader.line_num, cells if separator == "," else list(map(decimal_point, cells))
    except (OSError, ValueError, csv.Error) as failure:
        reason = getattr(failure, "strerror", None) or str(failure)
        raise RuleSheetError(unreadable_rows(path, reason)) from None


def _column(cells: Sequence[Any], path: str, name: str, lines: Sequence[int] | None, number: bool) -> Array:
    if isinstance(cells, np.ndarray):
        return cells
    try:
        return np.array([float(cell) if cell not in ("", None) else np.nan for cell in cells])
    except (TypeError, ValueError):
        values = [_value(cell, path, name, lines[row] if lines else row) for row, cell in enumerate(cells)]
        symbols = [row for row, value in enumerate(values) if isinstance(value, str)]
        if symbols and number:
            row = symbols[0]
            line = lines[row] if lines else row
            raise RuleSheetError(wrong_cell(path, line, str(cells[row]), name, number=True)) from None
        if not symbols:
            return np.array([np.nan if value is None else value for value in values])
        return np.array(values, dtype=object)


def _value(cell: Any, path: str, name: str, line: int) -> float | str | None:
    """A cell as text or as Parquet has it. Spreadsheets write what has no value in many ways."""
    if cell is None or (isinstance(cell, str) and cell.strip().lower() in ("", "nan", "na", "null", "none")):
        return None
    if isinstance(cell, str):
        try:
            return parse_value(cell)
        except RuleSheetError:
            raise RuleSheetError(wrong_cell(path, line, cell, name)) from None
    try:
        return float(cell)
    except (TypeError, ValueError):
        raise RuleSheetError(wrong_cell(path, line, str(cell), name)) from None


CSV, PARQUET = (".csv", ".txt", ""), (".parquet", ".pq")


class CsvFile:
    """Lines of CSV."""

    def __init__(self, path: str, names: Sequence[str]) -> None:
        self._file = Replacement(path)
        self._file.write(csv_head(names))

    def add(self, table: Columns) -> None:
        self._file.write(csv_rows(table))

    def close(self) -> None:
        self._file.keep()

    def discard(self) -> None:
        self._file.discard()


def is_csv(path: str) -> bool:
    """Whether a file is CSV; else it is Parquet. Raises RuleSheetError (E442) for other endings."""
    ending = os.path.splitext(path)[1].lower()
    if ending not in CSV + PARQUET:
        raise RuleSheetError(unknown_form(path, ".csv or .parquet"))
    return ending in CSV


def table_file(path: str, names: Sequence[str], symbols: Collection[str]) -> CsvFile | ParquetFile:
    """A file by its ending; ``symbols`` names the columns that hold symbols.

    Raises RuleSheetError: E442 for other endings, E416, E441.
    """
    return CsvFile(path, names) if is_csv(path) else ParquetFile(path, names, symbols)


def write_table(path: str, table: Columns) -> None:
    """Write a whole table. Raises RuleSheetError: E416, E441, E442."""
    symbols = [name for name, column in table.values.items() if column.dtype == object]
    file = table_file(path, tuple(table.values), symbols)
    try:
        file.add(table)
    except BaseException:
        file.discard()
        raise
    file.close()
