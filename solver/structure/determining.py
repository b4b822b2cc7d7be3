"""Which further inputs would determine what is undetermined.

In an under-determined part the unknowns that can be given together are the independent sets of a
matroid, the dual of the one of matchable unknowns (J. Edmonds & D. R. Fulkerson, "Transversals and
matroid partition", 1965). What they determine is their closure; so the least number of inputs that
determines some unknowns is the rank of these, and can be had without search.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import combinations, islice, product
from math import comb
from typing import TypeAlias

from solver.structure.dulmage_mendelsohn import dulmage_mendelsohn
from solver.structure.freedom import Freedom
from solver.structure.incidence import Block, Incidence
from solver.structure.matching import augmented

EFFORT = 200_000
"""Sets times edges that are looked at in a connected part."""

Determining: TypeAlias = tuple[tuple[int, ...], int]


def determining_sets(incidence: Incidence, undetermined: Collection[int], limit: int) -> list[Determining]:
    """Up to ``limit`` sets of extra knowns, with how many of ``undetermined`` each would make known.

    Those that determine most come first, of these the smallest, then source order. A set that
    determines all that is undetermined is complete; complete sets are listed in their least size
    (at least one of them, and all where the part is small), and single unknowns with what they
    achieve. The members of a set never contradict one another. Purely structural: equations may
    still turn out dependent at the numbers at hand.
    """
    under = dulmage_mendelsohn(incidence).under
    targets = frozenset(undetermined) & frozenset(under.unknowns)
    parts = [part for part in _connected(incidence.restrict(under)) if targets & set(part.block.unknowns)]
    complete: list[Sequence[tuple[int, ...]]] = []
    singles: list[Determining] = []
    for part in parts:
        own = targets & set(part.block.unknowns)
        alone = list(_alone(part, own))
        singles += alone
        complete.append(_complete(part, own, alone, limit))
    together = [tuple(sorted(sum(sets, ()))) for sets in islice(product(*complete), limit if parts else 0)]
    found = {**dict(singles), **dict.fromkeys(together, len(targets))}
    return sorted(found.items(), key=lambda d: (-d[1], len(d[0]), d[0]))[:limit]


def _connected(part: Incidence) -> Iterator[Incidence]:
    """The connected parts, by their first unknown."""
    seen: set[int] = set()
    for root in part.block.unknowns:
        if root not in seen:
            block = _component(part, root)
            seen.update(block.unknowns)
            yield part.restrict(block)


def _component(part: Incidence, root: int) -> Block:
    equations: set[int] = set()
    unknowns = {root}
    stack = [root]
    while stack:
        for equation in part.users[stack.pop()]:
            if equation not in equations:
                equations.add(equation)
                stack += (u for u in part.occurs[equation] if u not in unknowns)
                unknowns.update(part.occurs[equation])
    return Block.of(equations, unknowns)


def _alone(part: Incidence, targets: Collection[int]) -> Iterator[Determining]:
    """Single unknowns and how many targets each determines, itself included."""
    freedom = Freedom.of(part)
    for unknown in _candidates(part, targets, 1):
        fixed = freedom.without(unknown)
        if fixed is not None:
            yield (unknown,), fixed.determined(targets)


def _complete(
    part: Incidence, targets: Collection[int], alone: Iterable[Determining], limit: int
) -> list[tuple[int, ...]]:
    """Smallest sets that determine all targets, at most ``limit``."""
    first = _basis(part, targets)
    if len(first) == 1:
        return [knowns for knowns, count in alone if count == len(targets)][:limit]
    candidates = _candidates(part, targets, len(first))
    sets = (s for s in combinations(candidates, len(first)) if _determines(part, s, targets))
    return list(islice(dict.fromkeys((first, *sets)), limit))


def _basis(part: Incidence, targets: Collection[int]) -> tuple[int, ...]:
    """Targets, the first ones in the source, that determine the others and none of which the others do.

    They are what is left over when equations are matched with anything else rather than with them.
    """
    reluctant = sorted(part.block.unknowns, key=lambda u: (u in targets, -u))
    matched = set(augmented(reluctant, part.users).values())
    return tuple(sorted(set(targets) - matched))


def _determines(part: Incidence, knowns: Iterable[int], targets: Collection[int]) -> bool:
    freedom: Freedom | None = Freedom.of(part)
    for unknown in knowns:
        freedom = freedom.without(unknown) if freedom else None
    return freedom is not None and freedom.determined(targets) == len(targets)


def _candidates(part: Incidence, targets: Collection[int], size: int) -> list[int]:
    """As many unknowns to choose ``size`` from as the effort allows, targets before others."""
    unknowns = sorted(part.block.unknowns, key=lambda u: (u not in targets, u))
    effort = size * (part.edges + 1)
    count = size - 1
    while count < len(unknowns) and comb(count + 1, size) * effort <= EFFORT:
        count += 1
    return sorted(unknowns[:count])
