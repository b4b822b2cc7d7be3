"""Explains lines that cannot be read: by a table of mistakes, and by checks that patterns cannot do."""

from __future__ import annotations

import os
import re
import tomllib
import unicodedata
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, NamedTuple

from rulesheets.checks.marks import KINDS, Shape
from rulesheets.diagnosis import PROPERTIES, Diagnosis, closest, error_at, plural
from rulesheets.functions import TABLE
from rulesheets.parse.layout import LONGEST, NESTING, Line
from rulesheets.syntax import Source, Span
from rulesheets.syntax.nodes import (
    Call,
    Condition,
    Equality,
    Expression,
    IfRule,
    Inequality,
    Mark,
    Name,
    Product,
    Quotient,
    RuleBody,
    children,
)
from rulesheets.syntax.program import walk

# --- the table ------------------------------------------------------------------


class Mistake(NamedTuple):
    """A row of ``mistakes.toml``, which explains the columns."""

    pattern: re.Pattern[str]
    code: str
    message: str
    cure: str = ""
    label: str = ""
    kinds: str = "rule row mark"
    near: tuple[str, ...] = ()

    def cured(self, groups: Mapping[str, str]) -> str | None:
        """What to write instead; None if it is not a mistake."""
        if not self.near:
            return self.cure.format(**groups)
        word = groups["at"].lower()
        near = contents()["idioms"].get(word) or closest(word, self.near)
        return f"write {near}" if near else None


@cache
def contents() -> dict[str, Any]:
    """The contents of ``mistakes.toml``."""
    with open(os.path.join(os.path.dirname(__file__), "mistakes.toml"), "rb") as file:
        return tomllib.load(file)


@cache
def _table() -> list[Mistake]:
    """The mistakes with their patterns, compiled."""
    functions = "|".join(name for name, row in TABLE.items() if row.arguments)
    parts = contents()["parts"] | {"FUNCTIONS": functions, "PROPERTIES": "|".join(PROPERTIES)}

    def written(pattern: str) -> str:
        return re.sub(r"<([A-Z]+)>", lambda found: written(parts[found[1]]), pattern)

    def made(row: dict[str, Any]) -> Mistake:
        pattern = written(row["pattern"]).replace("@", _MARK)
        flags = re.IGNORECASE | (re.DOTALL if _MARK in pattern else 0)
        return Mistake(**row | {"pattern": re.compile(pattern, flags)})

    return [*map(made, contents()["mistake"])]


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
        """The diagnosis of a mistake if its pattern matches."""
        groups = {name: _plain(text) for name, text in found.groupdict().items()}
        groups |= {name: "(…)" for name in ("a", "b") if groups.get(name) in ("(", ")")}
        groups |= {"word": self.word, "found": found.group()}
        cure, here = mistake.cured(groups), self.here
        if cure is None:
            return None
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
    if kind in contents()["heads"]:
        return _wrong_head(stop, kind)
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
_STRANGE = re.compile(r"[^\t\n\v\f\r -~]")
_QUOTED = re.compile(r'\[[^\[\]\n]*\]|"[^"\n]*"')


@cache
def _signs() -> dict[str, str]:
    """What to write instead of a character."""
    return {one: cure for alike, cure in contents()["characters"].items() for one in alike}


def strange_characters(source: Source, line: Line) -> Iterator[Diagnosis]:
    """One diagnosis for each kind of character that has no meaning in the code of a line.

    Units in brackets and quoted file names may hold any.
    """
    if not _STRANGE.search(line.code):
        return
    code = _QUOTED.sub(lambda found: " " * len(found.group()), line.code)
    seen = set()
    for place, character in enumerate(code, line.start):
        if not _STRANGE.match(character) or character in _ALLOWED or _is_letter(character):
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


def _wrong_head(stop: Stop, kind: str) -> Diagnosis:
    """The mistake in a ``use``, ``function``, ``parameters`` or ``figure`` line."""
    source, line, note = stop.source, stop.line, contents()["heads"][kind]
    if kind == "use" and (line.comment is not None or '"' in line.code):
        start = max(source.text.rfind('"', line.start, line.end + 2), line.start)
        place = Span(source, start, start + 1)
        return error_at("E123", "a file name is never closed", place, note, label="opened here")
    word = line.code.split()[0].lower()
    return error_at("E118", f"this `{word}` line cannot be read", stop.here, note)


def unknown_section(word: str, span: Span) -> Diagnosis:
    """A word alone that is not a section head."""
    near = closest(word, SECTIONS)
    if word.lower() == "end":
        note = "leave it out: a function ends where the next section begins"
        return error_at("E116", f"`{word}` has nothing to end here", span, note)
    if near is None:
        message = f"`{word}` alone is neither a rule nor the head of a section"
        note = "a rule is an equation, such as V = I*R"
        return error_at(
            "E116", message, span, note, "sections are variables, rules, units, function and figure"
        )
    if near == word.lower():
        return error_at("E116", f"a section head is one word alone: {near}", span, f"write {near}")
    return error_at("E116", f"unknown section `{word}`", span, f"did you mean {near}?")


# --- shapes ---

DEEPEST = 200
"""Levels of a rule's tree: later stages walk trees by recursion, which must end in good time."""
FACTORS = 300
"""Factors of a product, each of which is a level of recursion; they count as one above."""


def wrong_shape(source: Source, line: Line) -> Diagnosis | None:
    """A mistake in the parentheses or the length of a line; None if it may be read."""
    if line.end - line.start > LONGEST:
        message = f"this line is too long to be a rule: {line.end - line.start:,} characters"
        note = f"a rule has at most {LONGEST:,} characters; give parts of it names of their own"
        return error_at("E125", message, Span(source, line.start, line.start + 1), note, label="begins here")
    if line.too_deep is not None:
        return _nested(Span(source, line.too_deep, line.too_deep + 1), f"more than {NESTING} are open here")
    if line.stray:
        place = Span(source, line.stray[0], line.stray[0] + 1)
        note = "remove it, or open a parenthesis before it"
        return error_at("E103", None, place, note, label="nothing is open here")
    if line.unclosed:
        place = Span(source, line.unclosed[-1], line.unclosed[-1] + 1)
        note = f"add {')' * len(line.unclosed)} where it ends"
        return error_at("E102", None, place, note, label="opened here")
    return None


def too_deep(tree: RuleBody | Condition | Expression) -> Diagnosis | None:
    """Whether a tree has more than DEEPEST levels, or a product more than FACTORS, by a loop."""
    if tree.span is None or tree.span.end - tree.span.start <= DEEPEST:
        return None  # a tree has no more levels than its text has characters
    chains = Product, Quotient
    stack: list[tuple[Any, int, int]] = [(tree, 1, 0)]  # the sign of equality is no factor
    while stack:
        node, level, factors = stack.pop()
        here = tree.span if node.span is None else node.span
        if level > DEEPEST:
            return _nested(here.part(0, 1), f"{DEEPEST} levels deep")
        if factors > FACTORS:
            message = f"this expression nests more than {FACTORS} levels deep"
            label = "every factor of a long product is a level"
            return error_at("E217", message, here.part(0, 1), "split it over several rules", label=label)
        if isinstance(node, IfRule):
            arms = filter(None, (node.condition, node.then, node.otherwise))
            stack += ((arm, level + 1, 0) for arm in arms)
            continue
        for part in reversed(children(node)):
            chained = isinstance(node, chains) and part is node.left and isinstance(part, chains)
            stack.append((part, level if chained else level + 1, factors + 1))
    return None


def _nested(span: Span, label: str) -> Diagnosis:
    note = "give the inner parts names of their own, in rules of their own"
    return error_at("E124", "this is nested too deeply", span, note, label=label)


def without_variable(rule: Equality | Inequality) -> Diagnosis | None:
    """The mistake in a rule with numbers only; None for any other.

    A call counts as a variable: its function may have parameters.
    """
    for node in walk(*children(rule)):
        if isinstance(node, Name) or (isinstance(node, Call) and node.function != "pi"):
            return None
    message, note = "this rule has no variable", "write a name on one side: x = 3"
    return error_at("E114", message, rule.span, note, label="only numbers")


# --- lines of a figure ----------------------------------------------------------

MARK_SHAPE = "a line of a figure reads point A = (x, y), line (O, A) or slider (B, 0)"


def _misshapen(stop: Stop) -> Diagnosis:
    """A line that is not a line of a figure, or one that ends before its parentheses."""
    word = (stop.line.code.split() or [""])[0].lower()
    if word in KINDS:
        return error_at(
            "E130", "this line of a figure cannot be read", stop.here, f"write {KINDS[word].example}"
        )
    place = stop.line.place(stop.source)
    near = closest(word, KINDS)
    notes = (f"did you mean {near}?",) if near else (MARK_SHAPE, "a rule stands under `rules`")
    return error_at("E130", None, place, *notes)


def wrong_mark(mark: Mark) -> Diagnosis | None:
    """The mistake in a line of a figure that the grammar accepts: its kind, or a missing part."""
    kind = KINDS.get(mark.kind)
    if kind is None:
        near = closest(mark.kind, KINDS)
        note = f"did you mean {near}?" if near else f"the kinds are {', '.join(KINDS)}"
        place = mark.span and mark.span.part(0, len(mark.kind))
        return error_at("E130", f"a figure has no `{mark.kind}`", place, note)
    count, message = len(mark.arguments), ""
    if kind.named and mark.name is None:
        message = f"this {mark.kind} has no name"
    elif kind.shape is Shape.DIRECTED and mark.name is not None:
        message = f"a {mark.kind} has no name of its own"
    elif count < kind.least or (kind.most is not None and count > kind.most):
        points = plural(kind.least, "point") + ("" if kind.most else " or more")
        expected = points if kind.shape is Shape.POINTS else kind.shape.value
        message = f"a {mark.kind} takes {expected}, not {count or 'none'}"
    if message:
        return error_at("E131", message, mark.span, f"write {kind.example}")
    places = {Shape.POINTS: mark.arguments, Shape.DIRECTED: mark.arguments[:1]}.get(kind.shape, ())
    for argument in places:
        if not isinstance(argument, Name) or "." in argument.name:
            note = f"name a point of the figure, as in {kind.example}"
            return error_at("E131", "this is not the name of a point", argument.span, note)
    return None
