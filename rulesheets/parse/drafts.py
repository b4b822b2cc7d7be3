"""Heads of sections, and figures and functions while their lines are read."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from rulesheets.syntax import nodes
from rulesheets.syntax.source import Source, Span

_HEAD = re.compile(
    r"""\s*(?:
        (?P<section>variables|rules|(?<![^\S\n])units)\s*\Z
      | (?P<use>use)\b\s*(?:["\w]|\Z)
      | (?P<parameters>parameters)\b\s*(?:[\w:]|\Z)
      | (?P<function>function)\b\s*(?:[\w(:]|\Z)
      | (?P<figure>figure)\b\s*(?:\s(?!in\s*\[)\w|\Z)
      | (?P<planned>list(?=\s+function\b)|procedure(?=\s+\w|\s*\Z))
    )""",
    re.IGNORECASE | re.VERBOSE,
)
_LONE = re.compile(r"\s*([^\W\d]\w*)\s*(:?)\s*\Z")
_ALMOST = frozenset({"rule", "variable", "equation", "equations", "formula", "formulas"})
"""Lone words that are taken for a misspelt head even where names stand alone."""


def head_word(code: str) -> str | None:
    """The word that makes a line the head of a section, in lower case; None for any other line."""
    found = _HEAD.match(code)
    return str(found[found.lastgroup or 0]).lower() if found else None


def misspelt_head(code: str, section: str) -> str | None:
    """A lone word, perhaps with a colon, that means nothing but a head that it is not."""
    lone = _LONE.match(code)
    if lone and (section != "variables" or lone[2] or lone[1].lower() in _ALMOST):
        return lone[1]
    return None


def nearest_section(word: str, section: str) -> str:
    """The section that most likely begins at a misspelt head, for reading on."""
    if word.lower() in ("variable", "variables"):
        return "variables"
    return "rules" if word.lower() in _ALMOST | {"rules"} and section != "function" else section


@dataclass
class FigureDraft:
    """What is known of a figure so far; ``end`` is where it ends."""

    name: str
    unit: str | None
    start: int
    end: int
    comment: str
    above: tuple[nodes.CommentLine, ...]
    marks: list[nodes.Mark | nodes.CommentLine] = field(default_factory=list)

    def node(self, source: Source) -> nodes.Figure:
        span = Span(source, self.start, self.end)
        return nodes.Figure(self.name, self.unit, tuple(self.marks), self.comment, span, self.above)


@dataclass(frozen=True, slots=True)
class Head:
    """The first line of a function."""

    name: str
    arguments: tuple[str, ...]
    results: tuple[str, ...]


@dataclass
class FunctionDraft:
    """What is known of a function so far; ``begun`` once its rules have begun, ``end`` where it ends."""

    head: Head
    start: int
    end: int
    comment: str
    above: tuple[nodes.CommentLine, ...]
    parameters: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    rules: list[nodes.Rule | nodes.CommentLine] = field(default_factory=list)
    begun: bool = False

    def node(self, source: Source) -> nodes.Function:
        return nodes.Function(
            self.head.name,
            self.head.arguments,
            self.head.results,
            tuple(self.parameters),
            tuple(self.rules),
            self.comment,
            Span(source, self.start, self.end),
            self.above,
            "; ".join(self.remarks),
        )
