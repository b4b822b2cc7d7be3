"""Text and places in it."""

from __future__ import annotations

import re
from bisect import bisect_right
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple


def escaped(text: str) -> str:
    """A text for a terminal: ``\\x1b`` stands for an escape character, and so on."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


LIKE_PI = re.compile("P[iI]|pI")
"""How ``pi`` is written, too; these may be variables."""


@dataclass(frozen=True)
class Source:
    """A text and its name in messages (a path, or ``<text>``)."""

    name: str
    text: str = field(repr=False)

    @cached_property
    def line_starts(self) -> tuple[int, ...]:
        """Offset of the first character of every line."""
        return (0, *(found.end() for found in re.finditer("\n", self.text)))

    @cached_property
    def variables_like_pi(self) -> frozenset[str]:
        """``Pi``, ``PI`` and ``pI``, if a row of variables or a rule (``Pi = V*I``) begins with
        it."""
        begins = rf"^[ \t]*({LIKE_PI.pattern})[ \t]*(?:[=~\[\"]|in\b|$)"
        return frozenset(re.findall(begins, self.text, re.MULTILINE))

    def place(self, offset: int) -> tuple[int, int]:
        """Line and column of an offset, both counted from 1."""
        line = bisect_right(self.line_starts, offset)
        return line, offset - self.line_starts[line - 1] + 1

    def line(self, number: int) -> str:
        """The text of a line (counted from 1) without its line end."""
        start = self.line_starts[number - 1]
        end = self.text.find("\n", start)
        return self.text[start : len(self.text) if end < 0 else end].rstrip("\r")


class Span(NamedTuple):
    """A stretch ``[start, end)`` of a source."""

    source: Source
    start: int
    end: int

    @property
    def file(self) -> str:
        return self.source.name

    @property
    def line(self) -> int:
        """The line that it begins on, counted from 1."""
        return self.source.place(self.start)[0]

    @property
    def column(self) -> int:
        """The column that it begins at, counted from 1."""
        return self.source.place(self.start)[1]

    @property
    def text(self) -> str:
        return self.source.text[self.start : self.end]

    def part(self, start: int, length: int) -> Span:
        """So many of its characters from ``start`` on, an offset into its text."""
        return Span(self.source, self.start + start, self.start + start + length)
