"""Sweeps as a stream: pieces of rows handed on to files and pictures in order, in bounded memory."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol, TextIO

import numpy as np

from rulesheets.diagnosis import RuleSheetError, error
from rulesheets.model import Model
from rulesheets.units.quantity import displays
from solver.facts import Status
from solver.files.replacing import other_sweep
from solver.files.tables import (
    Array,
    Columns,
    csv_head,
    csv_rows,
    free_name,
    heading,
    pieces,
    stacked,
    table_file,
)
from solver.interruption import Interrupted, Interrupts
from solver.sweeps.grid import Chunk
from solver.sweeps.work import Solved


class Sink(Protocol):
    """Takes the pieces in order; then it is closed, whole, or discarded."""

    def add(self, piece: Solved) -> None: ...
    def close(self) -> None: ...
    def discard(self) -> None: ...


class FileSink:
    """A table file by its ending."""

    def __init__(self, path: str, names: Sequence[str], symbols: Collection[str]) -> None:
        self._file = table_file(path, names, symbols)
        self.close, self.discard = self._file.close, self._file.discard

    def add(self, piece: Solved) -> None:
        self._file.add(piece.table)


class StreamSink:
    """Lines of CSV to an open stream, as they come."""

    def __init__(self, stream: TextIO, names: Sequence[str]) -> None:
        self._stream = stream
        self._head = csv_head(names).decode()

    def add(self, piece: Solved) -> None:
        self._begin()
        self._stream.write(csv_rows(piece.table).decode())

    def close(self) -> None:
        self._begin()
        self._stream.flush()

    def _begin(self) -> None:
        """The heading comes with the first rows: a sweep that never starts prints nothing."""
        self._stream.write(self._head)
        self._head = ""

    def discard(self) -> None:
        """What is printed is printed."""


def heads(names: Iterable[str], model: Model) -> tuple[str, ...]:
    """The headings of a table: ``v``, and ``v [km/h]`` for what is not in the unit of the rules."""
    found = displays(model, names)
    return tuple(
        f"{name} [{model.variables[name].display_unit}]" if name in found else name for name in names
    )


def shown_columns(table: Columns, model: Model) -> Columns:
    """The columns in display units, by their names."""
    values = dict(table.values)
    for name, (factor, shift) in displays(model, values).items():
        values[name] = values[name].astype(float) * factor + shift
    return replace(table, values=values)


class ShownSink:
    """Hands the pieces on to another sink in display units."""

    def __init__(self, sink: Sink, model: Model) -> None:
        self._sink, self._model = sink, model
        self.close, self.discard = sink.close, sink.discard

    def add(self, piece: Solved) -> None:
        table = shown_columns(piece.table, self._model)
        named = dict(zip(heads(table.values, self._model), table.values.values(), strict=True))
        self._sink.add(replace(piece, table=replace(table, values=named)))


def expect_plain(model: Model, names: Iterable[str]) -> None:
    """Raise RuleSheetError (E448) where a table that is gone on with has other units than the rules."""
    if found := next(iter(displays(model, names)), None):
        notes = (f"{found} is shown in {model.variables[found].display_unit}; start anew, or show none so",)
        raise RuleSheetError(error("E448", "--resume goes on in the units of the rules", notes=notes))


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


_STATUSES = tuple(Status)


class Outcome(NamedTuple):
    """``counts`` are the rows by status code, ``several`` those of which one of several answers is shown;
    ``interrupted`` says that there would have been more.
    """

    counts: tuple[int, ...]
    interrupted: bool = False
    several: int = 0

    @property
    def rows(self) -> int:
        return sum(self.counts)

    @property
    def all_solved(self) -> bool:
        return self.counts[_STATUSES.index(Status.SOLVED)] == self.rows

    def __str__(self) -> str:
        """``361 rows: 340 solved, 21 infeasible``."""
        if not self.rows:
            return "no rows"
        pairs = zip(self.counts, _STATUSES, strict=True)
        parts = ", ".join(f"{count:,} {status}" for count, status in pairs if count)
        told = f"{self.rows:,} {'row' if self.rows == 1 else 'rows'}: {parts}"
        if not self.several:
            return told
        have = "has" if self.several == 1 else "have"
        rows = "row" if self.rows == 1 else "rows"
        first = "several answers; the first of each is shown"
        return f"{told}\n{self.several:,} of {self.rows:,} {rows} {have} {first}"


def run(
    pieces: Iterator[Solved], sinks: Sequence[Sink], progress: Callable[[int], None] | None = None
) -> Outcome:
    """Hand every piece to every sink. ``progress`` hears the number of rows done.

    An interrupt ends the sweep and keeps what is done; anything else that ends it early discards the
    sinks and is raised. A second interrupt, while the files are finished, discards them too.
    """
    counts, several = [0] * len(_STATUSES), 0
    with Interrupts() as interrupts:
        try:
            for piece in _each(pieces, interrupts):
                for sink in sinks:
                    sink.add(piece)
                counts = [done + more for done, more in zip(counts, piece.counts, strict=True)]
                several += piece.several
                if progress is not None:
                    progress(sum(counts))
            for sink in sinks:
                sink.close()
        except BaseException:
            for sink in sinks:
                sink.discard()
            raise
        return Outcome(tuple(counts), interrupts.asked, several)


def _each(pieces: Iterator[Solved], interrupts: Interrupts) -> Iterator[Solved]:
    """The pieces, and what an interrupt leaves of those that are under way."""
    while not interrupts.asked:
        try:
            with interrupts.open():
                piece = next(pieces, None)
        except Interrupted as reached:
            yield from reached.kept
            return
        except KeyboardInterrupt:
            return
        if piece is None:
            return
        yield piece
