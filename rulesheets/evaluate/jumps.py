"""Where expressions jump: a theorem on continuous functions says nothing there, whatever the slopes are."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping

from rulesheets.evaluate.enclosing_ball import enclosing_ball
from rulesheets.functions import TABLE
from rulesheets.functions.balls import Ball
from rulesheets.nodes import Call, Expression, children, names


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
            case Call(function) as call if TABLE[function].steady is not None and not unknowns.isdisjoint(
                names(call)
            ):
                yield call
                stack.extend(call.arguments)
            case other:
                stack.extend(children(other))  # type: ignore[arg-type]
