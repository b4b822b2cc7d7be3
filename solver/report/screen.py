"""Where a report is shown: the columns there are, and how words are set off (the only import of rich)."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import TextIO


@dataclass(frozen=True)
class Screen:
    """``width`` columns, None for a file or a pipe; ``paint(text, style)`` sets off words."""

    width: int | None = None
    paint: Callable[[str, str], str] = lambda text, style: text


PLAIN = Screen()
SCREEN: ContextVar[Screen] = ContextVar("SCREEN", default=PLAIN)


@contextmanager
def shown_on(stream: TextIO) -> Iterator[None]:
    """Reports are made for this stream within the context."""
    before = SCREEN.set(screen_of(stream))
    try:
        yield
    finally:
        SCREEN.reset(before)


def screen_of(stream: TextIO) -> Screen:
    """The screen of a terminal; words are set off where ``rich`` is installed and NO_COLOR is not set.

    COLUMNS in the environment counts for pipes, too.
    """
    if not stream.isatty():
        columns = os.environ.get("COLUMNS", "")
        return Screen(int(columns) if columns.isdecimal() and int(columns) else None)
    width = shutil.get_terminal_size().columns
    if "NO_COLOR" in os.environ or os.environ.get("TERM") == "dumb":
        return Screen(width)
    try:
        from rich.color import ColorSystem
        from rich.style import Style
    except ImportError:  # the extra `terminal`
        return Screen(width)

    def paint(text: str, style: str) -> str:
        return Style.parse(style).render(text, color_system=ColorSystem.STANDARD) if text else text

    return Screen(width, paint)
