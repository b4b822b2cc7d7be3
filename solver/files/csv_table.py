"""Tables as CSV: every number reads back as the same float, nothing is a blank cell."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from io import StringIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solver.files.columns import Columns, free_name
from solver.files.decimals import WIDTH, decimals, windows

BLOCK = 4096
"""Rows whose cells fit the cache."""


def csv_head(names: Sequence[str]) -> bytes:
    """The first line: the names, and ``status``."""
    text = StringIO()
    csv.writer(text, lineterminator="\n").writerow((*names, free_name("status", names)))
    return text.getvalue().encode("utf-8")


def csv_rows(table: Columns) -> bytes:
    """One line a row, the status last. Numbers are written shortest, symbols with their apostrophe."""
    if any(column.dtype == object for column in table.values.values()):
        return "".join(_lines(table)).encode("utf-8")
    return b"".join(_block(table.rows(start, start + BLOCK)) for start in range(0, len(table), BLOCK))


def _lines(table: Columns) -> Iterator[str]:
    cells = [map(_cell, column.tolist()) for column in table.values.values()]
    words = [table.words[code] for code in table.status.tolist()]
    for row in zip(*cells, words, strict=True):
        yield ",".join(row) + "\n"


def _cell(value: Any) -> str:
    if isinstance(value, str):
        return f"'{value}"
    if value is None or value != value:
        return ""
    return repr(float(value) + 0.0).removesuffix(".0")


def _block(table: Columns) -> bytes:
    """Rows of numbers alone: each text into a cell of its own, then the cells one behind the other."""
    width = len(table.values) + 1
    cells = np.empty((len(table) * width + 1) * WIDTH, dtype=np.uint8)
    lengths = np.empty((len(table), width), dtype=np.intp)
    starts = np.arange(len(table)) * (width * WIDTH)
    for place, column in enumerate(table.values.values()):
        here = starts + place * WIDTH
        length = decimals(column, cells, here)
        cells[here + length] = ord(",")
        lengths[:, place] = length + 1
    words, sizes = _words(table.words)
    windows(cells, WIDTH)[starts + (width - 1) * WIDTH] = words[table.status]
    lengths[:, -1] = sizes[table.status]
    return _packed(cells, lengths.ravel())


def _words(words: Sequence[str]) -> tuple[NDArray[np.void], NDArray[np.intp]]:
    texts = [f"{word}\n".encode() for word in words]
    return np.array(texts, dtype=f"S{WIDTH}").view(f"V{WIDTH}"), np.array([len(text) for text in texts])


def _packed(cells: NDArray[np.uint8], lengths: NDArray[np.intp]) -> bytes:
    """The texts of the cells one behind the other: each is written over the rest of the cell before it."""
    ends = np.cumsum(lengths)
    packed = np.empty(int(ends[-1]) + WIDTH, dtype=np.uint8)
    windows(packed, WIDTH)[ends - lengths] = windows(cells, WIDTH)[: len(lengths) * WIDTH : WIDTH]
    return packed[: ends[-1]].tobytes()
