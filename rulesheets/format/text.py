"""Expressions, conditions and rules as text, with no parenthesis more than the grammar needs."""

from __future__ import annotations

from rulesheets.syntax.nodes import (
    And,
    Call,
    CallRule,
    Comparison,
    Condition,
    Equality,
    Expression,
    Given,
    IfRule,
    Inequality,
    Name,
    Negative,
    Not,
    Number,
    Or,
    Power,
    Product,
    Quotient,
    RuleBody,
    Sum,
    Symbol,
)

_SUM, _PRODUCT, _FACTOR, _ATOM = range(4)
"""How tightly an expression binds: where one stands that binds less, it goes in parentheses."""

_OR, _AND, _NOT = range(3)
"""The same for conditions."""


def format_number(value: float) -> str:
    """The shortest text that reads back as the same float: ``3``, ``0.1``, ``1e-5``, ``1e22``."""
    digits, mark, exponent = repr(value).partition("e")
    return digits.removesuffix(".0") + (f"e{int(exponent)}" if mark else "")


DIGITS = 10
"""Significant digits that a person reads: all that a sheet is judged by, none of the rounding noise."""


def readable(value: float | str | None) -> str:
    """A value for the variable sheet: ``'open``, ``-41.46077186``, blank where there is none."""
    if value is None:
        return ""
    if isinstance(value, str):
        return f"'{value}"
    return f"{value + 0.0:.{DIGITS}g}"


def format_expression(node: Expression) -> str:
    """An expression on one line: sums are spaced, products and powers are not."""
    return _expression(node, _SUM)


def format_condition(node: Condition) -> str:
    """A condition on one line, with infix ``and`` and ``or``."""
    return _condition(node, _OR)


def _expression(node: Expression, place: int) -> str:
    text, binds = _bound(node)
    return text if binds >= place else f"({text})"


def _bound(node: Expression) -> tuple[str, int]:
    """The text of a node without parentheses around it, and how tightly it binds."""
    match node:
        case Number(value, unit=unit):
            text = format_number(value) + ("" if unit is None else f"[{unit}]")
            return text, _ATOM if value >= 0 else _FACTOR
        case Name(name):
            return name, _ATOM
        case Symbol(name):
            return f"'{name}", _ATOM
        case Call("pi", ()):
            return "pi", _ATOM
        case Call(function, arguments):
            return f"{function}({format_list(arguments)})", _ATOM
        case Power(base, exponent):
            return f"{_expression(base, _ATOM)}^{_expression(exponent, _FACTOR)}", _FACTOR
        case Negative(operand):
            return f"-{_expression(operand, _FACTOR)}", _FACTOR
        case Product() | Quotient():
            return _chain(node), _PRODUCT
        case Sum(terms):
            first, *others = terms
            return _expression(first, _PRODUCT) + "".join(map(_added, others)), _SUM


def _chain(node: Expression) -> str:
    """``a*b/c``, by a loop: such a chain may be longer than recursion reaches."""
    parts = []
    while isinstance(node, Product | Quotient):
        sign = "*" if isinstance(node, Product) else "/"
        parts.append(sign + _expression(node.right, _FACTOR))
        node = node.left
    return _expression(node, _PRODUCT) + "".join(reversed(parts))


def _added(term: Expression) -> str:
    if isinstance(term, Negative):
        return f" - {_expression(term.operand, _PRODUCT)}"
    return f" + {_expression(term, _PRODUCT)}"


def format_list(expressions: tuple[Expression, ...]) -> str:
    """``a, b, c``."""
    return ", ".join(map(format_expression, expressions))


def _condition(node: Condition, place: int) -> str:
    match node:
        case Comparison(operator, left, right):
            return f"{format_expression(left)} {operator} {format_expression(right)}"
        case Given(name):
            return f"given('{name})"
        case Not(Comparison() as comparison):
            return f"not ({_condition(comparison, _OR)})"
        case Not(term):
            return f"not {_condition(term, _NOT)}"
        case And(terms):
            text, binds = " and ".join(_condition(term, _NOT) for term in terms), _AND
        case Or(terms):
            text, binds = " or ".join(_condition(term, _AND) for term in terms), _OR
    return text if binds >= place else f"({text})"


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
