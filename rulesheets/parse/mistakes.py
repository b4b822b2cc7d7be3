"""What is wrong with a rule, a row of the variables section, or a line of a figure."""

from __future__ import annotations

from rulesheets.checks.marks import KINDS, Shape
from rulesheets.diagnosis import Diagnosis, closest, plural, said
from rulesheets.parse.foreign import foreign_form, section_with_colon, unknown_section, unreadable
from rulesheets.parse.stop import (
    Explanation,
    Stop,
    bad_number,
    broken_line,
    explain_condition,
    first_of,
    missing,
    open_across_lines,
    two_operands,
)
from rulesheets.syntax.nodes import Call, Condition, Equality, Expression, Inequality, Mark, Name, children

_KEYWORDS = frozenset({"IF", "_THEN", "_ELSE", "CALL", "_AND", "_OR", "NOT"})


def explain_line(stop: Stop, kind: str) -> Diagnosis:
    """The most telling diagnosis of a rule, a row or a mark that the grammar rejects."""
    if kind == "mark" and stop.index < 4 and "(" not in stop.words[: stop.index]:
        return _misshapen(stop)
    return first_of(_MISTAKES[kind], stop) or unreadable(stop)


# --- rules ----------------------------------------------------------------------


def _reserved(stop: Stop) -> Diagnosis | None:
    """``and = 3``: a keyword where a name was meant."""
    for word, after in ((stop.word, stop.after), (stop.before, stop.word)):
        armed = word.type in ("_THEN", "_ELSE") and stop.count("IF")
        if word.type in _KEYWORDS and after == "=" and not armed:
            message = f"`{word}` is a keyword and cannot be the name of a variable"
            return said("E127", message, stop.span(word), f"give the variable another name, such as {word}_1")
    return None


def _second_equals(stop: Stop) -> Diagnosis | None:
    if stop.word != "=" or stop.lacks_operand or "=" not in stop.words[: stop.index]:
        return None
    first = max(index for index in range(stop.index) if stop.words[index] == "=")
    broken = broken_line(stop, first)
    if broken is not None:
        return broken
    a = stop.text(stop.words[_start_of_side(stop, first)], stop.words[first - 1])
    b = stop.text(stop.words[first + 1], stop.before)
    c = stop.text(stop.after, stop.words[-1]) if stop.after else "…"
    note = f"write two rules: {a} = {b} and {b} = {c}"
    return said("E106", "a rule has one equals sign", stop.here, note, label="a second one")


def _start_of_side(stop: Stop, end: int) -> int:
    """Index of the first word of the side that ends before a word."""
    arms = (i + 1 for i in range(end - 1, -1, -1) if stop.words[i].type in ("_THEN", "_ELSE"))
    return next(arms, 0)


def _equation_and_inequality(stop: Stop) -> Diagnosis | None:
    """``x = a < b`` and ``0 < x = a``."""
    signs = [word for word in stop.words[: stop.index] if word.relates]
    if not stop.word.relates or not signs or stop.condition is not None or stop.lacks_operand:
        return None
    message, note = "an equation and an inequality are two rules", "write each of them on a line of its own"
    return said("E106", message, stop.here, note, label=f"after {signs[-1]}")


def _decimal_comma(stop: Stop) -> Diagnosis | None:
    before, after = stop.before, stop.after
    if stop.word != "," or not stop.adjacent or (before.type, after.type) != ("NUMBER", "NUMBER"):
        return None
    place = stop.span(before, after)
    return said("E107", "a decimal comma cannot be read", place, f"write {before}.{after}")


def _no_equation(stop: Stop) -> Diagnosis | None:
    """A line, or an arm of a conditional, that has no equals sign."""
    if (stop.word and stop.word.type != "_ELSE") or not stop.follows_operand:
        return None
    if len(stop.words) == 1:
        return unknown_section(stop.words[0], stop.whole)
    place = stop.span(stop.words[_start_of_side(stop, stop.index)], stop.before)
    return said("E113", "this is no rule: it has no equals sign", place, "a rule is an equation: write … = …")


def _no_value(stop: Stop) -> Diagnosis | None:
    """A ``call`` or an ``if`` where a value should stand."""
    if not stop.lacks_operand or stop.word.type not in ("CALL", "IF"):
        return None
    if stop.word.type == "IF":
        message, note = (
            "`if` chooses between rules, not between values",
            "write if a > 0 then x = 1 else x = 2",
        )
        return said("E101", message, stop.here, note)
    note = "leave out call: x = f(a), where f has one result; or write call f(a; x) as a rule of its own"
    return said("E101", "`call` begins a rule and gives no value", stop.here, note)


def _misplaced(stop: Stop) -> Diagnosis | None:
    """A word that has its place elsewhere: in conditions, in calls, or in the variables section."""
    before, word, here = stop.before, stop.word, stop.here
    called = any(first.type == "CALL" for first in stop.words[: min(stop.index, 1)])
    if word.type in ("_AND", "_OR", "NOT") and stop.condition is None:
        note = "conditions stand between if and then; two rules stand on two lines"
        return said("E110", f"`{word}` belongs to conditions", here, note)
    if word == ";" and not stop.lacks_operand:
        if called and ";" in stop.words[: stop.index]:
            return said("E101", "a call has one `;`", here, "write a comma", label="a second one")
        note = "a function with several results is called by a rule of its own: call f(a; x, y)"
        return said("E101", "`;` parts arguments from results, which only `call` names", here, note)
    if word == "," and not stop.lacks_operand:
        note = "write rules on lines of their own, or as a tuple: (x, y) = (1, 2)"
        return said("E101", "a comma cannot part rules", here, note)
    if word == "~":
        note = f"write {before or 'x'} ~ … there"
        return said("E101", "a guess belongs to the variables section", here, note)
    if word.type in ("UNIT", "IN"):
        what, note = (
            "unit" if word.type == "UNIT" else "range",
            "write it there, beside the name of its variable",
        )
        if word.type == "UNIT" and before.type == "NUMBER":
            note += f"; the unit of a number follows it at once: {before}{word}"
        return said("E101", f"a {what} belongs to the variables section", here, note)
    if called and stop.index < 3 and word != "(":
        note = "write call f(a, b; x, y): arguments, a semicolon, results"
        return said("E118", "a call needs a function and its parentheses", here, note)
    if called and before == ")":
        note = "to reckon with the result of f write f(a) without call"
        return said("E101", "nothing may follow a call", here, note)
    return None


def without_variable(rule: Equality | Inequality) -> Diagnosis | None:
    """What is wrong with a rule about numbers alone; None for any other.

    A call counts as a variable: its function may have parameters.
    """
    sides = (*rule.left, *rule.right) if isinstance(rule, Equality) else rule.comparisons
    pending: list[Expression | Condition] = list(sides)
    while pending:
        node = pending.pop()
        if isinstance(node, Name) or (isinstance(node, Call) and node.function != "pi"):
            return None
        pending.extend(children(node))
    message, note = "no variable stands in this rule", "write a name on one side: x = 3"
    return said("E114", message, rule.span, note, label="only numbers")


# --- rows -----------------------------------------------------------------------

_ROW_SHAPE = 'a row reads name = value [unit] " comment'


def _range(stop: Stop) -> Diagnosis | None:
    """A range, or an operator before it, at the end of a line."""
    if stop.word in ("=", "~", ":") and (broken := broken_line(stop)):
        return broken
    starts = (stop.word == "[" and "," in stop.words) or stop.word.lower() == "in"
    unclosed = stop.count("IN") and "]" not in stop.words
    if not (starts or unclosed or stop.before.type == "IN"):
        return None
    return said("E121", "a range cannot be read", stop.here, "write in [0, 5], or > 0, < 5")


def _list_or_rule(stop: Stop) -> Diagnosis | None:
    """A list of values, or a rule or the beginning of one, in the variables section."""
    word = stop.word
    if word.lower() in ("to", "by") and stop.follows_operand:
        note = "give one value here, and use backsolve sweep for many"
        return said("E190", "lists are not there yet", stop.here, note)
    begins = stop.index == 0 and (word.type in ("IF", "CALL") or word == "(")
    reckons = stop.index == 1 and (word in tuple("+-*/^(") or word.type in ("_AND", "_OR"))
    equates = word == "=" and "=" in stop.words[: stop.index] and not stop.lacks_operand
    if not (begins or reckons or equates):
        return None
    note = f"put it under `rules`; {_ROW_SHAPE}"
    return said("E120", "a rule cannot stand in the variables section", stop.here, note)


def _one_word_more(stop: Stop) -> Diagnosis | None:
    """A word after all that a row has: most likely a comment."""
    before, word, both = stop.before, stop.word, stop.span(stop.before or stop.word, stop.word)
    if word.type == "UNIT":
        return said("E120", "a unit cannot stand here", stop.here, _ROW_SHAPE)
    if not stop.begins_operand:
        return None
    if not before:
        return said("E120", "a row begins with the name of a variable", stop.here, _ROW_SHAPE)
    if before.type == "UNIT" or (stop.follows_operand and word.type == "NAME" and not stop.adjacent):
        what = "unit" if before.type == "UNIT" else "name" if stop.index == 1 else "value"
        note = f'if it is a comment, write " {word} …'
        return said("E120", f"`{word}` cannot follow the {what}", stop.here, note)
    if stop.index == 1:
        message, note = f"something is missing between `{before}` and `{word}`", f"write {before} = {word}"
        return said("E120", message, both, note)
    note = f"write {before}*{word}"
    return said("E105", "a product needs a `*`", both, note) if stop.follows_operand else None


# --- lines of a figure ----------------------------------------------------------

MARK_SHAPE = "a line of a figure reads point A = (x, y), line (O, A) or slider (B, 0)"
_MISTAKES: dict[str, tuple[Explanation, ...]] = {
    "rule": (
        section_with_colon,
        lambda stop: open_across_lines(stop) if stop.word in ("=", ":") else None,
        *(foreign_form, _reserved, _no_value, explain_condition, two_operands, _second_equals),
        *(_equation_and_inequality, _decimal_comma, _misplaced, missing, _no_equation),
    ),
    "row": (section_with_colon, _range, foreign_form, _list_or_rule, bad_number, _one_word_more, missing),
    "mark": (broken_line, foreign_form, bad_number, two_operands, missing),
}


def _misshapen(stop: Stop) -> Diagnosis:
    """A line that is nothing of a figure, or a mark whose parentheses are not reached."""
    kind = KINDS.get(stop.words[0].lower()) if stop.words else None
    place = stop.here if stop.word else stop.whole
    if kind is not None:
        return said("E130", "this line of a figure cannot be read", place, f"write {kind.example}")
    if stop.words and (near := closest(stop.words[0], KINDS)) and stop.words[0] != near:
        return said("E130", None, stop.span(stop.words[0]), f"did you mean {near}?")
    return said("E130", None, place, MARK_SHAPE, "a rule stands under `rules`")


def wrong_mark(mark: Mark) -> Diagnosis | None:
    """What is wrong with a mark that the grammar accepts: its kind, or what it lacks."""
    kind = KINDS.get(mark.kind)
    if kind is None:
        near = closest(mark.kind, KINDS)
        note = f"did you mean {near}?" if near else f"the kinds are {', '.join(KINDS)}"
        place = mark.span and mark.span.part(0, len(mark.kind))
        return said("E130", f"a figure has no `{mark.kind}`", place, note)
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
        return said("E131", message, mark.span, f"write {kind.example}")
    places = {Shape.POINTS: mark.arguments, Shape.DIRECTED: mark.arguments[:1]}.get(kind.shape, ())
    for argument in places:
        if not isinstance(argument, Name) or "." in argument.name:
            note = f"name a point of the figure, as in {kind.example}"
            return said("E131", "this is not the name of a point", argument.span, note)
    return None
