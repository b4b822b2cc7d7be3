"""Columns by name, with a status for each row: what a table file holds; and the same as CSV."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from io import StringIO
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

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
    """One line a row, the status last. Numbers are written shortest, symbols with their apostrophe."""
    return "".join(_lines(table)).encode("utf-8")


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
