"""Conditions that others imply, and numbers that nothing reads, left out of an ending."""

from __future__ import annotations

from rulesheets.record import replace
from solver.compiled.schedule import operands

TYPE_CHECKING = False
if TYPE_CHECKING:
    from solver.compiled.flow import Flow
    from solver.compiled.program import Ending


def trimmed(flow: Flow, ending: Ending) -> Ending:
    """The same ending with fewer conditions."""
    zero = flow.constant(0.0)
    holds = [check for check in ending.holds if not _implied(flow, check, ending.holds, zero)]
    results = [result for result in ending.results if isinstance(result, int)]
    needed = _read(flow, [*holds, *ending.order, ending.gone, *results])
    finite = [node for node in ending.finite if node in needed]
    return replace(ending, holds=tuple(holds), finite=tuple(finite))


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
    return kind == "lt" and parts[1] == size and _not_negative(flow, int(parts[0]))


def _not_negative(flow: Flow, node: int) -> bool:
    kind, *parts = flow.nodes[node]
    if kind == "const":
        return float(parts[0]) >= 0.0
    if kind in ("abs", "sqrt"):
        return True
    return kind in ("mul", "add") and all(_not_negative(flow, int(part)) for part in parts)


def _read(flow: Flow, wanted: list[int]) -> set[int]:
    """What the wanted nodes are computed from, themselves included."""
    found: set[int] = set()
    while wanted:
        node = wanted.pop()
        if node not in found:
            found.add(node)
            wanted.extend(operands(flow, node))
    return found
