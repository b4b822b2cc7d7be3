"""The words of a sheet and their meaning, for the language server and the lexer.

This module finds the words and names of a text, even an unfinished one.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

from rulesheets.checks import KINDS
from rulesheets.functions import TABLE
from rulesheets.parse.layout import logical_lines
from rulesheets.parse.sections import head_word

HEADS = ("units", "variables", "rules", "function", "figure", "parameters", "use")
RESERVED = ("if", "then", "else", "call", "and", "or", "not")
KEYWORDS = (*RESERVED, "given", "in")
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


class Word(NamedTuple):
    """A range ``[start, end)`` of a text, and its section.

    ``kind`` is a group of the pattern above, or ``keyword``, ``head``, ``mark``, ``title``,
    ``constant``, ``builtin``, ``function``, ``comment``. ``scope`` is where its name is known: ""
    on the sheet (parameters included), the name of a function, or that of a figure and a colon.
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
            said, place = comment.group().rstrip(), start + comment.start()
            found.append(Word("comment", place, place + len(said), said))
    return found


def _code(text: str) -> Iterator[Word]:
    """Every word but the comments."""
    scope, section, shared = "", "rules", set[str]()
    for line in logical_lines(text):
        head = head_word(line.code) or ""
        if head and head != "parameters":
            scope = scope if head == "rules" else ""
            section, shared = head, shared if scope else set()
        for match, kind, reckoned in _kinds(line.code, section, head):
            said = match.group()
            if head == "function" and kind == "function":
                scope = said.lower()
            if head == "parameters" and kind == "name":
                shared.add(said)
            if head == "figure" and kind == "title":
                scope = f"{said}:"
            drawn = section == "figure" and not reckoned
            within = scope if drawn or (section != "figure" and said not in shared) else ""
            start, end = line.start + match.start(), line.start + match.end()
            yield Word(kind, start, end, said, within, section)


def _kinds(code: str, section: str, head: str) -> Iterator[tuple[re.Match[str], str, bool]]:
    """Each word of a line with its kind, and whether it is a variable, not a point of a figure."""
    mark, reckoned = "", False
    for index, match in enumerate(_WORD.finditer(code)):
        kind, word = str(match.lastgroup), match.group().lower()
        called, ranged = (following.match(code, match.end()) for following in (_CALLED, _RANGE))
        if mark:
            points = KINDS[mark].points
            opened = word == "(" and points == 0
            reckoned |= opened or (word == "," and points == 1)
        if kind != "name":
            pass
        elif index == 0 and head:
            kind = "head"
        elif index == 0 and section == "figure" and word in MARKS:
            kind, mark = "mark", word
        elif head == "figure":
            kind = "title"
        elif section == "units":
            kind = "unit"
        elif word in RESERVED or (word == "given" and called) or (word == "in" and ranged):
            kind = "keyword"
        elif called and (section != "figure" or reckoned):
            kind = "builtin" if word in TABLE else "function"
        elif match.group() == "pi":
            kind = "constant"
        yield match, kind, reckoned


class Symbol(NamedTuple):
    """A name in its scope, or a rule ``function``, whose name ignores case."""

    name: str
    scope: str
    function: bool = False


@dataclass(frozen=True)
class Names:
    """The names of one text."""

    text: str

    @cached_property
    def words(self) -> list[Word]:
        return words(self.text)

    def at(self, offset: int) -> Word | None:
        """The word at a place; of two adjacent words, the one that names something."""
        near = [word for word in self.words if word.start <= offset <= word.end]
        return next((word for word in near if symbol(word)), near[-1] if near else None)

    @cached_property
    def places(self) -> dict[Symbol, list[Word]]:
        """Every symbol with its words, in order."""
        found: dict[Symbol, list[Word]] = {}
        given = False
        for word in self.words:
            if given and word.kind == "symbol":  # in ``given('x)`` the variable is meant
                word = word._replace(kind="name", start=word.start + 1, text=word.text[1:])
            if named := symbol(word):
                found.setdefault(named, []).append(word)
            given = (word.text == "(" and given) or word.text.lower() == "given"
        return found

    def definition(self, named: Symbol) -> Word | None:
        """The row, head or ``parameters`` line that declares a name, else its first place."""
        stands = self.places.get(named, [])
        section = "function" if named.function or named.scope else "variables"
        declared = (word for word in stands if word.section == section)
        if named.function:
            return next(declared, None)
        return next(declared, stands[0] if stands else None)

    def known(self, scope: str) -> list[str]:
        """The names that can be written in a scope: its own, and those it shares with the sheet."""
        return sorted({one.name for one in self.places if one.scope == scope and not one.function})

    def functions(self) -> list[str]:
        heads = (word for word in self.words if word.section == "function")
        return [word.text for word in heads if word.kind == "function"]


def symbol(word: Word) -> Symbol | None:
    """The symbol of a word; None if it names nothing of the sheet's own."""
    if word.kind == "function":
        return Symbol(word.text.lower(), "", function=True)
    return Symbol(word.text, word.scope) if word.kind == "name" else None
