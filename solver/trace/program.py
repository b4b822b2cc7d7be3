"""What a record is: a graph of operations, the results of each answer, and when they count."""

from __future__ import annotations

from dataclasses import dataclass

from solver.trace.flow import Flow
from solver.trace.order import UNORDERED, Order


@dataclass(frozen=True, slots=True)
class Ending:
    """One answer as nodes of the graph: the wanted values (a symbol by its name).

    They count where all that ``holds`` is true and all that is ``finite`` is a finite number.
    """

    results: tuple[int | str, ...]
    holds: tuple[int, ...]
    finite: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Program:
    """``inputs`` is how many numbers it takes; ``symbols`` are the inputs, by place, that must be these.

    The endings are all answers of a row, in the order of the sample; ``order`` tells that of a row. Where one
    of them does not count, none does.
    """

    flow: Flow
    inputs: int
    endings: tuple[Ending, ...]
    symbols: tuple[tuple[int, str], ...] = ()
    order: Order = UNORDERED

    @property
    def wanted(self) -> tuple[int, ...]:
        """Every node that is read of the answers."""
        return tuple(
            node
            for e in self.endings
            for node in (*e.holds, *e.finite, *(r for r in e.results if isinstance(r, int)))
        )


def counts(flow: Flow, ending: Ending) -> int:
    """The node that is true where an ending counts."""
    holds = flow.true
    for check in ending.holds:
        holds = flow.add("and", holds, _whole(flow, check))
    total = None
    for node in ending.finite:
        total = node if total is None else flow.add("add", total, node)
    return holds if total is None else flow.add("and", holds, flow.node("finite", total))


def _whole(flow: Flow, condition: int) -> int:
    """A condition without its short cuts, which are of no use where every row computes everything."""
    kind, *parts = flow.nodes[condition]
    if kind == "sooner":
        return _whole(flow, int(parts[1]))
    if kind in ("and", "or", "not", "xor"):
        return flow.add(str(kind), *(_whole(flow, int(part)) for part in parts))
    return condition
