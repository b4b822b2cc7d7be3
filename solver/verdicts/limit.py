"""Blocks without an answer whose equations are 0/0 where there would be one."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rulesheets.evaluate import Undefined, derivatives
from rulesheets.model import Model, Value
from rulesheets.syntax.nodes import Expression, Quotient, operands
from solver.facts import Filled, NoRoot
from solver.result import Status
from solver.solution.casework import indeterminacy
from solver.solution.limits import answers_between
from solver.verdicts.verdict import Verdict

NEAR = 1e-4
"""Share of the change that its variables make of it, below which a side of a quotient may be 0."""


def at_a_limit(
    model: Model,
    verdict: Verdict,
    inputs: Mapping[str, Value],
    want: Sequence[str] | None,
    guesses: Mapping[str, float],
    judged: Sequence[str],
) -> Verdict | None:
    """The verdict that rules are undefined where there is an answer in the limit; None if there is none."""
    if not any(_near_zero_by_zero(model, verdict)):
        return None
    for leaf in answers_between(model, inputs, want, guesses, judged):
        filled = (fact.equation for fact in leaf.branch.facts if isinstance(fact, Filled))
        facts = tuple(indeterminacy(model.equations[index], leaf.branch.values) for index in filled)
        return Verdict(Status.SINGULAR, verdict.leaves, tuple(filter(None, facts)), verdict.undetermined)
    return None


def _near_zero_by_zero(model: Model, verdict: Verdict) -> Iterator[bool]:
    for fact in verdict.facts:
        if isinstance(fact, NoRoot) and verdict.leaves:
            values = {**verdict.leaves[0].branch.values, **fact.best}
            for equation in (model.equations[index] for index in fact.equations):
                yield any(_has_zero_by_zero(side, values) for side in (equation.left, equation.right))


def _has_zero_by_zero(side: Expression, values: Mapping[str, Value]) -> bool:
    stack: list[Any] = [side]
    while stack:
        node = stack.pop()
        if isinstance(node, Quotient) and all(_small(part, values) for part in (node.left, node.right)):
            return True
        stack.extend(operands(node))
    return False


def _small(part: Expression, values: Mapping[str, Value]) -> bool:
    try:
        number, slopes = derivatives(part, values)
    except (Undefined, KeyError, TypeError):
        return False
    return abs(number) <= NEAR * sum(
        abs(s * v) for n, s in slopes.items() if isinstance(v := values[n], float)
    )
