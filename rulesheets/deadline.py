"""Limits on long work: a time limit, an interrupt, which ends the time, and room for call frames.

The limit belongs to the context, and so to a thread: any loop can read it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from functools import wraps
from math import inf
from time import monotonic
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")
_END: ContextVar[float] = ContextVar("_END", default=inf)


class TimeIsUp(Exception):
    """The time limit of a solve was reached."""


@contextmanager
def setting(variable: ContextVar[T], value: T) -> Iterator[None]:
    """A variable has this value within the context."""
    before = variable.set(value)
    try:
        yield
    finally:
        variable.reset(before)


def time_limit(seconds: float | None) -> AbstractContextManager[None]:
    """Raise TimeIsUp from :func:`expect_time` after so many seconds; None adds no limit.

    Raises ValueError for a limit that is not positive.
    """
    if seconds is not None and not seconds > 0.0:
        raise ValueError(f"a limit in time is a positive number of seconds, and this is {seconds}")
    return setting(_END, min(monotonic() + (inf if seconds is None else seconds), _END.get()))


def grace(seconds: float) -> AbstractContextManager[None]:
    """A time limit of its own for the explanation of a solve whose time is up."""
    return setting(_END, monotonic() + seconds if limited() else inf)


def limited() -> bool:
    return _END.get() < inf


def expired() -> bool:
    """Whether the limit has passed, or an interrupt has come."""
    return bool(INTERRUPTS) or monotonic() > _END.get()


def expect_time() -> None:
    """Raise TimeIsUp if the limit has passed."""
    if expired():
        raise TimeIsUp


WATCH: ContextVar[Callable[[int], None] | None] = ContextVar("WATCH", default=None)
"""Called with the solved rows of the current piece, if these are solved one by one."""


INTERRUPTS: list[int] = []
"""The signals that have come; the first one ends the time."""


def interrupted() -> bool:
    """Whether an interrupt has come: rows that are not solved by then fail."""
    return bool(INTERRUPTS)


# --- room for the frames of calls, so that no loop asks the system for memory at every turn ---

SLOTS = 1 << 16
"""Pointers in the frame that makes room: half a megabyte, none of which is touched."""


def in_one_chunk(function: Callable[P, T]) -> Callable[P, T]:
    """The function, with its frame and those of the calls below it in one piece of memory.

    CPython keeps frames in chunks of 16 KB, and up to 3.13 it gives a chunk back as soon as the
    last frame in it returns. A loop whose calls lie across the end of a chunk takes ten times as
    long: which loop that is depends on how deep the caller's stack happens to be. For a frame as
    large as this one, a chunk of twice its size is made, and the calls below use the rest.
    """

    def within(*args: P.args, **kwargs: P.kwargs) -> T:
        return function(*args, **kwargs)

    within.__code__ = within.__code__.replace(co_stacksize=SLOTS)
    return wraps(function)(within)
