"""Which unknowns occur in which equations, and which of them each equation can be solved for.

A system is a bipartite graph of integers: equations 0..m-1, unknowns 0..n-1, and two sets of
edges. No algebra is known here.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, TypeAlias

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
    solving ``e`` for ``u``: 0 where the solution is single and safe, 1 where it is single but a
    coefficient may vanish, 2 and more the number of branches; absent where it can't be isolated.
    ``unknowns`` is n. A part keeps the numbering of the whole, so both are indexed alike; ``part``
    names what takes part (None: everything).
    """

    occurs: Rows
    resolvable: Costs
    unknowns: int
    part: Block | None = None

    @cached_property
    def block(self) -> Block:
        """The equations and unknowns that take part."""
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
        """How many occurrences there are."""
        return sum(len(self.occurs[equation]) for equation in self.block.equations)

    def restrict(self, block: Block) -> Incidence:
        """The part with these equations and unknowns alone; costs time for the part only."""
        if block == self.block:
            return self
        inside = frozenset(block.unknowns)
        occurs = {e: tuple(u for u in self.occurs[e] if u in inside) for e in block.equations}
        resolvable = {
            e: {u: cost for u, cost in self.resolvable[e].items() if u in inside} for e in block.equations
        }
        return Incidence(occurs, resolvable, self.unknowns, block)


class Frontier:
    """Propagation of what is known, one variable at a time.

    An equation with one unknown left is ripe, one with none left is spent (a check); ``ripe`` and ``spent``
    collect them in the order in which they come up. ``occurs[e]`` are the distinct variables of equation
    ``e``; where it is active, ``missing[e]`` counts those that are not ``known``.
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

    def learn(self, variable: int) -> None:
        if self.known[variable]:
            return
        self.known[variable] = True
        for equation in self._users[variable]:
            self.missing[equation] -= 1
            self._sort(equation)

    def unknown_of(self, equation: int) -> int | None:
        """The single unknown of a ripe equation, or None where it is not ripe any more."""
        if self.missing[equation] != 1:
            return None
        return next(v for v in self._occurs[equation] if not self.known[v])

    def _sort(self, equation: int) -> None:
        if self.missing[equation] == 1:
            self.ripe.append(equation)
        elif self.missing[equation] == 0:
            self.spent.append(equation)
