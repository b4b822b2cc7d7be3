"""What is wrong between ``if`` and ``then``."""

from __future__ import annotations

from rulesheets.diagnosis import Diagnosis
from rulesheets.parse.layout import Word
from rulesheets.parse.mistakes.operand import misspelt_keyword
from rulesheets.parse.mistakes.stop import Mistake, Stop, first_of


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
