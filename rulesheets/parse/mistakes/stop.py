"""The place where a line could not be read any further."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from rulesheets.diagnosis import Diagnosis, Label, error
from rulesheets.parse.layout import Line, Word
from rulesheets.syntax.source import Source, Span

OPERATORS = frozenset("+-*/^=<>,;~") | {"<=", ">=", "<>", "≤", "≥", "≠"}
_LINKS = frozenset({"_AND", "_OR", "NOT"})
_OPERANDS = frozenset({"NAME", "NUMBER", "SYMBOL", "LPAR", "GIVEN"})
_ENDS = frozenset({"NAME", "NUMBER", "SYMBOL", "RPAR"})


@dataclass(frozen=True)
class Stop:
    """The words of a line, and the index of the first one that does not fit (their number at the end)."""

    source: Source
    line: Line
    words: tuple[Word, ...]
    index: int

    @property
    def word(self) -> Word | None:
        """The word that does not fit, None at the end of the line."""
        return self.at(self.index)

    @property
    def before(self) -> Word | None:
        return self.at(self.index - 1)

    @property
    def after(self) -> Word | None:
        return self.at(self.index + 1)

    def at(self, index: int) -> Word | None:
        return self.words[index] if 0 <= index < len(self.words) else None

    # --- what kinds of words stand here ---

    @property
    def kind(self) -> str:
        """The kind of the word that does not fit; empty at the end of the line."""
        return self.word.type if self.word is not None else ""

    @property
    def kind_before(self) -> str:
        return self.before.type if self.before is not None else ""

    @property
    def relates(self) -> bool:
        """Whether the word is ``=`` or a sign of order."""
        return self.kind == "RELATION" or self.word == "="

    @property
    def begins_operand(self) -> bool:
        return self.word is not None and self.word.type in _OPERANDS

    @property
    def follows_operand(self) -> bool:
        return self.before is not None and self.before.type in _ENDS

    @property
    def lacks_operand(self) -> bool:
        """Whether something should stand between the word before and this one."""
        before = self.before
        return before is None or before in OPERATORS or before == "(" or before.type in _LINKS

    @property
    def adjacent(self) -> bool:
        """Whether no blank parts the word from the one before."""
        return (
            self.word is not None and self.before is not None and self.word.start_pos == self.before.end_pos
        )

    def line_ends_before(self, index: int) -> bool:
        """Whether a line of text ends between a word and the one before it."""
        if not 0 < index < len(self.words):
            return False
        return "\n" in self.line.code[self.words[index - 1].end_pos : self.words[index].start_pos]

    def count(self, kind: str) -> int:
        """How many words of a kind stand before the stop."""
        return sum(word.type == kind for word in self.words[: self.index])

    @property
    def condition(self) -> tuple[Word, ...] | None:
        """The words after an ``if`` that waits for its ``then``, up to the stop; None outside."""
        for index in range(min(self.index, len(self.words)) - 1, -1, -1):
            if self.words[index].type == "_THEN":
                return None
            if self.words[index].type == "IF":
                return self.words[index + 1 : self.index]
        return None

    # --- places ---

    def span(self, first: Word | None, last: Word | None = None) -> Span:
        """The place of a word, or of all from one to another; the end of the line for None."""
        if first is None:
            return Span(self.source, self.line.end, self.line.end + 1)
        last = last or first
        return Span(self.source, self.line.start + first.start_pos, self.line.start + last.end_pos)

    @property
    def here(self) -> Span:
        return self.span(self.word)

    @property
    def whole(self) -> Span:
        return self.span(self.words[0], self.words[-1])

    def text(self, first: Word, last: Word) -> str:
        return " ".join(self.line.code[first.start_pos : last.end_pos].split())

    def error(self, code: str, message: str | None, span: Span, label: str, *notes: str) -> Diagnosis:
        return error(code, message, Label(span, label), notes=notes)


@dataclass(frozen=True, slots=True)
class Mistake:
    """One row of a table of mistakes: ``when`` it is this one, and what is said where.

    ``at`` is ``here``, ``before``, ``both`` (the word before and the one here) or ``whole``. Texts may name
    ``{word}``, ``{before}`` and ``{after}``, the words around the stop.
    """

    when: Callable[[Stop], object]
    code: str
    message: str
    note: str
    at: str = "here"
    label: str = ""

    def __call__(self, stop: Stop) -> Diagnosis | None:
        if not self.when(stop):
            return None
        words = {"word": stop.word, "before": stop.before, "after": stop.after}
        before, word = stop.before or stop.word, stop.word
        places = {"here": (word,), "before": (before,), "both": (before, word)}
        span = stop.whole if self.at == "whole" else stop.span(*places[self.at])
        label, note = self.label.format(**words), self.note.format(**words)
        return stop.error(self.code, self.message.format(**words), span, label, note)


Explanation = Callable[[Stop], Diagnosis | None]


def first_of(explanations: Iterable[Explanation], stop: Stop) -> Diagnosis | None:
    """What the first of the explanations says that applies."""
    return next((found for explain in explanations if (found := explain(stop)) is not None), None)
