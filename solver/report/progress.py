"""One line on a terminal that tells how far a long sweep is."""

from __future__ import annotations

from time import monotonic
from typing import TextIO

PATIENCE = 1.0
"""Seconds before anything is shown."""
PAUSE = 0.2
"""Seconds between two pictures of the line."""


class Progress:
    """Called with the number of rows done; ``end`` leaves the line as if nothing had been."""

    def __init__(self, stream: TextIO, total: int | None) -> None:
        self._stream, self._total = stream, total
        self._began = monotonic()
        self._next = self._began + PATIENCE
        self._width = 0

    def __call__(self, done: int) -> None:
        now = monotonic()
        if now >= self._next:
            self._next = now + PAUSE
            self._show(progress_line(done, self._total, now - self._began))

    def end(self) -> None:
        if self._width:
            self._show("")
            self._stream.write("\r")
            self._stream.flush()

    def _show(self, line: str) -> None:
        self._stream.write("\r" + line.ljust(self._width))
        self._stream.flush()
        self._width = len(line)


def progress_line(done: int, total: int | None, seconds: float) -> str:
    """``1,200,000 of 4,000,000 rows  30 %  600,000 rows/s  0:05 left``."""
    rate = done / seconds if seconds > 0 else 0.0
    speed = f"{rate:,.0f} rows/s" if rate >= 10 else f"{rate:.2g} rows/s"
    if total is None:
        return f"{done:,} rows  {speed}"
    line = f"{done:,} of {total:,} rows  {100 * done // max(total, 1)} %  {speed}"
    return f"{line}  {clock((total - done) / rate)} left" if rate else line


def clock(seconds: float) -> str:
    """``0:05``, ``2:03:00``."""
    minutes, rest = divmod(int(seconds + 0.5), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}" if hours else f"{minutes}:{rest:02}"
