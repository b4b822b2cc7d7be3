"""Random systems for hypothesis, and brute force to hold the algorithms to."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

from hypothesis import settings
from hypothesis import strategies as st

from solver.structure.decomposition import Block, Incidence

patient = settings(deadline=None)
"""Brute force, and the first import of scipy, take the time that the machine has."""


def system(*rows: Sequence[int], unknowns: int | None = None, cost: int = 0) -> Incidence:
    """Every equation resolvable for each of its unknowns at the same cost."""
    n = unknowns if unknowns is not None else 1 + max((u for row in rows for u in row), default=-1)
    return Incidence(
        tuple(tuple(sorted(row)) for row in rows),
        tuple(dict.fromkeys(row, cost) for row in rows),
        n,
    )


@st.composite
def incidences(
    draw: st.DrawFn, equations: int = 6, unknowns: int = 6, square: bool = False
) -> Incidence:
    """Systems of up to so many equations and unknowns, with some edges not resolvable."""
    n = draw(st.integers(1, unknowns))
    m = n if square else draw(st.integers(0, equations))
    rows = [draw(st.sets(st.integers(0, n - 1), max_size=4)) for _ in range(m)]
    if square:  # a diagonal makes it structurally regular
        rows = [row | {i} for i, row in enumerate(rows)]
    costs = st.sampled_from([0, 0, 0, 1, 2, 4, None])
    drawn = [{u: draw(costs) for u in sorted(row)} for row in rows]
    resolvable = tuple({u: cost for u, cost in row.items() if cost is not None} for row in drawn)
    return Incidence(tuple(tuple(sorted(row)) for row in rows), resolvable, n)


def renumbered(incidence: Incidence, equation: Sequence[int], unknown: Sequence[int]) -> Incidence:
    """The same system in another order: old equation e becomes ``equation[e]``, likewise
    unknowns."""
    occurs: list[tuple[int, ...]] = [()] * len(equation)
    resolvable: list[dict[int, int]] = [{}] * len(equation)
    for e, new in enumerate(equation):
        occurs[new] = tuple(sorted(unknown[u] for u in incidence.occurs[e]))
        resolvable[new] = {unknown[u]: cost for u, cost in incidence.resolvable[e].items()}
    return Incidence(tuple(occurs), tuple(resolvable), incidence.unknowns)


@st.composite
def shuffled(draw: st.DrawFn, square: bool = False) -> tuple[Incidence, list[int], list[int]]:
    """A system with a new order of its equations and one of its unknowns."""
    incidence = draw(incidences(square=square))
    equations = draw(st.permutations(range(len(incidence.occurs))))
    return incidence, equations, draw(st.permutations(range(incidence.unknowns)))


def moved(block: Block, equation: Sequence[int], unknown: Sequence[int]) -> Block:
    return Block.of((equation[e] for e in block.equations), (unknown[u] for u in block.unknowns))


def matchable(rows: Sequence[Sequence[int]]) -> bool:
    """Hall's condition (1935), on every subset: whether every row can have an unknown of its
    own."""
    return all(
        len({u for row in some for u in row}) >= size
        for size in range(1, len(rows) + 1)
        for some in combinations(rows, size)
    )


def rank(rows: Sequence[Sequence[int]]) -> int:
    """König and Ore: the size of a maximum matching is the least of rows left out plus unknowns
    met."""
    return min(
        len(rows) - size + len({u for row in some for u in row})
        for size in range(len(rows) + 1)
        for some in combinations(rows, size)
    )


def columns(incidence: Incidence) -> list[list[int]]:
    """The equations of every unknown."""
    return [
        [e for e, row in enumerate(incidence.occurs) if u in row] for u in range(incidence.unknowns)
    ]


def closure(incidence: Incidence, known: set[int]) -> set[int]:
    """What follows, by trying every equation until none gives anything."""
    known = set(known)
    while True:
        left = [(e, set(row) - known) for e, row in enumerate(incidence.occurs)]
        new = {
            u
            for e, unknowns in left
            if len(unknowns) == 1
            for u in unknowns & {*incidence.resolvable[e]}
        }
        if not new:
            return known
        known |= new
