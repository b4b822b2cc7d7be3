"""Expressions built by code: the arithmetic constructors, with zeros and ones folded away."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from rulesheets.syntax.nodes import (
    Call,
    Expression,
    Name,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    Symbol,
    operands,
    rebuilt,
)

ZERO = Number(0.0)
ONE = Number(1.0)


def is_number(expression: Expression, value: float) -> bool:
    return isinstance(expression, Number) and expression.value == value


def negative(operand: Expression) -> Expression:
    match operand:
        case Number(value):
            return Number(-value) if value else operand
        case Negative(inner):
            return inner
        case _:
            return Negative(operand)


def add(*terms: Expression) -> Expression:
    kept = tuple(term for term in terms if not is_number(term, 0.0))
    if not kept:
        return ZERO
    return kept[0] if len(kept) == 1 else Sum(kept)


def subtract(left: Expression, right: Expression) -> Expression:
    return add(left, negative(right))


def multiply(left: Expression, right: Expression) -> Expression:
    if is_number(left, 0.0) or is_number(right, 0.0):
        return ZERO
    if is_number(left, 1.0):
        return right
    if is_number(right, 1.0):
        return left
    return Product(left, right)


def divide(left: Expression, right: Expression) -> Expression:
    if is_number(right, 1.0) or is_number(left, 0.0):
        return left
    return Quotient(left, right)


def power(base: Expression, exponent: Expression) -> Expression:
    if is_number(exponent, 1.0):
        return base
    return ONE if is_number(exponent, 0.0) else Power(base, exponent)


def call(function: str, *arguments: Expression) -> Expression:
    return Call(function, arguments)


def substitute(expression: Expression, replacements: Mapping[str, Expression]) -> Expression:
    """The expression with variables replaced."""
    return map_leaves(
        expression, lambda leaf: replacements.get(leaf.name, leaf) if isinstance(leaf, Name) else leaf
    )


def exchange(expression: Expression, old: Expression, new: Expression) -> Expression:
    """The expression with ``new`` wherever it has ``old``."""
    if expression == old:
        return new
    return rebuilt(expression, tuple(exchange(part, old, new) for part in operands(expression)))


def map_leaves(expression: Expression, change: Callable[[Name | Number | Symbol], Expression]) -> Expression:
    """The expression with every name, number and symbol turned into what ``change`` makes of it."""
    if isinstance(expression, Name | Number | Symbol):
        return change(expression)
    return rebuilt(expression, tuple(map_leaves(part, change) for part in operands(expression)))
