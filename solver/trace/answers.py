"""The endings of a program as all answers of a row on arrays: in their order, none of them twice.

Endings whose order is known beforehand stand in it, others are exchanged in pairs by selections (an insertion
sort without branches, stable as the list's own).
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
    order: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class AllAnswers:
    """``symbols`` (one a wanted name) are the words that a column of symbols has the numbers of, or None.

    ``there`` tells of each place whether it is no answer again that stands before it. All of it counts where
    the node ``holds`` is true.
    """

    places: tuple[Place, ...]
    there: tuple[int, ...]
    symbols: tuple[tuple[str, ...] | None, ...]
    holds: int


def every(program: Program) -> AllAnswers:
    """All answers of every row. Raises NotCompilable where symbols stand beside numbers, or orders differ."""
    flow, holds = program.flow, program.flow.true
    symbols = tuple(map(_words, zip(*(ending.results for ending in program.endings), strict=True)))
    for ending in program.endings:
        holds = flow.add("and", holds, counts(flow, ending))
    places = _sorted(flow, [Place(_coded(flow, e, symbols), e.order) for e in program.endings])
    there = list(_once(flow, places))
    pairs = [(place, node) for place, node in zip(places, there, strict=True) if node != flow.false]
    return AllAnswers(tuple(p for p, _ in pairs), tuple(node for _, node in pairs), symbols, holds)


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
    known = [tuple(map(flow.value_of, place.order)) for place in places]
    if all(None not in order for order in known):
        return [place for _, place in sorted(zip(known, places, strict=True), key=lambda pair: pair[0])]
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
