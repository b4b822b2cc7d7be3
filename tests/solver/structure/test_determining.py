"""Extra inputs against trying every set."""

from __future__ import annotations

from itertools import combinations

from hypothesis import given
from hypothesis import strategies as st

from solver.structure.determining import determining_sets
from solver.structure.incidence import Incidence
from tests.solver.structure.incidences import columns, incidences, patient, rank, system


def undetermined(incidence: Incidence, knowns: tuple[int, ...]) -> set[int]:
    """Unknowns that some maximum matching without the knowns leaves single."""
    cols = {u: col for u, col in enumerate(columns(incidence)) if u not in knowns}
    size = rank(list(cols.values()))
    return {u for u in cols if rank([col for v, col in cols.items() if v != u]) == size}


def contradicts(incidence: Incidence, knowns: tuple[int, ...]) -> bool:
    """Whether giving the knowns costs the equations more than they have to spare."""
    cols = columns(incidence)
    return rank([col for u, col in enumerate(cols) if u not in knowns]) < rank(cols)


@patient
@given(incidences(equations=4, unknowns=6), st.sets(st.integers(0, 5)))
def test_sets_against_brute_force(incidence: Incidence, wanted: set[int]) -> None:
    open_unknowns = undetermined(incidence, ())
    targets = wanted & open_unknowns
    found = determining_sets(incidence, wanted, limit=1000)
    for knowns, count in found:
        assert not contradicts(incidence, knowns)
        assert count == len(targets - undetermined(incidence, knowns))
    complete = {knowns for knowns, count in found if count == len(targets)}
    assert complete == smallest_complete(incidence, open_unknowns, targets)


def smallest_complete(
    incidence: Incidence, open_unknowns: set[int], targets: set[int]
) -> set[tuple[int, ...]]:
    if not targets:
        return set()
    for size in range(1, len(open_unknowns) + 1):
        sets = combinations(sorted(open_unknowns), size)
        sound = (s for s in sets if not contradicts(incidence, s))
        fitting = {s for s in sound if not targets & undetermined(incidence, s)}
        if fitting:
            return fitting
    raise AssertionError


def test_ohm_and_power_with_the_voltage_given() -> None:
    """V = I·R and P = V·I: any one of current, resistance and power will do."""
    current, resistance, power = range(3)
    circuit = system((current, resistance), (current, power))
    assert determining_sets(circuit, range(3), 5) == [((0,), 3), ((1,), 3), ((2,), 3)]


def test_where_one_is_not_enough_pairs_come_first_then_what_helps_most() -> None:
    two = system((0, 1), (1, 2), (3, 4))
    found = determining_sets(two, range(5), 100)
    assert [count for _, count in found] == [5] * 6 + [3] * 3 + [2] * 2
    assert found[0] == ((0, 3), 5)
    assert found[6:] == [((0,), 3), ((1,), 3), ((2,), 3), ((3,), 2), ((4,), 2)]


def test_only_what_is_asked_for_counts() -> None:
    assert determining_sets(system((0, 1), (3, 4), unknowns=5), {1}, 5) == [((0,), 1), ((1,), 1)]


def test_nothing_is_asked_where_all_is_determined() -> None:
    assert determining_sets(system((0,), (0, 1)), {0, 1}, 5) == []


def test_a_large_part_gets_one_complete_set() -> None:
    n = 600
    tree = system(*((i, 2 * i + 1, 2 * i + 2) for i in range(n)))
    knowns, count = determining_sets(tree, range(2 * n + 1), 3)[0]
    assert (len(knowns), count) == (n + 1, 2 * n + 1)
