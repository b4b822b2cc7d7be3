"""Diagnoses with their codes, places and notes; the catalogue of codes; suggestions for names."""

from __future__ import annotations

import os
import textwrap
from collections.abc import Collection, Iterable, Sequence
from enum import StrEnum
from functools import cache, cached_property
from operator import eq
from typing import NamedTuple

from rulesheets.syntax import Span, escaped

_WIDTH = 100
"""Characters of a source line that an excerpt shows at most."""


_LONG = 500
"""Characters that a message or a note shows at most."""


class Severity(StrEnum):
    """How serious a diagnosis is: an error means that there is no answer, or not the wanted one."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


class Label(NamedTuple):
    """A place with a short explanation. The first label of a diagnosis is the primary one."""

    span: Span
    text: str = ""


class Diagnosis(NamedTuple):
    """One complaint.

    ``code`` is a row of the catalogue (``E101`` …); ``notes`` are whole sentences, the
    suggestion first; ``variables`` are full names.
    """

    code: str
    severity: Severity
    message: str
    labels: tuple[Label, ...] = ()
    notes: tuple[str, ...] = ()
    variables: tuple[str, ...] = ()


def labels(*places: tuple[Span | None, str]) -> tuple[Label, ...]:
    return tuple(Label(span, text) for span, text in places if span is not None)


class RuleSheetError(Exception):
    """A sheet, a variable sheet or a command is wrong. One of the ``diagnoses`` is an error.

    A traceback of Python ends with the messages, their places and cures.
    """

    def __init__(self, *diagnoses: Diagnosis) -> None:
        super().__init__("\n".join(diagnosis.message for diagnosis in diagnoses))
        self.diagnoses = diagnoses

    @cached_property
    def __notes__(self) -> list[str]:  # type: ignore[override]
        """What Python shows below the message: places and cures; of several messages each whole."""
        shown = list(map(render, self.diagnoses))
        return (
            shown if len(shown) > 1 else [rest for one in shown if (rest := one.partition("\n")[2])]
        )

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), self.diagnoses

    def _render_traceback_(self) -> list[str]:
        """Displayed in a notebook instead of a traceback: places and carets, as in a terminal."""
        return [render(diagnosis, color=True) for diagnosis in self.diagnoses]


def refuse(complaints: Iterable[Diagnosis]) -> None:
    """Raise RuleSheetError with the complaints, if there are any."""
    if found := tuple(complaints):
        raise RuleSheetError(*found)


def error(
    code: str, message: str | None = None, *labels: Label, notes: tuple[str, ...] = ()
) -> Diagnosis:
    """An error with a code of the catalogue, whose title is the message unless one is given."""
    if message is None:
        message = catalogue()[code].title
    return Diagnosis(code, Severity.ERROR, message, labels, notes)


def error_at(
    code: str, message: str | None, place: Span | None, *notes: str, label: str = ""
) -> Diagnosis:
    """An error at one place, if the place is known."""
    return error(code, message, *labels((place, label)), notes=notes)


def refusal(
    code: str, message: str, place: Span | None = None, *notes: str, label: str = ""
) -> RuleSheetError:
    """The exception with one error, at a place if it is known."""
    return RuleSheetError(error_at(code, message, place, *notes, label=label))


# --- printing -------------------------------------------------------------------

_COLORS = {Severity.ERROR: "1;31", Severity.WARNING: "1;33", Severity.NOTE: "1;36"}
_BLUE, _BOLD, _GREEN = "1;34", "1", "1;32"


def render(diagnosis: Diagnosis, color: bool = False, width: int | None = None) -> str:
    """The diagnosis as lines of text, without a line end after the last.

    ``error[E104]: message``, then each labelled place as `` --> file:line:column`` with the line of
    the source and carets under the place, then the notes. ``color`` adds ANSI colours; sentences
    are folded to ``width`` columns where there is one.
    """
    return "\n".join(_Rendering(color, width).lines(diagnosis))


class _Rendering(NamedTuple):
    color: bool
    width: int | None = None

    def folded(self, text: str, before: int, margin: int) -> str:
        """A sentence from column ``before``, folded, with ``margin`` before its other lines."""
        if self.width is None or before + len(text) <= self.width:
            return text
        indent = " " * (before - margin)
        first, *rest = textwrap.wrap(text, self.width - margin, initial_indent=indent)
        return "\n".join((first[before - margin :], *(" " * margin + line for line in rest)))

    def paint(self, text: str, style: str) -> str:
        return f"\x1b[{style}m{text}\x1b[0m" if self.color and text else text

    def lines(self, diagnosis: Diagnosis) -> list[str]:
        style = _COLORS[diagnosis.severity]
        head = self.paint(f"{diagnosis.severity}[{diagnosis.code}]", style)
        gutter = max((len(str(label.span.line)) for label in diagnosis.labels), default=1)
        start = len(f"{diagnosis.severity}[{diagnosis.code}]: ")
        message = self.folded(_clipped_text(diagnosis.message), start, 2)
        lines = [f"{head}: {self.paint(message, _BOLD)}"]
        for index, label in enumerate(diagnosis.labels):
            lines += self.excerpt(label, gutter, style if index == 0 else _BLUE)
        margin = " " * gutter
        if diagnosis.labels and diagnosis.notes:
            lines.append(f"{margin} {self.paint('|', _BLUE)}")
        for index, note in enumerate(diagnosis.notes):
            word = "help" if index == 0 else "note"
            start = gutter + len(f" = {word}: ")
            said = self.folded(_clipped_text(note), start, start)
            lines.append(f"{margin} {self.paint('=', _BLUE)} {self.paint(word, _GREEN)}: {said}")
        return lines

    def excerpt(self, label: Label, gutter: int, style: str) -> list[str]:
        """The place, the first line of the source at it, and carets below."""
        span = label.span
        number, column = span.source.place(span.start)
        most = _WIDTH if self.width is None else max(self.width - gutter - 7, 20)
        line, length = span.source.line(number), span.end - span.start
        shown, start, width = _clipped(line, column - 1, length, most)
        margin, bar = " " * gutter, self.paint("|", _BLUE)
        carets = " " * start + self.paint(f"{'^' * width} {escaped(label.text)}".rstrip(), style)
        return [
            f"{margin}{self.paint('-->', _BLUE)} {escaped(span.file)}:{number}:{column}",
            f"{margin} {bar}",
            f"{self.paint(str(number).rjust(gutter), _BLUE)} {bar} {shown}".rstrip(),
            f"{margin} {bar} {carets}",
        ]


def _clipped(line: str, start: int, length: int, most: int) -> tuple[str, int, int]:
    """The part of the line around the place, with the column and the width of the place in it.

    A tab becomes four spaces and other control characters one, so that carets stay below their
    text.
    """
    length = max(1, min(length, len(line) - start))
    first = 0 if start + length < most else max(0, min(start - most // 3, len(line) - most))
    last = min(len(line), first + most)
    before, marked = _plain(line[first:start]), _plain(line[start : min(start + length, last)])
    ahead = "… " if first else ""
    behind = " …" if last < len(line) else ""
    text = ahead + before + marked + _plain(line[start + length : last]) + behind
    return text, len(ahead + before), max(1, len(marked))


def _clipped_text(text: str) -> str:
    """A message or note, truncated if a very long name would fill the screen."""
    return escaped(text if len(text) <= _LONG else text[:_LONG] + " …")


def _plain(text: str) -> str:
    return "".join(c if c.isprintable() else " " for c in text.replace("\t", "    "))


# --- the catalogue of codes --------------------------------------------------


class Entry(NamedTuple):
    """``title``: the mistake, without a full stop; ``cause`` and ``fix`` are sentences."""

    title: str
    cause: str
    fix: str


@cache
def catalogue() -> dict[str, Entry]:
    """The entries of all codes: E1 syntax, E2 names and calls, E3 files, E4 variable sheets,
    command input and units, W6 warnings about units, S5 outcomes of a solve."""
    import tomllib  # neither help nor a sheet without mistakes asks for it

    with open(os.path.join(os.path.dirname(__file__), "catalogue.toml"), "rb") as file:
        return {code: Entry(**row) for code, row in tomllib.load(file).items()}


# --- names that may be meant -------------------------------------------------


def closest(word: str, known: Iterable[str]) -> str | None:
    """The known word that ``word`` most likely stands for; None if none is similar.

    The same letters in another case come first, most of them in the same case, then those in
    another order, then Ratcliff and Obershelp's similarity; of equals, the first in the given
    order.
    """
    candidates = list(dict.fromkeys(known))
    letters = sorted(word.lower())
    if same := [one for one in candidates if sorted(one.lower()) == letters and one != word]:
        return max(same, key=lambda one: (one.lower() == word.lower(), sum(map(eq, one, word))))
    folded = {candidate.lower(): candidate for candidate in reversed(candidates)}
    from difflib import get_close_matches  # only mistakes need it

    near = get_close_matches(word.lower(), list(reversed(folded)), n=1, cutoff=0.6)
    return folded[near[0]] if near else None


def suggestion(word: str, known: Iterable[str]) -> tuple[str, ...]:
    """The note ``did you mean …?``, empty if nothing is similar."""
    near = closest(word, known)
    return (f"did you mean {near}?",) if near else ()


def meant(name: str, variables: Iterable[str]) -> tuple[str, ...]:
    """The note on an unknown variable: the full name of a local, or a similar name."""
    known = list(variables)
    locals_ = [full for full in known if full.endswith(f".{name}")]
    if locals_:
        also = f" (also {', '.join(locals_[1:])})" if len(locals_) > 1 else ""
        return (f"its full name is {locals_[0]}{also}",)
    return suggestion(name, known)


def side_by_side(text: str, names: Collection[str]) -> tuple[str, ...]:
    """The fewest names that make a text; none if they do not."""
    made: dict[int, tuple[str, ...]] = {len(text): ()}
    for k in reversed(range(len(text))):
        found = [(text[k:end], *rest) for end, rest in made.items() if text[k:end] in names]
        made |= {k: min(found, key=len)} if found else {}
    return made.get(0, ())


MAX_NAMED = 8


def plural(count: int, noun: str) -> str:
    """``1 argument``, ``2 arguments``, ``no argument``."""
    if count == 0:
        return f"no {noun}"
    return f"{count} {noun}" + ("s" if count > 1 else "")


def few(names: Sequence[str], most: int) -> str:
    """``a, b, …``: the first of them."""
    return ", ".join([*names[:most], "…"] if len(names) > most else names)


def listed(names: Sequence[str], last: str = "and") -> str:
    """``a, b and c``; long lists are cut."""
    if len(names) > MAX_NAMED:
        rest = "or one of" if last == "or" else last
        return f"{', '.join(names[:MAX_NAMED])} {rest} {len(names) - MAX_NAMED} more"
    return f" {last} ".join(filter(None, (", ".join(names[:-1]), names[-1])))


_PROPERTIES = """
conductivity cp cv density dewpoint enthalpy entropy humrat intenergy molarmass p_sat prandtl
pressure quality relhum soundspeed specheat surfacetension t_sat temperature viscosity volume
wetbulb"""
PROPERTIES = tuple(_PROPERTIES.split())
"""Functions of EES that give a property of a substance."""

WRITE_IN_PYTHON = 'write the function in Python, and name its file by use python "properties.py"'


def empty_range(span: Span | None) -> Diagnosis:
    return wrong_range("this range is empty: its lower end is not below its upper end", span)


def wrong_range(message: str, span: Span | None) -> Diagnosis:
    return error_at("E121", message, span, "write a range as in [0, 5], or as > 0, < 5")
