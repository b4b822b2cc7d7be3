"""A text as words with their kinds and scopes, also while it is being typed and no sheet yet."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from rulesheets.functions.table import TABLE
from rulesheets.marks import KINDS, Shape
from rulesheets.parse.drafts import head_word
from rulesheets.parse.layout import logical_lines

HEADS = ("units", "variables", "rules", "function", "figure", "parameters", "use")
RESERVED = ("if", "then", "else", "call", "and", "or", "not")
KEYWORDS = (*RESERVED, "given", "in")
FUNCTIONS = tuple(TABLE)
MARKS = tuple(KINDS)

NAME = re.compile(r"[^\W\d]\w*")

_WORD = re.compile(
    r"""(?P<number>(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)
      | (?P<name>(?:[^\W\d]\w*(?:\#\d+)?\.)*[^\W\d]\w*)
      | (?P<symbol>'[^\W\d]\w*)
      | (?P<unit>\[[^\[\],\n]*\])
      | (?P<path>"[^"\n]*")
      | (?P<operator><>|<=|>=|±|\+/?-|[-+*/^=<>≤≥≠~%])
      | (?P<punctuation>[(),;\[\]])
      | (?P<error>\S)""",
    re.IGNORECASE | re.VERBOSE,
)
_CALLED = re.compile(r"[^\S\n]*\(")
_RANGE = re.compile(r"[^\S\n]*\[")


@dataclass(frozen=True, slots=True)
class Word:
    """A stretch ``[start, end)`` of a text, and the section that it stands in.

    ``kind`` is a group of the pattern above, or ``keyword``, ``head``, ``mark``, ``title``, ``constant``,
    ``builtin``, ``function``, ``comment``. ``scope`` is where its name is known: "" on the sheet (parameters
    included), the name of a function, or that of a figure and a colon.
    """

    kind: str
    start: int
    end: int
    text: str
    scope: str = ""
    section: str = "rules"


def words(text: str) -> list[Word]:
    """Every word of a text in order, comments included."""
    code = list(_code(text))
    found: list[Word] = []
    for before, after in pairwise((None, *code, None)):
        if before is not None:
            found.append(before)
        start, end = before.end if before else 0, after.start if after else len(text)
        for comment in re.finditer(r"\S[^\n]*", text[start:end]):
            said = comment.group().rstrip()
            found.append(Word("comment", start + comment.start(), start + comment.start() + len(said), said))
    return found


def _code(text: str) -> Iterator[Word]:
    """Every word but the comments."""
    scope, section, shared = "", "rules", set[str]()
    for line in logical_lines(text):
        head = head_word(line.code) or ""
        if head and head != "parameters":
            scope = scope if head == "rules" else ""
            section, shared = head, shared if scope else set()
        place = _Place(section, head)
        for match in _WORD.finditer(line.code):
            kind, said = place.kind(match, line.code), match.group()
            if head == "function" and kind == "function":
                scope = said.lower()
            if head == "parameters" and kind == "name":
                shared.add(said)
            if head == "figure" and kind == "title":
                scope = f"{said}:"
            drawn = section == "figure" and not place.expression
            within = scope if drawn or (section != "figure" and said not in shared) else ""
            yield Word(kind, line.start + match.start(), line.start + match.end(), said, within, section)


@dataclass(slots=True)
class _Place:
    """Where the next word of a line stands. ``expression``: it is no point of a figure, but a variable."""

    section: str
    head: str
    mark: str = ""
    first: bool = True
    expression: bool = False

    def kind(self, match: re.Match[str], code: str) -> str:
        first, self.first = self.first, False
        kind, word = str(match.lastgroup), match.group().lower()
        if self.section == "figure" and self.mark:
            shape = KINDS[self.mark].shape
            opened = word == "(" and shape is Shape.COORDINATES
            self.expression |= opened or (word == "," and shape is Shape.DIRECTED)
        if kind != "name":
            return kind
        if first and self.head:
            return "head"
        if first and self.section == "figure" and word in MARKS:
            self.mark = word
            return "mark"
        if self.head == "figure":
            return "title"
        if self.section == "units":
            return "unit"
        called = _CALLED.match(code, match.end())
        if word in KEYWORDS and (word in RESERVED or (word == "given" and called)):
            return "keyword"
        if word == "in" and _RANGE.match(code, match.end()):
            return "keyword"
        if called and not (self.section == "figure" and not self.expression):
            return "builtin" if word in TABLE else "function"
        return "constant" if match.group() == "pi" else "name"
