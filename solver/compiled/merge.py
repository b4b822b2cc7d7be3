"""When an ending of a program counts, and the order of endings, as nodes."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from solver.compiled.flow import Flow
    from solver.compiled.program import Ending


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
