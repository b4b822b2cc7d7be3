"""Text tables: columns as wide as they need to be, nothing else."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

GAP = "  "


def table(header: Sequence[str], rows: Iterable[Sequence[str]], least: Sequence[int] = ()) -> str:
    """Lines of left-aligned columns under a header and a rule of dashes.

    ``least`` are the smallest widths of the first columns: a column of numbers that keeps
    its width does not shift the rest of the table when a number changes.
    """
    cells = [tuple(printable(cell) for cell in row) for row in rows]
    widths = [
        max(floor, *(width(row[i]) for row in (tuple(header), *cells)))
        for i, floor in enumerate((*least, *(0,) * (len(header) - len(least))))
    ]
    dashes = tuple("-" * size if head else "" for head, size in zip(header, widths, strict=True))
    return "\n".join(_line(row, widths) for row in (tuple(header), dashes, *cells))


def columns(rows: Iterable[Sequence[str]]) -> str:
    """Like :func:`table`, without a header."""
    cells = [tuple(printable(cell) for cell in row) for row in rows]
    widths = [max(map(width, column)) for column in zip(*cells, strict=True)]
    return "\n".join(_line(row, widths) for row in cells)


def width(text: str) -> int:
    """Cells that a text takes on a terminal: wide characters take two, combining ones none."""
    if text.isascii():
        return len(text)
    import unicodedata

    wide = sum(unicodedata.east_asian_width(character) in "WF" for character in text)
    return len(text) + wide - sum(map(bool, map(unicodedata.combining, text)))


def printable(text: str) -> str:
    """The text on one line, without characters that would move the cursor."""
    if text.isprintable():
        return text
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


def _line(row: Sequence[str], widths: Sequence[int]) -> str:
    padded = (cell + " " * (size - width(cell)) for cell, size in zip(row, widths, strict=True))
    return GAP.join(padded).rstrip()
