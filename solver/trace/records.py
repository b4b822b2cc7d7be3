"""The records of one pattern of inputs, each made from a row that was solved step by step.

A record is good for every row that decides as the row it was made from. It is tried on the rows that are
left, and what it does not settle is for the next one; for a row that none settles a full solve has the word,
and a new record may be made of it. A record that does not return what it was made from is not used.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any

from rulesheets.model import Model, Value
from solver.path.planner import Planner
from solver.ranking.ranking import Ranking
from solver.solution.leaves import Exploration, Leaf
from solver.trace.flow import NotCompilable
from solver.trace.program import Program
from solver.trace.python import compile_scalar
from solver.trace.record import record
from solver.trace.refusal import refusal
from solver.trace.state import Pattern

MAX_RECORDS = 24
"""Records of one pattern; a sheet whose rows decide otherwise more often is solved step by step beyond."""

MAX_FAILURES = 12
AGREEMENT = 1e-6
"""How near a record must come to the row that it was made from, relative to each number."""


class Records:
    """The records of one pattern: ``every`` gives all answers of a row by each of the ``programs``, and
    ``refused`` is not None for a row that is infeasible by one of the ``refusals``.
    """

    def __init__(self, model: Model, planner: Planner, pattern: Pattern) -> None:
        self.model, self.planner, self.pattern = model, planner, pattern
        self.programs: list[Program] = []
        self.every: list[Callable[..., Any]] = []
        self.refusals: list[Program] = []
        self.refused: list[Callable[..., Any]] = []
        self.failures = self.vain = 0

    def primary(self) -> Callable[..., Any]:
        """The first record, for its first answer alone."""
        return compile_scalar(self.programs[0])

    def learn(self, numbers: Sequence[Value], leaves: Sequence[Leaf], dead: Sequence[Leaf]) -> bool:
        """A new record from the answers of a row that was solved step by step, where it says the same."""
        if len(self.programs) >= MAX_RECORDS or self.failures >= MAX_FAILURES:
            return False
        for plain in (False, True):
            with suppress(NotCompilable):
                program = record(
                    self.model, self.planner, self.pattern, leaves, dead, plain, self._ranking(leaves)
                )
                every = compile_scalar(program, all_answers=True)
                if self._agrees(every(*numbers), [leaf.branch.values for leaf in leaves]):
                    self.programs.append(program)
                    self.every.append(every)
                    return True
        self.failures += 1
        return False

    def _ranking(self, leaves: Sequence[Leaf]) -> Ranking:
        want, pattern = self.pattern.want, self.pattern
        names = (*want, *(name for name in leaves[0].branch.values if name not in want))
        return Ranking(self.model, (*pattern.inputs, *pattern.given), names, pattern.guesses)

    def refuse(self, numbers: Sequence[Value], found: Exploration) -> None:
        """Learn to tell the rows that are refused as this one."""
        if len(self.refusals) >= MAX_RECORDS or self.vain >= MAX_FAILURES:
            return
        with suppress(NotCompilable):
            program = refusal(self.model, self.planner, self.pattern, found)
            refused = compile_scalar(program)
            if refused(*numbers) is not None:
                self.refusals.append(program)
                self.refused.append(refused)
                return
        self.vain += 1

    def mark(self) -> tuple[int, int, int, int]:
        """What has been learned so far, for ``forget``."""
        return len(self.programs), len(self.refusals), self.failures, self.vain

    def forget(self, mark: tuple[int, int, int, int]) -> None:
        """Go back to what was known at a mark."""
        programs, refusals, self.failures, self.vain = mark
        del self.programs[programs:]
        del self.every[programs:]
        del self.refusals[refusals:]
        del self.refused[refusals:]

    def _agrees(self, rows: object, answers: Sequence[Mapping[str, Value]]) -> bool:
        if not isinstance(rows, list):
            return False
        names = self.pattern.want
        wanted = [tuple(answer.get(name, math.nan) for name in names) for answer in answers]
        known = all(any(_same(one, row) for row in rows) for one in wanted)
        return known and all(any(_same(one, row) for one in wanted) for row in rows)


def _same(one: Sequence[Value], other: Sequence[Value]) -> bool:
    return all(_near(a, b) for a, b in zip(one, other, strict=True))


def _near(a: Value, b: Value) -> bool:
    if isinstance(a, str) or isinstance(b, str):
        return a == b
    return abs(a - b) <= AGREEMENT * max(abs(a), abs(b)) + 1e-12 or (math.isnan(a) and math.isnan(b))
