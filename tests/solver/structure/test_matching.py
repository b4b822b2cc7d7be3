"""Maximum matchings against Hall's and König's theorems."""

from __future__ import annotations

from itertools import combinations
from random import Random

from hypothesis import given

from solver.structure.decomposition import Incidence, maximum_matching
from tests.solver.structure.incidences import columns, incidences, matchable, patient, rank, system


@patient
@given(incidences())
def test_a_matching_is_maximum_and_consistent(incidence: Incidence) -> None:
    found = maximum_matching(incidence)
    pairs = [(e, u) for e, u in found.unknown_of.items() if u is not None]
    assert all(u in incidence.occurs[e] and found.equation_of[u] == e for e, u in pairs)
    matched = [u for u, e in found.equation_of.items() if e is not None]
    assert len(pairs) == len(matched) == rank(incidence.occurs)


@patient
@given(incidences())
def test_the_first_in_the_source_are_matched(incidence: Incidence) -> None:
    found = maximum_matching(incidence)
    equations = [e for e, u in found.unknown_of.items() if u is not None]
    unknowns = [u for u, e in found.equation_of.items() if e is not None]
    assert equations == first_matchable(incidence.occurs)
    assert unknowns == first_matchable(columns(incidence))


def first_matchable(rows: tuple[tuple[int, ...], ...] | list[list[int]]) -> list[int]:
    """The lexicographically first of the largest sets of rows that can be matched."""
    sets = combinations(range(len(rows)), rank(rows))
    return list(next(s for s in sets if matchable([rows[i] for i in s])))


def test_a_long_alternating_path_is_no_deep_recursion() -> None:
    n = 1500
    rows = [(i, i + 1) for i in range(n - 1)]
    found = maximum_matching(system(*rows, (0,)))
    assert None not in found.unknown_of.values()


def test_blocks_in_layers_are_no_exponential_search() -> None:
    """Each block of five reads the one before, so that levels double the paths between their
    ends."""
    blocks, size = 200, 5
    rows = [
        (*range(size * b, size * b + size), *((size * (b - 1) + i,) if b else ()))
        for b in range(blocks)
        for i in range(size)
    ]
    Random(1).shuffle(rows)
    assert None not in maximum_matching(system(*rows)).unknown_of.values()


def test_rows_are_read_a_few_times_each() -> None:
    """Points on levels, each with its neighbours and one of the next level; the first level's own
    come last.

    Nearly every equation starts with an unknown that another one needs, and a search in depth reads
    most of them again for each of the last ones.
    """
    width, levels = 400, 5
    near = [sorted({max(i - 1, 0), i, min(i + 1, width - 1)}) for i in range(width)]
    rows = [
        (*(width * level + j for j in near[i]), width * (level + 1) + i)
        for level in range(levels - 1)
        for i in range(width)
    ]
    net = system(*rows, *near)
    counted = Counted(enumerate(net.occurs))
    found = maximum_matching(Incidence(counted, net.resolvable, net.unknowns, net.block))
    assert None not in found.unknown_of.values()
    assert counted.reads < 20 * len(counted)


class Counted(dict[int, tuple[int, ...]]):
    """Rows that count how often one of them is read."""

    reads = 0

    def __getitem__(self, row: int) -> tuple[int, ...]:
        self.reads += 1
        return super().__getitem__(row)


def test_single_nodes() -> None:
    found = maximum_matching(system((0,), (0,), unknowns=2))
    assert found.unknown_of == {0: 0, 1: None}
    assert found.equation_of == {0: 0, 1: None}
    assert found.single_unknowns == (1,)
