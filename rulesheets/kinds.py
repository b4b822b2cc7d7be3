"""What a variable can hold, by the rules that read it: a symbol, or a number alone."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator

from rulesheets.model import Model
from rulesheets.syntax.nodes import Comparison, Condition, Expression, Name, Symbol, children, names


def symbolic(model: Model) -> frozenset[str]:
    """Variables that are given a symbol, compared with one, or tied to such a variable by a rule."""
    found = {name for name, variable in model.variables.items() if isinstance(variable.value, str)}
    pairs = _pairs(model)
    for condition in model.conditions:
        pairs.extend(_compared(condition))
    found.update(
        side.name
        for pair in pairs
        if any(isinstance(side, Symbol) for side in pair)
        for side in pair
        if isinstance(side, Name)
    )
    return _tied(found, pairs)


def quantities(model: Model) -> frozenset[str]:
    """Variables that can be nothing but a number.

    They have a unit or a range, or a rule computes with them or with what is tied to them, and nothing says
    that they may be symbols.
    """
    known: frozenset[str] | None = model.__dict__.get("_quantities")
    if known is None:
        known = model.__dict__["_quantities"] = _quantities(model)
    return known


def _quantities(model: Model) -> frozenset[str]:
    declared = {
        name for name, v in model.variables.items() if v.unit or math.isfinite(v.low) or math.isfinite(v.high)
    }
    pairs = _pairs(model)
    computed = {name for pair in pairs for side in pair if not isinstance(side, Name) for name in names(side)}
    return frozenset(declared) | (_tied(computed, pairs) - symbolic(model))


def _pairs(model: Model) -> list[tuple[Expression, Expression]]:
    return [(equation.left, equation.right) for equation in model.equations]


def _tied(found: Collection[str], pairs: Collection[tuple[Expression, Expression]]) -> frozenset[str]:
    """These variables, and those that rules set equal to one of them, one after another."""
    neighbours: dict[str, list[str]] = {}
    for left, right in pairs:
        if isinstance(left, Name) and isinstance(right, Name):
            neighbours.setdefault(left.name, []).append(right.name)
            neighbours.setdefault(right.name, []).append(left.name)
    reached, waiting = set(found), list(found)
    while waiting:
        new = [name for name in neighbours.get(waiting.pop(), ()) if name not in reached]
        reached.update(new)
        waiting.extend(new)
    return frozenset(reached)


def _compared(node: Condition | Expression) -> Iterator[tuple[Expression, Expression]]:
    if isinstance(node, Comparison):
        yield node.left, node.right
    for part in children(node):
        yield from _compared(part)
