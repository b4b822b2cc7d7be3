"""Propagation against the plain fixpoint, and its order against its promises."""

from __future__ import annotations

import time

from hypothesis import given
from hypothesis import strategies as st

from solver.structure.incidence import Incidence
from solver.structure.propagation import propagate
from tests.solver.structure.incidences import closure, incidences, patient, system


@patient
@given(incidences(), st.sets(st.integers(0, 5)))
def test_everything_that_follows_is_reached_once(incidence: Incidence, known: set[int]) -> None:
    known &= set(range(incidence.unknowns))
    order, checks = propagate(incidence, known)
    reached = known.copy()
    for equation, unknown in order:
        assert unknown in incidence.resolvable[equation]
        assert set(incidence.occurs[equation]) - reached == {unknown}
        reached.add(unknown)
    assert reached == closure(incidence, known)
    used = {equation for equation, _ in order}
    spent = [e for e, row in enumerate(incidence.occurs) if reached >= set(row)]
    assert checks == [e for e in spent if e not in used]


def test_a_round_takes_all_that_is_ripe_before_going_deeper() -> None:
    """Unknown 3 follows in two steps from 0 by way of 1, in one from 0 alone."""
    order, checks = propagate(system((0, 1), (1, 3), (0, 3), (3, 2)), {0})
    assert order == [(0, 1), (2, 3), (3, 2)]
    assert checks == [1]


def test_the_cheapest_equation_gives_the_unknown() -> None:
    incidence = Incidence(((0,), (0,), (0,)), ({0: 2}, {0: 0}, {0: 0}), 1)
    assert propagate(incidence, ()) == ([(1, 0)], [0, 2])


def test_what_cannot_be_isolated_stops_propagation() -> None:
    assert propagate(Incidence(((0, 1), (1,)), ({0: 0, 1: 0}, {}), 2), ()) == ([], [])


def test_a_full_sheet_of_rules_takes_no_time() -> None:
    n = 32_000
    rules = system(*((i, i + 1) for i in reversed(range(n))))
    start = time.process_time()
    order, _ = propagate(rules, {0})
    assert time.process_time() - start < 1.0
    assert [unknown for _, unknown in order] == list(range(1, n + 1))
