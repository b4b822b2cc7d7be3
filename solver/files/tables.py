"""Tables with a status for each row, and the files that hold them: CSV and Parquet, in pieces."""

from __future__ import annotations

import csv
import os
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence, Sized
from importlib import import_module
from itertools import islice
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rulesheets.diagnosis import RuleSheetError, refusal
from rulesheets.files import writing
from rulesheets.inputs import decimal_point, delimiter, exact, parse_value, readable, symbol_name
from rulesheets.model import Value
from solver.facts import Status, UnknownName
from solver.files import (
    Printed,
    Replacement,
    csv_text,
    expect_no_input,
    readable_rows,
    require_extra,
    wrong_cell,
)
from solver.path import Shown

Array: TypeAlias = NDArray[Any]


Chunk: TypeAlias = tuple[Array, ...]
"""The inputs of some rows, a column each."""


Column: TypeAlias = ArrayLike

WORDS = tuple(map(str, Status))
CODES = {status: code for code, status in enumerate(Status)}


class Table(dict[str, NDArray[Any]], Shown):
    """Columns (n,) by name: the inputs that were swept, then the wanted variables.

    A wanted value is NaN if its row is not solved (None in a column of symbols). ``status`` (n,)
    holds codes, 0 for solved; ``Table.STATUSES[code]`` is the status. ``answers`` (n,) is the
    number of known answers of each row.
    """

    STATUSES = tuple(Status)

    def __init__(
        self,
        columns: Mapping[str, NDArray[Any]],
        status: NDArray[np.int8],
        files: tuple[str, ...] = (),
        answers: NDArray[np.int64] | None = None,
    ) -> None:
        super().__init__(columns)
        self.status = status
        self._files = files
        self.answers = self.solved.astype(np.int64) if answers is None else answers

    def __missing__(self, name: str) -> NDArray[Any]:
        raise UnknownName(name, self)

    def to_pandas(self) -> Any:
        """Columns and status as a ``pandas.DataFrame``. Raises ImportError without pandas."""
        return import_module("pandas").DataFrame(self._frame())

    def to_polars(self) -> Any:
        """Columns and status as a ``polars.DataFrame``. Raises ImportError without polars."""
        return import_module("polars").DataFrame(self._frame())

    def _frame(self) -> dict[str, Any]:
        return {**self, free_name("status", self): self.words()}

    def words(self) -> list[str]:
        """The status of each row, as a word."""
        return [WORDS[code] for code in self.status]

    def lines(self, tell: Callable[[Value | None], str] = readable) -> Iterator[tuple[str, ...]]:
        """The cells of each row, blank without a value, and its status."""
        columns = ([None if v != v else v for v in column.tolist()] for column in self.values())
        return zip(*(map(tell, column) for column in columns), self.words(), strict=True)

    def __repr__(self) -> str:
        names = ", ".join(self)
        kind, rows = type(self).__name__, len(self.status)
        return f"<{kind} of {rows} rows, {self.solved.sum()} solved: {names}>"

    @property
    def solved(self) -> NDArray[np.bool_]:
        return np.asarray(self.status == CODES[Status.SOLVED])

    def begins(self) -> NDArray[np.bool_]:
        """Which rows begin the answers of a row of inputs, if each answer has a row.

        The numbers of answers do not show it: a branch keeps its number after earlier ones have
        ended.
        """
        places, each = np.arange(len(self.status)), np.maximum(self.answers, 1)
        start = np.maximum.accumulate(np.where(np.diff(each, prepend=0) != 0, places, 0))
        return np.asarray((places - start) % each == 0)

    def write(self, path: str) -> None:
        """Write a file by its ending, ``.csv`` or ``.parquet`` (with the extra ``parquet``).

        It is written completely or not at all. Numbers read back as the same floats, the status is
        a text, and missing values are blank or null. Raises RuleSheetError: E416, E441, E442, and
        E418 for a file that the model was read from.
        """
        expect_no_input(path, self._files)
        symbols = [name for name, column in self.items() if column.dtype == object]
        file = table_file(path, tuple(self), symbols)
        try:
            file.add(self)
            file.close()
        finally:
            file.discard()

    def having(self, columns: Mapping[str, NDArray[Any]]) -> Table:
        """The same rows with these columns."""
        return Table(columns, self.status, self._files, self.answers)

    def rows(self, first: int, last: int) -> Table:
        """Rows from ``first`` up to ``last``, exclusive."""
        kept = {name: column[first:last] for name, column in self.items()}
        return Table(kept, self.status[first:last], self._files, self.answers[first:last])


def joined(parts: Sequence[Table]) -> Table:
    """The rows of several pieces of one table, in order."""
    first, *others = parts
    if not others:
        return first
    columns = {name: stacked([part[name] for part in parts]) for name in first}
    status, answers = ([part.status for part in parts], [part.answers for part in parts])
    return Table(columns, np.concatenate(status), answers=np.concatenate(answers))


def stacked(pieces: Sequence[Array]) -> Array:
    """One column of several pieces. NaN next to symbols is None, as within a piece."""
    if any(piece.dtype == object for piece in pieces):
        lists = ([None if v != v else v for v in piece.tolist()] for piece in pieces)
        pieces = [np.array(values, dtype=object) for values in lists]
    return np.concatenate(pieces)


def free_name(name: str, taken: Iterable[str]) -> str:
    """``name``, with as many ``_`` as distinguish it from the variables of the table."""
    names = set(taken)
    while name in names:
        name += "_"
    return name


def csv_head(names: Sequence[str]) -> bytes:
    """The first line: the names, and ``status``."""
    return csv_text([(*names, free_name("status", names))]).encode("utf-8")


def csv_rows(table: Table) -> bytes:
    """A line for each row, the status last; numbers are shortest, symbols with apostrophes.

    By pyarrow if it is installed, which is five times as fast as ``repr``.
    """
    try:
        arrow = import_module("pyarrow")
        writer = import_module("pyarrow.csv")
    except ImportError:
        return "".join(f"{','.join(cells)}\n" for cells in table.lines(exact)).encode("utf-8")
    columns = []
    for column in table.values():
        told = list(map(exact, column.tolist())) if column.dtype == object else column + 0
        columns.append(arrow.array(told, from_pandas=column.dtype != object))
    columns.append(arrow.array(WORDS).take(arrow.array(table.status)))
    lines = arrow.BufferOutputStream()
    bare = writer.WriteOptions(include_header=False, quoting_style="none")
    writer.write_csv(arrow.table(columns, names=list(map(str, range(len(columns))))), lines, bare)
    return bytes(lines.getvalue())


ROW_GROUP = 262_144
"""Rows of a row group; the same whatever the pieces in which the rows come."""


class ParquetFile:
    """Row groups of Parquet, each written when it is full.

    Numbers are doubles, symbols and the status are texts, and missing values are null. ``symbols``
    names the columns that hold symbols. Raises RuleSheetError if pyarrow is missing (E441) or the
    file cannot be written (E416).
    """

    def __init__(self, path: str, names: Sequence[str], symbols: Collection[str]) -> None:
        self._arrow, self._parquet = _pyarrow()
        self._path, self._names, self._symbols = path, tuple(names), frozenset(symbols)
        self._file, self._held = Replacement(path), list[Table]()
        self._writer: Any = None
        self.discard = self._file.discard

    def add(self, table: Table) -> None:
        self._held.append(table)
        while (rows := sum(len(held.status) for held in self._held)) >= ROW_GROUP:
            whole = joined(self._held)
            self._write(whole.rows(0, ROW_GROUP))
            self._held = [whole.rows(ROW_GROUP, rows)]

    def close(self) -> None:
        """Write the waiting rows and the footer: after this the file can be read."""
        nothing = Table(dict.fromkeys(self._names, np.empty(0)), np.empty(0, np.int8))
        self._write(joined(self._held or [nothing]))
        with writing(self._path):
            self._writer.close()
        self._file.keep()

    def _write(self, table: Table) -> None:
        status = self._arrow.array(WORDS).take(self._arrow.array(table.status))
        columns = [self._array(*pair) for pair in zip(self._names, table.values(), strict=True)]
        names = [*self._names, free_name("status", self._names)]
        rows = self._arrow.table([*columns, status], names=names)
        if self._writer is None:
            texts = [field.name for field in rows.schema if field.type != self._arrow.float64()]
            how = {"use_dictionary": texts, "compression": "none"}
            self._writer = self._parquet.ParquetWriter(self._file.stream, rows.schema, **how)
        if len(table.status):
            with writing(self._path):
                self._writer.write_table(rows, row_group_size=ROW_GROUP)

    def _array(self, name: str, column: Array) -> Any:
        if name in self._symbols:
            texts = [exact(value).removeprefix("'") or None for value in column.tolist()]
            return self._arrow.array(texts, self._arrow.string())
        column = column.astype(np.int32 if column.dtype.kind == "i" else float, copy=False)
        return self._arrow.array(column, from_pandas=True)


def parquet_pieces(
    path: str, names: Sequence[str]
) -> Iterator[tuple[Sequence[int], Sequence[Any]]]:
    """The rows of some columns of a Parquet file, a piece at a time: arrays of numbers, or lists.

    Raises RuleSheetError (E440, E441).
    """
    with readable_rows(path):
        for batch in _pyarrow()[1].ParquetFile(path).iter_batches(columns=list(names)):
            columns = []
            for column in map(batch.column, names):
                if str(column.type) in ("double", "float"):
                    # NaN for null
                    columns.append(column.to_numpy(zero_copy_only=False).astype(float))
                else:
                    columns.append(column.to_pylist())
            yield range(batch.num_rows), columns


def _pyarrow() -> tuple[Any, Any]:
    require_extra("parquet", "Parquet files need", "pyarrow")
    import pyarrow
    import pyarrow.parquet

    return pyarrow, pyarrow.parquet


_NUMBERS = "biuf"


def column_of(values: Any, name: str = "the input") -> Array:
    """Floats (n,), or objects if symbols are among them; a single value is a column of one.

    A missing value is NaN, or None among symbols. Raises ValueError for anything that is neither a
    number nor a symbol, and for more than one dimension.
    """
    values = list(values) if isinstance(values, Iterator) else values
    try:
        column = np.asarray(values)
        if column.dtype.kind not in _NUMBERS:  # numpy would make texts of numbers among symbols
            column = np.asarray(values, dtype=object)
    except ValueError:
        why = "there are lists among them"
        raise ValueError(f"the values of {name} are no column: {why}") from None
    if column.ndim > 1:
        shape = "x".join(map(str, column.shape))
        raise ValueError(f"a column of a sweep has one dimension, and that of {name} is {shape}")
    column = np.atleast_1d(column)
    if column.dtype.kind in _NUMBERS:
        return column.astype(float, copy=False)
    return _gathered([_plain(value, name) for value in column.tolist()])


def _gathered(values: Sequence[float | str | None]) -> Array:
    """A column of objects if there are symbols, else of floats with NaN for None."""
    if any(isinstance(value, str) for value in values):
        return np.array(values, dtype=object)
    return np.array([np.nan if value is None else value for value in values], dtype=float)


def _plain(value: Any, name: str) -> float | str | None:
    if value is None:
        return None
    if isinstance(value, str):
        symbol = symbol_name(value)
        if symbol is None:
            why = "a text is read as a symbol, and this is not one"
            raise ValueError(f"{value!r} is not a valid value for {name}: {why}")
        return symbol
    try:
        return float(value)
    except (TypeError, ValueError):
        why = "neither a number nor a symbol"
        raise ValueError(f"{value!r} is not a valid value for {name}: {why}") from None


def one_length(names: Sequence[str], axes: Sequence[Sized]) -> None:
    """Raises ValueError for columns of different lengths."""
    if len(set(map(len, axes))) > 1:
        each = ", ".join(f"{name}: {len(axis)}" for name, axis in zip(names, axes, strict=True))
        raise ValueError(f"the columns of a sweep must have one length ({each}); or use grid=True")


PIECE = 8192
"""Rows of a CSV file that are read at once."""

CSV, PARQUET = (".csv", ".txt", ""), (".parquet", ".pq")


def heading(path: str) -> tuple[tuple[str, ...], int | None]:
    """The names of the columns, and the number of rows if the file states it.

    Raises RuleSheetError (E440, E441) for a file that is missing, unreadable, or has no heading.
    """
    with readable_rows(path):
        if path.lower().endswith(PARQUET):
            file = _pyarrow()[1].ParquetFile(path)
            return tuple(file.schema_arrow.names), file.metadata.num_rows
        for _, cells in _lines(path):
            return tuple(cell.strip() for cell in cells), None
        raise ValueError("it is empty")


def pieces(
    path: str, names: Sequence[str], numbers: Collection[str] = frozenset()
) -> Iterator[tuple[Array, ...]]:
    """The columns ``names`` of the file: floats, NaN for blank; or objects with symbols.

    Raises RuleSheetError (E440) at the first cell that is neither a number nor a symbol, or is a
    symbol in a column of ``numbers``.
    """
    found = parquet_pieces if path.lower().endswith(PARQUET) else _csv_pieces
    for lines, columns in found(path, names):
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
                counts = f"{len(cells)} cells, and the heading {len(head)}"
                message = f"line {number} of {path} has {counts}"
                notes = ("a row has a cell for each name of the heading; a cell may be blank",)
                raise refusal("E440", message, None, *notes)
        columns = [[cells[place] for _, cells in piece] for place in places]
        yield [number for number, _ in piece], columns


def _lines(path: str) -> Iterator[tuple[int, list[str]]]:
    """The lines that are not blank, with their numbers."""
    with readable_rows(path), open(path, encoding="utf-8-sig", newline="") as file:
        separator = delimiter(file.readline())
        file.seek(0)
        reader = csv.reader(file, delimiter=separator, strict=True)
        for cells in filter(None, reader):
            told = cells if separator == "," else list(map(decimal_point, cells))
            yield reader.line_num, told


def _column(
    cells: Sequence[Any], path: str, name: str, lines: Sequence[int], number: bool
) -> Array:
    """The cells of some ``lines``, as text or as Parquet has them."""
    if isinstance(cells, np.ndarray):
        return cells
    try:
        return np.array([float(cell) if cell not in ("", None) else np.nan for cell in cells])
    except (TypeError, ValueError):
        values: list[float | str | None] = []
        for line, cell in zip(lines, cells, strict=True):
            try:
                value = _value(cell)
            except (TypeError, ValueError, RuleSheetError):
                raise RuleSheetError(wrong_cell(path, line, str(cell), name)) from None
            if number and isinstance(value, str):
                raise RuleSheetError(wrong_cell(path, line, str(cell), name, number=True)) from None
            values.append(value)
        return _gathered(values)


def _value(cell: Any) -> float | str | None:
    """The value of a cell; spreadsheets write missing values in many ways."""
    if isinstance(cell, str):
        missing = cell.strip().lower() in ("", "nan", "na", "null", "none")
        return None if missing else parse_value(cell)
    return None if cell is None else float(cell)


class CsvFile:
    """Lines of CSV in a file or a stream. The heading comes with the first rows, or at the end."""

    def __init__(self, file: Replacement | Printed, names: Sequence[str]) -> None:
        self._file, self._head = file, csv_head(names)
        self.discard = file.discard

    def add(self, table: Table) -> None:
        self._file.write(self._head + csv_rows(table))
        self._head = b""

    def close(self) -> None:
        self._file.write(self._head)
        self._file.keep()


def table_file(path: str, names: Sequence[str], symbols: Collection[str]) -> CsvFile | ParquetFile:
    """A file by its ending; ``symbols`` names the columns that hold symbols.

    Raises RuleSheetError: E442 for other endings, E416, E441.
    """
    ending = os.path.splitext(path)[1].lower()
    if ending not in CSV + PARQUET:
        message, notes = f"{path} has an ending that is not one of a table", ".csv or .parquet"
        raise refusal("E442", message, None, f"choose a name that ends in {notes}")
    return CsvFile(Replacement(path), names) if ending in CSV else ParquetFile(path, names, symbols)


# --- samples within tolerances ---

SPREADS = {"uniform": 3**-0.5, "normal": 1 / 3}
"""The standard deviation of an input in units of its tolerance.

``uniform``: anywhere within the tolerance alike. ``normal``: the tolerance is three standard
deviations.
"""


class Samples(NamedTuple):
    """``table`` has the inputs and outputs of each sample, NaN where it is not solved."""

    table: Table
    tolerances: Mapping[str, float]
    outputs: tuple[str, ...]
    distribution: str
    seed: int

    @property
    def spread(self) -> float:
        """The standard deviation of an input, in units of its tolerance."""
        return SPREADS[self.distribution]

    def solved(self, name: str) -> NDArray[np.float64]:
        """The values of an output, of the samples that are solved."""
        column: NDArray[np.float64] = np.asarray(self.table[name], dtype=np.float64)
        return np.compress(np.isfinite(column), column)

    def statistics(self, name: str) -> tuple[float, float, float, float] | None:
        """Mean, standard deviation, least and greatest output; None for fewer than two samples."""
        column = self.solved(name)
        if len(column) < 2:
            return None
        least, greatest = float(column.min()), float(column.max())
        return float(column.mean()), float(column.std(ddof=1)), least, greatest

    @property
    def counts(self) -> dict[Status, int]:
        """The number of samples of each status."""
        codes, numbers = np.unique(self.table.status, return_counts=True)
        return {self.table.STATUSES[code]: int(n) for code, n in zip(codes, numbers, strict=True)}
