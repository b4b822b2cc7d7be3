"""What is wrong with a row of the variables section."""

from __future__ import annotations

from collections.abc import Callable

from rulesheets.diagnosis import Diagnosis
from rulesheets.parse.mistakes.foreign import foreign_form, unreadable
from rulesheets.parse.mistakes.heads import unknown_section
from rulesheets.parse.mistakes.operand import bad_number, broken_line, missing_operand
from rulesheets.parse.mistakes.stop import Stop

_SHAPE = 'a row reads name = value [unit] " comment'


def explain_row(stop: Stop) -> Diagnosis:
    """The most telling diagnosis of a row that the grammar rejects."""
    for explain in _EXPLANATIONS:
        found = explain(stop)
        if found is not None:
            return found
    return unreadable(stop)


def _section(stop: Stop) -> Diagnosis | None:
    if stop.word == ":" and stop.index == 1 and stop.after is None:
        return unknown_section(stop.words[0], stop.whole)
    return None


def _broken(stop: Stop) -> Diagnosis | None:
    return broken_line(stop) if stop.word in ("=", "~", ":") else None


def _range(stop: Stop) -> Diagnosis | None:
    word, before = stop.word, stop.before
    starts = word is not None and ((word == "[" and "," in stop.words) or word.lower() == "in")
    inside = before is not None and before.type == "IN"
    unclosed = stop.count("IN") and "]" not in stop.words
    if not (starts or inside or unclosed):
        return None
    return stop.error("E121", "a range cannot be read", stop.here, "", "write in [0, 5], or > 0, < 5")


def _list(stop: Stop) -> Diagnosis | None:
    if stop.word is None or stop.word.lower() not in ("to", "by") or not stop.follows_operand:
        return None
    return stop.error(
        "E190",
        "lists are not there yet",
        stop.here,
        "",
        "give one value here, and use backsolve sweep for many",
    )


def _rule(stop: Stop) -> Diagnosis | None:
    """A rule, or the beginning of one, in the variables section."""
    word = stop.word
    if word is None:
        return None
    begins = stop.index == 0 and (word.type in ("IF", "CALL") or word == "(")
    reckons = stop.index == 1 and (word in tuple("+-*/^(") or word.type in ("_AND", "_OR"))
    equates = word == "=" and "=" in stop.words[: stop.index] and not stop.lacks_operand
    if not (begins or reckons or equates):
        return None
    return stop.error(
        "E120",
        "a rule cannot stand in the variables section",
        stop.here,
        "",
        f"put it under `rules`; {_SHAPE}",
    )


def _remark(stop: Stop) -> Diagnosis | None:
    """Words after the value, or after the name, that look like a comment or a value."""
    word, before = stop.word, stop.before
    if word is None or not stop.begins_operand:
        return None
    if before is None:
        return stop.error("E120", "a row begins with the name of a variable", stop.here, "", _SHAPE)
    if before.type == "UNIT" or (stop.follows_operand and word.type == "NAME" and not stop.adjacent):
        return stop.error(
            "E120",
            f"`{word}` cannot follow the {'unit' if before.type == 'UNIT' else _what(stop)}",
            stop.here,
            "",
            f'if it is a comment, write " {word} …',
        )
    if stop.index == 1:
        return stop.error(
            "E120",
            f"something is missing between `{before}` and `{word}`",
            stop.span(before, word),
            "",
            f"write {before} = {word}",
        )
    if stop.follows_operand:
        return stop.error(
            "E105", "a product needs a `*`", stop.span(before, word), "", f"write {before}*{word}"
        )
    return None


def _what(stop: Stop) -> str:
    return "name" if stop.index == 1 else "value"


def _second_unit(stop: Stop) -> Diagnosis | None:
    if stop.word is not None and stop.word.type == "UNIT":
        return stop.error("E120", "a unit cannot stand here", stop.here, "", _SHAPE)
    return None


_EXPLANATIONS: tuple[Callable[[Stop], Diagnosis | None], ...] = (
    _section,
    _broken,
    _range,
    foreign_form,
    _list,
    _rule,
    bad_number,
    _remark,
    _second_unit,
    missing_operand,
)
