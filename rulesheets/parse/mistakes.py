"""What is wrong with a rule, a row of the variables section, or a line of a figure."""

from __future__ import annotations

from collections.abc import Callable

from rulesheets.checks.marks import KINDS, Kind, Shape
from rulesheets.diagnosis import Diagnosis, closest, plural, said
from rulesheets.parse.foreign import foreign_form, section_with_colon, unknown_section, unreadable
from rulesheets.parse.stop import (
    MISSING,
    Explanation,
    Mistake,
    Stop,
    bad_number,
    broken_line,
    explain_condition,
    first_of,
    open_across_lines,
    two_operands,
)
from rulesheets.syntax.nodes import Call, Condition, Equality, Expression, Inequality, Mark, Name, children

_KEYWORDS = frozenset({"IF", "_THEN", "_ELSE", "CALL", "_AND", "_OR", "NOT"})


def explain_rule(stop: Stop) -> Diagnosis:
    """The most telling diagnosis of a rule that the grammar rejects."""
    return first_of(_RULE_MISTAKES, stop) or unreadable(stop)


def _reserved(stop: Stop) -> Diagnosis | None:
    """``and = 3``: a keyword where a name was meant."""
    for word, after in ((stop.word, stop.after), (stop.before, stop.word)):
        if word is None or word.type not in _KEYWORDS or after is None or after != "=":
            continue
        if word.type in ("_THEN", "_ELSE") and stop.count("IF"):
            continue
        message = f"`{word}` is a keyword and cannot be the name of a variable"
        note = f"give the variable another name, such as {word}_1"
        return stop.error("E127", message, stop.span(word), "", note)
    return None


def _second_equals(stop: Stop) -> Diagnosis | None:
    if stop.word != "=" or stop.lacks_operand or "=" not in stop.words[: stop.index]:
        return None
    first = max(index for index in range(stop.index) if stop.words[index] == "=")
    broken = broken_line(stop, first)
    if broken is not None:
        return broken
    left = stop.words[_start_of_side(stop, first)]
    a = stop.text(left, stop.words[first - 1])
    b = stop.text(stop.words[first + 1], stop.words[stop.index - 1])
    c = stop.text(stop.words[stop.index + 1], stop.words[-1]) if stop.after is not None else "…"
    note = f"write two rules: {a} = {b} and {b} = {c}"
    return stop.error("E106", "a rule has one equals sign", stop.here, "a second one", note)


def _start_of_side(stop: Stop, equals: int) -> int:
    """Index of the first word of the side that ends before an equals sign."""
    index = equals
    while index and stop.words[index - 1].type not in ("_THEN", "_ELSE"):
        index -= 1
    return index


def _equation_and_inequality(stop: Stop) -> Diagnosis | None:
    """``x = a < b`` and ``0 < x = a``."""
    signs = [w for w in stop.words[: stop.index] if w == "=" or w.type == "RELATION"]
    if not stop.relates or not signs or stop.condition is not None or stop.lacks_operand:
        return None
    message, note = "an equation and an inequality are two rules", "write each of them on a line of its own"
    return stop.error("E106", message, stop.here, f"after {signs[-1]}", note)


def _decimal_comma(stop: Stop) -> Diagnosis | None:
    before, after = stop.before, stop.after
    if stop.word != "," or before is None or after is None or not stop.adjacent:
        return None
    if before.type != "NUMBER" or after.type != "NUMBER":
        return None
    span = stop.span(before, after)
    return stop.error("E107", "a decimal comma cannot be read", span, "", f"write {before}.{after}")


def _separates(stop: Stop, sign: str) -> bool:
    return stop.word == sign and not stop.lacks_operand


def _no_equation(stop: Stop) -> Diagnosis | None:
    """A line, or an arm of a conditional, that has no equals sign."""
    if (stop.word is not None and stop.kind != "_ELSE") or not stop.follows_operand:
        return None
    if len(stop.words) == 1:
        return unknown_section(stop.words[0], stop.whole)
    span = stop.span(stop.words[_start_of_side(stop, stop.index)], stop.words[stop.index - 1])
    note = "a rule is an equation: write … = …"
    return stop.error("E113", "this is no rule: it has no equals sign", span, "", note)


def _open_parenthesis(stop: Stop) -> Diagnosis | None:
    return open_across_lines(stop) if stop.word in ("=", ":") else None


def _called(stop: Stop) -> bool:
    return stop.words[0].type == "CALL" and bool(stop.count("CALL"))


_BESIDE = "write it there, beside the name of its variable"
_AT_ONCE = "; the unit of a number follows it at once: {before}{word}"

_RULE_MISTAKES: tuple[Explanation, ...] = (
    section_with_colon,
    _open_parenthesis,
    foreign_form,
    _reserved,
    Mistake(
        lambda stop: stop.lacks_operand and stop.kind == "CALL",
        *("E101", "`call` begins a rule and gives no value"),
        "leave out call: x = f(a), where f has one result; or write call f(a; x) as a rule of its own",
    ),
    Mistake(
        lambda stop: stop.lacks_operand and stop.kind == "IF",
        *("E101", "`if` chooses between rules, not between values", "write if a > 0 then x = 1 else x = 2"),
    ),
    explain_condition,
    two_operands,
    _second_equals,
    _equation_and_inequality,
    Mistake(
        lambda stop: stop.kind in ("_AND", "_OR", "NOT") and stop.condition is None,
        *("E110", "`{word}` belongs to conditions"),
        "conditions stand between if and then; two rules stand on two lines",
    ),
    _decimal_comma,
    Mistake(
        lambda stop: _separates(stop, ";") and _called(stop) and ";" in stop.words[: stop.index],
        *("E101", "a call has one `;`", "write a comma", "here", "a second one"),
    ),
    Mistake(
        lambda stop: _separates(stop, ";"),
        *("E101", "`;` parts arguments from results, which only `call` names"),
        "a function with several results is called by a rule of its own: call f(a; x, y)",
    ),
    Mistake(
        lambda stop: _separates(stop, ","),
        *("E101", "a comma cannot part rules"),
        "write rules on lines of their own, or as a tuple: (x, y) = (1, 2)",
    ),
    Mistake(
        lambda stop: stop.word == "~",
        *("E101", "a guess belongs to the variables section", "write {before} ~ … there"),
    ),
    Mistake(
        lambda stop: stop.kind == "UNIT" and stop.kind_before == "NUMBER",
        *("E101", "a unit belongs to the variables section", _BESIDE + _AT_ONCE),
    ),
    Mistake(lambda stop: stop.kind == "UNIT", *("E101", "a unit belongs to the variables section", _BESIDE)),
    Mistake(lambda stop: stop.kind == "IN", "E101", "a range belongs to the variables section", _BESIDE),
    Mistake(
        lambda stop: _called(stop) and stop.index < 3 and stop.word != "(",
        *("E118", "a call needs a function and its parentheses"),
        "write call f(a, b; x, y): arguments, a semicolon, results",
    ),
    Mistake(
        lambda stop: _called(stop) and stop.before == ")",
        *("E101", "nothing may follow a call", "to reckon with the result of f write f(a) without call"),
    ),
    *MISSING,
    _no_equation,
)


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


_ROW_SHAPE = 'a row reads name = value [unit] " comment'


def explain_row(stop: Stop) -> Diagnosis:
    """The most telling diagnosis of a row that the grammar rejects."""
    return first_of(_ROW_MISTAKES, stop) or unreadable(stop)


def _broken(stop: Stop) -> Diagnosis | None:
    return broken_line(stop) if stop.word in ("=", "~", ":") else None


def _range(stop: Stop) -> bool:
    word = stop.word
    starts = word is not None and ((word == "[" and "," in stop.words) or word.lower() == "in")
    unclosed = stop.count("IN") and "]" not in stop.words
    return starts or stop.kind_before == "IN" or bool(unclosed)


def _list(stop: Stop) -> bool:
    return stop.word is not None and stop.word.lower() in ("to", "by") and stop.follows_operand


def _is_rule(stop: Stop) -> bool:
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


_ROW_MISTAKES: tuple[Explanation, ...] = (
    section_with_colon,
    _broken,
    Mistake(_range, "E121", "a range cannot be read", "write in [0, 5], or > 0, < 5"),
    foreign_form,
    Mistake(
        _list,
        *("E190", "lists are not there yet", "give one value here, and use backsolve sweep for many"),
    ),
    Mistake(
        _is_rule,
        *("E120", "a rule cannot stand in the variables section", f"put it under `rules`; {_ROW_SHAPE}"),
    ),
    bad_number,
    Mistake(
        lambda stop: stop.begins_operand and stop.before is None,
        *("E120", "a row begins with the name of a variable", _ROW_SHAPE),
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
    Mistake(lambda stop: stop.kind == "UNIT", "E120", "a unit cannot stand here", _ROW_SHAPE),
    *MISSING,
)


MARK_SHAPE = "a line of a figure reads point A = (x, y), line (O, A) or slider (B, 0)"


def explain_mark(stop: Stop) -> Diagnosis:
    """The most telling diagnosis of a line of a figure that the grammar rejects."""
    before_parenthesis = "(" not in stop.words[: stop.index]
    if before_parenthesis and stop.index < 4:
        return _misshapen(stop)
    explanations = (broken_line, foreign_form, bad_number, two_operands, *MISSING)
    return first_of(explanations, stop) or unreadable(stop)


def _misshapen(stop: Stop) -> Diagnosis:
    """A line that is nothing of a figure, or a mark whose parentheses are not reached."""
    kind = KINDS.get(stop.words[0].lower()) if stop.words else None
    place = stop.whole if stop.word is None else stop.here
    if kind is not None:
        return stop.error("E130", "this line of a figure cannot be read", place, "", f"write {kind.example}")
    if stop.words and (near := closest(stop.words[0], KINDS)) and stop.words[0] != near:
        return stop.error("E130", None, stop.span(stop.words[0]), "", f"did you mean {near}?")
    return stop.error("E130", None, place, "", MARK_SHAPE, "a rule stands under `rules`")


def wrong_mark(mark: Mark) -> Diagnosis | None:
    """What is wrong with a mark that the grammar accepts: its kind, or what it lacks."""
    kind = KINDS.get(mark.kind)
    if kind is None:
        return _unknown_kind(mark)
    count, message = len(mark.arguments), ""
    if kind.named and mark.name is None:
        message = f"this {mark.kind} has no name"
    elif kind.shape is Shape.DIRECTED and mark.name is not None:
        message = f"a {mark.kind} has no name of its own"
    elif count < kind.least or (kind.most is not None and count > kind.most):
        message = f"a {mark.kind} takes {_expected(kind)}, not {count or 'none'}"
    if message:
        return said("E131", message, mark.span, f"write {kind.example}")
    places = {Shape.POINTS: mark.arguments, Shape.DIRECTED: mark.arguments[:1]}.get(kind.shape, ())
    for argument in places:
        if not isinstance(argument, Name) or "." in argument.name:
            note = f"name a point of the figure, as in {kind.example}"
            return said("E131", "this is not the name of a point", argument.span, note)
    return None


def _expected(kind: Kind) -> str:
    if kind.shape is Shape.POINTS:
        return plural(kind.least, "point") + ("" if kind.most else " or more")
    return str(kind.shape.value)


def _unknown_kind(mark: Mark) -> Diagnosis:
    near = closest(mark.kind, KINDS)
    note = f"did you mean {near}?" if near else f"the kinds are {', '.join(KINDS)}"
    return said(
        "E130", f"a figure has no `{mark.kind}`", mark.span and mark.span.part(0, len(mark.kind)), note
    )
