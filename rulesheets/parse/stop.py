"""Where reading a line stopped, and what was wrong with the term or the condition there."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from lark import Token

from rulesheets.diagnosis import Diagnosis, closest, said
from rulesheets.functions import TABLE
from rulesheets.parse.layout import Line
from rulesheets.syntax import Source, Span

OPERATORS = frozenset("+-*/^=<>,;~") | {"<=", ">=", "<>", "≤", "≥", "≠"}
_LINKS = frozenset({"_AND", "_OR", "NOT"})
_OPERANDS = frozenset({"NAME", "NUMBER", "SYMBOL", "LPAR", "GIVEN"})
_ENDS = frozenset({"NAME", "NUMBER", "SYMBOL", "RPAR"})


class Word(Token):
    """A word with its kind (``type``) and its place in the code."""

    start_pos: int
    end_pos: int


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
        return said(code, message, span, *notes, label=label)


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


_NUMBERLIKE = re.compile(r"[\d.][\d.]*(?:e[+-]?[\d.]*)?", re.IGNORECASE)
_FIRST = ("call", "function", "parameters", "variables", "rules", "procedure")
_NOTHING = "the rule alone: it needs no keyword"
_IDIOMS = {
    "iff": "if",
    "when": "if",
    "elseif": "else if",
    "elsif": "else if",
    "elif": "else if",
    "let": _NOTHING,
    "set": _NOTHING,
    "def": "function",
    "subprogram": "function",
    "module": "function",
    "include": "use",
    "import": "use",
}


def two_operands(stop: Stop) -> Diagnosis | None:
    """An operand right after another: a bad number, a misspelt keyword, or a product without its sign."""
    if not (stop.begins_operand and stop.follows_operand):
        return None
    return bad_number(stop) or open_across_lines(stop) or misspelt_keyword(stop) or _product(stop)


def bad_number(stop: Stop) -> Diagnosis | None:
    """``1.2.3`` and ``1e``, which are cut into two words."""
    before, word = stop.before, stop.word
    if before is None or word is None or before.type != "NUMBER" or not stop.adjacent:
        return None
    if word.type != "NUMBER" and not (word.type == "NAME" and word.lower() == "e"):
        return None
    found = _NUMBERLIKE.match(stop.line.code, before.start_pos)
    assert found is not None
    text = found.group()
    if word.type == "NAME":
        note = (
            f"an exponent needs digits, as in {before}e-3; for a product with the variable e write {before}*e"
        )
    else:
        note = "a number has one decimal point"
    start = stop.line.start + before.start_pos
    span = Span(stop.source, start, start + len(text))
    return stop.error("E107", f"{text} is not a number", span, "", note)


def misspelt_keyword(stop: Stop) -> Diagnosis | None:
    """A word near to a keyword, at the beginning of the line or where ``then`` or ``else`` is due."""
    before, word = stop.before, stop.word
    if word is not None and word.type == "NAME" and stop.count("IF"):
        near = closest(word, ("then", "else")) or _IDIOMS.get(word.lower())
        if near is not None and len(word) > 1:
            return _misspelt(stop, word, near)
    if before is not None and before.type == "NAME" and stop.index == 1:
        if before.lower() in ("variables", "rules"):
            message = f"`{before}` stands alone on its line"
            return stop.error("E118", message, stop.here, "", "put this on the next line")
        near = _IDIOMS.get(before.lower()) or _near_first(before)
        if near is not None:
            return _misspelt(stop, before, near)
    return None


def _near_first(word: str) -> str | None:
    near = closest(word, _FIRST)
    return (
        near if near is not None and abs(len(near) - len(word)) <= 2 and near[0] == word[0].lower() else None
    )


def _misspelt(stop: Stop, word: str, near: str) -> Diagnosis:
    place = stop.word if word is stop.word else stop.before
    return stop.error("E117", f"unknown keyword `{word}`", stop.span(place), "", f"write {near}")


def _product(stop: Stop) -> Diagnosis:
    before, word = stop.before, stop.word
    assert before is not None and word is not None
    span = stop.span(before, word)
    if "SYMBOL" in (before.type, word.type):
        note = f"compare them: {before} = {word}"
        return stop.error("E104", f"something is missing between `{before}` and `{word}`", span, "", note)
    if before.type == "NAME" and word.type in ("NAME", "NUMBER") and before.lower() in TABLE:
        note = f"write {before}({word})"
        return stop.error("E118", f"{before} needs parentheses around its argument", span, "", note)
    left = "(…)" if before == ")" else str(before)
    right = "(…)" if word == "(" else str(word)
    return stop.error(
        "E105",
        "a product needs a `*`",
        span,
        "two factors side by side",
        f"write {left}*{right}",
    )


_ON_THIS_LINE = "write the value that belongs there, on this line or the next"
_SYMBOL = "\" begins a comment; a symbolic value has an apostrophe: 'open"
_BETWEEN = "something is missing between `{before}` and `{word}`"

MISSING = (
    Mistake(
        lambda stop: stop.kind_before in ("_THEN", "_ELSE"),
        *("E104", "a rule is missing after `{before}`", "write … = …", "before"),
    ),
    Mistake(
        lambda stop: stop.kind_before == "IF",
        *("E104", "a condition is missing after `if`", "write if x > 0 then …", "before"),
    ),
    Mistake(
        lambda stop: stop.kind_before in ("_AND", "_OR", "NOT"),
        *("E104", "a condition is missing after `{before}`"),
        *("write another comparison, or remove the `{before}`", "before"),
    ),
    Mistake(
        lambda stop: stop.word is None and stop.before == "=" and stop.line.comment,
        *("E104", "something is missing after `{before}`", _SYMBOL, "before", "the line ends here"),
    ),
    Mistake(
        lambda stop: stop.word is None and stop.lacks_operand,
        *("E104", "something is missing after `{before}`", _ON_THIS_LINE, "before", "the line ends here"),
    ),
    Mistake(
        lambda stop: stop.before is None,
        *("E104", "something is missing before `{word}`", "write what belongs there"),
    ),
    Mistake(
        lambda stop: stop.before == "(" and stop.word == ")",
        *("E104", "there is nothing between these parentheses", "write a value there", "both"),
    ),
    Mistake(
        lambda stop: stop.lacks_operand and stop.word == ")",
        *("E104", _BETWEEN, "write a value there, or remove the `{before}`", "both"),
    ),
    Mistake(
        lambda stop: stop.lacks_operand,
        *("E104", _BETWEEN, "write a value there, or remove the `{word}`", "both"),
    ),
)
"""Nothing where a value, a condition or a rule should stand."""


def broken_line(stop: Stop, first: int = 0) -> Diagnosis | None:
    """An operator at the end of a line took in the next one, which then has a sign too many.

    Looks for the end of a line between the word ``first`` and the stop.
    """
    for index in range(stop.index - 2, first - 1, -1):
        word = stop.words[index]
        if stop.line_ends_before(index + 1):
            return stop.error(
                "E104",
                f"something is missing after `{word}`",
                stop.span(word),
                "so the next line is read as part of this one",
                f"complete the line, or remove the `{word}`",
            )
    return None


def open_across_lines(stop: Stop) -> Diagnosis | None:
    """A parenthesis that took in the next line, which begins right before the stop."""
    last = next((i for i in range(stop.index, 0, -1) if stop.line_ends_before(i)), None)
    if last is None or stop.index - last > 1:
        return None
    open_ones: list[Word] = []
    for word in stop.words[:last]:
        if word == "(":
            open_ones.append(word)
        elif word == ")":
            open_ones.pop()
    if not open_ones:
        return None
    note = "add ) where it ends, or an operator if it goes on in the next line"
    return stop.error(
        "E102", "this parenthesis is open at the end of its line", stop.span(open_ones[-1]), "", note
    )


def explain_condition(stop: Stop) -> Diagnosis | None:
    """A diagnosis if reading stops in a condition, or at a ``then`` or ``else`` without one."""
    condition = stop.condition
    if condition is None:
        return first_of(_WITHOUT_IF, stop)
    if stop.lacks_operand:
        return None
    if stop.word is None or stop.word in (",", ":", "{") or (stop.begins_operand and stop.follows_operand):
        return _end_of_condition(stop, condition)
    if stop.word.type in ("_THEN", "_AND", "_OR") or stop.word == ")":
        return _no_condition(stop, condition)
    if stop.relates:
        return _chain(stop, condition)
    if stop.word.type == "_ELSE":
        return _then_missing(stop)
    return None


def _relates(word: Word) -> bool:
    return word.type == "RELATION" or word == "="


def _piece(condition: tuple[Word, ...]) -> tuple[Word, ...]:
    """What stands after the last ``and``, ``or`` or ``not``, parentheses around it left out."""
    start = 0
    for index, word in enumerate(condition):
        if word.type in ("_AND", "_OR", "NOT") or (start and word == ","):
            start = index + 1
    piece = condition[start:]
    while len(piece) > 1 and piece[0] == "(" and sum(w == "(" for w in piece) > sum(w == ")" for w in piece):
        piece = piece[1:]
    return piece


def _next_piece(stop: Stop) -> str:
    """What follows the stop, up to the end of this part of the condition."""
    following = stop.words[stop.index + 1 :]
    ends = (
        i for i, word in enumerate(following) if word.type in ("_THEN", "_AND", "_OR") or word in (",", ")")
    )
    last = next(ends, len(following)) - 1
    return stop.text(following[0], following[last]) if last >= 0 else "…"


def _stray(stop: Stop) -> bool:
    """A ``then`` or ``else`` that no ``if`` waits for."""
    if stop.kind not in ("_THEN", "_ELSE") or stop.after == "=":
        return False
    return stop.kind == "_THEN" or stop.count("IF") <= stop.count("_ELSE")


_WITHOUT_IF = (
    Mistake(
        lambda stop: _stray(stop) and stop.count("IF"),
        *("E112", "there is one `{word}` too many", "use else if for a chain of conditions"),
    ),
    Mistake(_stray, "E112", "`{word}` has no `if`", "write if condition then rule else rule"),
)


def _end_of_condition(stop: Stop, condition: tuple[Word, ...]) -> Diagnosis | None:
    misspelt = misspelt_keyword(stop)
    if misspelt is not None:
        return misspelt
    later = {word.type for word in stop.words[stop.index :]}
    if "_THEN" in later:
        return _no_condition(stop, condition) if stop.word == "," else None
    return _then_missing(stop)


def _then_missing(stop: Stop) -> Diagnosis:
    first = max(i for i in range(min(stop.index, len(stop.words))) if stop.words[i].type == "IF")
    condition = stop.text(stop.words[first], stop.words[stop.index - 1])
    place = stop.here if stop.word is not None else stop.span(stop.before)
    label = "it should stand before this" if stop.word is not None else "it should follow here"
    return stop.error("E109", "`then` is missing", place, label, f"write {condition} then …")


def _no_condition(stop: Stop, condition: tuple[Word, ...]) -> Diagnosis | None:
    piece = _piece(condition)
    if any(map(_relates, piece)):
        return None
    if not piece:
        return stop.error("E110", "a condition is missing", stop.here, "before this", "write if x > 0 then …")
    text = stop.text(piece[0], piece[-1])
    return stop.error(
        "E110",
        f"{text} is not a condition: it is neither true nor false",
        stop.span(piece[0], piece[-1]),
        "",
        f"compare it with something, as in {text} > 0",
    )


def _chain(stop: Stop, condition: tuple[Word, ...]) -> Diagnosis | None:
    piece = _piece(condition)
    places = [index for index, word in enumerate(piece) if _relates(word)]
    if not places or places[-1] + 1 == len(piece):
        return None
    middle = stop.text(piece[places[-1] + 1], piece[-1])
    third = _next_piece(stop)
    whole = stop.text(piece[0], piece[-1])
    return stop.error(
        "E110",
        "a comparison has two sides only",
        stop.here,
        "a third one follows",
        f"write two comparisons: {whole} and {middle} {stop.word} {third}",
    )
