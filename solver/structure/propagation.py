"""Propagation: what follows from the knowns, one equation and one unknown at a time.

M. Konopasek & S. Jayaraman, "The TK!Solver Book" (1984), the Direct Solver: it succeeds exactly
where the incidence matrix without the knowns can be permuted to triangular form with every
diagonal entry resolvable.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import NamedTuple

from solver.structure.incidence import Incidence


class Propagation(NamedTuple):
    """``order`` are (equation, unknown) pairs, each needing only what comes before it.

    ``checks`` are equations with nothing left to find, in source order. The set of unknowns in
    ``order`` is unique; which equation gives an unknown is settled by fewest rounds, least cost,
    source order.
    """

    order: list[tuple[int, int]]
    checks: list[int]


def propagate(incidence: Incidence, known: Collection[int]) -> Propagation:
    """Peel the system from its head, in time proportional to its edges.

    Breadth first: a round takes everything that the rounds before it allow, so that every unknown
    is reached by as few rounds as can be.
    """
    return _Peeling(incidence, known).run()


class _Peeling:
    def __init__(self, incidence: Incidence, known: Collection[int]) -> None:
        self.incidence = incidence
        self.known = set(known)
        self.missing = {
            e: sum(u not in self.known for u in incidence.occurs[e]) for e in incidence.block.equations
        }

    def run(self) -> Propagation:
        order: list[tuple[int, int]] = []
        ripe = [e for e, missing in self.missing.items() if missing == 1]
        while ripe:
            taken = self._round(ripe)
            order += taken
            ripe = self._learn(unknown for _, unknown in taken)
        used = {equation for equation, _ in order}
        checks = [e for e, missing in self.missing.items() if not missing and e not in used]
        return Propagation(order, checks)

    def _round(self, ripe: Iterable[int]) -> list[tuple[int, int]]:
        """For every unknown that a ripe equation gives, the cheapest, then first, that does."""
        best: dict[int, tuple[int, int]] = {}
        for equation in ripe:
            unknown = next((u for u in self.incidence.occurs[equation] if u not in self.known), None)
            cost = None if unknown is None else self.incidence.resolvable[equation].get(unknown)
            if unknown is not None and cost is not None:
                offer = (cost, equation)
                best[unknown] = min(best.get(unknown, offer), offer)
        return [(equation, unknown) for unknown, (_, equation) in sorted(best.items(), key=lambda b: b[1])]

    def _learn(self, unknowns: Iterable[int]) -> list[int]:
        """Mark as known; the equations that come down to one unknown."""
        ripe: list[int] = []
        for unknown in unknowns:
            self.known.add(unknown)
            for equation in self.incidence.users[unknown]:
                self.missing[equation] -= 1
                if self.missing[equation] == 1:
                    ripe.append(equation)
        return ripe
