"""Text → logical lines: where a line continues, where its comments are, and what form it has.

A logical line may span several lines of text. Its comments are blanked out in ``code``, which keeps
every offset, so the grammar knows neither comments nor line ends.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count
from typing import Any, NamedTuple, TypeAlias

from rulesheets.diagnosis import Diagnosis, error_at
from rulesheets.syntax import Source, Span
from rulesheets.syntax.nodes import Call, Equality, Name, Number, Sum, walk

LONGEST = 200_000
"""Characters that a logical line may have; a longer one is refused unread."""

STRANGE = re.compile(r"[^\t\n\v\f\r -~]")
"""Characters that have no meaning in a rule, but for a few signs and letters."""

_MARK = re.compile(r'["();]')
_CLOSED = re.compile(r'(?:[^"();\n]++|\((?:[^"();\n]++|\([^"();\n]*+\))*+\))*+')
"""What has no comment, and closes what it opens, up to two levels deep."""
_GOES_ON = re.compile(r"(?:[-+*/^,=<>≤≥≠~]|\b(?:then|else|and|or|not))\Z", re.IGNORECASE)
_CARRIES_ON = re.compile(
    r"""(?:[^\S\n]*(?:[";][^\n]*)?\n)*+()[^\S\n]*(?:then|else)\b""", re.IGNORECASE
)
"""``then`` or ``else`` on the next line with code, whose start is the group."""
_USE = re.compile(r"\s*use\b", re.IGNORECASE)
_PATH = re.compile(r'"[^"\n]*"(?=\s*(?:[,";]|$))', re.MULTILINE)
_HEAD = re.compile(
    r"[^\S\n]*(?:(?:variables|rules|units)[^\S\n]*(?:[\";]|$)"
    r"|(?:function|figure)\s+[^\W\d]|use\s*\")",
    re.IGNORECASE | re.MULTILINE,
)


@dataclass(slots=True)
class Line:
    """One logical line; all offsets count from the start of the text.

    ``code`` begins at ``start`` and has blanks for comments; ``end`` is the end without trailing
    blanks. ``comment`` is the text of the comments, joined by ``; ``, or None. ``gap``: a blank
    line precedes it. ``unclosed`` are the parentheses that are never closed, ``stray`` the closing
    ones without a partner.
    """

    start: int
    end: int
    gap: bool
    code: str = ""
    comment: str | None = None
    unclosed: list[int] = field(default_factory=list)
    stray: list[int] = field(default_factory=list)

    @property
    def blank(self) -> bool:
        """Whether there is nothing but comments."""
        return self.end == self.start

    def place(self, source: Source) -> Span:
        """Its start, without the blanks before it."""
        start = self.start + len(self.code) - len(self.code.lstrip())
        return Span(source, min(start, self.end), self.end)

    def follow(self, text: str, start: int, end: int) -> int:
        """Follow the parentheses of the line of text ``[start, end)`` up to its comment."""
        last = min(end, start + LONGEST)
        closed = _CLOSED.match(text, start, last)
        position = closed.end() if closed else start
        while found := _MARK.search(text, position, last):
            place, position = found.start(), found.end()
            if found.group() == "(":
                self.unclosed.append(place)
            elif found.group() == ")":
                if self.unclosed:
                    self.unclosed.pop()
                else:
                    self.stray.append(place)
            elif found.group() == '"' and (path := self._path(text, place, end)):
                position = path.end()
            elif found.group() == '"' or not self.unclosed:
                return place
        return end

    def _path(self, text: str, quote: int, end: int) -> re.Match[str] | None:
        """The quoted file name that begins here, if this is a ``use`` line."""
        if not _USE.match(text, self.start) or text[self.start : quote].rstrip().endswith('"'):
            return None
        return _PATH.match(text, quote, end)


def logical_lines(text: str) -> Iterator[Line]:
    """The logical lines of a text in order; blank ones are left out.

    A parenthesis that is not closed before the next section head, or at all, does not continue its
    line: one slip should not swallow the sheet.
    """
    position, gap = 0, False
    while position < len(text):
        end = _line_end(text, position)
        if not text[position:end].strip():
            gap, position = True, end + 1
            continue
        line, after = _gather(text, position, gap, through_parentheses=True)
        if line.unclosed:
            line, after = _gather(text, position, gap, through_parentheses=False)
        yield line
        position, gap = after, False


def _line_end(text: str, start: int) -> int:
    end = text.find("\n", start)
    return len(text) if end < 0 else end


def _gather(text: str, start: int, gap: bool, through_parentheses: bool) -> tuple[Line, int]:
    """The logical line that begins at ``start``, and where the next one may begin."""
    line, code, comments = Line(start, start, gap), [], []
    position = taken = start
    while True:
        end = _line_end(text, position)
        mark = line.follow(text, position, end)
        code.append(text[position:mark].ljust(end - position))
        if mark < end:
            comments.append(text[mark + 1 : end].strip())
        if shown := text[position:mark].rstrip():
            line.end = position + len(shown)
        position = end + 1
        if position >= len(text) or position - start > LONGEST or line.blank:
            break
        if position <= taken:
            continue
        if _HEAD.match(text, position):
            break
        if line.unclosed and through_parentheses:
            continue
        if _GOES_ON.search(text, max(line.end - 5, start), line.end):
            if not text[position : _line_end(text, position)].strip():
                break
        elif found := _CARRIES_ON.match(text, position):
            taken = found.start(1)
        else:
            break
    line.code = "\n".join(code)[: line.end - start]
    line.comment = "; ".join(filter(None, comments)) if comments else None
    return line, position


def wrong_shape(source: Source, line: Line) -> Diagnosis | None:
    """A mistake in the parentheses or the length of a line; None if it may be read."""
    if line.end - line.start > LONGEST:
        message = f"this line is too long to be a rule: {line.end - line.start:,} characters"
        note = f"a rule has at most {LONGEST:,} characters; give parts of it names of their own"
        place = Span(source, line.start, line.start + 1)
        return error_at("E125", message, place, note, label="begins here")
    if line.stray:
        place = Span(source, line.stray[0], line.stray[0] + 1)
        note = "remove it, or open a parenthesis before it"
        return error_at("E103", None, place, note, label="nothing is open here")
    if line.unclosed:
        place = Span(source, line.unclosed[-1], line.unclosed[-1] + 1)
        note = f"add {')' * len(line.unclosed)} where it ends"
        return error_at("E102", None, place, note, label="opened here")
    return None


# --- rules of one form ---

LONGEST_OF_A_FORM = 3_000
"""Characters of a rule that is compared: ten thousand forms of so many are remembered."""

_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_NAME = (
    r"(?!(?=[iteconapITECONAP])(?i:if|then|else|call|and|or|not|pi)\b)"
    r"[a-zA-Z_][a-zA-Z_0-9]*+(?!\w|\s*\()"
)
_LEAF = re.compile(rf"(?=[\w.])(?<![\w.])(?:({_NAME})|({_NUMBER}))")


class Leaves(NamedTuple):
    """A line: the ``key`` that determines its tree, and its names and numbers in order."""

    key: tuple[str, bytes]
    names: list[str]
    numbers: list[float]


def leaves_of(code: str) -> Leaves | None:
    """None if the line is long, or has a number out of range."""
    if len(code) > LONGEST_OF_A_FORM:
        return None
    parts = _LEAF.split(code)
    names, written = (list(filter(None, found)) for found in (parts[1::3], parts[2::3]))
    numbers = list(map(float, written))
    if math.inf in numbers:
        return None
    if 0.0 in numbers:
        pairs = zip(numbers, written, strict=True)
        if any(not number and text.strip("0.") for number, text in pairs):
            return None
    return Leaves(("@".join(parts[::3]), bytes(map(bool, parts[1::3]))), names, numbers)


Form: TypeAlias = Callable[[Sequence[str], Sequence[float], Span], Equality]
"""Makes rules that differ in names and numbers only, all of each in the place of the rule."""


def form_of(first: object, leaves: Leaves) -> Form | None:
    """The form of the rules that differ from a line in names and numbers only, from its tree.

    None for rules with arms, conditions, tuples, symbols or units.
    """
    if not isinstance(first, Equality) or first.span is None:
        return None
    kinds = list(map(type, walk(*first.parts)))
    leaf_kinds = len(first.parts), kinds.count(Name), kinds.count(Number)
    if leaf_kinds != (2, len(leaves.names), len(leaves.numbers)):
        return None
    lines, counts = list[str](), {Name: count(), Number: count()}
    left, right = (_written(side[0], lines, counts) for side in (first.left, first.right))
    lines.append(f"whole = Equality(({left},), ({right},), span)")
    lines += ["whole.names = tuple(dict.fromkeys(names))", "return whole"]
    body = "\n    ".join(lines)
    made: dict[str, Any] = {kind.__name__: kind for kind in (Equality, *kinds)}
    exec(f"def made(names, numbers, span):\n    {body}", made)
    form: Form = made["made"]
    return form if form(leaves.names, leaves.numbers, first.span) == first else None


def _written(node: Any, lines: list[str], counts: Mapping[type, Iterator[int]]) -> str:
    """A variable for a node; ``lines`` of Python make it and its parts."""
    kind, parts = type(node), [_written(part, lines, counts) for part in node.parts]
    listed = "".join(f"{part}, " for part in parts)
    if kind in counts:
        made = f"{'names' if kind is Name else 'numbers'}[{next(counts[kind])}], "
    else:
        made = f"{node.function!r}, ({listed}), " if kind is Call else listed
    if kind is Sum:
        made = f"({listed}), "
    lines.append(f"t{len(lines)} = {kind.__name__}({made}span)")
    return f"t{len(lines) - 1}"
