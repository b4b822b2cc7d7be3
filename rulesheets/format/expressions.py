"""Expressions and conditions as text, with no parenthesis more than the grammar needs."""

from __future__ import annotations

from rulesheets.nodes import (
    And,
    Call,
    Comparison,
    Condition,
    Expression,
    Given,
    Name,
    Negative,
    Not,
    Number,
    Or,
    Power,
    Product,
    Quotient,
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
