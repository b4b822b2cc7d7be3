"""Table files by their endings: what takes the pieces of a table, and what writes one at once."""

from __future__ import annotations

import os
from collections.abc import Collection, Sequence

from rulesheets.diagnosis import RuleSheetError
from solver.files.columns import Columns, csv_head, csv_rows
from solver.files.messages import unknown_form
from solver.files.parquet import ParquetTable
from solver.files.replacing import Replacement

CSV, PARQUET = (".csv", ".txt", ""), (".parquet", ".pq")


class CsvFile:
    """Lines of CSV. Pieces may come as lines, too."""

    def __init__(self, path: str, names: Sequence[str]) -> None:
        self._file = Replacement(path)
        self._file.write(csv_head(names))

    def add(self, table: Columns) -> None:
        self.add_lines(csv_rows(table))

    def add_lines(self, lines: bytes) -> None:
        self._file.write(lines)

    def close(self) -> None:
        self._file.keep()

    def discard(self) -> None:
        self._file.discard()


class ParquetFile:
    """Row groups of Parquet."""

    def __init__(self, path: str, names: Sequence[str], symbols: Collection[str]) -> None:
        self._file = Replacement(path)
        try:
            self._table = ParquetTable(self._file, path, names, symbols)
        except RuleSheetError:
            self._file.discard()
            raise

    def add(self, table: Columns) -> None:
        self._table.add(table)

    def close(self) -> None:
        try:
            self._table.close()
        except BaseException:
            self.discard()
            raise
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
