"""Next to some numbers the first answer of a record is known to be the first: the others need no look there.

They are followed to both ends of a range of each input, and what they may be anywhere in all ranges is taken
for twice as far from where they are as the moves of all inputs add up to. Where the rule puts one answer
first whatever the numbers are, within that, it is the first in all of the box.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

from rulesheets.model import Value
from solver.ranking.ranking import Key
from solver.trace.implied import lean
from solver.trace.order import RANGES, UNORDERED, Range, Ranked, before, spread
from solver.trace.program import Box, Ending, Program
from solver.trace.python import compile_scalar

SHARES = (0.1, 0.05, 0.02, 0.01, 5e-3, 2e-3, 1e-3)
"""How far the ranges reach, relative to the numbers that they lie around."""
PRICE = 32
"""Calls that pay for another box; twice as many for each after one that was not worth it."""

Numbers: TypeAlias = tuple[Value, ...]
Rows: TypeAlias = Sequence[Sequence[float]]


class Nearby:
    """The boxes of one record, the first around its ``sample``. ``settles`` tells whether it is the record
    that settles a row."""

    def __init__(self, program: Program, sample: Numbers, settles: Callable[[Numbers], bool]) -> None:
        assert program.ranked is not None and program.brief is not None
        self.program, self.ranked, self.settles = program, program.ranked, settles
        self.endings = program.brief.alone
        self.box: Box | None = None
        self.call: Callable[..., Any] | None = None
        """What tells the first answer of rows in the box."""
        self._alone: dict[int, tuple[Box, Callable[..., Any]]] = {}
        self._missed, self._price = 0, 1
        self._values = compile_scalar(_reading(program, program.ranked), all_answers=True)
        self._lay(sample)

    def move(self, numbers: Numbers) -> None:
        """Take note of numbers outside of the box, and lay it around them where enough of them were asked."""
        told = self.box.told if self.box else 0
        self._missed += 1
        if told + self._missed < self._price:
            return
        self._price = PRICE if told >= PRICE else 2 * self._price
        self._missed = 0
        self._lay(numbers)

    def _lay(self, numbers: Numbers) -> None:
        self.box, self.call = None, None
        if (found := self._found(numbers)) is not None:
            place, ends = found
            if place not in self._alone:
                box = Box(ends)
                alone = self.program._replace(endings=(self.endings[place],), order=UNORDERED, box=box)
                self._alone[place] = box, compile_scalar(lean(alone))
            self.box, self.call = self._alone[place]
            self.box.ends, self.box.told = ends, 0

    def _found(self, numbers: Numbers) -> tuple[int, tuple[float, ...]] | None:
        """The place of the first answer and the ends of the widest box in which it is the first."""
        here = self._rows(numbers)
        if here is None:
            return None
        keys = self._keys(here)
        place = min(range(len(keys)), key=keys.__getitem__)
        for share in SHARES:
            moves = [
                [(*numbers[:at], number + way * share * abs(number), *numbers[at + 1 :]) for way in (-1, 1)]
                for at, number in enumerate(numbers)
                if isinstance(number, float) and number
            ]
            there = [rows for pair in moves for rows in map(self._rows, pair) if rows is not None]
            if len(there) == 2 * len(moves) and self._is_first(place, here, there):
                ends = ((n - share * abs(n), n + share * abs(n)) for n in numbers if isinstance(n, float))
                return place, tuple(end for pair in ends for end in pair)
        return None

    def _rows(self, numbers: Numbers) -> Rows | None:
        """The numbers of every answer that the rule reads, and those that are given."""
        found: list[tuple[float, ...]] | None = self._values(*numbers)
        count = len(self.program.endings)
        return found if found is not None and len(found) == count and self.settles(numbers) else None

    def _keys(self, rows: Rows) -> list[Key]:
        count = len(self.ranked.ranking.read)
        return self.ranked.ranking.keys_of_rows([row[:count] for row in rows], rows[0][count:])

    def _is_first(self, place: int, here: Rows, there: Sequence[Rows]) -> bool:
        """Whether an answer comes first wherever the numbers are."""
        ranking, count = self.ranked.ranking, len(self.ranked.ranking.read)
        zero = tuple(number == 0.0 for number in here[0][count:])
        ranges = [
            [_around(*numbers) for numbers in zip(*rows, strict=True)]
            for rows in zip(here, *there, strict=True)
        ]
        told = ranking.keys_on(RANGES, [row[:count] for row in ranges], ranges[0][count:], zero)
        keys = [self._keys(rows) for rows in (here, *there)]
        others = (other for other in range(len(here)) if other != place)
        return all(before(told[place], told[k], [(key[place], key[k]) for key in keys]) for k in others)


def _reading(program: Program, ranked: Ranked) -> Program:
    """What the rule reads of all answers, in place of what is wanted."""
    missing = program.flow.constant(math.nan)
    endings = (
        Ending(
            tuple(missing if n is None else n for n in (*answer, *ranked.given)), ending.holds, ending.finite
        )
        for answer, ending in zip(ranked.answers, program.endings, strict=True)
    )
    return program._replace(endings=tuple(endings), order=UNORDERED)


def _around(*numbers: float) -> Any:
    """A number that is not there stays so."""
    far = spread(numbers)
    return Range(numbers[0] - far, numbers[0] + far) if far == far else math.nan
