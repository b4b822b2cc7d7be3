"""The three parts against their definition: which nodes some maximum matching leaves single."""

from __future__ import annotations

from hypothesis import given

from solver.structure.decomposition import Block, Incidence, Parts, dulmage_mendelsohn
from tests.solver.structure.incidences import (
    columns,
    incidences,
    moved,
    patient,
    rank,
    renumbered,
    shuffled,
    system,
)


def without(rows: list[list[int]], i: int) -> list[list[int]]:
    return rows[:i] + rows[i + 1 :]


def never_needed(rows: list[list[int]]) -> set[int]:
    """Rows without which a matching can be as large."""
    size = rank(rows)
    return {i for i in range(len(rows)) if rank(without(rows, i)) == size}


@patient
@given(incidences(equations=5, unknowns=5))
def test_parts_follow_the_definition(incidence: Incidence) -> None:
    parts = dulmage_mendelsohn(incidence)
    rows, cols = [list(row) for row in incidence.occurs], columns(incidence)
    assert set(parts.over.equations) == never_needed(rows)
    assert set(parts.over.unknowns) == {u for e in parts.over.equations for u in rows[e]}
    assert set(parts.under.unknowns) == never_needed(cols)
    assert set(parts.under.equations) == {e for u in parts.under.unknowns for e in cols[u]}


@patient
@given(incidences())
def test_everything_is_in_one_part(incidence: Incidence) -> None:
    parts = dulmage_mendelsohn(incidence)
    three = (parts.over, parts.square, parts.under)
    assert sorted(e for p in three for e in p.equations) == list(range(len(incidence.occurs)))
    assert sorted(u for p in three for u in p.unknowns) == list(range(incidence.unknowns))
    assert len(parts.square.equations) == len(parts.square.unknowns)
    for block, excess in ((parts.over, 1), (parts.under, -1)):
        difference = excess * (len(block.equations) - len(block.unknowns))
        assert difference > 0 or block == Block((), ())


@patient
@given(shuffled())
def test_shuffling_changes_nothing(case: tuple[Incidence, list[int], list[int]]) -> None:
    incidence, equations, unknowns = case
    parts = dulmage_mendelsohn(incidence)
    expected = (moved(p, equations, unknowns) for p in (parts.over, parts.square, parts.under))
    assert dulmage_mendelsohn(renumbered(*case)) == Parts(*expected)


def test_too_many_rules_enough_rules_too_few() -> None:
    parts = dulmage_mendelsohn(system((0, 1), (0, 1), (0, 1), (1, 2), (2, 3, 4)))
    assert parts.over == Block((0, 1, 2), (0, 1))
    assert parts.square == Block((3,), (2,))
    assert parts.under == Block((4,), (3, 4))
