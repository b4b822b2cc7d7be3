"""What a path comes down to for one run of decisions: a graph, its results, and when they count."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from solver.compiled.flow import Flow


@dataclass(frozen=True, slots=True)
class Ending:
    """One way through the forks of a path, as nodes of the graph.

    ``results`` are the wanted values (a symbol by its name), ``holds`` whether all of it is known to be an
    answer, ``gone`` whether it is known to be none; where neither is, the step-by-step way decides.
    ``order`` sorts the answers, the primary first.
    """

    results: tuple[int | str, ...]
    holds: tuple[int, ...]
    finite: tuple[int, ...]
    gone: int
    order: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Program:
    """``inputs`` is how many numbers it takes; ``symbols`` are the inputs, by place, that must be these.

    ``ordered``: the rule of which answer comes first orders the endings.
    """

    flow: Flow
    inputs: int
    endings: tuple[Ending, ...]
    symbols: tuple[tuple[int, str], ...] = ()
    ordered: bool = False
