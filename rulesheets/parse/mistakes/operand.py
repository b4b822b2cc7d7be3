"""Operands that are missing, or stand side by side."""

from __future__ import annotations

import re

from rulesheets.diagnosis import Diagnosis
from rulesheets.functions import TABLE
from rulesheets.parse.layout import Word
from rulesheets.parse.mistakes.stop import Mistake, Stop
from rulesheets.spelling import closest
from rulesheets.syntax.source import Span

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
