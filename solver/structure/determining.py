"""Which further inputs would determine what is undetermined.

In an under-determined part the sets of inputs that determine all of it are the complements of the
matchable sets of unknowns: the bases of the dual of a transversal matroid (J. Edmonds &
D. R. Fulkerson, "Transversals and matroid partition", 1965).
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from itertools import combinations
from math import comb
from typing import TypeAlias

from solver.structure.dulmage_mendelsohn import dulmage_mendelsohn
from solver.structure.incidence import Block, Incidence

EFFORT = 300_000
"""Edges looked at before the search for sets of one size is cut short."""

Determining: TypeAlias = tuple[tuple[int, ...], int]


def determining_sets(incidence: Incidence, undetermined: Collection[int], limit: int) -> list[Determining]:
    """Up to ``limit`` sets of extra knowns, with how many of ``undetermined`` each would make known.

    Those that determine most come first, of these the smallest, then source order. A set that
    determines all of ``undetermined`` is complete. Larger sets are tried only while no complete
    one is found; of sets of two and more only complete ones are listed. No set says more than is
    open: each leaves the part free of contradictions. Purely structural: equations may still turn
    out dependent.
    """
    under = dulmage_mendelsohn(incidence).under
    targets = frozenset(undetermined) & frozenset(under.unknowns)
    deficiency = len(under.unknowns) - len(under.equations)
    if not targets:
        return []
    part = incidence.restrict(under)
    found = _determining(part, targets, ((u,) for u in _first(part, targets, 1)))
    size = 2
    while size <= deficiency and all(count < len(targets) for _, count in found):
        sets = combinations(_first(part, targets, size), size)
        found += [d for d in _determining(part, targets, sets) if d[1] == len(targets)]
        size += 1
    if all(count < len(targets) for _, count in found):
        found += _grown(part, targets)
    return sorted(found, key=lambda d: (-d[1], len(d[0]), d[0]))[:limit]


def _first(part: Incidence, targets: Collection[int], size: int) -> tuple[int, ...]:
    """As many unknowns to choose from as the effort allows, those asked for first."""
    unknowns = sorted(part.block.unknowns, key=lambda u: (u not in targets, u))
    count = len(unknowns)
    while count > size and comb(count, size) * (part.edges + 1) > EFFORT:
        count -= 1
    return tuple(sorted(unknowns[:count]))


def _determining(
    part: Incidence, targets: Collection[int], sets: Iterable[tuple[int, ...]]
) -> list[Determining]:
    counted = ((knowns, _count(part, targets, knowns)) for knowns in sets)
    return [(knowns, count) for knowns, count in counted if count is not None]


def _count(part: Incidence, targets: Collection[int], knowns: tuple[int, ...]) -> int | None:
    """How many targets are known then; None where the knowns contradict one another."""
    left = Block(part.block.equations, tuple(u for u in part.block.unknowns if u not in knowns))
    parts = dulmage_mendelsohn(part.restrict(left))
    if parts.over.equations:
        return None
    return sum(u in targets for u in (*knowns, *parts.square.unknowns))


def _grown(part: Incidence, targets: Collection[int]) -> list[Determining]:
    """One complete set, one unknown after another, each the one that determines most."""
    knowns: tuple[int, ...] = ()
    best = 0
    while best < len(targets):
        steps = ((*knowns, u) for u in _first(part, targets, 1) if u not in knowns)
        offers = _determining(part, targets, steps)
        knowns, best = max(offers, key=lambda d: (d[1], [-u for u in d[0]]))
    return [(tuple(sorted(knowns)), best)]
