"""Numbers that miss a rule, or the boundary of the assumed case, by rounding alone: moved onto
it."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress

from rulesheets.evaluate import Undefined, derivatives
from rulesheets.syntax.nodes import subtract
from solver.accuracy.rule_check import check_rule
from solver.kernel.step import StepSolver
from solver.leaves import Branch, CaseAnalysis
from solver.numerics.tolerances import ROUGHLY, SAFETY
from solver.path import activity, equations_of
from solver.path.cases import Pair
from solver.path.graph import ModelGraph


def agreed(graph: ModelGraph, branch: Branch, equation: int, inputs: Collection[str]) -> bool:
    """Whether another value, equally good for all its rules, satisfies a rule that fails: it is
    taken.

    It is the nearest one: a farther one may be another answer, which has a branch of its own.
    """
    for name in graph.model.equations[equation].names:
        isolation, _ = graph.isolated(equation, graph.number[name])
        number = branch.values[name]
        if name in inputs or isolation is None or isinstance(number, str):
            continue
        others = {other: value for other, value in branch.values.items() if other != name}
        found = StepSolver(graph, equation, name, others).outcome().values
        nearest = sorted((v for v in found if isinstance(v, float)), key=lambda v: abs(v - number))
        if any(_moved(graph, branch, name, value) for value in nearest):
            return True
    return False


def _moved(graph: ModelGraph, branch: Branch, name: str, value: float) -> bool:
    """Whether the rules that read a computed number also hold at another value of it, which is
    taken.

    None of the block that it came from may be left open by an unknown: no value of that need save
    it.
    """
    trial, decided = {**branch.values, name: value}, branch.conditions
    active = [e for i in graph.users[name] if activity(e := graph.model.equations[i], decided)]
    known = [e for e in active if all(other in trial for other in e.names)]
    told_by = () if name not in branch.origins else equations_of(branch.origins[name])
    if any(e.index in told_by and e not in known for e in active):
        return False
    if not all(check_rule(e, trial).holds for e in known):
        return False
    branch.values[name] = value
    branch.precise.pop(name, None)
    return True


def onto_boundary(
    graph: ModelGraph,
    branch: Branch,
    pair: Pair,
    inputs: Collection[str],
    errors: Callable[[Branch], Mapping[str, float]],
    analysis: CaseAnalysis,
) -> bool | None:
    """Whether a branch misses the equality of a pair by no more than its rounding: a number is
    moved onto it. None if no number can be moved alone, so that the case stays open.

    The Reynolds number that a friction factor gives as 2299.9999999999995 belongs to ``Re >=
    2300``.
    """
    with suppress(Undefined, KeyError, TypeError):
        miss, slopes = derivatives(subtract(*pair), branch.values)
        numbers = {name: v for name in slopes if isinstance(v := branch.values[name], float)}
        if not abs(miss) <= ROUGHLY * sum(abs(slopes[n] * v) for n, v in numbers.items()):
            return False
        off = errors(branch)
        if abs(miss) > SAFETY * sum(abs(slope) * off[name] for name, slope in slopes.items()):
            return False
        ends = [
            (n, v - miss / slopes[n]) for n, v in numbers.items() if n not in inputs and slopes[n]
        ]
        beside = (
            (name, math.nextafter(at, to)) for name, at in ends for to in (at, math.inf, -math.inf)
        )
        open_: bool | None = None
        for name, number in beside:
            if _moved(graph, trial := branch.without(()), name, number):
                if not analysis.contradicted(trial):
                    branch.values, branch.precise = trial.values, trial.precise
                    return True
                open_ = False
        return open_
    return False
