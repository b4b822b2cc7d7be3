"""What ends long work early: a limit in time, and an interrupt, which keeps the rows that are done.

The limit belongs to the context (of a thread, too), so that every loop sees it without passing it on.
"""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from math import inf
from threading import current_thread, main_thread
from time import monotonic
from types import FrameType, TracebackType
from typing import Any, Self, TypeVar

T = TypeVar("T")
_END: ContextVar[float] = ContextVar("_END", default=inf)


class TimeIsUp(Exception):
    """The limit in time of a solve was met."""


@contextmanager
def setting(variable: ContextVar[T], value: T) -> Iterator[None]:
    """A variable has this value within the context."""
    before = variable.set(value)
    try:
        yield
    finally:
        variable.reset(before)


def time_limit(seconds: float | None) -> AbstractContextManager[None]:
    """Raise TimeIsUp from :func:`expect_time` after so many seconds; None is no limit beside those around.

    Raises ValueError for a limit that is not positive.
    """
    if seconds is not None and not seconds > 0.0:
        raise ValueError(f"a limit in time is a positive number of seconds, and this is {seconds}")
    return setting(_END, min(monotonic() + (inf if seconds is None else seconds), _END.get()))


def grace(seconds: float) -> AbstractContextManager[None]:
    """So much time in any case: for what is to be said of a solve whose time is up."""
    return setting(_END, monotonic() + seconds if limited() else inf)


def limited() -> bool:
    """Whether there is a limit at all."""
    return _END.get() < inf


def expired() -> bool:
    """Whether the limit has passed."""
    return monotonic() > _END.get()


def expect_time() -> None:
    """Raise TimeIsUp if the limit has passed."""
    if expired():
        raise TimeIsUp


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
