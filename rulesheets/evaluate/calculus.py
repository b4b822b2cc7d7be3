"""Symbolic partial derivatives of expressions, and folding of constants."""

from __future__ import annotations

from typing import assert_never

from rulesheets.evaluate.number import Undefined, value
from rulesheets.functions import TABLE
from rulesheets.syntax.construct import (
    ONE,
    ZERO,
    add,
    call,
    divide,
    is_number,
    multiply,
    negative,
    power,
    subtract,
)
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
)


class NotDifferentiable(ValueError):
    """A derivative was asked for that has no formula (Bessel functions by their order)."""


def differentiate(expression: Expression, name: str) -> Expression:
    """Partial derivative by the variable ``name``, with zeros and ones folded away.

    It is right wherever the expression is differentiable; at jumps and kinks it is that of one
    side. Raises NotDifferentiable where a function has no formula for its derivative.
    """
    match expression:
        case Name(found):
            return ONE if found == name else ZERO
        case Number() | Symbol():
            return ZERO
        case Negative(operand):
            return negative(differentiate(operand, name))
        case Sum(terms):
            return add(*(differentiate(term, name) for term in terms))
        case Product(left, right):
            by_left, by_right = differentiate(left, name), differentiate(right, name)
            return add(multiply(by_left, right), multiply(left, by_right))
        case Quotient(left, right):
            by_left, by_right = differentiate(left, name), differentiate(right, name)
            return divide(subtract(by_left, multiply(expression, by_right)), right)
        case Power(base, exponent):
            return _power(expression, differentiate(base, name), differentiate(exponent, name))
        case Call():
            return _call(expression, name)
        case _:
            assert_never(expression)


def _power(whole: Power, by_base: Expression, by_exponent: Expression) -> Expression:
    base, exponent = whole.base, whole.exponent
    lower = Number(exponent.value - 1.0) if isinstance(exponent, Number) else subtract(exponent, ONE)
    through_base = multiply(multiply(exponent, power(base, lower)), by_base)
    if is_number(by_exponent, 0.0):
        return through_base
    return add(through_base, multiply(multiply(whole, call("ln", base)), by_exponent))


def _call(expression: Call, name: str) -> Expression:
    inner = [differentiate(argument, name) for argument in expression.arguments]
    if all(is_number(slope, 0.0) for slope in inner):
        return ZERO
    outer = TABLE[expression.function].partials(expression.arguments)
    terms: list[Expression] = []
    for slope, by_argument in zip(inner, outer, strict=True):
        if is_number(slope, 0.0):
            continue
        if by_argument is None:
            raise NotDifferentiable(f"no derivative of {expression.function} is known")
        terms.append(multiply(by_argument, slope))
    return add(*terms)


def simplify(expression: Expression) -> Expression:
    """The expression with every part that has no variable replaced by its value, where it has one."""
    match expression:
        case Name() | Number() | Symbol():
            return expression
        case Negative(operand):
            return negative(simplify(operand))
        case Sum(terms):
            return _folded(add(*map(simplify, terms)))
        case Product(left, right):
            return _folded(multiply(simplify(left), simplify(right)))
        case Quotient(left, right):
            return _folded(_quotient(simplify(left), simplify(right)))
        case Power(base, exponent):
            return _folded(power(simplify(base), simplify(exponent)))
        case Call(function, arguments):
            return _folded(Call(function, tuple(map(simplify, arguments)), expression.span))
        case _:
            assert_never(expression)


def _quotient(left: Expression, right: Expression) -> Expression:
    return Quotient(left, right) if is_number(right, 0.0) else divide(left, right)


def _folded(expression: Expression) -> Expression:
    """The value of an expression all of whose parts are numbers; else the expression itself."""
    parts = operands(expression)
    if not parts or isinstance(expression, Negative) or not all(isinstance(part, Number) for part in parts):
        return expression
    try:
        return Number(value(expression, {}))
    except Undefined:
        return expression
