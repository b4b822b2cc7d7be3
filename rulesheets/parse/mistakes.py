"""What is wrong with a rule, a row of the variables section, or a line of a figure."""

from __future__ import annotations

import re
from collections.abc import Callable

from rulesheets.checks.marks import KINDS, Shape
from rulesheets.diagnosis import Diagnosis, closest, plural, said
from rulesheets.functions import TABLE
from rulesheets.parse.foreign import (
    LINKS,
    Stop,
    Word,
    foreign_form,
    section_with_colon,
    unknown_section,
    unreadable,
)
from rulesheets.syntax import Span
from rulesheets.syntax.nodes import Call, Condition, Equality, Expression, Inequality, Mark, Name, children

Explanation = Callable[[Stop], Diagnosis | None]


_KEYWORDS = frozenset({"IF", "_THEN", "_ELSE", "CALL", "_AND", "_OR", "NOT"})


def explain_line(stop: Stop, kind: str) -> Diagnosis:
    """The most telling diagnosis of a rule, a row or a mark that the grammar rejects."""
    if kind == "mark" and stop.index < 4 and "(" not in stop.words[: stop.index]:
        return _misshapen(stop)
    return next(filter(None, (explain(stop) for explain in _MISTAKES[kind])), None) or unreadable(stop)


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
    if found := bad_number(stop) or open_across_lines(stop) or misspelt_keyword(stop):
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
    if before.type in LINKS:
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
        if word.type in LINKS or (start and word == ","):
            start = index + 1
    piece = condition[start:]
    while len(piece) > 1 and piece[0] == "(" and sum(w == "(" for w in piece) > sum(w == ")" for w in piece):
        piece = piece[1:]
    return piece


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
