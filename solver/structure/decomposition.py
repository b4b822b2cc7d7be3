"""Which rules determine which unknowns: matching, over- and under-determined parts, blocks to solve
in turn.

A system is a bipartite graph of integers: equations 0..m-1, unknowns 0..n-1, and two sets of edges:
which unknowns occur in which equations, and which of them each can be solved for. No algebra is
known here.

Equations are matched with unknowns one after another, each by a shortest augmenting path: all their
lengths add up to n log² n at most (A. Bernstein, J. Holm & E. Rotenberg, "Online bipartite matching
with amortized O(log² n) replacements", J. ACM 66, 2019). The first in the source come first on
either side. That is possible on both sides at once because matchable sets form a matroid on either
side (N. S. Mendelsohn & A. L. Dulmage, "Some generalizations of the problem of distinct
representatives", 1958).

The parts are those of A. L. Dulmage & N. S. Mendelsohn, "Coverings of bipartite graphs", Canad. J.
Math. 10 (1958); see A. Pothen & C.-J. Fan, "Computing the block triangular form of a sparse
matrix", ACM TOMS 16 (1990). The blocks are strong components: R. Tarjan, "Depth-first search and
linear graph algorithms", SIAM J. Comput. 1 (1972), without recursion, so that a chain of any length
is no depth.

scipy's ``maximum_bipartite_matching`` takes exponential time where blocks follow one another in
layers (scipy issue 26147), as rules do, and loading ``scipy.sparse`` takes longer than most sheets.
"""

from __future__ import annotations

from collections.abc import Collection, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from graphlib import TopologicalSorter
from heapq import heapify, heappop, heappush
from typing import NamedTuple, TypeAlias

from rulesheets.deadline import expect_time

Rows: TypeAlias = tuple[tuple[int, ...], ...] | Mapping[int, tuple[int, ...]]
Costs: TypeAlias = tuple[dict[int, int], ...] | Mapping[int, dict[int, int]]


class Block(NamedTuple):
    """Some equations and some unknowns of a system, each in ascending order."""

    equations: tuple[int, ...]
    unknowns: tuple[int, ...]

    @classmethod
    def of(cls, equations: Iterable[int], unknowns: Iterable[int]) -> Block:
        return cls(tuple(sorted(equations)), tuple(sorted(unknowns)))


@dataclass(frozen=True)
class Incidence:
    """The bipartite graph of a system, or of a part of one.

    ``occurs[e]`` are the unknowns of equation ``e``, ascending. ``resolvable[e][u]`` is the cost of
    solving ``e`` for ``u``: 0 if the solution is single and safe, 1 if it is single but a
    coefficient may vanish, 2 and more the number of branches; absent if it cannot be isolated.
    ``unknowns`` is n. A part keeps the numbering of the whole, so both are indexed alike; ``part``
    lists its members (None: everything).
    """

    occurs: Rows
    resolvable: Costs
    unknowns: int
    part: Block | None = None

    @cached_property
    def block(self) -> Block:
        if self.part is not None:
            return self.part
        return Block(tuple(range(len(self.occurs))), tuple(range(self.unknowns)))

    @cached_property
    def users(self) -> dict[int, list[int]]:
        """The column view: the equations of every unknown, ascending."""
        users: dict[int, list[int]] = {unknown: [] for unknown in self.block.unknowns}
        for equation in self.block.equations:
            for unknown in self.occurs[equation]:
                users[unknown].append(equation)
        return users

    @cached_property
    def edges(self) -> int:
        return sum(len(self.occurs[equation]) for equation in self.block.equations)

    def restrict(self, block: Block) -> Incidence:
        """The part with only these equations and unknowns; takes time only for the part."""
        if block == self.block:
            return self
        inside = frozenset(block.unknowns)
        occurs = {e: tuple(u for u in self.occurs[e] if u in inside) for e in block.equations}
        resolvable = {
            e: {u: cost for u, cost in self.resolvable[e].items() if u in inside}
            for e in block.equations
        }
        return Incidence(occurs, resolvable, self.unknowns, block)


class Frontier:
    """Propagation of known variables, one at a time.

    An equation with one unknown left is ripe, one with none left is spent (a check); ``ripe`` and
    ``spent`` collect them in order. ``occurs[e]`` are the distinct variables of equation ``e``; if
    it is active, ``missing[e]`` counts those that are not ``known``.
    """

    def __init__(self, occurs: Sequence[Sequence[int]], variables: int) -> None:
        self._occurs = occurs
        self._users: list[list[int]] = [[] for _ in range(variables)]
        self.missing = [0] * len(occurs)
        self.known = [False] * variables
        self.ripe: list[int] = []
        self.spent: list[int] = []

    def activate(self, equations: Iterable[int]) -> None:
        for equation in equations:
            unknowns = [variable for variable in self._occurs[equation] if not self.known[variable]]
            for variable in unknowns:
                self._users[variable].append(equation)
            self.missing[equation] = len(unknowns)
            self._sort(equation)

    def set_known(self, variable: int) -> None:
        if self.known[variable]:
            return
        self.known[variable] = True
        for equation in self._users[variable]:
            self.missing[equation] -= 1
            self._sort(equation)

    def unknown_of(self, equation: int) -> int | None:
        """The single unknown of a ripe equation, or None if it is not ripe any more."""
        if self.missing[equation] != 1:
            return None
        return next(v for v in self._occurs[equation] if not self.known[v])

    def _sort(self, equation: int) -> None:
        if self.missing[equation] == 1:
            self.ripe.append(equation)
        elif self.missing[equation] == 0:
            self.spent.append(equation)


# --- matching, parts and blocks ---

Edges: TypeAlias = Sequence[Sequence[int]] | Mapping[int, Sequence[int]]


class Matching(NamedTuple):
    """Partners by number, None for an unmatched node.

    The size of a maximum matching is unique. The unmatched equations and unknowns are made unique:
    the last possible ones, in source order. Who is matched with whom is not unique.
    """

    unknown_of: dict[int, int | None]
    equation_of: dict[int, int | None]

    @property
    def single_unknowns(self) -> tuple[int, ...]:
        return tuple(unknown for unknown, equation in self.equation_of.items() if equation is None)


def maximum_matching(incidence: Incidence) -> Matching:
    """As many disjoint (equation, unknown) pairs as possible, each unknown in its equation.

    Maximum matchings differ only in which unknowns of the under-determined part are unmatched.
    """
    equations, unknowns = incidence.block
    equation_of: dict[int, int | None] = dict.fromkeys(unknowns)
    unknown_of: dict[int, int | None] = dict.fromkeys(equations)
    equation_of |= augmented(equations, incidence.occurs)
    unknown_of |= {e: u for u, e in equation_of.items() if e is not None}
    under = reached(Matching(unknown_of, equation_of).single_unknowns, incidence.users, unknown_of)
    again = augmented(sorted(under), incidence.users)
    unknown_of |= again
    equation_of |= dict.fromkeys(under)
    equation_of |= {u: e for e, u in again.items()}
    return Matching(unknown_of, equation_of)


def augmented(nodes: Iterable[int], edges: Edges) -> dict[int, int]:
    """The owner of every partner: nodes are matched in turn, and stay matched.

    So the nodes that end up matched are the lexicographically first set possible.
    """
    owner_of: dict[int, int] = {}
    spent: set[int] = set()  # partners from which no free one can be reached, now or later
    for root in nodes:
        before, end = shortest_path(root, edges, owner_of, spent)
        if end is None:
            spent |= before.keys()
        while end is not None:
            previous = before[end]
            owner_of[end] = root if previous is None else owner_of[previous]
            end = previous
    return owner_of


def shortest_path(
    root: int, edges: Edges, owner_of: Mapping[int, int], spent: Container[int]
) -> tuple[dict[int, int | None], int | None]:
    """The partner before each one reached (None: the root is), and the nearest free one."""
    before: dict[int, int | None] = {}
    queue: list[int | None] = [None]
    for previous in queue:
        expect_time()
        for partner in edges[root if previous is None else owner_of[previous]]:
            if partner not in owner_of:
                before[partner] = previous
                return before, partner
            if partner not in before and partner not in spent:
                before[partner] = previous
                queue.append(partner)
    return before, None


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


class Parts(NamedTuple):
    """Every equation and every unknown belongs to exactly one part. The parts are unique.

    ``over`` has more equations than unknowns (or is empty): its equations contradict one another or
    are dependent. ``square`` has as many of both and can be solved once ``over`` is. ``under`` has
    more unknowns than equations: none of its unknowns is determined.
    """

    over: Block
    square: Block
    under: Block


def dulmage_mendelsohn(incidence: Incidence, matching: Matching | None = None) -> Parts:
    """The three parts; any maximum ``matching`` gives the same."""
    matching = matching or maximum_matching(incidence)
    single = (equation for equation, unknown in matching.unknown_of.items() if unknown is None)
    over = reached(single, incidence.occurs, matching.equation_of)
    under = reached(matching.single_unknowns, incidence.users, matching.unknown_of)
    over_unknowns = {unknown for equation in over for unknown in incidence.occurs[equation]}
    under_equations = {equation for unknown in under for equation in incidence.users[unknown]}
    square = Block(
        tuple(e for e in incidence.block.equations if e not in over and e not in under_equations),
        tuple(u for u in incidence.block.unknowns if u not in over_unknowns and u not in under),
    )
    return Parts(Block.of(over, over_unknowns), square, Block.of(under_equations, under))


def undetermined(incidence: Incidence, given: Collection[int]) -> frozenset[int]:
    """The unknowns that stay undetermined if some are given.

    An equation determines one that it can be solved for, once all its others are determined.
    """
    equations, unknowns = incidence.block
    part = incidence.restrict(Block(equations, tuple([u for u in unknowns if u not in given])))
    bodies = {equation: tuple(sorted(part.resolvable[equation])) for equation in equations}
    matching = maximum_matching(replace(part, occurs=bodies))
    return frozenset(reached(matching.single_unknowns, part.users, matching.unknown_of))


def strong_components(successors: Sequence[Sequence[int]]) -> Iterator[list[int]]:
    """Nodes that reach one another, ascending, each group after those that it reaches."""
    index, low = [-1] * len(successors), [0] * len(successors)
    closed = [False] * len(successors)
    entered, waiting = 0, list[int]()
    for root in range(len(successors)):
        path = [(root, iter(successors[root]))] if index[root] < 0 else []
        while path:
            node, rest = path[-1]
            if index[node] < 0:
                index[node] = low[node] = entered
                entered += 1
                waiting.append(node)
            for following in rest:
                if index[following] < 0:
                    path.append((following, iter(successors[following])))
                    break
                if not closed[following]:
                    low[node] = min(low[node], low[following])
            else:
                path.pop()
                if path:
                    low[path[-1][0]] = min(low[path[-1][0]], low[node])
                if low[node] == index[node]:
                    group = [waiting.pop()]
                    while group[-1] != node:
                        group.append(waiting.pop())
                    for member in group:
                        closed[member] = True
                    yield sorted(group)


def block_triangular(
    incidence: Incidence, square: Block | None = None, matching: Matching | None = None
) -> tuple[Block, ...]:
    """The blocks to solve one after another, each of simultaneous equations.

    The blocks are unique, for any matching; of the orders in which every block comes after those
    that it needs, this is the one closest to the source. ``matching`` may be any maximum matching
    of the whole, if known already. Raises ValueError if the part cannot be matched completely.
    """
    part = incidence if square is None else incidence.restrict(square)
    equations = part.block.equations
    matching = matching or maximum_matching(part)
    unknowns = [u for e in equations if (u := matching.unknown_of[e]) is not None]
    if len(equations) != len(part.block.unknowns) or set(unknowns) != set(part.block.unknowns):
        raise ValueError("a block triangular form needs as many independent equations as unknowns")
    number = {unknown: i for i, unknown in enumerate(unknowns)}
    needs = [[number[u] for u in part.occurs[e]] for e in equations]
    groups = sorted(strong_components(needs))
    group_of = {node: g for g, group in enumerate(groups) for node in group}
    needed = [{group_of[other] for node in group for other in needs[node]} for group in groups]
    sorter = TopologicalSorter({g: others - {g} for g, others in enumerate(needed)})
    sorter.prepare()
    ready, blocks = list(sorter.get_ready()), list[Block]()
    heapify(ready)
    while ready:
        g = heappop(ready)
        blocks.append(Block.of((equations[i] for i in groups[g]), (unknowns[i] for i in groups[g])))
        sorter.done(g)
        for follower in sorter.get_ready():
            heappush(ready, follower)
    return tuple(blocks)
