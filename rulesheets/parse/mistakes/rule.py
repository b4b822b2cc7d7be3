"""What is wrong with a rule."""

from __future__ import annotations

from collections.abc import Callable

from rulesheets.diagnosis import Diagnosis, Label, error
from rulesheets.nodes import Call, Condition, Equality, Expression, Inequality, Name, children
from rulesheets.parse.mistakes.condition import explain_condition
from rulesheets.parse.mistakes.foreign import foreign_form, unreadable
from rulesheets.parse.mistakes.heads import unknown_section
from rulesheets.parse.mistakes.operand import broken_line, missing_operand, open_across_lines, two_operands
from rulesheets.parse.mistakes.stop import Stop


def explain_rule(stop: Stop) -> Diagnosis:
    """The most telling diagnosis of a rule that the grammar rejects."""
    for explain in _EXPLANATIONS:
        found = explain(stop)
        if found is not None:
            return found
    return unreadable(stop)


def _reserved(stop: Stop) -> Diagnosis | None:
    """``and = 3``: a keyword where a name was meant."""
    for word, after in ((stop.word, stop.after), (stop.before, stop.word)):
        if word is None or word.type not in _KEYWORDS or after is None or after != "=":
            continue
        if word.type in ("_THEN", "_ELSE") and stop.count("IF"):
            continue
        return stop.error(
            "E127",
            f"`{word}` is a keyword and cannot be the name of a variable",
            stop.span(word),
            "",
            f"give the variable another name, such as {word}_1",
        )
    return None


_KEYWORDS = frozenset({"IF", "_THEN", "_ELSE", "CALL", "_AND", "_OR", "NOT"})


def _in_expression(stop: Stop) -> Diagnosis | None:
    """``x = if …`` and ``x = call f(a)``."""
    word = stop.word
    if word is None or not stop.lacks_operand or word.type not in ("IF", "CALL"):
        return None
    if word.type == "CALL":
        note = "leave out call: x = f(a), where f has one result; or write call f(a; x) as a rule of its own"
        return stop.error("E101", "`call` begins a rule and gives no value", stop.here, "", note)
    note = "write if a > 0 then x = 1 else x = 2"
    return stop.error("E101", "`if` chooses between rules, not between values", stop.here, "", note)


def _second_equals(stop: Stop) -> Diagnosis | None:
    if stop.word != "=" or stop.lacks_operand or "=" not in stop.words[: stop.index]:
        return None
    first = max(index for index in range(stop.index) if stop.words[index] == "=")
    broken = broken_line(stop, first)
    if broken is not None:
        return broken
    left = stop.words[_start_of_side(stop, first)]
    middle_first, middle_last = stop.words[first + 1], stop.words[stop.index - 1]
    a, b = stop.text(left, stop.words[first - 1]), stop.text(middle_first, middle_last)
    c = stop.text(stop.words[stop.index + 1], stop.words[-1]) if stop.after is not None else "…"
    return stop.error(
        "E106",
        "a rule has one equals sign",
        stop.here,
        "a second one",
        f"write two rules: {a} = {b} and {b} = {c}",
    )


def _start_of_side(stop: Stop, equals: int) -> int:
    """Index of the first word of the side that ends before an equals sign."""
    index = equals
    while index and stop.words[index - 1].type not in ("_THEN", "_ELSE"):
        index -= 1
    return index


def _equation_and_inequality(stop: Stop) -> Diagnosis | None:
    """``x = a < b`` and ``0 < x = a``."""
    word = stop.word
    signs = [w for w in stop.words[: stop.index] if w == "=" or w.type == "RELATION"]
    if word is None or not signs or stop.condition is not None or stop.lacks_operand:
        return None
    if word.type != "RELATION" and word != "=":
        return None
    return stop.error(
        "E106",
        "an equation and an inequality are two rules",
        stop.here,
        f"after {signs[-1]}",
        "write each of them on a line of its own",
    )


def _junction(stop: Stop) -> Diagnosis | None:
    """``x = a and b`` outside a condition."""
    word = stop.word
    if word is None or word.type not in ("_AND", "_OR", "NOT") or stop.condition is not None:
        return None
    return stop.error(
        "E110",
        f"`{word}` belongs to conditions",
        stop.here,
        "",
        "conditions stand between if and then; two rules stand on two lines",
    )


def _separator(stop: Stop) -> Diagnosis | None:
    """A comma or semicolon where none belongs."""
    word, before, after = stop.word, stop.before, stop.after
    if word is None or word not in (",", ";") or stop.lacks_operand:
        return None
    numbers = before is not None and after is not None and {before.type, after.type} == {"NUMBER"}
    if word == "," and numbers and stop.adjacent:
        assert before is not None and after is not None
        return stop.error(
            "E107",
            "a decimal comma cannot be read",
            stop.span(before, after),
            "",
            f"write {before}.{after}",
        )
    if word == ";" and stop.words[0].type == "CALL" and ";" in stop.words[: stop.index]:
        return stop.error("E101", "a call has one `;`", stop.here, "a second one", "write a comma")
    if word == ";":
        note = "a function with several results is called by a rule of its own: call f(a; x, y)"
        return stop.error(
            "E101", "`;` parts arguments from results, which only `call` names", stop.here, "", note
        )
    note = "write rules on lines of their own, or as a tuple: (x, y) = (1, 2)"
    return stop.error("E101", "a comma cannot part rules", stop.here, "", note)


def _misplaced(stop: Stop) -> Diagnosis | None:
    """What belongs to the variables section."""
    word = stop.word
    if word is None:
        return None
    if word == "~":
        note = f"write {stop.before} ~ … there"
        return stop.error("E101", "a guess belongs to the variables section", stop.here, "", note)
    if word.type in ("UNIT", "IN"):
        what = "a unit" if word.type == "UNIT" else "a range"
        note = "write it there, beside the name of its variable"
        if stop.before is not None and stop.before.type == "NUMBER":
            note += f"; the unit of a number follows it at once: {stop.before}{word}"
        return stop.error("E101", f"{what} belongs to the variables section", stop.here, "", note)
    return None


def _after_call(stop: Stop) -> Diagnosis | None:
    """``call f`` without parentheses, and what follows a complete call."""
    if not stop.count("CALL") or stop.words[0].type != "CALL":
        return None
    if stop.index < 3 and stop.word != "(":
        note = "write call f(a, b; x, y): arguments, a semicolon, results"
        return stop.error("E118", "a call needs a function and its parentheses", stop.here, "", note)
    if stop.before == ")":
        note = "to reckon with the result of f write f(a) without call"
        return stop.error("E101", "nothing may follow a call", stop.here, "", note)
    return None


def _no_equation(stop: Stop) -> Diagnosis | None:
    """A line, or an arm of a conditional, that has no equals sign."""
    if (stop.word is not None and stop.word.type != "_ELSE") or not stop.follows_operand:
        return None
    if len(stop.words) == 1:
        return unknown_section(stop.words[0], stop.whole)
    start = _start_of_side(stop, stop.index)
    span = stop.span(stop.words[start], stop.words[stop.index - 1])
    return stop.error(
        "E113", "this is no rule: it has no equals sign", span, "", "a rule is an equation: write … = …"
    )


def _open_parenthesis(stop: Stop) -> Diagnosis | None:
    return open_across_lines(stop) if stop.word in ("=", ":") else None


def _section_with_colon(stop: Stop) -> Diagnosis | None:
    if stop.word == ":" and stop.index == 1 and stop.after is None:
        return unknown_section(stop.words[0], stop.whole)
    return None


_EXPLANATIONS: tuple[Callable[[Stop], Diagnosis | None], ...] = (
    _section_with_colon,
    _open_parenthesis,
    foreign_form,
    _reserved,
    _in_expression,
    explain_condition,
    two_operands,
    _second_equals,
    _equation_and_inequality,
    _junction,
    _separator,
    _misplaced,
    _after_call,
    missing_operand,
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
