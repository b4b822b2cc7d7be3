"""What is wrong with sections and whole lines: heads, order, parentheses, length, depth."""

from __future__ import annotations

from rulesheets.diagnosis import Diagnosis, Label, error
from rulesheets.parse.layout import LONGEST, NESTING, Line
from rulesheets.parse.mistakes.stop import Stop
from rulesheets.spelling import closest
from rulesheets.syntax.nodes import (
    Condition,
    Expression,
    IfRule,
    Inequality,
    Product,
    Quotient,
    RuleBody,
    children,
)
from rulesheets.syntax.source import Source, Span

SECTIONS = ("variables", "rules", "units", "function", "parameters", "use", "figure")

_SHAPES = {
    "use": 'write use "position.tk"',
    "head": "write function f(a, b; x, y): arguments, a semicolon, results",
    "parameters": "write parameters AB, AO",
    "figure": "write figure velocity [m/s]: a name, and the unit of its scale if there is one",
}
_PLANNED = {
    "list": ("list functions are", "write the formula, or a chain of if … then … else if …"),
    "procedure": ("procedure functions are", "write its formulas as the rules of a function"),
}


def explain_head(stop: Stop, kind: str) -> Diagnosis:
    """What is wrong with a ``use``, ``function``, ``parameters`` or ``figure`` line."""
    note = _SHAPES[kind]
    if kind == "use" and (stop.line.comment is not None or '"' in stop.line.code):
        start = max(stop.source.text.rfind('"', stop.line.start, stop.line.end + 2), stop.line.start)
        return error(
            "E123",
            "a file name is never closed",
            Label(Span(stop.source, start, start + 1), "opened here"),
            notes=(note,),
        )
    if kind == "parameters" and stop.begins_operand and stop.follows_operand:
        note = f"write a comma: {stop.before}, {stop.word}"
    word = stop.words[0].lower() if stop.words else kind
    place = stop.here if stop.word is not None else stop.whole
    return stop.error("E118", f"this `{word}` line cannot be read", place, "", note)


def unknown_section(word: str, span: Span) -> Diagnosis:
    """A lone word that is no section head."""
    near = closest(word, SECTIONS)
    plain = "a rule is an equation, such as V = I*R"
    if word.lower() == "end":
        note = "leave it out: a function ends where the next section begins"
        return error("E116", f"`{word}` ends nothing here", Label(span), notes=(note,))
    if near is None:
        return error(
            "E116",
            f"`{word}` alone is neither a rule nor the head of a section",
            Label(span),
            notes=(plain, "sections are variables, rules, units, function and figure"),
        )
    if near == word.lower():
        return error(
            "E116", f"a section head is one word alone: {near}", Label(span), notes=(f"write {near}",)
        )
    return error("E116", f"unknown section `{word}`", Label(span), notes=(f"did you mean {near}?",))


def section_with_colon(stop: Stop) -> Diagnosis | None:
    """``rules:`` and the like."""
    if stop.word == ":" and stop.index == 1 and stop.after is None:
        return unknown_section(stop.words[0], stop.whole)
    return None


def not_there_yet(word: str, span: Span) -> Diagnosis:
    """A construct that the language plans."""
    what, note = _PLANNED[word.lower()]
    return error("E190", f"{what} not there yet", Label(span), notes=(note,))


def second_rules(span: Span) -> Diagnosis:
    return error(
        "E119",
        "this function has its rules already",
        Label(span, "a second head"),
        notes=("rules of the sheet itself stand before the first function",),
    )


def stray_parameters(span: Span) -> Diagnosis:
    return error(
        "E119",
        "parameters belong to a function",
        Label(span),
        notes=("put the line between the head of the function and its rules",),
    )


def no_rule(source: Source) -> Diagnosis:
    span = Span(source, 0, 1)
    return error(
        "E126",
        f"{source.name} has no rule",
        Label(span, "nothing to solve"),
        notes=("write a rule, such as V = I*R",),
    )


def function_without_rules(name: str, span: Span) -> Diagnosis:
    return error(
        "E126",
        f"the function {name} has no rule",
        Label(span, "its rules are missing"),
        notes=("write its rules below its head, under `rules`",),
    )


DEEPEST = 200
"""Levels of a rule's tree: later stages walk trees by recursion, which must end in good time."""


def wrong_shape(source: Source, line: Line) -> Diagnosis | None:
    """What parentheses and length say against a line; None where it may be read."""
    if line.end - line.start > LONGEST:
        return _too_long(source, line)
    if line.too_deep is not None:
        return _nested(Span(source, line.too_deep, line.too_deep + 1), f"more than {NESTING} are open here")
    if line.stray:
        place = line.stray[0]
        return error(
            "E103",
            None,
            Label(Span(source, place, place + 1), "nothing is open here"),
            notes=("remove it, or open a parenthesis before it",),
        )
    if line.unclosed:
        return _unclosed(source, line)
    return None


def _unclosed(source: Source, line: Line) -> Diagnosis:
    place = line.unclosed[-1]
    missing = ")" * len(line.unclosed)
    return error(
        "E102",
        None,
        Label(Span(source, place, place + 1), "opened here"),
        notes=(f"add {missing} where it ends",),
    )


def _too_long(source: Source, line: Line) -> Diagnosis:
    return error(
        "E125",
        f"this line is too long to be a rule: {line.end - line.start:,} characters",
        Label(Span(source, line.start, line.start + 1), "begins here"),
        notes=(f"a rule has at most {LONGEST:,} characters; give parts of it names of their own",),
    )


def too_deep(rule: RuleBody) -> Diagnosis | None:
    """Whether the tree of a rule has more than DEEPEST levels. Walks without recursion."""
    level: list[RuleBody | Condition | Expression] = [rule]
    for _ in range(DEEPEST):
        level = [part for node in level for part in _parts(node)]
        if not level:
            return None
    span = level[0].span
    assert span is not None
    return _nested(Span(span.source, span.start, span.start + 1), f"{DEEPEST} levels deep")


def _parts(node: RuleBody | Condition | Expression) -> tuple[RuleBody | Condition | Expression, ...]:
    if isinstance(node, Product | Quotient):
        return _factors(node)
    if isinstance(node, Inequality):
        return node.comparisons
    if isinstance(node, IfRule):
        arms = (node.then,) if node.otherwise is None else (node.then, node.otherwise)
        return (node.condition, *arms)
    sides = getattr(node, "left", None), getattr(node, "right", None)
    if isinstance(sides[0], tuple) and isinstance(sides[1], tuple):
        return sides[0] + sides[1]
    return (*getattr(node, "arguments", ()), *getattr(node, "results", ())) or children(node)  # type: ignore[arg-type]


def _factors(node: Product | Quotient) -> tuple[Expression, ...]:
    """The parts of a chain of products, which is one level however long."""
    parts: list[Expression] = []
    rest: Expression = node
    while isinstance(rest, Product | Quotient):
        parts.append(rest.right)
        rest = rest.left
    return (rest, *parts)


def _nested(span: Span, label: str) -> Diagnosis:
    return error(
        "E124",
        "this is nested too deeply",
        Label(span, label),
        notes=("give the inner parts names of their own, in rules of their own",),
    )
