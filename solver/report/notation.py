"""Mathematics as text or as LaTeX: the same expression with names, with numbers, and its value."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Protocol

from rulesheets.format import DIGITS, format_condition, format_expression, readable
from rulesheets.model import Equation, Value
from rulesheets.syntax.nodes import (
    And,
    Condition,
    Expression,
    Name,
    Negative,
    Not,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    Symbol,
    children,
    names,
    rebuilt,
    substitute,
)


class Notation(Protocol):
    """How mathematics is written."""

    def expression(self, node: Expression) -> str: ...

    def filled(self, node: Expression, values: Mapping[str, Value]) -> str:
        """The expression with numbers for its names."""

    def value(self, value: Value) -> str: ...

    def conditions(self, outcomes: Iterable[tuple[Condition, bool]]) -> str:
        """The conditions that hold, and that the others do not, joined by ``and``."""


class Plain:
    """As in a rule sheet, numbers below zero in parentheses wherever a sign would precede them."""

    def expression(self, node: Expression) -> str:
        return format_expression(_filled(node, {}, first=True))

    def filled(self, node: Expression, values: Mapping[str, Value]) -> str:
        return format_expression(_filled(node, values, first=True))

    def value(self, value: Value) -> str:
        return readable(value)

    def conditions(self, outcomes: Iterable[tuple[Condition, bool]]) -> str:
        return format_condition(_joined(outcomes))


class Tex:
    """LaTeX for mathematics mode."""

    def expression(self, node: Expression) -> str:
        from rulesheets.algebra import expression_latex

        return expression_latex(node)

    def filled(self, node: Expression, values: Mapping[str, Value]) -> str:
        return self.expression(substitute(node, {name: _rounded(values[name]) for name in names(node)}))

    def value(self, value: Value) -> str:
        return self.expression(_rounded(value))

    def conditions(self, outcomes: Iterable[tuple[Condition, bool]]) -> str:
        from rulesheets.algebra import condition_latex

        return condition_latex(_joined(outcomes))


def equation(notation: Notation, equation: Equation) -> str:
    """``left = right``."""
    return f"{notation.expression(equation.left)} = {notation.expression(equation.right)}"


def _joined(outcomes: Iterable[tuple[Condition, bool]]) -> Condition:
    terms = tuple(condition if holds else Not(condition) for condition, holds in outcomes)
    return terms[0] if len(terms) == 1 else And(terms)


def _rounded(value: Value) -> Expression:
    """A value as a person reads it."""
    return Symbol(value) if isinstance(value, str) else Number(float(f"{value:.{DIGITS}g}") + 0.0)


def _filled(node: Expression, values: Mapping[str, Value], first: bool) -> Expression:
    """Names with a value replaced by it, and ``x + -1`` by ``x - 1``.

    ``first``: nothing stands to the left of the node, so that a sign needs no parentheses.
    """
    if isinstance(node, Name) and node.name in values:
        text = readable(values[node.name])
        return Name(f"({text})" if text.startswith("-") and not first else text)
    parts = children(node)
    places = _first_places(node, first, len(parts))
    if isinstance(node, Sum):
        parts = (parts[0], *map(_subtracted, node.terms[1:]))
    return rebuilt(
        node,
        tuple(_filled(part, values, place) for part, place in zip(parts, places, strict=True)),  # type: ignore[arg-type]
    )


def _subtracted(term: Expression) -> Expression:
    """A negative number as one that is subtracted."""
    return Negative(Number(-term.value)) if isinstance(term, Number) and term.value < 0 else term


def _first_places(node: Expression, first: bool, count: int) -> tuple[bool, ...]:
    match node:
        case Sum():  # anything but the first term of another sum stands in parentheses
            return (True, *(False,) * (count - 1))
        case Product() | Quotient():
            return (first, *(False,) * (count - 1))
        case Power() | Negative():
            return (False,) * count
        case _:
            return (True,) * count
