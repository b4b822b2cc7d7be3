"""What is wrong with a row of the variables section."""

from __future__ import annotations

from collections.abc import Callable

from rulesheets.diagnosis import Diagnosis
from rulesheets.parse.mistakes.foreign import foreign_form, section_with_colon, unreadable
from rulesheets.parse.mistakes.operand import (
    MISSING,
    Explanation,
    Mistake,
    Stop,
    bad_number,
    broken_line,
    first_of,
)

_SHAPE = 'a row reads name = value [unit] " comment'


def explain_row(stop: Stop) -> Diagnosis:
    """The most telling diagnosis of a row that the grammar rejects."""
    return first_of(_EXPLANATIONS, stop) or unreadable(stop)


def _broken(stop: Stop) -> Diagnosis | None:
    return broken_line(stop) if stop.word in ("=", "~", ":") else None


def _range(stop: Stop) -> bool:
    word = stop.word
    starts = word is not None and ((word == "[" and "," in stop.words) or word.lower() == "in")
    unclosed = stop.count("IN") and "]" not in stop.words
    return starts or stop.kind_before == "IN" or bool(unclosed)


def _list(stop: Stop) -> bool:
    return stop.word is not None and stop.word.lower() in ("to", "by") and stop.follows_operand


def _rule(stop: Stop) -> bool:
    """A rule, or the beginning of one, in the variables section."""
    word = stop.word
    begins = stop.index == 0 and (stop.kind in ("IF", "CALL") or word == "(")
    reckons = stop.index == 1 and (word in tuple("+-*/^(") or stop.kind in ("_AND", "_OR"))
    equates = word == "=" and "=" in stop.words[: stop.index] and not stop.lacks_operand
    return begins or reckons or equates


def _remark(stop: Stop) -> bool:
    """Words after the value, or after the name, that look like a comment."""
    apart = stop.follows_operand and stop.kind == "NAME" and not stop.adjacent
    return stop.begins_operand and (apart or stop.kind_before == "UNIT")


def _after(what: str, when: Callable[[Stop], bool]) -> Mistake:
    """The row for words that look like a comment after the unit, the name or the value."""
    note = 'if it is a comment, write " {word} …'
    message = f"`{{word}}` cannot follow the {what}"
    return Mistake(lambda stop: _remark(stop) and when(stop), "E120", message, note)


_EXPLANATIONS: tuple[Explanation, ...] = (
    section_with_colon,
    _broken,
    Mistake(_range, "E121", "a range cannot be read", "write in [0, 5], or > 0, < 5"),
    foreign_form,
    Mistake(
        _list,
        *("E190", "lists are not there yet", "give one value here, and use backsolve sweep for many"),
    ),
    Mistake(
        _rule,
        *("E120", "a rule cannot stand in the variables section", f"put it under `rules`; {_SHAPE}"),
    ),
    bad_number,
    Mistake(
        lambda stop: stop.begins_operand and stop.before is None,
        *("E120", "a row begins with the name of a variable", _SHAPE),
    ),
    _after("unit", lambda stop: stop.kind_before == "UNIT"),
    _after("name", lambda stop: stop.index == 1),
    _after("value", lambda stop: True),
    Mistake(
        lambda stop: stop.begins_operand and stop.index == 1,
        *("E120", "something is missing between `{before}` and `{word}`", "write {before} = {word}", "both"),
    ),
    Mistake(
        lambda stop: stop.begins_operand and stop.follows_operand,
        *("E105", "a product needs a `*`", "write {before}*{word}", "both"),
    ),
    Mistake(lambda stop: stop.kind == "UNIT", "E120", "a unit cannot stand here", _SHAPE),
    *MISSING,
)
