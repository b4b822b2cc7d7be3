"""A piece of a sweep that an interrupt ends: the rows before the one at hand are kept."""

from __future__ import annotations

from collections.abc import Callable
from contextvars import ContextVar
from typing import Any

WATCH: ContextVar[Callable[[int], None] | None] = ContextVar("WATCH", default=None)
"""Hears of the rows of the piece at hand that are solved, where these go one by one."""


class Interrupted(KeyboardInterrupt):
    """So many ``rows`` of a piece are solved; ``kept`` holds them in the form of the room that raises."""

    def __init__(self, rows: int, kept: Any = None) -> None:
        super().__init__()
        self.rows, self.kept = rows, kept
