"""Expressions and functions on balls: rigorous enclosures to any precision, by Arb.

A ball is a middle and a radius that holds the exact value (F. Johansson, IEEE Trans. Computers 66
(2017) 1281–1292). Outside its domain a function gives a ball that is not finite.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from fractions import Fraction
from typing import Any, TypeAlias

from flint import arb, arb_mat, ctx

from rulesheets.evaluate.number import Arithmetic, Undefined
from rulesheets.functions import TABLE
from rulesheets.functions.row import Forms, Function
from rulesheets.syntax.nodes import Call, Expression, Name, Number, Power, Quotient, calls, names

Ball: TypeAlias = Any
"""An ``arb`` of python-flint (which has no types of its own)."""


def precision(bits: int) -> Any:
    """A context in which balls are computed with so many bits."""
    return ctx.workprec(bits)


def ball(number: Any) -> Ball:
    """The exact number: a float, an int, or an mpmath number."""
    if hasattr(number, "_mpf_"):
        sign, mantissa, exponent, _ = number._mpf_
        return (arb(-int(mantissa)) if sign else arb(int(mantissa))) * arb(2) ** exponent
    return arb(number)


def exact_ball(number: Fraction) -> Ball:
    """A ball around a rational number; without a radius if it has a short binary form."""
    return arb(number.numerator) / arb(number.denominator)


def exact_fraction(number: Ball) -> Fraction | None:
    """The number of a ball without a radius; None for any other."""
    if not (number.is_exact() and number.is_finite()):
        return None
    mantissa, exponent = number.mid().man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


def around(middle: Ball, radius: float) -> Ball:
    """Everything within ``radius`` of a number."""
    return middle + arb(0, radius)


def whole_power(base: Ball, exponent: int) -> Ball:
    """An integral power, multiplied out around 0: Arb takes logarithms of such a ball."""
    if exponent < 1 or not base.mid().is_zero():
        return base**exponent
    reach = base.abs_upper() ** exponent
    return reach.union(arb(0 if exponent % 2 == 0 else -reach))


def preconditioned(
    jacobian: Sequence[Sequence[Ball]], centre: Sequence[Sequence[Ball]], residual: Sequence[Ball]
) -> tuple[list[list[Ball]], list[Ball]] | None:
    """I − Y J and Y F, for Y near the inverse of the middle of ``centre``; None if singular."""
    try:
        rough = arb_mat(centre).mid().inv().mid()
    except ZeroDivisionError:
        return None
    rest, shift = 1 - rough * arb_mat(jacobian), rough * arb_mat([[f] for f in residual])
    return rest.tolist(), shift.entries()


def _form(row: Function) -> Callable[..., Ball]:
    def defined(template: Expression, places: Mapping[str, Ball]) -> Ball:
        try:
            return enclosing_ball(template, places)
        except Undefined:
            return arb(0, "inf")

    return row.form("ball", arb, defined) or (lambda *arguments: arb(0, "inf"))


FUNCTIONS = Forms(TABLE, _form)
"""Every function of the table on balls, by name; not finite where nothing is known."""


def enclosing_ball(expression: Expression, balls: Mapping[str, Ball]) -> Ball:
    """A ball that holds every value of ``expression`` over the ``balls`` of its variables.

    Raises Undefined if it may not be defined everywhere, KeyError for a variable without a ball.
    """
    return Balls(balls).of(expression)


class Balls(Arithmetic[Ball]):
    def __init__(self, balls: Mapping[str, Ball]) -> None:
        self.balls = balls

    def number(self, node: Number) -> Ball:
        return ball(node.value)

    def name(self, node: Name) -> Ball:
        return self.balls[node.name]

    def divided(self, node: Quotient, above: Ball, below: Ball) -> Ball:
        return _defined(above / below, "/", node)

    def raised(self, node: Power, base: Ball, exponent: Ball) -> Ball:
        whole = exponent.unique_fmpz() if exponent.is_exact() and exponent.is_integer() else None
        power = base**exponent if whole is None else whole_power(base, int(whole))
        return _defined(power, "^", node)

    def applied(self, node: Call, arguments: list[Ball]) -> Ball:
        return _defined(FUNCTIONS[node.function](*arguments), node.function, node)


def _defined(result: Ball, operation: str, expression: Expression) -> Ball:
    if not result.is_finite():
        raise Undefined(operation, (math.nan, math.nan)[: 2 if operation == "^" else 1], expression)
    return result


# --- jumps: a theorem on continuous functions says nothing there ----------------


def jumps(expressions: Iterable[Expression], unknowns: Collection[str]) -> tuple[Call, ...]:
    """The calls in expressions of functions with jumps, with an unknown in their arguments."""
    jumping = (call for call in calls(*expressions) if TABLE[call.function].steady)
    found = (call for call in jumping if not set(unknowns).isdisjoint(names(call)))
    return tuple(dict.fromkeys(found))


def continuous(jumping: Iterable[Call], balls: Mapping[str, Ball]) -> bool:
    """Whether none of these calls can jump within the balls of their variables.

    Raises as ``enclosing_ball`` does.
    """
    for call in jumping:
        steady = TABLE[call.function].steady
        if steady and not steady(*(enclosing_ball(one, balls) for one in call.arguments)):
            return False
    return True
