"""Requirements on single unknowns as ranges: a search that cannot cover everything keeps within them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from rulesheets.deadline import TimeIsUp
from rulesheets.evaluate import Undefined, value
from rulesheets.model import Model, Value, Variable
from rulesheets.syntax.nodes import Comparison, Name, names
from solver.path.planner import planner
from solver.solution.leaves import CutOff, Exploration, Leaf
from solver.solution.refinement import certain, explore_refined

WIDE = 1e6
"""The width of a range beyond which it tells a search next to nothing."""
TURNS = 4
"""The same for angles, in turns."""
_MIRRORED = {"<": ">", "<=": ">=", ">": "<", ">=": "<="}


def explore_required(
    model: Model,
    inputs: Mapping[str, Value],
    want: Sequence[str] | None,
    guesses: Mapping[str, float],
    judged: Sequence[str],
    always: bool = False,
) -> Exploration:
    """As ``explore_refined``; where that leaves something open, again within what requirements allow, and
    without ranges that are too wide to be of help.

    Answers that break a requirement remain known from the first search.
    """
    found = _within_requirements(model, inputs, want, guesses, judged, always)
    free = None if found.complete else _without_wide_ranges(model)
    if free is None:
        return found
    try:
        others = explore_refined(free, inputs, want, guesses, judged, always)
    except TimeIsUp:
        raise CutOff(certain(model, found, judged), inputs) from None
    inside = (leaf for leaf in others.leaves if leaf.solved and _admitted(model, leaf, inputs))
    return replace(found, leaves=(*inside, *found.leaves))


def _admitted(model: Model, leaf: Leaf, inputs: Mapping[str, Value]) -> bool:
    return all(
        model.variables[name].admits(number)
        for name, number in leaf.branch.values.items()
        if isinstance(number, float) and name not in inputs
    )


def _without_wide_ranges(model: Model) -> Model | None:
    """The model without ranges that are very wide, or many turns; None where there are none."""
    if "_unbounded" not in model.__dict__:
        turn = planner(model).graph.turn
        variables = {
            name: replace(v, low=-math.inf, high=math.inf, low_open=False, high_open=False)
            if v.high - v.low >= (TURNS * t if (t := turn(name)) else WIDE) and math.isfinite(v.high - v.low)
            else v
            for name, v in model.variables.items()
        }
        changed = variables != dict(model.variables)
        model.__dict__["_unbounded"] = replace(model, variables=variables) if changed else None
    found: Model | None = model.__dict__["_unbounded"]
    return found


def _within_requirements(
    model: Model,
    inputs: Mapping[str, Value],
    want: Sequence[str] | None,
    guesses: Mapping[str, float],
    judged: Sequence[str],
    always: bool,
) -> Exploration:
    found = explore_refined(model, inputs, want, guesses, judged, always)
    if found.complete or not model.requirements:
        return found
    within = narrowed(model, inputs)
    if within is None:
        return found
    try:
        inside = explore_refined(within, inputs, want, guesses, judged, always)
    except TimeIsUp:
        raise CutOff(certain(model, found, judged), inputs) from None
    better = _solved(inside) >= _solved(found) if inside.complete else _solved(inside) > 0 == _solved(found)
    return replace(inside, dead=inside.dead or found.dead) if better else found


def _solved(found: Exploration) -> int:
    return sum(leaf.solved for leaf in found.leaves)


def narrowed(model: Model, inputs: Mapping[str, Value]) -> Model | None:
    """The model with the ranges that requirements amount to at these inputs; None where that is no news."""
    variables = dict(model.variables)
    for requirement in model.requirements:
        for name, operator, limit in _limits(requirement.comparison, inputs):
            if not requirement.guard:
                variables[name] = _within(variables[name], operator, limit)
    if variables == dict(model.variables) or any(v.low > v.high for v in variables.values()):
        return None
    kept: Model | None = model.__dict__.get("_narrowed")
    if kept is None or kept.variables != variables:
        kept = model.__dict__["_narrowed"] = replace(model, variables=variables)
    return kept


def _limits(comparison: Comparison, inputs: Mapping[str, Value]) -> Iterator[tuple[str, str, float]]:
    """The unknown that a comparison bounds by a known number, if there is one, with relation and bound."""
    pairs = (
        (comparison.left, comparison.operator, comparison.right),
        (
            comparison.right,
            _MIRRORED.get(comparison.operator, "<>"),
            comparison.left,
        ),
    )
    for side, operator, other in pairs:
        if isinstance(side, Name) and side.name not in inputs and inputs.keys() >= set(names(other)):
            try:
                limit = value(other, inputs)
            except (Undefined, TypeError):
                continue
            if operator != "<>" and math.isfinite(limit):
                yield side.name, operator, limit


def _within(variable: Variable, operator: str, limit: float) -> Variable:
    is_open = len(operator) == 1
    if operator[0] == ">" and (limit, is_open) > (variable.low, variable.low_open):
        return replace(variable, low=limit, low_open=is_open)
    if operator[0] == "<" and (limit, not is_open) < (variable.high, not variable.high_open):
        return replace(variable, high=limit, high_open=is_open)
    return variable
