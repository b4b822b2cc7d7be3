"""Boxes of inputs in which the first answer of a record is known to stay the first: others are not
computed.

The answers are computed at both ends of a range of each input. Their values anywhere in all ranges
are bounded by twice the sum of the moves of all inputs. If the ranking puts one answer first for
all values within these bounds, it is the first everywhere in the box. If only the sizes of a few
others may put them first, the ranking of the two is evaluated at every call.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache, partial
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from rulesheets.model import Row
from solver.ranking.ranking import GRAIN, SIZE, SLACK, ZERO, Key
from solver.trace.order import UNORDERED, KeyRanges, before, keys_as_nodes, spread
from solver.trace.program import Box, Program, simplified
from solver.trace.python import compile_scalar

SHARES = (0.1, 0.03, 0.01, 3e-3, 1e-3)
"""How far the ranges reach, relative to the numbers that they lie around."""
HALVINGS = 4
"""How often a number may come to half of what it is, or to twice that, where it might come to 0."""
ROUNDED = 2.0
"""More than rounding takes from the difference of two parts of a key."""
PRICE = 32
"""Calls that are worth another box; four times as many for each after one that was not."""

Rows: TypeAlias = Sequence[Sequence[float]]
Ends: TypeAlias = tuple[float, float]
Limits: TypeAlias = Mapping[int, Ends]


class Asked(NamedTuple):
    """The ``answers`` that are computed, the limits on their numbers, and those that are
    ``compared`` with the first one at every call."""

    answers: list[int]
    limits: Limits
    compared: list[int]


class Nearby:
    """The boxes of a record, the first around its ``sample``; ``settles``: it covers a row."""

    def __init__(self, program: Program, sample: Row, settles: Callable[[Row], bool]) -> None:
        assert program.ranked is not None
        self.program, self.ranked, self.settles = program, program.ranked, settles
        self.endings = program.endings
        self.box: Box | None = None
        self.call: Callable[..., Any] | None = None
        """Computes the first answer of rows in the box."""
        self._alone: dict[tuple[int, tuple[int, ...]], tuple[Box, Callable[..., Any]]] = {}
        self._missed, self._price = 0, 1
        missing = program.flow.constant(math.nan)
        read = ((*answer, *self.ranked.given) for answer in self.ranked.answers)
        endings = tuple(
            ending._replace(results=tuple(missing if node is None else node for node in nodes))
            for nodes, ending in zip(read, program.endings, strict=True)
        )
        reading = program._replace(endings=endings, order=UNORDERED)
        self._values = compile_scalar(reading, all_answers=True)
        """The numbers of all answers that the ranking reads, instead of the wanted ones."""
        self._over = cache(partial(KeyRanges, self.ranked))
        """By the given numbers that are 0."""
        self._lay(sample)

    def move(self, numbers: Row) -> None:
        """Record numbers outside of the box, and move it to them after enough of these."""
        uses = self.box.uses if self.box else 0
        self._missed += 1
        if uses + self._missed < self._price:
            return
        self._price = PRICE if uses >= PRICE else 4 * self._price
        self._missed = 0
        self._lay(numbers)

    def _lay(self, numbers: Row) -> None:
        """Put the box around some numbers: the widest of those with the fewest answers to
        compute."""
        self.box, self.call = None, None
        if (here := self._rows(numbers)) is None:
            return
        keys = self._keys(here)
        place, most = min(range(len(keys)), key=keys.__getitem__), len(keys)
        best: tuple[Asked, float] | None = None
        for share in SHARES:
            there = self._moved(numbers, share) if most else None
            asked = there and self._asked(place, [here, *there], most)
            if asked:
                most, best = len(asked.answers) - 1, (asked, share)
        if best is None:
            return
        flow, (asked, share), checks = self.program.flow, best, list[int]()
        for node, (low, high) in asked.limits.items():
            checks += flow.add("lt", low, node), flow.add("lt", node, high)
        # the sizes of others are so much farther that only they decide, by more than rounding
        ranking, answers, given = self.ranked
        zero = tuple(number == 0.0 for number in here[0][len(ranking.read) :])
        for other in asked.compared:
            pair = [answers[place], answers[other]]
            _, farther = keys_as_nodes(flow, ranking, pair, given, zero)
            checks.append(flow.add("lt", ROUNDED, farther[SIZE]))
        pairs = ((n - share * abs(n), n + share * abs(n)) for n in numbers if isinstance(n, float))
        ends, key = tuple(end for pair in pairs for end in pair), (place, tuple(checks))
        if key not in self._alone:
            box, ending = Box(ends), self.endings[place].without(self.program.watches)
            ending = ending._replace(holds=(*ending.holds, *checks))
            alone = self.program._replace(endings=(ending,), order=UNORDERED, box=box)
            self._alone[key] = box, compile_scalar(simplified(alone))
        self.box, self.call = self._alone[key]
        self.box.ends, self.box.uses = ends, 0

    def _moved(self, numbers: Row, share: float) -> list[Rows] | None:
        """The answers with each number moved down and up by a share; None if one of them ends."""
        found = []
        for at, number in enumerate(numbers):
            if isinstance(number, float) and number:
                for move in (-share * abs(number), share * abs(number)):
                    rows = self._rows((*numbers[:at], number + move, *numbers[at + 1 :]))
                    if rows is None:
                        return None
                    found.append(rows)
        return found

    def _asked(self, place: int, rows: Sequence[Rows], most: int) -> Asked | None:
        """The conditions, for at ``most`` so many answers, for one of them to be the first.
        ``rows`` are the answers here and with each number moved."""
        ranges = [list(map(_around, *some)) for some in zip(*rows, strict=True)]
        keys = [self._keys(some) for some in rows]
        asked, new = list[int](), [place]
        while new and len(asked) + len(new) <= most:
            asked += new
            limits = self._limits([(k, rows[0][k], ranges[k]) for k in asked])
            unclear, comparable = self._unclear(place, ranges, keys, limits)
            if comparable.issuperset(unclear) and set(asked).issuperset(unclear):
                return Asked(asked, limits, unclear)
            new = [other for other in unclear if other not in asked]
        return None

    def _limits(self, answers: Iterable[tuple[int, Sequence[float], Sequence[Ends]]]) -> Limits:
        """The nodes of the numbers of answers that may come close to 0, and their bounds."""
        found, ranking = {}, self.ranked.ranking
        angles = (*ranking.angles, *(False for _ in ranking.read))
        for k, numbers, ranges in answers:
            columns = zip(self.ranked.answers[k], numbers, ranges, angles, strict=False)
            for node, number, around, angle in columns:
                if node is None or not number or angle or number != number:
                    continue
                power = math.frexp(number)[1]
                inside = math.ldexp(0.5, power - HALVINGS), math.ldexp(1.0, power + HALVINGS)
                if number < 0.0:
                    inside = -inside[1], -inside[0]
                if not inside[0] <= around[0] <= around[1] <= inside[1]:
                    found[node] = inside
        return found

    def _rows(self, numbers: Row) -> Rows | None:
        """The numbers of every answer that the ranking reads, and the given ones."""
        found: list[tuple[float, ...]] | None = self._values(*numbers)
        count = len(self.program.endings)
        return (
            found if found is not None and len(found) == count and self.settles(numbers) else None
        )

    def _keys(self, rows: Rows) -> list[Key]:
        count = len(self.ranked.ranking.read)
        return self.ranked.ranking.keys_of_rows([row[:count] for row in rows], rows[0][count:])

    def _unclear(
        self,
        place: int,
        ranges: Sequence[Sequence[Ends]],
        keys: Sequence[Sequence[Key]],
        limits: Limits,
    ) -> tuple[list[int], set[int]]:
        """The answers that may come before that of a place somewhere in the ranges, within the
        limits, and those that only the sizes distinguish from it."""
        ranking, answers, given = self.ranked
        rows = [
            [
                _shared(one, one if n is None else limits.get(n, one))
                for n, one in zip(nodes, some, strict=False)
            ]
            for nodes, some in zip(answers, ranges, strict=True)
        ]
        known = ranges[0][len(ranking.read) :]
        columns = zip((*answers, given), (*rows, known), strict=True)
        ends = {
            node: (np.array([low]), np.array([high]))
            for nodes, some in columns
            for node, (low, high) in zip(nodes, some, strict=False)
            if node is not None
        }
        told = self._over(tuple(pair == (0.0, 0.0) for pair in known))(ends)
        others = [other for other in range(len(rows)) if other != place]
        unclear = [
            k
            for k in others
            if not before(told[place], told[k], [(key[place], key[k]) for key in keys])
        ]
        whole = {k for k in (place, *unclear) if _counts_whole(k, rows, ranking.angles)}
        comparable = set[int]()
        for k in unclear:
            parts = zip(told[place][:SIZE], told[k][:SIZE], strict=True)
            alike = all(a[1] <= b[0] for a, b in parts)
            nearer = keys[0][k][SIZE] - keys[0][place][SIZE] > GRAIN * SLACK
            if alike and nearer and {place, k} <= whole:
                comparable.add(k)
        return unclear, comparable


def _counts_whole(place: int, rows: Sequence[Sequence[Ends]], angles: Sequence[bool]) -> bool:
    """Whether no number of an answer, except angles, is so small in its range that it may count as
    0 relative to those of the others."""
    for angle, column in zip(angles, zip(*rows, strict=True), strict=False):
        least = max(column[place][0], -column[place][1], 0.0)
        if not angle and any(least <= 2.0 * ZERO * max(-low, high) for low, high in column):
            return False
    return True


def _shared(one: Ends, other: Ends) -> Ends:
    return max(one[0], other[0]), min(one[1], other[1])


def _around(*numbers: float) -> Ends:
    """The range around a number; a missing one stays missing."""
    far = spread(numbers)
    return numbers[0] - far, numbers[0] + far
