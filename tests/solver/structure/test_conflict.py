"""Conflicts: one equation too many, and none that could be left out."""

from __future__ import annotations

import pytest
from hypothesis import given

from solver.structure.conflict import minimal_conflict
from solver.structure.incidence import Block, Incidence
from solver.structure.matching import Matching, maximum_matching
from tests.solver.structure.incidences import incidences, matchable, patient, system


@patient
@given(incidences(equations=7, unknowns=4))
def test_every_member_is_needed(incidence: Incidence) -> None:
    for single in maximum_matching(incidence).single_equations:
        conflict = minimal_conflict(incidence, single)
        rows = [incidence.occurs[e] for e in conflict.equations]
        assert single in conflict.equations
        assert set(conflict.unknowns) == {u for row in rows for u in row}
        assert len(rows) == len(conflict.unknowns) + 1
        assert not matchable(rows)
        assert all(matchable(rows[:i] + rows[i + 1 :]) for i in range(len(rows)))


def test_the_pair_is_named_and_bystanders_are_not() -> None:
    """x + y = 26, z = 1, x + y = 27, x = z."""
    assert minimal_conflict(system((0, 1), (2,), (0, 1), (0, 2), (2,)), 4) == Block((1, 4), (2,))


def test_a_derivation_decides_which_equations_are_blamed() -> None:
    """Three equations for one unknown: the check is at odds with the one that was used."""
    same = system((0,), (0,), (0,))
    assert minimal_conflict(same, 2).equations == (0, 2)
    assert minimal_conflict(same, 2, Matching.of(same, [(1, 0)])).equations == (1, 2)


def test_a_matched_equation_is_refused() -> None:
    with pytest.raises(ValueError, match="unknown of its own"):
        minimal_conflict(system((0,), (0,)), 0)
