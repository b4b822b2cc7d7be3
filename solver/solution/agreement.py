"""Redundant rules that disagree by rounding alone: one value that satisfies them all.

A value that is a difference of large terms comes out as their rounding where a redundant rule says 0; either
number satisfies the first rule, and only 0 the second.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import partial

from rulesheets.model import Value
from solver.accuracy.rule_check import check_rule
from solver.kernel.steps.step import solve_step
from solver.path.cases import activity
from solver.path.graph import ModelGraph


def agreed(
    graph: ModelGraph,
    equation: int,
    values: Mapping[str, Value],
    inputs: Collection[str],
    decided: Mapping[int, bool],
) -> tuple[str, float] | None:
    """A computed variable of an equation that does not hold, and a value with which it does, and so do all
    other rules that read it as far as their values are known. None where there is none.

    The nearest is taken: another may be another answer, and that is on a branch of its own.
    """
    for name in graph.model.equations[equation].names:
        isolation = graph.isolation(equation, graph.number[name])
        if name in inputs or isolation is None:
            continue
        others = {other: value for other, value in values.items() if other != name}
        numbers = [v for v in solve_step(graph, equation, isolation, others).values if isinstance(v, float)]
        for value in sorted(numbers, key=partial(_distance, values[name])):
            if _hold(graph, name, {**others, name: value}, decided):
                return name, value
    return None


def _distance(value: Value, other: float) -> float:
    return abs(other - value) if isinstance(value, float) else 0.0


def _hold(graph: ModelGraph, name: str, values: Mapping[str, Value], decided: Mapping[int, bool]) -> bool:
    readers = (graph.model.equations[index] for index in graph.users(name))
    return all(
        check_rule(equation, values).holds
        for equation in readers
        if activity(equation, decided) and all(other in values for other in equation.names)
    )
