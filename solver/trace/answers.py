"""The endings of a program as all answers of a row on arrays: in their order, none of them twice.

Where that is not known beforehand they are exchanged in pairs by selections (an insertion sort without
branches, stable as the list's own).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from solver.trace.flow import Flow, NotCompilable
from solver.trace.program import Ending, Program, counts


@dataclass(frozen=True, slots=True)
class Place:
    """One place of the list of answers, as nodes: the wanted values, and what sorts them."""

    results: tuple[int, ...]
    order: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class AllAnswers:
    """``symbols`` (one a wanted name) are the words that a column of symbols has the numbers of, or None.

    ``there`` tells of each place that its values stand at none before it. All of it counts where the node
    ``holds`` is true; where ``usual`` is, the order is known.
    """

    places: tuple[Place, ...]
    there: tuple[int, ...]
    symbols: tuple[tuple[str, ...] | None, ...]
    holds: int
    usual: int


def every(program: Program, in_order: bool) -> AllAnswers:
    """All answers of every row, sorted, or else as they stand.

    Raises NotCompilable where symbols stand beside numbers.
    """
    flow, order = program.flow, program.order
    holds = usual = flow.true
    symbols = tuple(map(_words, zip(*(ending.results for ending in program.endings), strict=True)))
    for ending in program.endings:
        holds = flow.add("and", holds, counts(flow, ending))
    places = [Place(_coded(flow, e, symbols)) for e in program.endings]
    if in_order:
        for told in order.told:
            holds = flow.add("and", holds, told)
        pairs = zip(places, order.keys, strict=True)
        places = _sorted(flow, [Place(place.results, key) for place, key in pairs])
    elif order.keys:
        usual = flow.constant(bool(order.usual))
        for node, low, high in order.usual:
            usual = flow.add("and", usual, flow.add("le", flow.constant(low), node))
            usual = flow.add("and", usual, flow.add("le", node, flow.constant(high)))
    return AllAnswers(tuple(places), tuple(_once(flow, places)), symbols, holds, usual)


def _words(column: tuple[int | str, ...]) -> tuple[str, ...] | None:
    """The symbols that a wanted variable can be."""
    words = {result for result in column if isinstance(result, str)}
    if words and not all(isinstance(result, str) for result in column):
        raise NotCompilable
    return tuple(sorted(words)) or None


def _coded(flow: Flow, ending: Ending, symbols: tuple[tuple[str, ...] | None, ...]) -> tuple[int, ...]:
    return tuple(
        flow.constant(float(words.index(result))) if words and isinstance(result, str) else int(result)
        for result, words in zip(ending.results, symbols, strict=True)
    )


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
