"""A limit in time on whatever runs within a context: loops that can run long look at the clock.

The limit belongs to the context (of a thread, too), so that every loop sees it without passing it on.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from math import inf
from time import monotonic

_END: ContextVar[float] = ContextVar("_END", default=inf)


class TimeIsUp(Exception):
    """The limit in time of a solve was met."""


@contextmanager
def time_limit(seconds: float | None) -> Iterator[None]:
    """Raise TimeIsUp from :func:`expect_time` after so many seconds; None is no limit beside those around.

    Raises ValueError for a limit that is not positive.
    """
    if seconds is None:
        yield
        return
    if not seconds > 0.0:
        raise ValueError(f"a limit in time is a positive number of seconds, and this is {seconds}")
    before = _END.set(min(monotonic() + seconds, _END.get()))
    try:
        yield
    finally:
        _END.reset(before)


@contextmanager
def grace(seconds: float) -> Iterator[None]:
    """So much time in any case: for what is to be said of a solve whose time is up."""
    before = _END.set(monotonic() + seconds if _END.get() < inf else inf)
    try:
        yield
    finally:
        _END.reset(before)


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
