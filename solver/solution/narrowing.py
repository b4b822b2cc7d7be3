"""Requirements on single unknowns as ranges: a search that cannot cover everything keeps within them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from rulesheets.deadline import TimeIsUp
from rulesheets.evaluate import Undefined, value
from rulesheets.model import Model, Value, Variable
from rulesheets.nodes import Comparison, Name, names
from solver.solution.leaves import CutOff, Exploration
from solver.solution.refinement import certain, explore_refined

_MIRRORED = {"<": ">", "<=": ">=", ">": "<", ">=": "<="}


def explore_required(
    model: Model,
    inputs: Mapping[str, Value],
    want: Sequence[str] | None,
    guesses: Mapping[str, float],
    judged: Sequence[str],
    always: bool = False,
) -> Exploration:
    """As ``explore_refined``; where that leaves something open, again within what requirements allow.

    Answers that break a requirement remain known from the first search.
    """
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
