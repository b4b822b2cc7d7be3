"""Text → logical lines: where a line goes on, and where its comments are.

A logical line may span several lines of text. Its comments are blanked out in ``code``,
which keeps every offset, so the grammar knows neither of comments nor of line ends.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

NESTING = 100
"""Parentheses that may be open at a time."""

LONGEST = 200_000
"""Characters that a logical line may have; a longer one is refused unread."""

_MARK = re.compile(r'["();]')
_OTHERS = re.compile(r"[^()]+")
_GOES_ON = re.compile(r"(?:[-+*/^,=<>≤≥≠~]|\b(?:then|else|and|or|not))\Z", re.IGNORECASE)
_CARRIES_ON = re.compile(r"[^\S\n]*(?:then|else)\b", re.IGNORECASE)
_USE = re.compile(r"\s*use\b", re.IGNORECASE)
_PATH = re.compile(r'"[^"\n]*"(?=\s*(?:[,";]|$))', re.MULTILINE)
_HEAD = re.compile(
    r"[^\S\n]*(?:(?:variables|rules|units)[^\S\n]*(?:[\";]|$)|(?:function|figure)\s+[^\W\d]|use\s*\")",
    re.IGNORECASE | re.MULTILINE,
)


class Line(NamedTuple):
    """One logical line; all offsets count from the start of the text.

    ``code`` begins at ``start`` and has blanks for comments; ``end`` is where it ends without
    trailing blanks. ``comment`` is what the comments say, joined by ``; ``, or None. ``gap``:
    a blank line stands before. ``unclosed`` are the parentheses that are never closed, ``stray``
    the closing ones that nothing opened, ``too_deep`` is the first beyond NESTING.
    """

    start: int
    end: int
    code: str
    comment: str | None
    gap: bool
    unclosed: tuple[int, ...]
    stray: tuple[int, ...]
    too_deep: int | None

    @property
    def blank(self) -> bool:
        """Whether there is nothing but comments."""
        return self.end == self.start


@dataclass(slots=True)
class _Draft:
    """A logical line while it is gathered from lines of text."""

    text: str
    start: int
    code: list[str] = field(default_factory=list)
    comments: list[str] = field(default_factory=list)
    ending: str = ""
    end: int = 0
    too_deep: int | None = None
    open: list[int] = field(default_factory=list)
    stray: list[int] = field(default_factory=list)

    def add(self, start: int, end: int) -> None:
        """Take in the line of text ``[start, end)``: follow its parentheses to where its comment begins."""
        position, mark = start, end
        while mark == end and (found := _MARK.search(self.text, position, min(end, start + LONGEST))):
            place, position = found.start(), found.end()
            if found.group() == "(":
                self.open.append(place)
                if len(self.open) > NESTING and self.too_deep is None:
                    self.too_deep = place
            elif found.group() == ")":
                if self.open:
                    self.open.pop()
                else:
                    self.stray.append(place)
            elif found.group() == '"' and (path := self._path(place, end)):
                position = path.end()
            elif found.group() == '"' or not self.open:
                mark = place
        code = self.text[start:mark]
        if mark < end:
            self.comments.append(self.text[mark + 1 : end].strip())
        if shown := code.rstrip():
            self.ending = shown
            self.end = start + len(shown)
        self.code.append(code + " " * (end - mark))

    def _path(self, quote: int, end: int) -> re.Match[str] | None:
        """The quoted file name that begins here, if this is a ``use`` line."""
        if not _USE.match(self.text, self.start) or self.text[self.start : quote].rstrip().endswith('"'):
            return None
        return _PATH.match(self.text, quote, end)

    def line(self, gap: bool) -> Line:
        return Line(
            self.start,
            self.end or self.start,
            "\n".join(self.code)[: max(0, self.end - self.start)],
            "; ".join(filter(None, self.comments)) if self.comments else None,
            gap,
            tuple(self.open),
            tuple(self.stray),
            self.too_deep,
        )


def logical_lines(text: str) -> Iterator[Line]:
    """The logical lines of a text in order; blank ones are left out.

    A parenthesis that is not closed before the next section head, or at all, does not make
    its line go on: one slip should not swallow the sheet.
    """
    position, gap = 0, False
    while position < len(text):
        end = _line_end(text, position)
        shown = text[position:end].rstrip()
        if not shown:
            gap, position = True, end + 1
            continue
        if _is_plain(shown) and _carried_on(text, end + 1) < 0:
            yield Line(position, position + len(shown), shown, None, gap, (), (), None)
            gap, position = False, end + 1
            continue
        draft, after = _gather(text, position, through_parentheses=True)
        if draft.open:
            draft, after = _gather(text, position, through_parentheses=False)
        yield draft.line(gap)
        gap, position = False, after


def _is_plain(shown: str) -> bool:
    """Whether a line of text says all by itself: no comment, every parenthesis closed, nothing to come."""
    if '"' in shown or ";" in shown or len(shown) > LONGEST or _GOES_ON.search(shown[-5:]):
        return False
    signs, before = _OTHERS.sub("", shown), ""
    while signs != before:
        signs, before = signs.replace("()", ""), signs
    return not signs and shown.count("(") <= NESTING


def _line_end(text: str, start: int) -> int:
    end = text.find("\n", start)
    return len(text) if end < 0 else end


def _gather(text: str, start: int, through_parentheses: bool) -> tuple[_Draft, int]:
    """The logical line that begins at ``start``, and where the next one may begin."""
    draft = _Draft(text, start)
    position = taken = start
    while True:
        end = _line_end(text, position)
        draft.add(position, end)
        position = end + 1
        if position >= len(text) or position - start > LONGEST or not draft.ending:
            return draft, position
        if position <= taken:
            continue
        if _HEAD.match(text, position):
            return draft, position
        if draft.open and through_parentheses:
            continue
        if _GOES_ON.search(draft.ending[-5:]):
            goes_on = bool(text[position : _line_end(text, position)].strip())
        else:
            taken = _carried_on(text, position)
            goes_on = taken >= position
        if not goes_on:
            return draft, position


def _carried_on(text: str, position: int) -> int:
    """Where the next line that says anything begins, if it does so with ``then`` or ``else``; else -1."""
    while position < len(text):
        if _CARRIES_ON.match(text, position):
            return position
        end = _line_end(text, position)
        line = text[position:end].lstrip()
        if line and line[0] not in '";':
            return -1
        position = end + 1
    return -1
