"""Answers that floats leave too vague, solved again to as many digits as it takes.

The given values are exact numbers, so that an answer exists to all digits, however ill-conditioned. Where the
error bar of an answer says that floats lose more than their rounding, the path is followed once more in
numbers of higher precision, and of twice that, until two precisions agree: then every value is the float
nearest to the exact one. Where they never do, what floats found stands, with its error bars, unless those
leave no digit of a value.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace

from rulesheets.deadline import TimeIsUp, grace
from rulesheets.evaluate import Undefined, value
from rulesheets.model import Model, Value, Variable
from rulesheets.syntax.nodes import Comparison, Name, names
from solver.accuracy.forward_error import slopes
from solver.facts import Conflict
from solver.leaves import Asked, CutOff, Exploration, Leaf, leaf_errors
from solver.numerics.tolerances import LOST, MEANINGLESS, NO_DIGIT, SAFETY, VAGUE
from solver.solution.explore import GRACE, explore
from solver.solution.precise_search import explore_precisely

MAX_STEPS = 2_000
"""Steps of a path, over all answers, that are worth following in extended precision."""


def explore_refined(asked: Asked, always: bool = False) -> Exploration:
    """As ``explore``, with every judged value that has a number right to the last digit of a float.

    Leaves that are refined hold their values to more digits in ``branch.precise``; ``always``: all are,
    needed or not. Raises CutOff where a limit in time is met.
    """
    try:
        found = explore(asked, thorough=always)
    except CutOff as reached:
        known = asked.inputs if reached.found.delicate else reached.known
        raise CutOff(certain(asked, reached.found), known) from None
    try:
        if not always and not _delicate(asked, found):
            return found
        return explore_precisely(asked, found) or _meaningful(asked, found)
    except TimeIsUp:
        raise CutOff(certain(asked, found), asked.inputs) from None


def _meaningful(asked: Asked, found: Exploration) -> Exploration:
    """The exploration without answers that are nothing but rounding: the sine of 1e90 + x is any number for
    values of 1e90 that are next to one another, and the rule holds whatever x is."""
    leaves = tuple(leaf for leaf in found.leaves if not (leaf.solved and _meaningless(asked, leaf)))
    return found if len(leaves) == len(found.leaves) else replace(found, leaves=leaves, complete=False)


def _meaningless(asked: Asked, leaf: Leaf) -> bool:
    errors, values = leaf_errors(asked.model, leaf).error, leaf.branch.values
    numbers = ((name, v) for name in asked.judged if isinstance(v := values.get(name), float) and v)
    return any(MEANINGLESS * abs(v) < errors[name] < math.inf for name, v in numbers)


def certain(asked: Asked, found: Exploration) -> Exploration:
    """The answers that floats are sure of: the only part of a search that was cut off that tells anything."""
    leaves: tuple[Leaf, ...] = ()
    with grace(GRACE), suppress(TimeIsUp):
        if not found.delicate:
            leaves = tuple(one for one in found.leaves if one.solved and not _vague(asked, one))
    return replace(found, leaves=leaves, dead=(), adrift=(), complete=False)


def _delicate(asked: Asked, found: Exploration) -> bool:
    """Whether floats may have lost digits of an answer, or the answer to whether there is one."""
    leaves = (*found.leaves, *found.dead)
    if sum(len(leaf.branch.steps) for leaf in leaves) > MAX_STEPS:
        return False
    return found.delicate or any(_vague(asked, leaf) for leaf in leaves)


def _vague(asked: Asked, leaf: Leaf) -> bool:
    told, values = leaf_errors(asked.model, leaf), leaf.branch.values
    errors = told.error
    numbers = {name: abs(v) for name, v in values.items() if isinstance(v, float)}
    names, limit = (asked.judged, VAGUE) if leaf.solved else (tuple(numbers), LOST)
    return (
        told.cancelled
        or any(errors[name] > limit * numbers[name] for name in names if name in numbers)
        or any(errors[name] >= NO_DIGIT * size > 0.0 for name, size in numbers.items())
        or any(
            isinstance(c, Conflict) and _within_errors(asked.model, c, values, errors) for c in leaf.conflicts
        )
    )


def _within_errors(
    model: Model, conflict: Conflict, values: Mapping[str, Value], errors: Mapping[str, float]
) -> bool:
    """Whether a rule is missed by no more than the errors of the values explain."""
    for equation in (model.equations[index] for index in conflict.equations):
        try:
            reach = sum(abs(s) * errors.get(name, 0.0) for name, s in slopes(equation, values).items())
        except Undefined:
            return True
        if conflict.miss is not None and abs(conflict.miss) <= SAFETY * reach:
            return True
    return False


# --- requirements on single unknowns as ranges: a search that cannot cover everything keeps to them ---

_MIRRORED = {"<": ">", "<=": ">=", ">": "<", ">=": "<="}


def explore_required(asked: Asked, always: bool = False) -> Exploration:
    """As ``explore_refined``; where that leaves something open, again within what requirements allow.

    Answers that break a requirement remain known from the first search.
    """
    found = explore_refined(asked, always)
    if found.complete or not asked.model.requirements:
        return found
    within = narrowed(asked.model, asked.inputs)
    if within is None:
        return found
    try:
        inside = explore_refined(asked._replace(model=within), always)
    except TimeIsUp:
        raise CutOff(certain(asked, found), asked.inputs) from None
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
