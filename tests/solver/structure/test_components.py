"""Strong components against mutual reachability."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from solver.structure.decomposition import strong_components
from tests.solver.structure.incidences import patient

graphs = st.integers(1, 7).flatmap(
    lambda n: st.lists(
        st.lists(st.integers(0, n - 1), unique=True, max_size=3), min_size=n, max_size=n
    )
)


def reachable(successors: list[list[int]], node: int) -> set[int]:
    found = {node}
    while new := {s for n in found for s in successors[n]} - found:
        found |= new
    return found


@patient
@given(graphs)
def test_a_label_for_each_class_of_mutual_reach(successors: list[list[int]]) -> None:
    reach = [reachable(successors, node) for node in range(len(successors))]
    groups = list(strong_components(successors))
    labels = {node: label for label, group in enumerate(groups) for node in group}
    assert sorted(node for group in groups for node in group) == list(range(len(successors)))
    for one in range(len(successors)):
        for other in range(len(successors)):
            mutual = other in reach[one] and one in reach[other]
            assert (labels[one] == labels[other]) is mutual


def test_a_long_circle_is_no_deep_recursion() -> None:
    n = 5000
    assert list(strong_components([[(i + 1) % n] for i in range(n)])) == [list(range(n))]
