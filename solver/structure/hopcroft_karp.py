"""Maximum matching in O(edges * sqrt(nodes)).

J. E. Hopcroft & R. M. Karp, "An n^5/2 algorithm for maximum matchings in bipartite graphs", SIAM J.
Comput. 2 (1973). scipy's ``maximum_bipartite_matching`` does not mark the dead ends of its search and
takes exponential time where blocks follow one another in layers (scipy issue 26147), as rules do.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TypeAlias

from rulesheets.deadline import expect_time

Edges: TypeAlias = Sequence[Sequence[int]] | Mapping[int, Sequence[int]]


def hopcroft_karp(nodes: Iterable[int], edges: Edges) -> dict[int, int]:
    """The owner of every matched partner; as many nodes as possible own one of their ``edges``."""
    owner_of: dict[int, int] = {}
    free = [node for node in nodes if not _taken_at_once(node, edges, owner_of)]
    while free:
        expect_time()
        levels = _levels(free, edges, owner_of)
        if levels is None:
            break
        left = {node: iter(edges[node]) for node in levels}
        free = [root for root in free if not _augment(root, left, levels, owner_of)]
    return owner_of


def _taken_at_once(node: int, edges: Edges, owner_of: dict[int, int]) -> bool:
    for partner in edges[node]:
        if partner not in owner_of:
            owner_of[partner] = node
            return True
    return False


def _levels(free: Sequence[int], edges: Edges, owner_of: Mapping[int, int]) -> dict[int, int] | None:
    """Alternating distance of nodes from the free ones, up to the first free partner; None without one."""
    levels = dict.fromkeys(free, 0)
    layer: list[int] = list(free)
    while layer:
        following: list[int] = []
        ends = False
        for node in layer:
            for partner in edges[node]:
                owner = owner_of.get(partner)
                if owner is None:
                    ends = True
                elif owner not in levels:
                    levels[owner] = levels[node] + 1
                    following.append(owner)
        if ends:
            for node in following:
                del levels[node]  # farther than the nearest free partner
            return levels
        layer = following
    return None


def _augment(
    root: int, left: Mapping[int, Iterator[int]], levels: Mapping[int, int], owner_of: dict[int, int]
) -> bool:
    """Follow one shortest path from ``root`` to a free partner, and swap owners along it.

    ``left`` are the edges that this phase has not looked at: a dead end is met once.
    """
    path, through = [root], list[int]()
    while path:
        node = path[-1]
        for partner in left[node]:
            owner = owner_of.get(partner)
            if owner is None:
                owner_of.update(zip([*through, partner], path, strict=True))
                return True
            if levels.get(owner) == levels[node] + 1:
                path.append(owner)
                through.append(partner)
                break
        else:
            path.pop()
            if through:
                through.pop()
    return False
