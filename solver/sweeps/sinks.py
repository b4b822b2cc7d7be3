"""Where the pieces of a solved sweep go."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from queue import Queue
from threading import Thread
from typing import Protocol, TextIO

from solver.files.columns import csv_head, csv_rows
from solver.files.tables import CsvFile, table_file
from solver.sweeps.work import Solved


class Sink(Protocol):
    """Takes the pieces in order; then it is closed, whole, or discarded."""

    def add(self, piece: Solved) -> None: ...
    def close(self) -> None: ...
    def discard(self) -> None: ...


class FileSink:
    """A table file by its ending, written in a thread of its own while the next rows are solved.

    What goes wrong there is raised at the next piece, or at the end.
    """

    WAITING = 2
    """Pieces that may wait to be written: what bounds the memory."""

    def __init__(self, path: str, names: Sequence[str], symbols: Collection[str]) -> None:
        self._file = table_file(path, names, symbols)
        self._waiting: Queue[Solved | None] = Queue(self.WAITING)
        self._failure: BaseException | None = None
        self._thread = Thread(target=self._work, daemon=True, name="sink")
        self._thread.start()

    def add(self, piece: Solved) -> None:
        self._waiting.put(piece)
        self._raise()

    def close(self) -> None:
        self._end()
        self._raise()
        self._file.close()

    def discard(self) -> None:
        self._end()
        self._file.discard()

    def _end(self) -> None:
        if self._thread.is_alive():
            self._waiting.put(None)
            self._thread.join()

    def _work(self) -> None:
        while (piece := self._waiting.get()) is not None:
            if self._failure is None:
                try:
                    self._write(piece)
                except BaseException as failure:
                    self._failure = failure

    def _write(self, piece: Solved) -> None:
        if piece.text is not None and isinstance(self._file, CsvFile):
            self._file.add_lines(piece.text)
        else:
            assert piece.table is not None
            self._file.add(piece.table)

    def _raise(self) -> None:
        if self._failure is not None:
            raise self._failure


class StreamSink:
    """Lines of CSV to an open stream, as they come."""

    def __init__(self, stream: TextIO, names: Sequence[str]) -> None:
        self._stream = stream
        self._head = csv_head(names).decode()

    def add(self, piece: Solved) -> None:
        self._begin()
        if piece.text is not None:
            self._stream.write(piece.text.decode())
        else:
            assert piece.table is not None
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
