"""Kinks at an answer: functions at a corner or a jump, and comparisons of guards with equal sides."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import combinations

from rulesheets.evaluate import Undefined, value
from rulesheets.evaluate.number import equal
from rulesheets.model import Equation, Model, Value
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Call, Expression, Number, Quotient
from rulesheets.syntax.program import walk
from solver.path.cases import Pair, comparisons

ZERO = Number(0.0)


def active_comparisons(model: Model, values: Mapping[str, Value]) -> tuple[Pair, ...]:
    """The pairs of numbers that guards compare, that are equal at ``values`` and can move."""
    guards = {premise.condition for equation in model.equations for premise in equation.guard}
    found: dict[Pair, None] = {}
    for index in sorted(guards):
        for atom in comparisons(model.conditions[index]):
            pair = atom.left, atom.right
            varies = any(True for side in pair for _ in nodes.names(side))
            if varies and pair[::-1] not in found and _even(pair, values):
                found[pair] = None
    return tuple(found)


def kinks(equation: Equation, values: Mapping[str, Value]) -> Iterator[Pair]:
    """Pairs that are equal at a kink or a jump of some function in the equation, and come apart beside it."""
    for side in (equation.left, equation.right):
        for node in walk(side):
            if isinstance(node, Call) and node.arguments:
                yield from (pair for pair in _meetings(node, values) if _even(pair, values))


def _meetings(call: Call, values: Mapping[str, Value]) -> Iterator[Pair]:
    first, *rest = call.arguments
    match call.function:
        case "abs" | "sgn":
            yield first, ZERO
        case "min" | "max":
            extreme = _number(call, values)
            met = [a for a in call.arguments if extreme is not None and _number(a, values) == extreme]
            yield from combinations(met, 2)
        case "step":
            yield first, rest[0]
        case "int" | "frac":
            yield from _whole(first, 0.0, values)
        case "round":
            yield from _whole(first, 0.5, values)
        case "mod":
            yield from _whole(Quotient(first, rest[0]), 0.0, values)


def _whole(argument: Expression, offset: float, values: Mapping[str, Value]) -> Iterator[Pair]:
    """The argument and the nearest number at which the function jumps."""
    number = _number(argument, values)
    if number is not None:
        yield argument, Number(round(number - offset) + offset)


def _even(pair: Pair, values: Mapping[str, Value]) -> bool:
    left, right = (_number(side, values) for side in pair)
    return left is not None and right is not None and equal(left, right)


def _number(expression: Expression, values: Mapping[str, Value]) -> float | None:
    try:
        return value(expression, values)
    except (Undefined, KeyError, TypeError):
        return None
