"""One line on a terminal that tells how far a long sweep is, from the first second on."""

from __future__ import annotations

from time import monotonic
from typing import TextIO

from solver.sweeps.sinks import Sink
from solver.sweeps.work import Solved

PATIENCE = 0.5
"""Seconds before anything is shown."""
PAUSE = 0.2
"""Seconds between two states of the line."""


class Progress:
    """Called with the number of rows done; ``within`` hears of rows of the piece at hand.

    ``end`` leaves the line as if nothing had been.
    """

    def __init__(self, stream: TextIO, total: int | None) -> None:
        self._stream, self._total = stream, total
        self._began = monotonic()
        self._due = self._began + PATIENCE
        self._done = self._width = 0

    def __call__(self, done: int) -> None:
        self._done = done
        self.within(0)

    def within(self, rows: int) -> None:
        now = monotonic()
        if now >= self._due:
            self._due = now + PAUSE
            self._show(progress_line(self._done + rows, self._total, now - self._began))

    def end(self) -> None:
        """Clear the line, also for whoever writes to the same terminal next."""
        if self._width:
            self._show("")
            self._stream.write("\r")
            self._stream.flush()

    def _show(self, line: str) -> None:
        self._stream.write("\r" + line.ljust(self._width))
        self._stream.flush()
        self._width = len(line)


class Quietly:
    """A sink that writes where the line stands, which makes way for its rows."""

    def __init__(self, sink: Sink, progress: Progress) -> None:
        self._sink, self._progress = sink, progress

    def add(self, piece: Solved) -> None:
        self._progress.end()
        self._sink.add(piece)

    def close(self) -> None:
        self._progress.end()
        self._sink.close()

    def discard(self) -> None:
        self._sink.discard()


def progress_line(done: int, total: int | None, seconds: float) -> str:
    """``1,200,000 of 4,000,000 rows  30 %  600,000 rows/s  0:05 left``."""
    rate = done / seconds if seconds > 0 else 0.0
    speed = f"{rate:,.0f} rows/s" if rate >= 10 else f"{rate:.2g} rows/s"
    if not done:
        speed = clock(seconds)
    if total is None:
        return f"{done:,} rows  {speed}"
    line = f"{done:,} of {total:,} rows  {100 * done // max(total, 1)} %  {speed}"
    return f"{line}  {clock((total - done) / rate)} left" if rate else line


def clock(seconds: float) -> str:
    """``0:05``, ``2:03:00``."""
    minutes, rest = divmod(int(seconds + 0.5), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"
