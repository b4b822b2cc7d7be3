"""Columns by name, with a status for each row: what a table file holds; the same as CSV and as Parquet."""

from __future__ import annotations

import csv
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from inspect import signature
from io import StringIO
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.diagnosis import RuleSheetError
from rulesheets.input_messages import expect_regular, unwritable
from rulesheets.inputs import is_symbol
from solver.files.replacing import Replacement, missing_extra, unreadable_rows

Array: TypeAlias = NDArray[Any]


@dataclass(frozen=True)
class Columns:
    """``values`` (n,) by name: floats with NaN for nothing, integers, or objects (symbols, floats, None).

    ``status`` (n,) are indices into ``words``. ``whole``: every number is known to be there.
    """

    values: Mapping[str, Array]
    status: Array
    words: Sequence[str]
    whole: bool = False

    def __len__(self) -> int:
        return len(self.status)

    def rows(self, first: int, last: int) -> Columns:
        """Rows ``first`` up to, but without, ``last``."""
        kept = {name: column[first:last] for name, column in self.values.items()}
        return Columns(kept, self.status[first:last], self.words, self.whole)


def joined(parts: Sequence[Columns]) -> Columns:
    """The rows of several pieces of one table, one after another."""
    if len(parts) == 1:
        return parts[0]
    values = {name: stacked([part.values[name] for part in parts]) for name in parts[0].values}
    whole = all(part.whole for part in parts)
    return Columns(values, stacked([part.status for part in parts]), parts[0].words, whole)


def stacked(pieces: Sequence[Array]) -> Array:
    """One column of several pieces. NaN beside symbols is None, as it is within a piece."""
    if any(piece.dtype == object for piece in pieces):
        pieces = [piece if piece.dtype == object else objects(piece) for piece in pieces]
    return np.concatenate(pieces)


def objects(column: Array) -> Array:
    """A column of floats as one that may hold symbols, None for NaN."""
    return np.array([None if value != value else value for value in column.tolist()], dtype=object)


def free_name(name: str, taken: Iterable[str]) -> str:
    """``name``, with as many ``_`` after it as keep it apart from the variables of the table."""
    names = set(taken)
    while name in names:
        name += "_"
    return name


def csv_head(names: Sequence[str]) -> bytes:
    """The first line: the names, and ``status``."""
    text = StringIO()
    csv.writer(text, lineterminator="\n").writerow((*names, free_name("status", names)))
    return text.getvalue().encode("utf-8")


def csv_rows(table: Columns) -> bytes:
    """One line a row, the status last. Numbers are written shortest, symbols with their apostrophe.

    By pyarrow where it is installed, which prints a number in a fifth of the time of ``repr``.
    """
    arrow = _arrow_csv()
    if arrow is None:
        return "".join(_lines(table)).encode("utf-8")
    words = arrow.array(table.words).take(arrow.array(table.status))
    columns = [*(_printable(arrow, column) for column in table.values.values()), words]
    lines, bare = (
        arrow.BufferOutputStream(),
        arrow.csv.WriteOptions(include_header=False, quoting_style="none"),
    )
    arrow.csv.write_csv(arrow.table(columns, names=list(map(str, range(len(columns))))), lines, bare)
    text: bytes = lines.getvalue().to_pybytes()
    return text


@cache
def _arrow_csv() -> Any:
    try:
        import pyarrow.csv
    except ImportError:
        return None
    return pyarrow


def _printable(arrow: Any, column: Array) -> Any:
    if column.dtype == object:
        return arrow.array(list(map(_cell, column.tolist())))
    return arrow.array(column + 0, from_pandas=True)


def _lines(table: Columns) -> Iterator[str]:
    cells = [map(_cell, column.tolist()) for column in table.values.values()]
    words = [f"{table.words[code]}\n" for code in table.status.tolist()]
    return map(",".join, zip(*cells, words, strict=True))


def _cell(value: Any) -> str:
    if isinstance(value, str):
        return f"'{value}"
    if value is None or value != value:
        return ""
    return repr(float(value) + 0.0).removesuffix(".0")


ROW_GROUP = 262_144
"""Rows of a row group; the same whatever the pieces in which the rows come."""
BATCH = 65_536
"""Rows that the encoder takes at once."""
BUFFER = 2**20
"""Bytes below which parts (the heads of pages) are handed over together: each holds up the solver."""
SAMPLE = 4096
"""Rows by which it is judged whether a column repeats."""


class ParquetTable:
    """A Parquet file under construction.

    Numbers are doubles, symbols and the status are texts, and where a row has no value there is null.
    ``symbols`` names the columns that hold symbols. Raises RuleSheetError where pyarrow is missing
    (E441) and where the file cannot be written (E416).
    """

    def __init__(self, file: Replacement, path: str, names: Sequence[str], symbols: Collection[str]) -> None:
        self._arrow, self._parquet = _pyarrow("Parquet files need")
        self._file, self._path = file, path
        self._symbols = frozenset(symbols)
        self._names = tuple(names)
        self._waiting: list[Columns] = []
        self._held = 0
        self._writer: Any = None
        self._stream: Any = None

    def add(self, table: Columns) -> None:
        self._waiting.append(table)
        self._held += len(table)
        while self._held >= ROW_GROUP:
            group, rest = _divided(self._waiting, ROW_GROUP)
            self._write(group)
            self._waiting, self._held = rest, self._held - ROW_GROUP

    def close(self) -> None:
        """Write the rows that wait, and the footer: after this the file can be read."""
        if self._held or self._writer is None:
            self._write(self._waiting or [self._empty()])
        self._guarded(self._writer.close)
        self._guarded(self._stream.close)

    def _write(self, pieces: Sequence[Columns]) -> None:
        batch = self._batch(pieces)
        if self._writer is None:
            first = joined(_divided(pieces, SAMPLE)[0])
            self._writer = self._opened(batch.schema, [n for n in self._names if self._repeats(n, first)])
        self._guarded(lambda: self._writer.write_table(batch, row_group_size=ROW_GROUP))

    def _repeats(self, name: str, sample: Columns) -> bool:
        """Whether a column has few values: symbols, the number of an answer, an outer input of a grid."""
        column = sample.values[name]
        return name in self._symbols or len(set(column.tolist())) <= len(column) // 8

    def _opened(self, schema: Any, repeating: list[str]) -> Any:
        """What repeats is written as runs of a dictionary; other doubles would not get smaller.

        A page holds a row group of a column: it goes to the file in one write, and the pieces in which the
        rows came leave no trace in it.
        """
        texts = [*repeating, free_name("status", self._names)]
        pages: dict[str, Any] = {"data_page_size": 16 * ROW_GROUP, "write_batch_size": BATCH}
        if "max_rows_per_page" in signature(self._parquet.ParquetWriter).parameters:
            pages["max_rows_per_page"] = ROW_GROUP
        file = self._arrow.PythonFile(_Sink(self._file), mode="w")
        self._stream = self._arrow.BufferedOutputStream(file, BUFFER)
        return self._parquet.ParquetWriter(
            self._stream, schema, use_dictionary=texts, compression="none", **pages
        )

    def _batch(self, pieces: Sequence[Columns]) -> Any:
        arrays = {name: self._column(name, pieces) for name in pieces[0].values}
        texts = self._arrow.array(list(pieces[0].words), self._arrow.string())
        codes = stacked([piece.status for piece in pieces])
        arrays[free_name("status", self._names)] = self._arrow.DictionaryArray.from_arrays(codes, texts)
        return self._arrow.table(arrays)

    def _column(self, name: str, pieces: Sequence[Columns]) -> Any:
        """Doubles stay where they are; what has a dictionary is brought together for it."""
        columns = [piece.values[name] for piece in pieces]
        if name in self._symbols:
            texts = [_text(value) for column in columns for value in column.tolist()]
            return self._arrow.array(texts, self._arrow.string()).dictionary_encode()
        if columns[0].dtype.kind == "i":
            return self._arrow.array(stacked(columns), self._arrow.int32())
        whole = [piece.whole for piece in pieces]
        return self._arrow.chunked_array(list(map(self._doubles, columns, whole)))

    def _doubles(self, column: Array, whole: bool) -> Any:
        """Without gaps the column need not be copied."""
        gaps = not whole and bool(np.isnan(column).any())
        return self._arrow.array(column, self._arrow.float64(), from_pandas=gaps)

    def _empty(self) -> Columns:
        none = np.zeros(0)
        return Columns(dict.fromkeys(self._names, none), np.zeros(0, dtype=np.int8), ("solved",))

    def _guarded(self, write: Callable[[], object]) -> None:
        try:
            write()
        except OSError as failure:
            raise RuleSheetError(unwritable(self._path, failure)) from None


def _divided(pieces: Sequence[Columns], rows: int) -> tuple[list[Columns], list[Columns]]:
    """The first ``rows`` of some pieces, and what comes after them."""
    first, after = list[Columns](), list[Columns]()
    for piece in pieces:
        if rows > 0:
            first.append(piece.rows(0, rows))
        if len(piece) > rows:
            after.append(piece.rows(max(rows, 0), len(piece)))
        rows -= len(piece)
    return first, after


class _Sink:
    """The part of a file that pyarrow asks for."""

    closed = False

    def __init__(self, file: Replacement) -> None:
        self._file = file
        self._position = 0

    def write(self, data: Any) -> int:
        self._file.write(data)
        self._position += len(data)
        return len(data)

    def tell(self) -> int:
        return self._position

    def flush(self) -> None:
        """Nobody reads the file before it is whole."""

    def writable(self) -> bool:
        return True

    def readable(self) -> bool:
        return False

    def seekable(self) -> bool:
        return False

    def close(self) -> None:
        """The replacement itself is kept or discarded by whom it belongs to."""


def parquet_columns(path: str) -> tuple[tuple[str, ...], int]:
    """The names of the columns of a Parquet file, and the number of its rows.

    Raises RuleSheetError (E440, E441).
    """
    file = _opened(path)
    return tuple(file.schema_arrow.names), file.metadata.num_rows


def parquet_pieces(path: str, names: Sequence[str]) -> Iterator[Mapping[str, Any]]:
    """The rows of some columns of a Parquet file, a piece at a time: arrays of numbers, or lists.

    Raises RuleSheetError (E440, E441).
    """
    file = _opened(path)
    try:
        for batch in file.iter_batches(columns=list(names)):
            yield {name: _cells(batch.column(name)) for name in names}
    except (OSError, ValueError) as failure:
        raise RuleSheetError(unreadable_rows(path, str(failure))) from None


def _cells(column: Any) -> Any:
    """Floats as an array, NaN for null; anything else as a list."""
    if str(column.type) in ("double", "float"):
        return column.to_numpy(zero_copy_only=False).astype(float)
    return column.to_pylist()


def _opened(path: str) -> Any:
    _, parquet = _pyarrow("Parquet files need")
    expect_regular(path)
    try:
        return parquet.ParquetFile(path)
    except (OSError, ValueError) as failure:
        reason = getattr(failure, "strerror", None) or str(failure)
        raise RuleSheetError(unreadable_rows(path, reason)) from None


def _pyarrow(purpose: str) -> tuple[Any, Any]:
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise RuleSheetError(missing_extra(purpose, "pyarrow", "parquet")) from None
    return pyarrow, pyarrow.parquet


def _text(value: Any) -> str | None:
    if isinstance(value, str):
        return value
    return None if value is None or value != value else repr(float(value)).removesuffix(".0")


_NUMBERS = "biuf"


def column_of(values: Any, name: str) -> Array:
    """Floats (n,), or objects where symbols are among them; a single value is a column of one.

    What is lacking is NaN, among symbols None.

    Raises ValueError for what is neither number nor symbol, and for what has more than one dimension.
    """
    column = _array(list(values) if isinstance(values, Iterator) else values, name)
    if column.ndim > 1:
        shape = "x".join(map(str, column.shape))
        raise ValueError(f"a column of a sweep has one dimension, and that of {name} is {shape}")
    column = np.atleast_1d(column)
    if column.dtype.kind in _NUMBERS:
        return column.astype(float, copy=False)
    plain = [_plain(value, name) for value in column.tolist()]
    if any(isinstance(value, str) for value in plain):
        return np.array(plain, dtype=object)
    return np.array([np.nan if value is None else value for value in plain], dtype=float)


def _array(values: Any, name: str) -> Array:
    """What the values are, numbers among symbols included (numpy would make texts of them)."""
    try:
        column = np.asarray(values)
        return column if column.dtype.kind in _NUMBERS else np.asarray(values, dtype=object)
    except ValueError:
        raise ValueError(f"the values of {name} are no column: there are lists among them") from None


def _plain(value: Any, name: str) -> float | str | None:
    if value is None:
        return None
    if isinstance(value, str):
        if not is_symbol(value):
            raise ValueError(
                f"{value!r} is no value for {name}: a text is read as a symbol, and this is none"
            )
        return value.removeprefix("'")
    try:
        return float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{value!r} is no value for {name}: neither a number nor a symbol") from None
