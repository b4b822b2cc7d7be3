"""What follows from unknowns once they are taken as known; taking them can be undone."""

from __future__ import annotations

from collections.abc import Iterable

from solver.structure.incidence import Incidence


class Reach:
    """The closure of a set of knowns under resolvable equations with one unknown left.

    The closure is unique: it depends neither on the order of learning nor on which equation gives
    an unknown. Learning and undoing cost time for the unknowns reached alone. ``missing[e]`` is how
    many unknowns equation ``e`` has left.
    """

    def __init__(self, incidence: Incidence, knowns: Iterable[int] = ()) -> None:
        self._incidence = incidence
        equations = incidence.block.equations
        self.known: set[int] = set()
        self.missing = {e: len(incidence.occurs[e]) for e in equations}
        # The sum of the unknowns left names the last one without a search.
        self._left = {e: sum(incidence.occurs[e]) for e in equations}
        self._follow([*knowns, *(u for e in equations if (u := self._given_by(e)) is not None)])

    @property
    def complete(self) -> bool:
        return len(self.known) == len(self._incidence.block.unknowns)

    def learn(self, unknown: int) -> list[int]:
        """Take an unknown as known: all that is known now and was not before, itself first."""
        return self._follow([unknown])

    def undo(self, learnt: Iterable[int]) -> None:
        """Forget the latest answer of :meth:`learn` that has not been undone yet."""
        for unknown in learnt:
            self.known.remove(unknown)
            self._count(unknown, 1)

    def gain(self, unknown: int) -> int:
        """How many unknowns one more known would give, itself included."""
        learnt = self.learn(unknown)
        self.undo(learnt)
        return len(learnt)

    def _count(self, unknown: int, by: int) -> None:
        for equation in self._incidence.users[unknown]:
            self.missing[equation] += by
            self._left[equation] += by * unknown

    def _follow(self, unknowns: Iterable[int]) -> list[int]:
        learnt = [u for u in dict.fromkeys(unknowns) if u not in self.known]
        self.known.update(learnt)
        for unknown in learnt:
            self._count(unknown, -1)
            for equation in self._incidence.users[unknown]:
                found = self._given_by(equation)
                if found is not None:
                    self.known.add(found)
                    learnt.append(found)
        return learnt

    def _given_by(self, equation: int) -> int | None:
        """The unknown that the equation yields now and that is not known yet."""
        if self.missing[equation] != 1:
            return None
        unknown = self._left[equation]
        new = unknown not in self.known and unknown in self._incidence.resolvable[equation]
        return unknown if new else None
