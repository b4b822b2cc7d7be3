"""The endings of a program as all answers of a row: in their order, none of them twice.

What straight-line code lists is sorted by what orders the endings, and an answer whose wanted values another
one had is left out. On arrays both are selections: endings whose order
is known beforehand stand in it, others are exchanged in pairs (an insertion sort without branches, stable as
the list's own).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from solver.compiled.flow import NotCompilable
from solver.compiled.merge import less, states

if TYPE_CHECKING:
    from collections.abc import Iterator

    from solver.compiled.flow import Flow
    from solver.compiled.program import Ending, Program


@dataclass(frozen=True, slots=True)
class Place:
    """One place of the list of answers, as nodes: the wanted values, and whether they count."""

    results: tuple[int, ...]
    order: tuple[int, ...]
    there: int


@dataclass(frozen=True, slots=True)
class AllAnswers:
    """``symbols`` (one a wanted name) are the words that a column of symbols has the numbers of, or None.

    The places count where the node ``holds`` is true: there they are all answers, and there is one.
    """

    places: tuple[Place, ...]
    symbols: tuple[tuple[str, ...] | None, ...]
    holds: int


def every(program: Program) -> AllAnswers:
    """All answers of every row. Raises NotCompilable where symbols stand beside numbers, or orders differ."""
    flow = program.flow
    symbols = tuple(map(_words, zip(*(ending.results for ending in program.endings), strict=True)))
    places, holds, some = [], flow.true, flow.false
    for ending in program.endings:
        there, known = states(flow, ending)
        places.append(Place(_coded(flow, ending, symbols), ending.order, there))
        holds, some = flow.add("and", holds, known), flow.add("or", some, there)
    placed = _sorted(flow, places)
    return AllAnswers(tuple(_once(flow, placed)), symbols, flow.add("and", holds, some))


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
    if len(set(map(len, known))) > 1:
        raise NotCompilable
    placed: list[Place] = []
    for place in places:
        placed.append(place)
        for at in range(len(placed) - 1, 0, -1):
            placed[at - 1 : at + 1] = _exchanged(flow, *placed[at - 1 : at + 1])
    return placed


def _exchanged(flow: Flow, one: Place, other: Place) -> tuple[Place, Place]:
    """Two places in their order; one without an answer comes after one with."""
    sooner = less(flow, other.order, one.order)
    swap = flow.add("and", other.there, flow.add("or", flow.add("not", one.there), sooner))

    def chosen(yes: Place, no: Place, there: int) -> Place:
        results, order = (
            tuple(flow.add("where", swap, *pair) for pair in zip(*pairs, strict=True))
            for pairs in ((yes.results, no.results), (yes.order, no.order))
        )
        return Place(results, order, there)

    some, both = (flow.add(kind, one.there, other.there) for kind in ("or", "and"))
    return chosen(other, one, some), chosen(one, other, both)


def _once(flow: Flow, places: list[Place]) -> Iterator[Place]:
    """The places without those whose values stand at one before them."""
    for at, place in enumerate(places):
        there = place.there
        for before in places[:at]:
            same = before.there
            for pair in zip(before.results, place.results, strict=True):
                if pair[0] != pair[1]:
                    same = flow.add("and", same, flow.add("eq", *pair))
            there = flow.add("and", there, flow.add("not", same))
        yield replace(place, there=there)
