"""Maximum matching of equations with unknowns.

How many are matched is found by Hopcroft & Karp. Which nodes stay single is then settled by source
order, by augmenting paths with look-ahead (I. S. Duff, "On algorithms for obtaining a maximum
transversal", ACM TOMS 7, 1981). That is possible on both sides at once because matchable sets form a
matroid on either side (N. S. Mendelsohn & A. L. Dulmage, "Some generalizations of the problem of
distinct representatives", 1958).

J. E. Hopcroft & R. M. Karp, "An n^5/2 algorithm for maximum matchings in bipartite graphs", SIAM J. Comput. 2
(1973). scipy's ``maximum_bipartite_matching`` does not mark the dead ends of its search and takes exponential
time where blocks follow one another in layers (scipy issue 26147), as rules do.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple, TypeAlias

from rulesheets.deadline import expect_time
from solver.structure.incidence import Incidence

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
        free = [root for root in free if not _extended(root, left, levels, owner_of)]
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


def _extended(
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


class Matching(NamedTuple):
    """Partners by number, None where there is none.

    Of a maximum matching the size is unique. Which equations and which unknowns stay single is
    made so: the last ones, in source order, that can. Who is matched with whom is not unique.
    """

    unknown_of: Mapping[int, int | None]
    equation_of: Mapping[int, int | None]

    @classmethod
    def of(cls, incidence: Incidence, pairs: Iterable[tuple[int, int]]) -> Matching:
        """A matching from (equation, unknown) pairs, no two of which share a member."""
        unknown_of: dict[int, int | None] = dict.fromkeys(incidence.block.equations)
        equation_of: dict[int, int | None] = dict.fromkeys(incidence.block.unknowns)
        for equation, unknown in pairs:
            unknown_of[equation] = unknown
            equation_of[unknown] = equation
        return cls(unknown_of, equation_of)

    @property
    def size(self) -> int:
        return sum(unknown is not None for unknown in self.unknown_of.values())

    @property
    def single_equations(self) -> tuple[int, ...]:
        return tuple(equation for equation, unknown in self.unknown_of.items() if unknown is None)

    @property
    def single_unknowns(self) -> tuple[int, ...]:
        return tuple(unknown for unknown, equation in self.equation_of.items() if equation is None)


def maximum_matching(incidence: Incidence) -> Matching:
    """As many disjoint (equation, unknown) pairs as there can be, each unknown in its equation."""
    owner_of = hopcroft_karp(incidence.block.equations, incidence.occurs)
    pairs = ((equation, unknown) for unknown, equation in owner_of.items())
    return _settled(Matching.of(incidence, pairs), incidence)


def _settled(matching: Matching, incidence: Incidence) -> Matching:
    """The same outside the over- and under-determined parts; inside, the first in the source are matched.

    Maximum matchings differ in whom they leave single only inside these parts, and no pair of a
    maximum matching crosses their borders (Dulmage & Mendelsohn 1958).
    """
    unknown_of, equation_of = dict(matching.unknown_of), dict(matching.equation_of)
    over = reached(matching.single_equations, incidence.occurs, equation_of)
    under = reached(matching.single_unknowns, incidence.users, unknown_of)
    _rematch(over, incidence.occurs, unknown_of, equation_of)
    _rematch(under, incidence.users, equation_of, unknown_of)
    return Matching(unknown_of, equation_of)


def _rematch(
    nodes: Iterable[int], edges: Edges, partner_of: dict[int, int | None], owner_of: dict[int, int | None]
) -> None:
    ordered = sorted(nodes)
    partner_of.update(dict.fromkeys(ordered))
    for partner, owner in augmented(ordered, edges).items():
        partner_of[owner] = partner
        owner_of[partner] = owner


def augmented(nodes: Iterable[int], edges: Edges) -> dict[int, int]:
    """The owner of every partner: nodes are given one in turn, and never lose it to a later node.

    So the nodes that end up matched are the lexicographically first set that can be.
    """
    owner_of: dict[int, int] = {}
    spent: set[int] = set()
    for node in nodes:
        _augment(node, edges, owner_of, spent)
    return owner_of


def _augment(root: int, edges: Edges, owner_of: dict[int, int], spent: set[int]) -> None:
    """Depth first along an alternating path from ``root`` to a free partner, if there is one.

    ``spent`` are partners from which none can be reached, now or later.
    """
    seen: set[int] = set()
    path, through, branches = [root], list[int](), [iter(edges[root])]
    while True:
        expect_time()
        free = next((partner for partner in edges[path[-1]] if partner not in owner_of), None)
        if free is not None:
            owner_of.update(zip([*through, free], path, strict=True))
            return
        while (step := next((p for p in branches[-1] if p not in seen and p not in spent), None)) is None:
            path.pop()
            branches.pop()
            if not path:
                spent |= seen
                return
            through.pop()
        seen.add(step)
        through.append(step)
        path.append(owner_of[step])
        branches.append(iter(edges[owner_of[step]]))


def reached(roots: Iterable[int], edges: Edges, owner_of: Mapping[int, int | None]) -> set[int]:
    """Nodes on the roots' side at the end of alternating paths from the roots, these included."""
    found = set(roots)
    stack = list(found)
    while stack:
        for partner in edges[stack.pop()]:
            owner = owner_of[partner]
            if owner is not None and owner not in found:
                found.add(owner)
                stack.append(owner)
    return found
