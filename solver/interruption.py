"""A piece of a sweep that an interrupt ends: the rows before the one at hand are kept."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from threading import current_thread, main_thread
from types import FrameType, TracebackType
from typing import Any, Self

WATCH: ContextVar[Callable[[int], None] | None] = ContextVar("WATCH", default=None)
"""Hears of the rows of the piece at hand that are solved, where these go one by one."""


class Interrupted(KeyboardInterrupt):
    """So many ``rows`` of a piece are solved; ``kept`` holds them in the form of the room that raises."""

    def __init__(self, rows: int, kept: Any = None) -> None:
        super().__init__()
        self.rows, self.kept = rows, kept


ENDING = (signal.SIGINT, signal.SIGTERM)
"""Ctrl-C, and the request to end that a batch system sends."""


class Interrupts:
    """While this context lasts, the first interrupt is raised within ``open`` alone, and else remembered.

    A second one is raised wherever it comes. Only the main thread hears signals: elsewhere nothing changes.
    """

    def __init__(self) -> None:
        self.asked = False
        self._open = False
        self._before: dict[signal.Signals, Any] = {}

    def __enter__(self) -> Self:
        if current_thread() is main_thread():
            self._before = {number: signal.signal(number, self._heard) for number in ENDING}
        return self

    def __exit__(
        self, kind: type[BaseException] | None, failure: BaseException | None, trace: TracebackType | None
    ) -> None:
        for number, before in self._before.items():
            signal.signal(number, before)

    @contextmanager
    def open(self) -> Iterator[None]:
        """A stretch that an interrupt may leave at once."""
        self._open = True
        try:
            yield
        finally:
            self._open = False

    def _heard(self, number: int, frame: FrameType | None) -> None:
        again, self.asked = self.asked, True
        if self._open or again:
            raise KeyboardInterrupt
