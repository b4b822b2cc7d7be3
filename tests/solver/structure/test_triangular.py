"""Block triangular form: each block needs only earlier ones, and none can be split."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations

import pytest
from hypothesis import given

from solver.structure.decomposition import Block, Incidence, block_triangular
from tests.oracles.operations import growth
from tests.solver.structure.incidences import (
    incidences,
    moved,
    patient,
    renumbered,
    shuffled,
    system,
)


@patient
@given(incidences(square=True))
def test_each_block_needs_only_what_comes_before(incidence: Incidence) -> None:
    known: set[int] = set()
    equations: list[int] = []
    for block in block_triangular(incidence):
        assert len(block.equations) == len(block.unknowns)
        known |= set(block.unknowns)
        equations += block.equations
        assert all(set(incidence.occurs[e]) <= known for e in block.equations)
    assert sorted(equations) == sorted(known) == list(range(incidence.unknowns))


@patient
@given(incidences(square=True))
def test_no_block_can_be_split(incidence: Incidence) -> None:
    for block in block_triangular(incidence):
        rows = [set(incidence.occurs[e]) & set(block.unknowns) for e in block.equations]
        for size in range(1, len(rows)):
            assert all(len(set().union(*some)) > size for some in combinations(rows, size))


@patient
@given(shuffled(square=True))
def test_shuffling_keeps_the_blocks(case: tuple[Incidence, list[int], list[int]]) -> None:
    incidence, equations, unknowns = case
    expected = {moved(block, equations, unknowns) for block in block_triangular(incidence)}
    assert set(block_triangular(renumbered(*case))) == expected


def test_ready_blocks_come_in_source_order() -> None:
    blocks = block_triangular(system((3, 0), (1,), (2, 1), (3,)))
    assert [block.equations for block in blocks] == [(1,), (2,), (3,), (0,)]


def test_a_part_of_a_larger_system() -> None:
    incidence = system((0, 1), (1, 2), (1, 2))
    assert block_triangular(incidence, Block((1, 2), (1, 2))) == (Block((1, 2), (1, 2)),)


@pytest.mark.parametrize(
    "incidence", [system((0,), (0,), unknowns=2), system((0, 1)), system((0,), (0,))]
)
def test_a_part_that_cannot_be_matched_is_refused(incidence: Incidence) -> None:
    with pytest.raises(ValueError, match="as many independent equations"):
        block_triangular(incidence)


def test_a_chain_of_a_hundred_thousand() -> None:
    n = 100_000
    chain = system((0,), *((i - 1, i) for i in range(1, n)))
    assert [block.unknowns for block in block_triangular(chain)] == [(i,) for i in range(n)]


def test_the_cost_is_linear() -> None:
    def chain(n: int) -> Callable[[], object]:
        made = system((0,), *((i - 1, i) for i in range(1, n)))
        return lambda: block_triangular(made)

    def rings(n: int) -> Callable[[], object]:
        made = system(*(tuple(ring) for ring in blocks_of_five(n)))
        return lambda: block_triangular(made)

    assert growth(chain, 2_000) < 1.2
    assert growth(rings, 200) < 1.2


def blocks_of_five(count: int) -> list[set[int]]:
    return [
        {5 * b + k, 5 * b + (k + 1) % 5, max(5 * b - 1, 0)} for b in range(count) for k in range(5)
    ]


def test_thousands_of_blocks_of_five() -> None:
    count = 6400
    blocks = block_triangular(system(*(tuple(ring) for ring in blocks_of_five(count))))
    assert [block.equations for block in blocks] == [
        tuple(range(5 * b, 5 * b + 5)) for b in range(count)
    ]
