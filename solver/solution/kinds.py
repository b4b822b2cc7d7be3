"""Steps that pose the same problem with other names and numbers, such as the nodes of a network."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias

from rulesheets.model import Model, Value
from solver.path import SolveBlock, Step, equations_of, given_by
from solver.path.graph import Shape, asked_shape, shape_of

Kind: TypeAlias = tuple[Shape, ...]
"""The shapes of the rules of a step, in which known names are numbers: equal for such steps."""


def kind_of(model: Model, step: Step) -> Kind:
    rules, unknown = [model.equations[e] for e in equations_of(step)], frozenset(given_by(step))
    return tuple(
        [asked_shape(shape_of(e)[0], tuple([n in unknown for n in e.names])) for e in rules]
    )


def unknowns_by_kind(model: Model, steps: Iterable[Step]) -> Counter[Kind]:
    """The number of unknowns of the blocks of each kind."""
    found = Counter[Kind]()
    for step in steps:
        if isinstance(step, SolveBlock):
            found[kind_of(model, step)] += len(step.unknowns)
    return found


def continued(model: Model, steps: Sequence[Step], begun: Mapping[str, Value]) -> dict[str, float]:
    """The values that steps have ``begun`` with; others continue the last of their kind."""
    last, found = dict[Kind, tuple[float, ...]](), dict[str, float]()
    for step in steps:
        kind = kind_of(model, step)
        numbers = [v for name in given_by(step) if isinstance(v := begun.get(name), float)]
        if len(numbers) == len(given_by(step)):
            last[kind] = tuple(numbers)
        found.update(zip(given_by(step), last.get(kind, ()), strict=False))
    return found
