"""Which variables may hold symbols: what a column of a file is, before its first value is known."""

from __future__ import annotations

from collections.abc import Iterator

from rulesheets.model import Model
from rulesheets.nodes import Comparison, Condition, Expression, Name, Symbol, children


def symbolic(model: Model) -> frozenset[str]:
    """Variables that are given a symbol, compared with one, or tied to such a variable by a rule."""
    found = {name for name, variable in model.variables.items() if isinstance(variable.value, str)}
    pairs = [(equation.left, equation.right) for equation in model.equations]
    for condition in model.conditions:
        pairs.extend(_compared(condition))
    ties = [tuple(side.name for side in pair if isinstance(side, Name)) for pair in pairs]
    for pair, names in zip(pairs, ties, strict=True):
        if any(isinstance(side, Symbol) for side in pair):
            found.update(names)
    while True:
        reached = {name for names in ties if found.intersection(names) for name in names}
        if reached <= found:
            return frozenset(found)
        found |= reached


def _compared(node: Condition | Expression) -> Iterator[tuple[Expression, Expression]]:
    if isinstance(node, Comparison):
        yield node.left, node.right
    for part in children(node):
        yield from _compared(part)
