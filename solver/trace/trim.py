"""Conditions that others imply, and numbers that nothing reads, left out of an ending."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from solver.trace.flow import Flow
from solver.trace.program import Ending
from solver.trace.schedule import operands
from solver.trace.simplify import not_negative


def trimmed(flow: Flow, ending: Ending) -> Ending:
    """The same ending with fewer conditions."""
    zero = flow.constant(0.0)
    holds = [check for check in ending.holds if not _implied(flow, check, ending.holds, zero)]
    results = [result for result in ending.results if isinstance(result, int)]
    needed = computed_from(flow, [*holds, *results]) | flow.always
    finite, sure = _heads(flow, [node for node in ending.finite if node in needed])
    holds = [check for check in holds if not _shown(flow, check, sure, zero)]
    return replace(ending, holds=tuple(holds), finite=tuple(finite))


_INHERITING = frozenset({"add", "sub", "mul", "neg", "abs", "sqrt", "sind", "cosd", "sin", "cos"})
"""Operations that give no finite number where an operand is none."""


def _heads(flow: Flow, finite: list[int]) -> tuple[list[int], set[int]]:
    """Those of some numbers that are finite only where the others are, and all that they are finite with."""
    heads: list[int] = []
    sure: set[int] = set()
    for node in sorted(finite, reverse=True):
        if node in sure:
            continue
        heads.append(node)
        waiting = [node]
        while waiting:
            at = waiting.pop()
            if at in sure:
                continue
            sure.add(at)
            kind, *parts = flow.nodes[at]
            if kind in _INHERITING:
                waiting.extend(int(part) for part in parts)
            elif kind == "div":
                waiting.append(int(parts[0]))
    return heads[::-1], sure


def _shown(flow: Flow, check: int, sure: set[int], zero: int) -> bool:
    """Whether finite numbers show it: x ≠ 0 where one is divided by x, x ≥ 0 where one is its root."""
    kind, *parts = flow.nodes[check]
    if kind == "le" and parts[0] == zero:
        return any(flow.nodes[node] == ("sqrt", parts[1]) for node in sure)
    if kind != "not" or flow.nodes[int(parts[0])][0] != "eq":
        return False
    _, number, other = flow.nodes[int(parts[0])]
    return other == zero and any(
        flow.nodes[node][0] == "div" and flow.nodes[node][2] == number for node in sure
    )


def _implied(flow: Flow, check: int, checks: tuple[int, ...], zero: int) -> bool:
    """Whether other conditions say as much: not (a and b) where not a, a ≠ 0 where |a| > k |b|."""
    if flow.nodes[check][0] != "not":
        return False
    inside = int(flow.nodes[check][1])
    kind, *parts = flow.nodes[inside]
    if kind == "and":
        return any(flow.nodes[other] == ("not", part) for part in parts for other in checks)
    if kind != "eq" or parts[1] != zero:
        return False
    size = flow.add("abs", int(parts[0]))
    return any(_exceeds_size(flow, other, size) for other in checks)


def _exceeds_size(flow: Flow, check: int, size: int) -> bool:
    """Whether a condition says that ``size`` is more than something that is not negative."""
    kind, *parts = flow.nodes[check]
    return kind == "lt" and parts[1] == size and not_negative(flow, int(parts[0]))


def computed_from(flow: Flow, wanted: Iterable[int]) -> set[int]:
    """What the wanted nodes are computed from, themselves included."""
    found: set[int] = set()
    waiting = list(wanted)
    while waiting:
        node = waiting.pop()
        if node not in found:
            found.add(node)
            waiting.extend(operands(flow, node))
    return found
