"""The operations that some results need, in order, with registers for them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from solver.trace.flow import Flow

LOGICAL = frozenset({"lt", "le", "eq", "near", "and", "or", "xor", "not", "finite", "sooner"})
LEAVES = frozenset({"const", "input"})
SELECTORS = frozenset({"call", "root", "item"})
"""Operations whose first operand is no node."""


@dataclass(frozen=True, slots=True)
class Schedule:
    """``order`` lists the nodes to compute; ``last`` is the place in it after which a node is not read."""

    order: tuple[int, ...]
    last: dict[int, int]


def operands(flow: Flow, node: int) -> tuple[int, ...]:
    """The nodes that a node reads."""
    operation, *rest = flow.nodes[node]
    if operation in LEAVES:
        return ()
    return tuple(int(o) for o in (rest[1:] if operation in SELECTORS else rest))


def schedule(flow: Flow, wanted: Sequence[int]) -> Schedule:
    """Depth first from the wanted nodes, so that what is computed is soon read.

    The sine and the cosine of one angle stand side by side.
    """
    order: list[int] = []
    placed: set[int] = set()
    partner = _partners(flow, wanted)

    def place(node: int) -> None:
        stack = [(node, False)]
        while stack:
            at, ready = stack.pop()
            if at in placed or flow.nodes[at][0] in LEAVES:
                continue
            if ready:
                placed.add(at)
                order.append(at)
                if at in partner and partner[at] not in placed:
                    placed.add(partner[at])
                    order.append(partner[at])
                continue
            stack.append((at, True))
            stack.extend((o, False) for o in reversed(operands(flow, at)))

    for node in wanted:
        place(node)
    last = {node: place for place, node in enumerate(order)}
    for at, node in enumerate(order):
        for operand in operands(flow, node):
            last[operand] = at
    for node in wanted:
        last[node] = len(order)
    return Schedule(tuple(order), last)


def _partners(flow: Flow, wanted: Sequence[int]) -> dict[int, int]:
    needed: set[int] = set()
    waiting = list(wanted)
    while waiting:
        node = waiting.pop()
        if node not in needed:
            needed.add(node)
            waiting.extend(operands(flow, node))
    by_angle: dict[int, dict[str, int]] = {}
    for node in needed:
        operation, *rest = flow.nodes[node]
        if operation in ("sind", "cosd"):
            by_angle.setdefault(int(rest[0]), {})[str(operation)] = node
    pairs = [tuple(found.values()) for found in by_angle.values() if len(found) == 2]
    return {one: other for a, b in pairs for one, other in ((a, b), (b, a))}
