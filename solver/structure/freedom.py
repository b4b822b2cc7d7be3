"""How far a part of a system is free, and what is left of it when unknowns are given."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from solver.structure.incidence import Incidence
from solver.structure.matching import maximum_matching, reached


@dataclass(frozen=True)
class Freedom:
    """A matching of every equation of an under-determined part, and the ``free`` unknowns outside it.

    There are as many free unknowns as inputs are missing. Which ones they are is not unique; what
    can be reached from them by alternating paths, the undetermined unknowns, is.
    """

    part: Incidence
    unknown_of: Mapping[int, int]
    equation_of: Mapping[int, int]
    free: frozenset[int]

    @classmethod
    def of(cls, part: Incidence) -> Freedom:
        """The freedom of a part all of whose equations can be matched."""
        matching = maximum_matching(part)
        unknown_of = {e: u for e, u in matching.unknown_of.items() if u is not None}
        equation_of = {u: e for e, u in unknown_of.items()}
        return cls(part, unknown_of, equation_of, frozenset(matching.single_unknowns))

    def without(self, unknown: int) -> Freedom | None:
        """What is left when ``unknown`` is given; None where it is determined already."""
        if unknown in self.free:
            return Freedom(self.part, self.unknown_of, self.equation_of, self.free - {unknown})
        path = self._to_free(unknown)
        if path is None:
            return None
        unknown_of = {**self.unknown_of, **path}
        equation_of = {u: e for e, u in unknown_of.items()}
        return Freedom(self.part, unknown_of, equation_of, self.free - set(path.values()))

    def determined(self, targets: Collection[int]) -> int:
        """How many of the targets are determined."""
        loose = reached(self.free, self.part.users, self.unknown_of)
        return sum(target not in loose for target in targets)

    def _to_free(self, unknown: int) -> dict[int, int] | None:
        """New partners of equations along a shortest path that gives up ``unknown`` for a free one."""
        if unknown not in self.equation_of:
            return None
        came_from: dict[int, tuple[int, int] | None] = {self.equation_of[unknown]: None}
        queue = list(came_from)
        for equation in queue:
            for other in self.part.occurs[equation]:
                if other in self.free:
                    return _partners(equation, other, came_from)
                owner = self.equation_of.get(other)
                if owner is not None and owner not in came_from:
                    came_from[owner] = (equation, other)
                    queue.append(owner)
        return None


def _partners(equation: int, unknown: int, came_from: Mapping[int, tuple[int, int] | None]) -> dict[int, int]:
    partners = {equation: unknown}
    step = came_from[equation]
    while step is not None:
        equation, unknown = step
        partners[equation] = unknown
        step = came_from[equation]
    return partners
