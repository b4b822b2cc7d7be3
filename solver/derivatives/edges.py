"""Comparisons that stand on their edge at an answer: both sides equal, so that a move changes the rules."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from itertools import product

from rulesheets import nodes
from rulesheets.evaluate import Undefined, holds, value
from rulesheets.evaluate.conditions import equal
from rulesheets.model import Model, Value
from solver.path.cases import EQUAL, GREATER, LESS, Pair, assumed_outcome, comparisons, outcome

MOST = 3
"""Edges that are told apart; at more of them at once nothing is said."""


def edges(model: Model, values: Mapping[str, Value]) -> tuple[Pair, ...]:
    """The pairs of numbers that guards compare, that are equal at ``values`` and can move."""
    guards = {premise.condition for equation in model.equations for premise in equation.guard}
    found: dict[Pair, None] = {}
    for index in sorted(guards):
        for atom in comparisons(model.conditions[index]):
            pair = atom.left, atom.right
            if pair[::-1] not in found and _even(pair, values):
                found[pair] = None
    return tuple(found)


def _even(pair: Pair, values: Mapping[str, Value]) -> bool:
    if not any(True for side in pair for _ in nodes.names(side)):
        return False
    try:
        left, right = (value(side, values) for side in pair)
    except (Undefined, KeyError):
        return False
    return equal(left, right)


def sides(pairs: Collection[Pair]) -> Iterator[dict[Pair, int]]:
    """Every way in which the pairs can come apart, or stay equal."""
    for signs in product((EQUAL, LESS, GREATER), repeat=len(pairs)):
        yield dict(zip(pairs, signs, strict=True))


def outcomes(
    model: Model, values: Mapping[str, Value], inputs: Collection[str], signs: Mapping[Pair, int]
) -> dict[int, bool]:
    """How the conditions come out where the pairs have these signs."""

    def settle(atom: nodes.Condition) -> bool | None:
        assumed = assumed_outcome(atom, signs) if isinstance(atom, nodes.Comparison) else None
        if assumed is not None:
            return assumed
        try:
            return holds(atom, values, inputs)
        except KeyError:
            return None
        except Undefined:
            return False

    found = {index: outcome(condition, settle) for index, condition in enumerate(model.conditions)}
    return {index: known for index, known in found.items() if known is not None}
