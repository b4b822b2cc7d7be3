"""What a record is: a graph of operations, the results of each answer, and when they count.

On arrays the endings are all answers of a row in their order, none
of them twice; where the order is not known beforehand they are exchanged in pairs by selections (an insertion
sort without branches, stable as the list is).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

from solver.trace.flow import Flow
from solver.trace.graph import NotCompilable
from solver.trace.order import UNORDERED, Order, Ranked


class Ending(NamedTuple):
    """One answer as nodes of the graph: the wanted values (a symbol by its name).

    They count where all that ``holds`` is true and all that is ``finite`` is a finite number.
    """

    results: tuple[int | str, ...]
    holds: tuple[int, ...]
    finite: tuple[int, ...]


@dataclass(slots=True)
class Box:
    """Ranges of the inputs that are numbers: the ends of each. ``told`` counts the answers told there."""

    ends: tuple[float, ...]
    told: int = 0


class Program(NamedTuple):
    """``inputs`` is how many numbers it takes; ``symbols`` are the inputs, by place, that must be these.

    The endings are all answers of a row, in the order of the sample; ``order`` tells that of a row. Where one
    of them does not count, none does. ``brief`` tells the first answer of most rows with less work: of the
    endings that it has ``alone``, each with what is asked of all, only the first one has to count. Where
    answers are iterated, ``ranked`` is what orders them. A single input lies inside its ``reach``, and each
    of them within the ``box``.
    """

    flow: Flow
    inputs: int
    endings: tuple[Ending, ...]
    symbols: tuple[tuple[int, str], ...] = ()
    order: Order = UNORDERED
    brief: Program | None = None
    alone: tuple[Ending, ...] = ()
    ranked: Ranked | None = None
    reach: tuple[float, float] = (-math.inf, math.inf)
    box: Box | None = None

    @property
    def wanted(self) -> tuple[int, ...]:
        """Every node that is read of the answers."""
        return tuple(
            node
            for e in self.endings
            for node in (*e.holds, *e.finite, *(r for r in e.results if isinstance(r, int)))
        )


def counts(flow: Flow, ending: Ending, quick: bool = False) -> int:
    """The node that is true where an ending counts; ``quick``: only where it is soon seen to count."""
    holds = flow.true
    for check in ending.holds:
        holds = flow.add("and", holds, _straight(flow, check, quick))
    total = None
    for node in ending.finite:
        total = node if total is None else flow.add("add", total, node)
    return holds if total is None else flow.add("and", holds, flow.node("finite", total))


def _straight(flow: Flow, condition: int, quick: bool) -> int:
    """A condition without its short cuts, which are of no use where every row computes everything.

    Where it is ``quick`` a short cut stands for the whole, but not for the opposite of it.
    """
    kind, *parts = flow.nodes[condition]
    if kind == "sooner":
        return _straight(flow, int(parts[0 if quick else 1]), quick)
    if kind in ("and", "or", "not", "xor"):
        quick = quick and kind in ("and", "or")
        return flow.add(str(kind), *(_straight(flow, int(part), quick) for part in parts))
    return condition


def each_of(flow: Flow, conditions: Iterable[int]) -> Iterator[int]:
    """Conditions one by one."""
    for condition in conditions:
        kind, *parts = flow.nodes[condition]
        if kind == "and":
            yield from each_of(flow, map(int, parts))
        else:
            yield condition


class Place(NamedTuple):
    """One place of the list of answers, as nodes: the wanted values, and what sorts them."""

    results: tuple[int, ...]
    order: tuple[int, ...] = ()


class AllAnswers(NamedTuple):
    """``symbols`` (one a wanted name) are the words that a column of symbols has the numbers of, or None.

    ``there`` tells of each place that its values stand at none before it. All of it counts where the node
    ``holds`` is true.
    """

    places: tuple[Place, ...]
    there: tuple[int, ...]
    symbols: tuple[tuple[str, ...] | None, ...]
    holds: int


def every(program: Program, in_order: bool, quick: bool) -> AllAnswers:
    """All answers of every row, sorted, or else as they stand; ``quick`` as in ``counts``.

    Raises NotCompilable where symbols stand beside numbers.
    """
    flow, order = program.flow, program.order
    holds = flow.true
    symbols = tuple(map(_words, zip(*(ending.results for ending in program.endings), strict=True)))
    for ending in program.endings:
        holds = flow.add("and", holds, counts(flow, ending, quick))
    pairs = [zip(ending.results, symbols, strict=True) for ending in program.endings]
    coded = [tuple(flow.constant(float(w.index(str(r)))) if w else int(r) for r, w in pair) for pair in pairs]
    places = [Place(results) for results in coded]
    if in_order:
        for told in order.told:
            holds = flow.add("and", holds, told)
        places = _sorted(flow, [Place(*pair) for pair in zip(coded, order.keys, strict=True)])
    return AllAnswers(tuple(places), tuple(_once(flow, places)), symbols, holds)


def _words(column: tuple[int | str, ...]) -> tuple[str, ...] | None:
    """The symbols that a wanted variable can be."""
    words = {result for result in column if isinstance(result, str)}
    if words and not all(isinstance(result, str) for result in column):
        raise NotCompilable
    return tuple(sorted(words)) or None


def _sorted(flow: Flow, places: list[Place]) -> list[Place]:
    placed: list[Place] = []
    for place in places:
        placed.append(place)
        for at in range(len(placed) - 1, 0, -1):
            placed[at - 1 : at + 1] = _exchanged(flow, *placed[at - 1 : at + 1])
    return placed


def _exchanged(flow: Flow, one: Place, other: Place) -> tuple[Place, Place]:
    """Two places in their order."""
    swap = _less(flow, other.order, one.order)

    def chosen(yes: Place, no: Place) -> Place:
        pairs = (yes.results, no.results), (yes.order, no.order)
        return Place(
            *(tuple(flow.add("where", swap, a, b) for a, b in zip(*pair, strict=True)) for pair in pairs)
        )

    return chosen(other, one), chosen(one, other)


def _less(flow: Flow, one: tuple[int, ...], other: tuple[int, ...]) -> int:
    """Lexicographic order."""
    less = flow.false
    for a, b in reversed(list(zip(one, other, strict=True))):
        less = flow.add("or", flow.add("lt", a, b), flow.add("and", flow.add("eq", a, b), less))
    return less


def _once(flow: Flow, places: list[Place]) -> Iterator[int]:
    """Of each place the node that is true where its values stand at none before it."""
    for at, place in enumerate(places):
        there = flow.true
        for before in places[:at]:
            same = flow.true
            for pair in zip(before.results, place.results, strict=True):
                same = flow.add("and", same, flow.add("eq", *pair))
            there = flow.add("and", there, flow.add("not", same))
        yield there
