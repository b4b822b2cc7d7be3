"""The endings of a program merged by selections: one result for each row, and whether it counts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from solver.compiled.flow import NotCompilable

if TYPE_CHECKING:
    from solver.compiled.flow import Flow
    from solver.compiled.program import Ending, Program


@dataclass(frozen=True, slots=True)
class Merged:
    """``results`` are nodes (a symbol by its name) that count where the node ``holds`` is true."""

    results: tuple[int | str, ...]
    holds: int


def primary(program: Program) -> Merged:
    """The primary answer of every row."""
    flow, endings = program.flow, program.endings
    found = [states(flow, ending) for ending in endings]
    results, order = endings[0].results, endings[0].order
    have, sure = found[0]
    for ending, (holds, known) in zip(endings[1:], found[1:], strict=True):
        before = flow.add("or", flow.add("not", have), less(flow, ending.order, order))
        better = flow.add("and", holds, before)
        results = tuple(_chosen(flow, better, *pair) for pair in zip(ending.results, results, strict=True))
        order = tuple(flow.add("where", better, *pair) for pair in zip(ending.order, order, strict=True))
        have, sure = flow.add("or", have, holds), flow.add("and", sure, known)
    return Merged(results, flow.add("and", have, sure))


def states(flow: Flow, ending: Ending) -> tuple[int, int]:
    """Whether an ending is an answer, and whether that is known."""
    holds = flow.true
    for check in ending.holds:
        holds = flow.add("and", holds, whole(flow, check))
    total = None
    for node in ending.finite:
        total = node if total is None else flow.add("add", total, node)
    if total is not None:
        holds = flow.add("and", holds, flow.node("finite", total))
    gone = whole(flow, ending.gone)
    if gone == flow.false:
        return holds, holds
    return flow.add("and", holds, flow.add("not", gone)), flow.add("or", holds, gone)


def whole(flow: Flow, condition: int) -> int:
    """A condition without its short cuts, which are of no use where every row computes everything."""
    kind, *parts = flow.nodes[condition]
    if kind in ("sooner", "unless"):
        return whole(flow, int(parts[1]))
    if kind in ("and", "or", "not", "xor"):
        return flow.add(str(kind), *(whole(flow, int(part)) for part in parts))
    return condition


def less(flow: Flow, one: tuple[int, ...], other: tuple[int, ...]) -> int:
    """Lexicographic order."""
    less = flow.false
    for a, b in reversed(list(zip(one, other, strict=True))):
        less = flow.add("or", flow.add("lt", a, b), flow.add("and", flow.add("eq", a, b), less))
    return less


def _chosen(flow: Flow, better: int, one: int | str, other: int | str) -> int | str:
    if isinstance(one, str) or isinstance(other, str):
        if one != other:
            raise NotCompilable
        return one
    return flow.add("where", better, one, other)
