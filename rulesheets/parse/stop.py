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

    @property
    def relates(self) -> bool:
        """Whether it is ``=`` or a sign of order."""
        return self.type == "RELATION" or self == "="


_NONE = Word("", "", 0, end_pos=0)
"""What stands before the first word of a line and after the last: empty, and of no kind."""


@dataclass(frozen=True)
class Stop:
    """The words of a line, and the index of the first one that does not fit (their number at the end)."""

    source: Source
    line: Line
    words: tuple[Word, ...]
    index: int

    @property
    def word(self) -> Word:
        """The word that does not fit."""
        return self.at(self.index)

    @property
    def before(self) -> Word:
        return self.at(self.index - 1)

    @property
    def after(self) -> Word:
        return self.at(self.index + 1)

    def at(self, index: int) -> Word:
        return self.words[index] if 0 <= index < len(self.words) else _NONE

    # --- what kinds of words stand here ---

    @property
    def begins_operand(self) -> bool:
        return self.word.type in _OPERANDS

    @property
    def follows_operand(self) -> bool:
        return self.before.type in _ENDS

    @property
    def lacks_operand(self) -> bool:
        """Whether something should stand between the word before and this one."""
        before = self.before
        return not before or before in OPERATORS or before == "(" or before.type in _LINKS

    @property
    def adjacent(self) -> bool:
        """Whether no blank parts the word from the one before."""
        return bool(self.word and self.before) and self.word.start_pos == self.before.end_pos

    def line_ends_before(self, index: int) -> bool:
        """Whether a line of text ends between a word and the one before it."""
        between = self.line.code[self.at(index - 1).end_pos : self.at(index).start_pos]
        return 0 < index < len(self.words) and "\n" in between

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

    def span(self, first: Word, last: Word | None = None) -> Span:
        """The place of a word, or of all from one to another; the end of the line for none."""
        if not first:
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


Explanation = Callable[[Stop], Diagnosis | None]


def first_of(explanations: Iterable[Explanation], stop: Stop) -> Diagnosis | None:
    """What the first of the explanations says that applies."""
    return next((found for explain in explanations if (found := explain(stop)) is not None), None)


# --- two operands side by side --------------------------------------------------

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
    before, word = stop.before, stop.word
    if not (stop.begins_operand and stop.follows_operand):
        return None
    if found := first_of((bad_number, open_across_lines, misspelt_keyword), stop):
        return found
    span = stop.span(before, word)
    if "SYMBOL" in (before.type, word.type):
        message = f"something is missing between `{before}` and `{word}`"
        return said("E104", message, span, f"compare them: {before} = {word}")
    if before.type == "NAME" and word.type in ("NAME", "NUMBER") and before.lower() in TABLE:
        return said(
            "E118", f"{before} needs parentheses around its argument", span, f"write {before}({word})"
        )
    note = f"write {'(…)' if before == ')' else before}*{'(…)' if word == '(' else word}"
    return said("E105", "a product needs a `*`", span, note, label="two factors side by side")


def bad_number(stop: Stop) -> Diagnosis | None:
    """``1.2.3`` and ``1e``, which are cut into two words."""
    before, word = stop.before, stop.word
    if before.type != "NUMBER" or not stop.adjacent:
        return None
    if word.type != "NUMBER" and not (word.type == "NAME" and word.lower() == "e"):
        return None
    found = _NUMBERLIKE.match(stop.line.code, before.start_pos)
    assert found is not None
    note = "a number has one decimal point"
    if word.type == "NAME":
        note = f"an exponent needs digits, as in {before}e-3"
        note += f"; for a product with the variable e write {before}*e"
    span = Span(stop.source, stop.line.start + found.start(), stop.line.start + found.end())
    return said("E107", f"{found.group()} is not a number", span, note)


def misspelt_keyword(stop: Stop) -> Diagnosis | None:
    """A word near to a keyword, at the beginning of the line or where ``then`` or ``else`` is due."""
    wrong, near = stop.word, None
    if wrong.type == "NAME" and len(wrong) > 1 and stop.count("IF"):
        near = closest(wrong, ("then", "else")) or _IDIOMS.get(wrong.lower())
    if near is None and stop.before.type == "NAME" and stop.index == 1:
        wrong = stop.before
        if wrong.lower() in ("variables", "rules"):
            message = f"`{wrong}` stands alone on its line"
            return said("E118", message, stop.here, "put this on the next line")
        first = closest(wrong, _FIRST) or ""
        alike = abs(len(first) - len(wrong)) <= 2 and first[:1] == wrong[0].lower()
        near = _IDIOMS.get(wrong.lower()) or (first if alike else None)
    if near is None:
        return None
    return said("E117", f"unknown keyword `{wrong}`", stop.span(wrong), f"write {near}")


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
    return said("E102", "this parenthesis is open at the end of its line", stop.span(open_ones[-1]), note)


# --- nothing where something should stand ---------------------------------------

_ON_THIS_LINE = "write the value that belongs there, on this line or the next"
_SYMBOL = "\" begins a comment; a symbolic value has an apostrophe: 'open"


def missing(stop: Stop) -> Diagnosis | None:
    """Nothing where a value, a condition or a rule should stand."""
    before, word = stop.before, stop.word
    here, both = stop.span(before or word), stop.span(before or word, word)
    if before.type in ("_THEN", "_ELSE"):
        return said("E104", f"a rule is missing after `{before}`", here, "write … = …")
    if before.type == "IF":
        return said("E104", "a condition is missing after `if`", here, "write if x > 0 then …")
    if before.type in _LINKS:
        note = f"write another comparison, or remove the `{before}`"
        return said("E104", f"a condition is missing after `{before}`", here, note)
    if not word and stop.lacks_operand:
        note = _SYMBOL if before == "=" and stop.line.comment else _ON_THIS_LINE
        message = f"something is missing after `{before or 'x'}`"
        return said("E104", message, here, note, label="the line ends here")
    if not before:
        return said("E104", f"something is missing before `{word}`", here, "write what belongs there")
    if before == "(" and word == ")":
        return said("E104", "there is nothing between these parentheses", both, "write a value there")
    if stop.lacks_operand:
        note = f"write a value there, or remove the `{before if word == ')' else word}`"
        return said("E104", f"something is missing between `{before}` and `{word}`", both, note)
    return None


def broken_line(stop: Stop, first: int = 0) -> Diagnosis | None:
    """An operator at the end of a line took in the next one, which then has a sign too many.

    Looks for the end of a line between the word ``first`` and the stop.
    """
    for index in range(stop.index - 2, first - 1, -1):
        if stop.line_ends_before(index + 1):
            word, label = stop.words[index], "so the next line is read as part of this one"
            note = f"complete the line, or remove the `{word}`"
            return said("E104", f"something is missing after `{word}`", stop.span(word), note, label=label)
    return None


# --- conditions -----------------------------------------------------------------


def explain_condition(stop: Stop) -> Diagnosis | None:
    """A diagnosis if reading stops in a condition, or at a ``then`` or ``else`` without one."""
    condition, word = stop.condition, stop.word
    if condition is None:
        return _stray(stop)
    if stop.lacks_operand:
        return None
    if not word or word in (",", ":", "{") or (stop.begins_operand and stop.follows_operand):
        if misspelt := misspelt_keyword(stop):
            return misspelt
        if all(later.type != "_THEN" for later in stop.words[stop.index :]):
            return _then_missing(stop)
        return _no_condition(stop, condition) if word == "," else None
    if word.type in ("_THEN", "_AND", "_OR") or word == ")":
        return _no_condition(stop, condition)
    if word.relates:
        return _chain(stop, condition)
    return _then_missing(stop) if word.type == "_ELSE" else None


def _stray(stop: Stop) -> Diagnosis | None:
    """A ``then`` or ``else`` that no ``if`` waits for."""
    word, armed = stop.word, stop.count("IF")
    stray = word.type == "_THEN" or (word.type == "_ELSE" and armed <= stop.count("_ELSE"))
    if not stray or stop.after == "=":
        return None
    if armed:
        note = "use else if for a chain of conditions"
        return said("E112", f"there is one `{word}` too many", stop.here, note)
    return said("E112", f"`{word}` has no `if`", stop.here, "write if condition then rule else rule")


def _then_missing(stop: Stop) -> Diagnosis:
    first = max(i for i, word in enumerate(stop.words[: stop.index]) if word.type == "IF")
    place = stop.span(stop.word or stop.before)
    label = "it should stand before this" if stop.word else "it should follow here"
    note = f"write {stop.text(stop.words[first], stop.words[stop.index - 1])} then …"
    return said("E109", "`then` is missing", place, note, label=label)


def _no_condition(stop: Stop, condition: tuple[Word, ...]) -> Diagnosis | None:
    piece = _piece(condition)
    if not piece:
        note = "write if x > 0 then …"
        return said("E110", "a condition is missing", stop.here, note, label="before this")
    if any(word.relates for word in piece):
        return None
    text, place = stop.text(piece[0], piece[-1]), stop.span(piece[0], piece[-1])
    note = f"compare it with something, as in {text} > 0"
    return said("E110", f"{text} is not a condition: it is neither true nor false", place, note)


def _chain(stop: Stop, condition: tuple[Word, ...]) -> Diagnosis | None:
    """``0 < x < 1``: a sign of order after a comparison."""
    piece = _piece(condition)
    places = [index for index, word in enumerate(piece) if word.relates]
    if not places or places[-1] + 1 == len(piece):
        return None
    middle, whole = stop.text(piece[places[-1] + 1], piece[-1]), stop.text(piece[0], piece[-1])
    rest = stop.words[stop.index + 1 :]  # what follows, up to the end of this part of the condition
    ends = (i for i, word in enumerate(rest) if word.type in ("_THEN", "_AND", "_OR") or word in (",", ")"))
    last = next(ends, len(rest)) - 1
    third = stop.text(rest[0], rest[last]) if last >= 0 else "…"
    note = f"write two comparisons: {whole} and {middle} {stop.word} {third}"
    return said("E110", "a comparison has two sides only", stop.here, note, label="a third one follows")


def _piece(condition: tuple[Word, ...]) -> tuple[Word, ...]:
    """What stands after the last ``and``, ``or`` or ``not``, parentheses around it left out."""
    start = 0
    for index, word in enumerate(condition):
        if word.type in _LINKS or (start and word == ","):
            start = index + 1
    piece = condition[start:]
    while len(piece) > 1 and piece[0] == "(" and sum(w == "(" for w in piece) > sum(w == ")" for w in piece):
        piece = piece[1:]
    return piece
