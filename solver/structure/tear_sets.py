"""Sets of tears: all of the smallest ones where that can be searched, else a good one.

Finding a smallest set is NP-complete (it contains feedback vertex set; see A. Baharev, H. Schichl
& A. Neumaier, "Tearing systems of nonlinear equations II", 2016), so exact for small blocks only.
The heuristic is Cellier's: among the equations with the fewest unknowns left, the unknown from
which most follows.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from heapq import heapify, heappop, heappush
from math import comb

from rulesheets.deadline import expect_time
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


EFFORT = 50_000
"""Sets times unknowns up to which all sets are tried: five of 15, one or two tears in larger blocks."""

TRIM = 1_000_000
"""Tears times edges up to which a set is searched for idle tears."""

CANDIDATES = 40
"""How many unknowns the heuristic tries before it takes the best as a tear."""


def smallest_sets(incidence: Incidence, weights: Mapping[int, int]) -> list[tuple[int, ...]]:
    """Sets of tears of one size: all of the least size, or the one that the heuristic finds."""
    reach = Reach(incidence)
    n = len(incidence.block.unknowns)
    for size in range(_at_least(incidence, reach), n + 1):
        if comb(n, size) * n > EFFORT:
            break
        sets = list(_complete(incidence.block.unknowns, reach, size, 0))
        if sets:
            return sets
    return [_without_idle(incidence, _greedy(incidence, weights))]


def _at_least(incidence: Incidence, reach: Reach) -> int:
    """A lower bound: what no equation can give, and all but one unknown of the first step's equation."""
    if reach.complete:
        return 0
    given = {u for e in incidence.block.equations for u in incidence.resolvable[e]}
    never_given = len(set(incidence.block.unknowns) - given)
    first = min((reach.missing[e] for e in incidence.block.equations if reach.missing[e]), default=1)
    return max(never_given, first - 1, 1)


def _complete(unknowns: tuple[int, ...], reach: Reach, size: int, start: int) -> Iterator[tuple[int, ...]]:
    """Sets of ``size`` further tears from which everything follows, in lexicographic order.

    An unknown that follows from the tears before it is passed over: a set with it is not smallest. As many as
    are missing have to be left: sets of fewer tears have been searched.
    """
    if reach.complete:
        yield ()
        return
    if min((missing for missing in reach.missing.values() if missing > 1), default=0) > size + 1:
        return  # too few tears for any further step
    for i in range(start, len(unknowns) - size + 1 if size else 0):
        expect_time()
        if unknowns[i] not in reach.known:
            learnt = reach.learn(unknowns[i])
            for rest in _complete(unknowns, reach, size - 1, i + 1):
                yield (unknowns[i], *rest)
            reach.undo(learnt)


def _greedy(incidence: Incidence, weights: Mapping[int, int]) -> list[int]:
    reach = Reach(incidence)
    shortest = [(reach.missing[e], e) for e in incidence.block.equations]
    heapify(shortest)
    tears: list[int] = []
    while not reach.complete:
        expect_time()
        promising = _promising(incidence, reach, shortest)
        best = max(promising, key=lambda u: (reach.gain(u), -weights.get(u, 0), -u))
        tears.append(best)
        for unknown in reach.learn(best):
            for equation in incidence.users[unknown]:
                heappush(shortest, (reach.missing[equation], equation))
    return tears


def _promising(incidence: Incidence, reach: Reach, shortest: list[tuple[int, int]]) -> list[int]:
    """Up to about ``CANDIDATES`` unknowns of the equations with the fewest left that can still be a step."""
    taken: list[tuple[int, int]] = []
    found: dict[int, None] = {}
    while shortest and len(found) < CANDIDATES and (not taken or shortest[0][0] == taken[0][0]):
        entry = heappop(shortest)
        if (not taken or entry != taken[-1]) and _may_follow(incidence, reach, entry):
            taken.append(entry)
            left = (u for u in incidence.occurs[entry[1]] if u not in reach.known)
            found.update(dict.fromkeys(left))
    for entry in taken:
        heappush(shortest, entry)
    return list(found)[:CANDIDATES] or [next(u for u in incidence.block.unknowns if u not in reach.known)]


def _may_follow(incidence: Incidence, reach: Reach, entry: tuple[int, int]) -> bool:
    """Whether a queue entry is up to date and its equation could become a step."""
    missing, equation = entry
    current = missing == reach.missing[equation] and missing > 1
    return current and any(unknown not in reach.known for unknown in incidence.resolvable[equation])


def _without_idle(incidence: Incidence, tears: Sequence[int]) -> tuple[int, ...]:
    """Drop tears that follow from the others, the first taken first; not tried for very many."""
    kept = list(tears)
    if len(tears) * incidence.edges <= TRIM:
        for idle in tears:
            rest = [u for u in kept if u != idle]
            if Reach(incidence, rest).complete:
                kept = rest
    return tuple(sorted(kept))
