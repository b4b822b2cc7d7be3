"""Room for the frames of calls, so that no loop asks the system for memory at every turn."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")

SLOTS = 1 << 16
"""Pointers in the frame that makes room: half a megabyte, none of which is touched."""


def in_one_chunk(function: Callable[P, T]) -> Callable[P, T]:
    """The function, with its frame and those of the calls below it in one piece of memory.

    CPython keeps frames in chunks of 16 KB, and up to 3.13 it gives a chunk back as soon as the last frame in
    it returns. A loop whose calls lie across the end of a chunk takes ten times as long: which loop that is
    depends on how deep the caller's stack happens to be. For a frame as large as this one, a chunk
    of twice its size is made, and the calls below use the rest.
    """

    def within(*args: P.args, **kwargs: P.kwargs) -> T:
        return function(*args, **kwargs)

    within.__code__ = within.__code__.replace(co_stacksize=SLOTS)
    return wraps(function)(within)
