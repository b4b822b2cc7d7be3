"""Rules as text: on one line, or a long conditional with its arms below each other."""

from __future__ import annotations

from rulesheets.format.expressions import format_condition, format_expression, format_list
from rulesheets.nodes import CallRule, Equality, Expression, IfRule, Inequality, RuleBody

WIDTH = 80
"""Characters beyond which a conditional with ``else`` is broken into lines."""

_INDENTED = 32
"""Where ``then`` stands further to the right than this, ``else`` is not put below it."""


def format_rule(body: RuleBody) -> str:
    """The rule on one line."""
    match body:
        case Equality(left, right):
            return f"{_side(left)} = {_side(right)}"
        case Inequality(comparisons):
            first, *others = map(format_condition, comparisons)
            starts = (len(format_expression(comparison.left)) for comparison in comparisons[1:])
            return first + "".join(text[start:] for text, start in zip(others, starts, strict=True))
        case CallRule(function, arguments, results):
            shown = f"; {format_list(results)}" if results else ""
            return f"call {function}({format_list(arguments)}{shown})"
        case IfRule():
            return " ".join(_arms(body))


def rule_lines(body: RuleBody) -> list[str]:
    """The rule as lines: one, or for a long conditional one for each arm, ``else`` below ``then``."""
    whole = format_rule(body)
    if not isinstance(body, IfRule) or body.otherwise is None or len(whole) <= WIDTH:
        return [whole]
    first, *others = _arms(body)
    below_then = len(f"if {format_condition(body.condition)} ")
    margin = " " * (below_then if len(others) == 1 and below_then <= _INDENTED else 2)
    return [first, *(margin + arm for arm in others)]


def _arms(rule: IfRule) -> list[str]:
    """``if … then …``, ``else if … then …``, ``else …``."""
    arms = []
    word = "if"
    rest: RuleBody | None = rule
    while isinstance(rest, IfRule):
        arms.append(f"{word} {format_condition(rest.condition)} then {_then(rest.then)}")
        word, rest = "else if", rest.otherwise
    if rest is not None:
        arms.append(f"else {format_rule(rest)}")
    return arms


def _then(body: RuleBody) -> str:
    """A conditional after ``then`` goes in parentheses, so that an ``else`` cannot be taken for its own."""
    return f"({format_rule(body)})" if isinstance(body, IfRule) else format_rule(body)


def _side(expressions: tuple[Expression, ...]) -> str:
    text = format_list(expressions)
    return f"({text})" if len(expressions) > 1 else format_expression(expressions[0])
