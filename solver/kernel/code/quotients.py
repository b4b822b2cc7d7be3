"""Quotients whose dividend and divisor vanish together, bounded where they do.

``rate/(1 - (1 + rate)^(-term))`` is 0/0 at 0, and next to that interval arithmetic knows nothing of it.
But if N and D both vanish at 0, then N(x)/D(x) = N'(t)/D'(t) for some t between 0 and x (Cauchy's mean
value theorem), so that the slopes over the hull of 0 and the box bound the quotient over the box.
"""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from rulesheets.evaluate import NotDifferentiable, differentiate
from rulesheets.functions import TABLE
from rulesheets.syntax import nodes
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
    exchange,
    substitute,
)
from solver.kernel.code.chain import Chain

if TYPE_CHECKING:
    from collections.abc import Iterator

    from solver.kernel.code.interval_code import IntervalEmitter, Pair

_FROM_ZERO = "#from zero"


def by_slopes(emitter: IntervalEmitter, chain: Chain) -> Iterator[Pair]:
    """Other bounds of the residual, with one such quotient bounded by slopes; nan where they have none."""
    tear = chain.tears[0]
    assigned = {item.name for item in chain.assignments}
    residual = chain.assignments[-1].expression
    for number, quotient in enumerate(dict.fromkeys(_quotients(residual))):
        used = {*nodes.names(quotient)}
        if tear not in used or used & assigned:
            continue
        if _at_zero(quotient.left, tear) != 0 or _at_zero(quotient.right, tear) != 0:
            continue
        try:
            slopes = [differentiate(part, tear) for part in (quotient.left, quotient.right)]
        except NotDifferentiable:
            continue
        emitter.assign(_FROM_ZERO, emitter.apply("from_zero", emitter.of(Name(tear))))
        pairs = [emitter.of(substitute(slope, {tear: Name(_FROM_ZERO)})) for slope in slopes]
        bounded = f"#quotient {number}"
        emitter.assign(bounded, emitter.apply("by_slopes", *pairs))
        yield emitter.of(exchange(residual, quotient, Name(bounded)))


def _quotients(expression: Expression) -> Iterator[Quotient]:
    stack = [expression]
    while stack:
        node = stack.pop()
        if isinstance(node, Quotient):
            yield node
        stack.extend(nodes.operands(node))


def _at_zero(expression: Expression, tear: str) -> Fraction | None:
    """The exact value where the tear is 0, whatever the other numbers are; None where it depends on them."""
    match expression:
        case Number(value):
            return Fraction(value)
        case Name(name):
            return Fraction(0) if name == tear else None
        case Negative(operand):
            inside = _at_zero(operand, tear)
            return None if inside is None else -inside
        case Sum(terms):
            values = [v for term in terms if (v := _at_zero(term, tear)) is not None]
            return sum(values, Fraction(0)) if len(values) == len(terms) else None
        case Product(left, right):
            one, other = _at_zero(left, tear), _at_zero(right, tear)
            if one == 0 or other == 0:
                return Fraction(0)
            return None if one is None or other is None else one * other
        case Power(base, exponent):
            raised = _at_zero(base, tear)
            power = _at_zero(exponent, tear)
            if raised == 1 or power == 0:
                return Fraction(1)
            return Fraction(0) if raised == 0 and power is not None and power > 0 else None
        case Call(function, (argument,)) if _at_zero(argument, tear) == 0:
            return _value_at_zero(function)
        case _:
            return None


def _value_at_zero(function: str) -> Fraction | None:
    """The exact value of a function at 0, where that is 0 or 1; None of those registered from Python."""
    row = TABLE[function]
    try:
        value = row.value(0.0)
    except (ArithmeticError, ValueError):
        return None
    return Fraction(value) if row.source is None and row.smooth and value in (0.0, 1.0) else None
