"""Tearing against trying every set of tears and every order."""

from __future__ import annotations

import random
from itertools import combinations

import pytest
from hypothesis import given

from solver.structure import tearing as module
from solver.structure.decomposition import Incidence
from solver.structure.tearing import Tearing, tearings
from tests.solver.structure.incidences import (
    closure,
    incidences,
    patient,
    renumbered,
    shuffled,
    system,
)


def assert_valid(incidence: Incidence, tearing: Tearing) -> None:
    known = set(tearing.tears)
    for equation, unknown in tearing.order:
        assert unknown in incidence.resolvable[equation]
        assert set(incidence.occurs[equation]) - known == {unknown}
        known.add(unknown)
    assert known == set(incidence.block.unknowns)
    used = [equation for equation, _ in tearing.order]
    assert sorted((*used, *tearing.residuals)) == list(incidence.block.equations)


def tear(incidence: Incidence, weights: dict[int, int] | None = None) -> Tearing:
    return tearings(incidence, weights or {}, limit=1)[0]


def cost(incidence: Incidence, tearing: Tearing) -> int:
    return sum(incidence.resolvable[e][u] for e, u in tearing.order)


def sets_of_tears(incidence: Incidence) -> list[tuple[int, ...]]:
    """All the smallest ones."""
    unknowns = range(incidence.unknowns)
    for size in range(incidence.unknowns + 1):
        found = [
            s for s in combinations(unknowns, size) if closure(incidence, set(s)) == set(unknowns)
        ]
        if found:
            return found
    raise AssertionError


def least_cost(incidence: Incidence, known: frozenset[int]) -> int:
    """By trying every order of steps."""
    costs = [
        incidence.resolvable[e][u] + least_cost(incidence, known | {u})
        for e, row in enumerate(incidence.occurs)
        for u in set(row) - known
        if set(row) - known == {u} and u in incidence.resolvable[e]
    ]
    return min(costs, default=0)


@patient
@given(incidences(square=True))
def test_a_tearing_is_valid_smallest_and_cheapest(incidence: Incidence) -> None:
    found = tear(incidence)
    sets = sets_of_tears(incidence)
    assert_valid(incidence, found)
    assert found.tears in sets
    assert len(found.residuals) == len(found.tears)
    assert cost(incidence, found) == min(least_cost(incidence, frozenset(s)) for s in sets)


@patient
@given(incidences(square=True))
def test_alternatives_are_all_the_others_best_first(incidence: Incidence) -> None:
    found = tearings(incidence, {}, limit=1000)
    assert sorted(t.tears for t in found) == sets_of_tears(incidence)
    keys = [(cost(incidence, t), t.tears) for t in found]
    assert keys == sorted(keys)


@patient
@given(shuffled(square=True))
def test_shuffling_changes_neither_number_nor_cost(
    case: tuple[Incidence, list[int], list[int]],
) -> None:
    one, other = tear(case[0]), tear(renumbered(*case))
    assert len(one.tears) == len(other.tears)
    assert cost(case[0], one) == cost(renumbered(*case), other)


@patient
@given(incidences(square=True))
def test_the_heuristic_is_valid_and_leaves_no_idle_tear(incidence: Incidence) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "EFFORT", 20)
        found = tearings(incidence, {}, limit=5)
    assert len({t.tears for t in found}) == len(found)
    for tearing in found:
        assert_valid(incidence, tearing)
        assert len(tearing.tears) == len(found[0].tears)
        for idle in tearing.tears:
            assert closure(incidence, set(tearing.tears) - {idle}) != set(range(incidence.unknowns))


def test_weights_decide_between_equals() -> None:
    ring = system((0, 1), (1, 2), (2, 0))
    assert tear(ring).tears == (0,)
    assert tear(ring, {0: 1, 1: 1, 2: 0}).tears == (2,)


def test_cost_outweighs_weight() -> None:
    costly = Incidence(((0, 1), (0, 1)), ({0: 2}, {1: 0}), 2)
    assert tear(costly, {0: 1, 1: 0}) == Tearing((0,), ((1, 1),), (0,))


def test_an_expensive_step_is_put_off() -> None:
    """Unknown 1 could come at cost 4 from the first equation at once; by way of 2 it is free."""
    block = Incidence(((0, 1), (0, 2), (1, 2, 0)), ({1: 4}, {2: 1}, {1: 0}), 3)
    assert tear(block) == Tearing((0,), ((1, 2), (2, 1)), (0,))


def test_the_cheapest_next_step_may_not_be_the_best() -> None:
    """At 3 for unknown 1 the first step is dearer than one at 2 for unknown 2, but gives 2 for
    nothing."""
    block = Incidence(((0, 1), (0, 2), (1, 2), (0, 1, 2)), ({1: 3}, {2: 2}, {2: 0}, {}), 3)
    found = tear(block.restrict(block.block))
    assert found.order == ((0, 1), (2, 2))


def test_the_slider_of_a_crank() -> None:
    """xA = AO cos theta, yA = AO sin theta, (xB-xA)² + (yB-yA)² = AB²: guess the angle, evaluate
    the rest."""
    theta, x, y = range(3)
    crank = Incidence(
        ((theta, x), (theta, y), (x, y)), ({theta: 2, x: 0}, {theta: 2, y: 0}, {x: 2, y: 2}), 3
    )
    assert tear(crank) == Tearing((theta,), ((0, x), (1, y)), (2,))


def test_an_equation_that_gives_nothing_is_the_residual() -> None:
    assert tear(Incidence(((0,),), ({},), 1)) == Tearing((0,), (), (0,))


@pytest.mark.parametrize(("n", "width"), [(60, 2), (400, 3), (80, 30)])
def test_large_blocks(n: int, width: int) -> None:
    chance = random.Random(n)
    block = system(*({i, *(chance.randrange(n) for _ in range(width))} for i in range(n)))
    found = tearings(block, {}, limit=3)
    for tearing in found:
        assert_valid(block, tearing)
    assert 0 < len(found[0].tears) < n


def test_a_band_needs_no_more_tears_than_its_half_width() -> None:
    n = 2000
    band = system(*(range(max(0, i - 2), min(n, i + 3)) for i in range(n)))
    found = tear(band)
    assert_valid(band, found)
    assert len(found.tears) == 2


def test_where_no_rule_gives_an_unknown_all_are_tears_and_that_is_seen_at_once() -> None:
    n = 50
    occurs = tuple(tuple(range(max(0, i - 1), min(n, i + 2))) for i in range(n))
    assert tear(Incidence(occurs, ({},) * n, n)).tears == tuple(range(n))
