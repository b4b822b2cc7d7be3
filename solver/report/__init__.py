"""Reports of a solve for people and programs: variable sheet, path, JSON, CSV.

This module has text tables, as wide as the screen allows (the only import of rich).
"""

from __future__ import annotations

import os
import unicodedata
from collections.abc import Collection, Iterable, Sequence
from contextvars import ContextVar
from shutil import get_terminal_size
from typing import NamedTuple, TextIO

from rulesheets.diagnosis import Diagnosis, render


class Screen(NamedTuple):
    """``width`` columns, None for a file or a pipe; whether words are highlighted in ``color``."""

    width: int | None = None
    color: bool = False

    def paint(self, text: str, style: str) -> str:
        """Highlight words, if ``rich`` is installed."""
        if not self.color or not text:
            return text
        try:
            from rich.color import ColorSystem
            from rich.style import Style
        except ImportError:  # the extra `terminal`
            return text
        return Style.parse(style).render(text, color_system=ColorSystem.STANDARD)

    def said(self, diagnoses: Iterable[Diagnosis]) -> list[str]:
        return [render(diagnosis, color=self.color, width=self.width) for diagnosis in diagnoses]


PLAIN = Screen()
SCREEN: ContextVar[Screen] = ContextVar("SCREEN", default=PLAIN)
"""What reports are made for."""


def screen_of(stream: TextIO) -> Screen:
    """The screen of a terminal, in colour unless NO_COLOR is set. COLUMNS counts for pipes, too."""
    columns = os.environ.get("COLUMNS", "")
    if not stream.isatty():
        return Screen(int(columns) if columns.isdecimal() and int(columns) else None)
    color = "NO_COLOR" not in os.environ and os.environ.get("TERM") != "dumb"
    return Screen(get_terminal_size().columns, color)


GAP = "  "
LEAST = 8
"""Characters that a column keeps when a table is made to fit."""


def table(
    header: Sequence[str],
    rows: Iterable[Sequence[str]],
    least: Sequence[int] = (),
    soft: Collection[int] = (-1,),
    styles: Sequence[str] = (),
) -> str:
    """Lines of left-aligned columns under a header and a rule of dashes.

    ``least`` are the smallest widths of the first columns: columns of numbers with a fixed width do
    not shift the table when a number changes. ``soft`` columns are cut if the screen is too narrow;
    ``styles`` highlight the cells of the first columns on a terminal.
    """
    cells = [tuple(map(printable, row)) for row in rows]
    lines = [tuple(header), *cells] if header else cells
    widths, room = _widths(lines, least), SCREEN.get().width
    if room is not None and _total(widths) > room:
        widths = _widths(lines)
        places = [place % len(widths) for place in soft]
        while _total(widths) > room and places:
            if widths[widest := max(places, key=widths.__getitem__)] <= LEAST:
                break
            widths[widest] -= 1
    body = [_line(row, widths, [*styles, *[""] * (len(widths) - len(styles))]) for row in cells]
    if header:
        dashes = ["-" * size if head else "" for head, size in zip(header, widths, strict=True)]
        bold, dim = (["bold"] * len(widths), ["dim"] * len(widths))
        body = [_line(tuple(header), widths, bold), _line(dashes, widths, dim), *body]
    return "\n".join(body)


def fits(header: Sequence[str], rows: Iterable[Sequence[str]]) -> bool:
    """Whether a table whose last column may be cut fits the screen."""
    room = SCREEN.get().width
    widths = _widths((tuple(header), *map(tuple, rows)))
    return room is None or _total([*widths[:-1], min(widths[-1], LEAST)]) <= room


def width(text: str) -> int:
    """The cells of a text on a terminal: wide characters take two, combining ones none."""
    if text.isascii():
        return len(text)
    wide = sum(unicodedata.east_asian_width(character) in "WF" for character in text)
    return len(text) + wide - sum(map(bool, map(unicodedata.combining, text)))


def printable(text: str) -> str:
    """The text on one line, without characters that would move the cursor."""
    if text.isprintable():
        return text
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


def _widths(rows: Sequence[Sequence[str]], least: Sequence[int] = ()) -> list[int]:
    columns = enumerate(zip(*rows, strict=True))
    return [max(*map(width, column), *least[place : place + 1], 0) for place, column in columns]


def _total(widths: Sequence[int]) -> int:
    return sum(widths) + len(GAP) * (len(widths) - 1)


def _line(row: Sequence[str], widths: Sequence[int], styles: Sequence[str]) -> str:
    paint = SCREEN.get().paint
    parts: list[str] = []
    pad = 0
    for text, size, style in zip(row, widths, styles, strict=True):
        if width(text) > size:
            while width(text) > size - 1:
                text = text[:-1]
            text = text.rstrip() + "…"
        if text:
            parts.append(" " * pad + (paint(text, style) if style else text))
            pad = 0
        pad += size - width(text) + len(GAP)
    return "".join(parts)
