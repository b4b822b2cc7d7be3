"""What is wrong with a rule."""

from __future__ import annotations

from rulesheets.diagnosis import Diagnosis, Label, error
from rulesheets.parse.mistakes.foreign import foreign_form, section_with_colon, unknown_section, unreadable
from rulesheets.parse.mistakes.operand import (
    MISSING,
    Explanation,
    Mistake,
    Stop,
    broken_line,
    explain_condition,
    first_of,
    open_across_lines,
    two_operands,
)
from rulesheets.syntax.nodes import Call, Condition, Equality, Expression, Inequality, Name, children

_KEYWORDS = frozenset({"IF", "_THEN", "_ELSE", "CALL", "_AND", "_OR", "NOT"})


def explain_rule(stop: Stop) -> Diagnosis:
    """The most telling diagnosis of a rule that the grammar rejects."""
    return first_of(_EXPLANATIONS, stop) or unreadable(stop)


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

_EXPLANATIONS: tuple[Explanation, ...] = (
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
    assert rule.span is not None
    return error(
        "E114",
        "no variable stands in this rule",
        Label(rule.span, "only numbers"),
        notes=("write a name on one side: x = 3",),
    )
