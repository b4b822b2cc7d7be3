"""No more than needed: the steps of a path that lead to what is wanted."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence

from solver.path.graph import ModelGraph
from solver.path.steps import Assume, Check, Decide, Evaluate, Select, SolveBlock, Step, equations_of


def needed_steps(
    graph: ModelGraph, steps: Sequence[Step], want: Iterable[str], undetermined: Collection[str]
) -> list[Step]:
    """The steps that the wanted variables need; no decision, where these are all reached."""
    needed = set(want)
    reached = needed.isdisjoint(undetermined)
    kept: list[Step] = []
    for step in reversed(steps):
        wanted = not reached if isinstance(step, Decide | Assume) else needed.intersection(given_by(step))
        if wanted:
            needed.update(_read_by(graph, step))
            kept.append(step)
    return kept[::-1]


def given_by(step: Step) -> tuple[str, ...]:
    """The variables that a step finds."""
    match step:
        case Evaluate(unknown=unknown) | Select(unknown=unknown):
            return (unknown,)
        case SolveBlock(unknowns=unknowns):
            return unknowns
        case Check() | Decide() | Assume():
            return ()


def _read_by(graph: ModelGraph, step: Step) -> Iterator[str]:
    conditions: tuple[int, ...] = ()
    if isinstance(step, Decide):
        conditions = step.conditions
    elif isinstance(step, Assume):
        conditions = (step.condition,)
    for equation in equations_of(step):
        yield from graph.model.equations[equation].names
        conditions = (*conditions, *(p.condition for p in graph.model.equations[equation].guard))
    for condition in conditions:
        yield from (graph.names[v] for v in graph.condition_occurs[condition])
