"""Answers of a plan near to one another: on the same branch of a motion."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import pi, sqrt

from rulesheets.model import Model, Value
from solver.plan import Plan, Unsolved

_TURNS = {"deg": 360.0, "°": 360.0, "rad": 2 * pi}

Row = dict[str, Value]


def turn(model: Model, name: str) -> float:
    """A full turn of an angle, 0 for what is none."""
    return _TURNS.get(model.variables[name].unit or "", 0.0)


def nearest(plan: Plan, at: float, like: Mapping[str, Value]) -> Row | None:
    """The answer of a plan with one input that is nearest to given values."""
    try:
        answers = plan.all(at)
    except Unsolved:
        return None
    rows = [
        dict(plan.given) | {plan.inputs[0]: at} | dict(zip(plan.want, one, strict=True)) for one in answers
    ]
    return min(rows, key=lambda row: apart(plan.model, row, like), default=None)


def apart(model: Model, one: Mapping[str, Value], other: Mapping[str, Value]) -> float:
    """A measure of how far two answers are from each other: 0 where all that both have is equal."""
    total = 0.0
    for name in one.keys() & other.keys():
        a, b = one[name], other[name]
        if isinstance(a, float) and isinstance(b, float):
            gap, whole = abs(a - b), turn(model, name)
            if whole:
                gap = min(gap % whole, whole - gap % whole)
            total += (gap / (1.0 + max(abs(a), abs(b)))) ** 2
        else:
            total += a != b
    return total


def golden_section(size: Callable[[float], float], low: float, high: float) -> float:
    """Where a function with one minimum between ``low`` and ``high`` has it (Kiefer 1953).

    Its value there is as good as a float can be; the place to half of the digits, as for any method.
    """
    share = (sqrt(5.0) - 1.0) / 2.0
    while abs(high - low) > 1e-9 * (abs(low) + abs(high) + 1e-9):
        left, right = high - share * (high - low), low + share * (high - low)
        if size(left) <= size(right):
            high = right
        else:
            low = left
    return (low + high) / 2.0
