"""Explains lines that cannot be read: by a table of mistakes, and by further checks."""

from __future__ import annotations

import os
import re
import unicodedata
from collections.abc import Iterable, Iterator
from functools import cache
from typing import Any, NamedTuple

from rulesheets.checks import KINDS, MARK_SHAPE
from rulesheets.diagnosis import PROPERTIES, Diagnosis, closest, error_at
from rulesheets.functions import TABLE
from rulesheets.parse.layout import STRANGE, Line
from rulesheets.syntax import Source, Span

# --- the table ------------------------------------------------------------------


class Mistake(NamedTuple):
    """A row of ``mistakes.toml``, which explains the columns."""

    pattern: re.Pattern[str]
    code: str
    message: str
    cure: str = ""
    label: str = ""
    kinds: str = "rule"
    near: tuple[str, ...] = ()


@cache
def contents() -> dict[str, Any]:
    """The contents of ``mistakes.toml``."""
    import tomllib  # a right sheet does without

    with open(os.path.join(os.path.dirname(__file__), "mistakes.toml"), "rb") as file:
        return tomllib.load(file)


@cache
def _table() -> list[Mistake]:
    """The mistakes with their patterns, compiled."""
    functions = "|".join(name for name, row in TABLE.items() if row.arguments)
    parts = contents()["parts"] | {"FUNCTIONS": functions, "PROPERTIES": "|".join(PROPERTIES)}
    signs = [{"pattern": sign, "cure": cure} for sign, cure in contents()["signs"].items()]

    def written(pattern: str) -> str:
        return re.sub(r"<([A-Z]+)>", lambda found: written(parts[found[1]]), pattern)

    def made(row: dict[str, Any]) -> Mistake:
        pattern = written(row["pattern"]).replace("@", _MARK)
        flags = re.IGNORECASE | (re.DOTALL if _MARK in pattern else 0)
        return Mistake(**row | {"pattern": re.compile(pattern, flags)})

    rows = contents()["mistake"]
    each = (row | one for row in rows for one in (signs if row["pattern"] == "<SIGNS>" else [{}]))
    return [*map(made, each)]


_MARK = "\ue000"
"""Stands for the ``@`` of a pattern in the text: no line holds it."""
_WINDOW = 400
"""Characters before and behind the stop that patterns are compared with."""
_WORD = re.compile(r"\[[^\]\n]*\]|\d[\d.]*|'?[^\W\d]\w*(?:\.\w+)*|<>|[<>]=|\S")


class Stop:
    """Where reading a line stopped: the text before and after it, and the ``word`` there."""

    def __init__(self, source: Source, line: Line, place: int) -> None:
        self.source, self.line = source, line
        self.start = max(place - _WINDOW, 0)
        self.before, self.after = line.code[self.start : place], line.code[place : place + _WINDOW]
        found = _WORD.match(self.after)
        self.word = found.group() if found else ""

    @property
    def here(self) -> Span:
        """The place of the word; the end of the line without one."""
        if not self.word:
            return Span(self.source, self.line.end, self.line.end + 1)
        return self.span(len(self.before), len(self.before) + len(self.word))

    def span(self, first: int, last: int) -> Span:
        """The place of some of the text, ``before`` and ``after`` together."""
        begin = self.line.start + self.start
        return Span(self.source, begin + first, begin + last)

    def match(self, pattern: re.Pattern[str]) -> re.Match[str] | None:
        """The match of a pattern: one with a mark at the stop, any other around it."""
        if _MARK in pattern.pattern:
            return pattern.search(f"{self.before}{_MARK}{self.after}")
        first, last = len(self.before), len(self.before) + len(self.word)
        found = pattern.finditer(self.before + self.after) if self.word else ()
        return next((one for one in found if one.start() <= first and last <= one.end()), None)

    def explained(self, mistake: Mistake, found: re.Match[str]) -> Diagnosis | None:
        """The diagnosis of a mistake; None if its words are not ``near`` one."""
        groups = {name: _plain(text) for name, text in found.groupdict().items()}
        groups |= {name: "(…)" for name in ("a", "b") if groups.get(name) in ("(", ")")}
        groups |= {"word": self.word, "found": found.group()}
        cure, here = mistake.cure.format(**groups), self.here
        if mistake.near:
            word = groups["at"].lower()
            if not (near := contents()["idioms"].get(word) or closest(word, mistake.near)):
                return None
            cure = f"write {near}"
        if (shown := found.groupdict().get("at")) or _MARK not in mistake.pattern.pattern:
            first, last = found.span("at" if shown else 0)
            last -= len(found.string[first:last]) - len(found.string[first:last].rstrip())
            before = [found.string.count(_MARK, 0, end) for end in (first, last)]
            here = self.span(first - before[0], last - before[1])
        message, label = mistake.message.format(**groups), mistake.label.format(**groups)
        return error_at(mistake.code, message, here, cure, label=label)


def explain_line(source: Source, line: Line, place: int, kind: str) -> Diagnosis:
    """The most helpful diagnosis of a line of a ``kind`` that cannot be read beyond a place."""
    stop = Stop(source, line, place)
    if note := contents()["heads"].get(kind):
        if kind == "use" and (line.comment is not None or '"' in line.code):
            start = max(source.text.rfind('"', line.start, line.end + 2), line.start)
            quote = Span(source, start, start + 1)
            return error_at("E123", "a file name is never closed", quote, note, label="opened here")
        word = line.code.split()[0].lower()
        return error_at("E118", f"this `{word}` line cannot be read", stop.here, note)
    if kind == "mark" and "(" not in stop.before and len(_WORD.findall(stop.before)) < 4:
        return _misshapen(stop)
    for mistake in _table():
        found = stop.match(mistake.pattern) if kind in mistake.kinds else None
        if found is not None and (diagnosis := stop.explained(mistake, found)) is not None:
            return diagnosis
    if not stop.word:
        return error_at("E101", "this line ends too early", stop.here)
    return error_at("E101", f"`{stop.word}` cannot stand here", stop.here, "remove it")


def _plain(text: str | None) -> str:
    """The text of a group, on one line."""
    return " ".join((text or "…").replace(_MARK, "").split())


# --- characters -----------------------------------------------------------------


_ALLOWED = frozenset("≤≥≠±")
_QUOTED = re.compile(r'\[[^\[\]\n]*\]|"[^"\n]*"')


@cache
def _signs() -> dict[str, str]:
    """What to write instead of a character."""
    return {one: cure for alike, cure in contents()["characters"].items() for one in alike}


def strange_characters(source: Source, line: Line) -> Iterator[Diagnosis]:
    """One diagnosis for each kind of character that has no meaning in the code of a line.

    Units in brackets and quoted file names may hold any.
    """
    code = _QUOTED.sub(lambda found: " " * len(found.group()), line.code)
    seen = set()
    for place, character in enumerate(code, line.start):
        if not STRANGE.match(character) or character in _ALLOWED or _is_letter(character):
            continue
        cure = _replacement(character)
        if cure not in seen:
            seen.add(cure)
            name = unicodedata.name(character, "").lower() or f"U+{ord(character):04X}"
            shown = f"{character} ({name})" if character.isprintable() else name
            note = f"write {cure}" if cure else "remove it, or put it into a comment"
            message = f"{shown} has no meaning in a rule sheet"
            yield error_at("E108", message, Span(source, place, place + 1), note)


def _is_letter(character: str) -> bool:
    """Whether it may stand in a name: a letter with no other spelling (π is read as pi)."""
    return (
        character not in _signs()
        and f"a{character}".isidentifier()
        and not unicodedata.combining(character)
        and unicodedata.normalize("NFKC", character) == character
    )


def _replacement(character: str) -> str:
    if character in _signs():
        return _signs()[character]
    category = unicodedata.category(character)
    if category.startswith("Z"):
        return "a plain blank"
    if category == "Cf":
        return "nothing: it is invisible"
    plain = unicodedata.normalize("NFKC", character)
    return plain if plain != character and plain.isprintable() else ""


# --- sections and their heads ---

SECTIONS = ("variables", "rules", "units", "function", "parameters", "use", "figure")


def unknown_section(word: str, span: Span) -> Diagnosis:
    """A word alone that is not a section head."""
    near = closest(word, SECTIONS)
    if word.lower() in ("end", "endif"):
        note = "leave it out: a rule ends with its line, a function where the next section begins"
        return error_at("E116", f"`{word}` has nothing to end here", span, note)
    if near is None:
        message = f"`{word}` alone is neither a rule nor the head of a section"
        note = "a rule is an equation, such as V = I*R"
        heads = "sections are variables, rules, units, function and figure"
        return error_at("E116", message, span, note, heads)
    if near == word.lower():
        return error_at("E116", f"a section head is one word alone: {near}", span, f"write {near}")
    return error_at("E116", f"unknown section `{word}`", span, f"did you mean {near}?")


def misspelt_head(rows: Iterable[Any]) -> list[Diagnosis]:
    """The first row that is a word alone like `rules`, in a sheet without that head."""
    words = (row.span for row in rows if row.span.text.isidentifier())
    words = (span for span in words if closest(span.text, ("rules",)))
    return [unknown_section(span.text, span) for span in words][:1]


# --- lines of a figure ----------------------------------------------------------


def _misshapen(stop: Stop) -> Diagnosis:
    """A line that is not a line of a figure, or one that ends before its parentheses."""
    word = (stop.line.code.split() or [""])[0].lower()
    if word in KINDS:
        message = "this line of a figure cannot be read"
        return error_at("E130", message, stop.here, f"write {KINDS[word].example}")
    place = stop.line.place(stop.source)
    near = closest(word, KINDS)
    notes = (f"did you mean {near}?",) if near else (MARK_SHAPE, "a rule stands under `rules`")
    return error_at("E130", None, place, *notes)
