"""What ends long work early: a limit in time, or an interrupt, which lets the time be up.

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
    """Whether the limit has passed, or an interrupt has come."""
    return _interrupted or monotonic() > _END.get()


def expect_time() -> None:
    """Raise TimeIsUp if the limit has passed."""
    if expired():
        raise TimeIsUp


WATCH: ContextVar[Callable[[int], None] | None] = ContextVar("WATCH", default=None)
"""Hears of the rows of the piece at hand that are solved, where these go one by one."""


ENDING = (signal.SIGINT, signal.SIGTERM)
"""Ctrl-C, and the request to end that a batch system sends."""


_interrupted = False


def interrupted() -> bool:
    """Whether an interrupt has come: what is not solved by then fails."""
    return _interrupted


class Interrupts:
    """While this context lasts, the first interrupt lets the time be up, and a second one is raised.

    Only the main thread hears signals: elsewhere nothing changes.
    """

    def __init__(self) -> None:
        self._before: dict[signal.Signals, Any] = {}

    def __enter__(self) -> Self:
        if current_thread() is main_thread():
            self._before = {number: signal.signal(number, self._heard) for number in ENDING}
        return self

    def __exit__(
        self, kind: type[BaseException] | None, failure: BaseException | None, trace: TracebackType | None
    ) -> None:
        global _interrupted
        for number, before in self._before.items():
            signal.signal(number, before)
        _interrupted = _interrupted and not self._before

    def _heard(self, number: int, frame: FrameType | None) -> None:
        global _interrupted
        again, _interrupted = _interrupted, True
        if again:
            raise KeyboardInterrupt
