"""The value of an expression over balls: a rigorous enclosure to any precision; and where it may jump."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping

from rulesheets.evaluate.arithmetic import Arithmetic
from rulesheets.evaluate.undefined import Undefined
from rulesheets.functions import TABLE
from rulesheets.functions.balls import FUNCTIONS, Ball, ball, whole_power
from rulesheets.functions.slopes import ROUNDED
from rulesheets.syntax.nodes import Call, Expression, Name, Number, Power, Quotient, children, names


def enclosing_ball(expression: Expression, balls: Mapping[str, Ball], derivative: bool = False) -> Ball:
    """A ball that holds every value of ``expression`` over the ``balls`` of its variables.

    ``derivative``: the expression is one, in which some floats stand for the exact numbers next to
    them; both are enclosed. Raises Undefined where it may not be defined everywhere, KeyError for a
    variable without a ball.
    """
    return Balls(balls, derivative).of(expression)


class Balls(Arithmetic[Ball]):
    def __init__(self, balls: Mapping[str, Ball], derivative: bool) -> None:
        self.balls, self.derivative = balls, derivative

    def number(self, node: Number) -> Ball:
        exact = ROUNDED.get(node.value) if self.derivative else None
        return ball(node.value) if exact is None else ball(node.value).union(enclosing_ball(exact, {}))

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
    """The calls in expressions of functions that jump, with an unknown in their arguments."""
    return tuple(dict.fromkeys(call for one in expressions for call in _calls(one, frozenset(unknowns))))


def continuous(calls: Iterable[Call], balls: Mapping[str, Ball]) -> bool:
    """Whether none of these calls can jump within the balls of their variables.

    Raises as ``enclosing_ball`` does.
    """
    return all(
        steady(*(enclosing_ball(argument, balls) for argument in call.arguments))
        for call in calls
        if (steady := TABLE[call.function].steady) is not None
    )


def _calls(expression: Expression, unknowns: frozenset[str]) -> Iterator[Call]:
    stack = [expression]
    while stack:
        match stack.pop():
            case Call(function) as call if TABLE[function].steady and not unknowns.isdisjoint(names(call)):
                yield call
                stack.extend(call.arguments)
            case other:
                stack.extend(children(other))  # type: ignore[arg-type]
