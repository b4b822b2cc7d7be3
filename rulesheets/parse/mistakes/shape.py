"""Lines that are wrong before any word of them is read: parentheses, length, depth."""

from __future__ import annotations

from rulesheets.diagnosis import Diagnosis, Label, error
from rulesheets.nodes import Condition, Expression, IfRule, Inequality, Product, Quotient, RuleBody, children
from rulesheets.parse.layout import LONGEST, NESTING, Line
from rulesheets.source import Source, Span

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
