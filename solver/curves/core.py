"""The unknowns that a curve of answers is followed in: those that can have several values.

What follows from them by steps with one value is computed afterwards, point by point, as in any solve. So
kinks and poles of what is derived (a speed at a dead centre) do not stand in the way of the curve.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from rulesheets.model import Model
from rulesheets.syntax.nodes import names as names_in
from rulesheets.syntax.nodes import subtract
from solver.path.isolate import is_linear
from solver.path.steps import Assume, Evaluate, Select, SolveBlock, Step, equations_of


@dataclass(frozen=True)
class _Made:
    """What a step computes, and what it reads."""

    names: tuple[str, ...]
    reads: frozenset[str]
    forks: bool


@dataclass(frozen=True)
class Core:
    """``names``: the unknowns of the steps that can have several values, and all that these need of what
    moves with the parameter, in the order of the steps. ``moving``: everything that does, the parameter too.
    """

    names: tuple[str, ...]
    moving: frozenset[str]


def core_of(model: Model, steps: Sequence[Step], parameter: str) -> Core:
    """The core of a path; it has no names where every step has one value, and no case was assumed."""
    made = [one for one in (_made(model, step) for step in steps) if one is not None]
    assumed = {
        name for s in steps if isinstance(s, Assume) for name in names_in(model.conditions[s.condition])
    }
    moving = {parameter}
    for one in made:
        if one.reads & moving:
            moving.update(one.names)
    needed: set[str] = set()
    for one in reversed(made):
        if moving.isdisjoint(one.names):
            continue
        if one.forks or not (needed | assumed).isdisjoint(one.names):
            needed.update(one.names, one.reads & moving)
    names = tuple(name for one in made for name in one.names if name in needed and name in moving)
    return Core(names, frozenset(moving))


def _made(model: Model, step: Step) -> _Made | None:
    match step:
        case Evaluate(_, unknown, branches) | Select(_, unknown, branches):
            names: tuple[str, ...] = (unknown,)
            forks = branches > 1
        case SolveBlock(equations, names):
            forks = not all(_linear(model, index, names) for index in equations)
        case _:
            return None
    read = {name for index in equations_of(step) for name in _read(model, index)}
    return _Made(names, frozenset(read.difference(names)), forks)


def _linear(model: Model, index: int, unknowns: Sequence[str]) -> bool:
    """Whether a rule is linear in the unknowns of its block: such a block has one answer, none or all."""
    equation = model.equations[index]
    return is_linear(subtract(equation.left, equation.right), unknowns)


def _read(model: Model, index: int) -> Collection[str]:
    equation = model.equations[index]
    guards = (name for p in equation.guard for name in names_in(model.conditions[p.condition]))
    return {*equation.names, *guards}
