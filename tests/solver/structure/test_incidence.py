"""Parts of a system keep its numbering."""

from __future__ import annotations

from solver.structure.decomposition import Block, Incidence
from tests.solver.structure.incidences import system


def test_column_view() -> None:
    assert system((0, 2), (2,), unknowns=4).users == {0: [0], 1: [], 2: [0, 1], 3: []}


def test_a_part_keeps_numbers_and_forgets_the_rest() -> None:
    whole = Incidence(((0, 1), (1, 2), (0, 2)), ({0: 1}, {1: 2, 2: 0}, {}), 3)
    part = whole.restrict(Block((1, 2), (2,)))
    assert part.block == Block((1, 2), (2,))
    assert (part.occurs[1], part.occurs[2]) == ((2,), (2,))
    assert part.resolvable[1] == {2: 0}
    assert part.users == {2: [1, 2]}
    assert (whole.edges, part.edges) == (6, 2)


def test_a_block_is_ascending() -> None:
    assert Block.of({3, 1}, [2, 0]) == Block((1, 3), (0, 2))
