"""A sweep that goes on where it was cut off: the rows of its file, then those that are left."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from rulesheets.diagnosis import RuleSheetError
from solver.files.columns import Array, Columns, free_name, stacked
from solver.files.replacing import other_sweep
from solver.files.tables import heading, pieces
from solver.result import Status
from solver.sweeps.chunks import Chunk
from solver.sweeps.work import Solved

_WORDS = tuple(map(str, Status))
_CODES = {word: code for code, word in enumerate(_WORDS)}


@dataclass(frozen=True)
class Earlier:
    """The rows of a file that an earlier run of the sweep has left."""

    path: str
    names: tuple[str, ...]
    table: Columns

    def __len__(self) -> int:
        return len(self.table)

    def solved(self) -> Solved:
        counts = np.bincount(self.table.status, minlength=len(_WORDS))
        return Solved(tuple(counts.tolist()), self.table)

    def after(self, chunks: Iterator[Chunk], inputs: Sequence[str]) -> Iterator[Chunk]:
        """The rows that are left. Raises RuleSheetError (E448) if the earlier ones are others."""
        done = 0
        for chunk in chunks:
            count = min(len(chunk[0]), len(self) - done)
            for name, column in zip(inputs, chunk, strict=True):
                before = self.table.values[name][done : done + count]
                if count and not _alike(before, column[:count]):
                    raise RuleSheetError(other_sweep(self.path, "its rows have other inputs"))
            done += count
            if count < len(chunk[0]):
                yield tuple(column[count:] for column in chunk)
        if done < len(self):
            raise RuleSheetError(other_sweep(self.path, "it has more rows"))


def earlier(path: str, names: tuple[str, ...]) -> Earlier:
    """The rows of a table file with the columns ``names`` and a status.

    Rows at its end that failed are left out: they are solved again, with more time perhaps. Raises
    RuleSheetError: E448 for a file with other columns, E440, E441.
    """
    status = free_name("status", names)
    if heading(path)[0] != (*names, status):
        raise RuleSheetError(other_sweep(path, "its columns are others"))
    read = list(pieces(path, (*names, status)))
    columns = [stacked(column) for column in zip(*read, strict=True)] or [np.zeros(0)] * (len(names) + 1)
    words = columns.pop().tolist()
    if not _CODES.keys() >= set(words):
        raise RuleSheetError(other_sweep(path, "it has rows without a status"))
    codes = np.array([_CODES[word] for word in words], dtype=np.int8)
    done = np.flatnonzero(codes != _CODES[str(Status.FAILED)])
    rows = int(done[-1]) + 1 if len(done) else 0
    values = dict(zip(names, columns, strict=True))
    values[names[-1]] = values[names[-1]].astype(np.int64)  # the numbers of answers
    return Earlier(path, names, Columns(values, codes, _WORDS).rows(0, rows))


def _alike(one: Array, other: Array) -> bool:
    if one.dtype == object or other.dtype == object:
        return list(map(_told, one.tolist())) == list(map(_told, other.tolist()))
    return bool(np.array_equal(one, other, equal_nan=True))


def _told(value: object) -> object:
    return None if value != value else value
