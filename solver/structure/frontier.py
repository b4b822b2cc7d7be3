"""Propagation of what is known, one variable at a time.

An equation with one unknown left is ripe, one with none left is spent (a check). The
order is breadth first: a round takes what is ripe now, so derivations stay short.
Every edge is looked at once, whatever the number of rounds.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence


class Frontier:
    """Counts of unknowns per equation, kept up to date as variables are learnt.

    ``occurs[e]`` are the distinct variables of equation ``e``; only the equations in ``active``
    take part. ``ripe`` and ``spent`` collect equations in the order in which they come up.
    """

    def __init__(self, occurs: Sequence[Sequence[int]], variables: int) -> None:
        self._occurs = occurs
        self._users: list[list[int]] = [[] for _ in range(variables)]
        self._missing = [0] * len(occurs)
        self._active = [False] * len(occurs)
        self.known = [False] * variables
        self.ripe: list[int] = []
        self.spent: list[int] = []

    def activate(self, equations: Iterable[int]) -> None:
        for equation in equations:
            self._active[equation] = True
            missing = 0
            for variable in self._occurs[equation]:
                if not self.known[variable]:
                    self._users[variable].append(equation)
                    missing += 1
            self._missing[equation] = missing
            self._sort(equation)

    def learn(self, variable: int) -> None:
        if self.known[variable]:
            return
        self.known[variable] = True
        for equation in self._users[variable]:
            self._missing[equation] -= 1
            self._sort(equation)

    def unknown_of(self, equation: int) -> int | None:
        """The single unknown of a ripe equation, or None where it is not ripe any more."""
        if self._missing[equation] != 1:
            return None
        return next(v for v in self._occurs[equation] if not self.known[v])

    def unknowns(self, equation: int) -> tuple[int, ...]:
        return tuple(v for v in self._occurs[equation] if not self.known[v])

    def missing(self, equation: int) -> int:
        return self._missing[equation]

    def _sort(self, equation: int) -> None:
        if self._missing[equation] == 1:
            self.ripe.append(equation)
        elif self._missing[equation] == 0:
            self.spent.append(equation)
