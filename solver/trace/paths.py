"""The compiled ways of one pattern of inputs: learned from rows that were solved step by step.

A way is good for every row that decides as the row it was learned from. It is tried on the rows that are
left, and what it does not settle is for the next way; for a row that none settles the step-by-step
way has the word, and a new way may be learned from it. A way that does not return what it was
learned from is not used.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from solver.compiled.flow import NotCompilable
from solver.compiled.refusal import refusals
from solver.compiled.scalar import compile_scalar
from solver.compiled.translate import translate
from solver.compiled.way import Pattern
from solver.trace.record import record

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from typing import Any

    from rulesheets.model import Model, Value
    from solver.compiled.program import Program
    from solver.path.planner import Planner
    from solver.ranking.ranking import Ranking
    from solver.solution.leaves import Leaf

MAX_WAYS = 24
"""Ways of one pattern; a sheet whose rows decide in more ways than this is solved step by step beyond."""

MAX_FAILURES = 12
AGREEMENT = 1e-6
"""How near a way must come to the row that it was learned from, relative to each number."""


class CompiledPaths:
    """Ways to answer one pattern. ``every`` gives all answers of a row, in no order that tells; ``primary``
    the only one, of the ways that have no more.
    """

    def __init__(self, model: Model, planner: Planner, pattern: Pattern) -> None:
        self.model, self.planner, self.pattern = model, planner, pattern
        self.programs: list[Program] = []
        self.every: list[Callable[..., Any]] = []
        self.refusals: list[Program] = []
        self.failures = 0

    @property
    def forked(self) -> bool:
        """Whether some way may have several answers."""
        return any(len(program.endings) > 1 and not program.ordered for program in self.programs)

    def primary(self) -> Callable[..., Any]:
        """The first way, for its only answer."""
        return compile_scalar(self.programs[0])

    def record(self, numbers: Sequence[Value], leaves: Sequence[Leaf], ranking: Ranking) -> bool:
        """A record of several answers, which stand in the order of the rule."""
        if len(self.programs) >= MAX_WAYS or self.failures >= MAX_FAILURES:
            return False
        return any(
            self._learned(numbers, leaves, lambda some, plain: self._recorded(some, plain, ranking), plain)
            for plain in (False, True)
        )

    def learn(self, numbers: Sequence[Value], leaves: Sequence[Leaf]) -> bool:
        """A new way from the answers of a row that was solved step by step, where there is one that says the
        same: along the path, or else the record of what was done.
        """
        if len(self.programs) >= MAX_WAYS or self.failures >= MAX_FAILURES:
            return False
        for written in (self._along_the_path, self._recorded):
            if any(self._learned(numbers, leaves, written, plain) for plain in (False, True)):
                return True
        self.failures += 1
        return False

    def _learned(
        self,
        numbers: Sequence[Value],
        leaves: Sequence[Leaf],
        written: Callable[[Sequence[Leaf], bool], Program],
        plain: bool,
    ) -> bool:
        try:
            program = written(leaves, plain)
            every = compile_scalar(program, all_answers=True)
        except NotCompilable:
            return False
        agrees = self._agrees(every(*numbers), [leaf.branch.values for leaf in leaves])
        if agrees:
            self._take(program, every)
        return agrees

    def _along_the_path(self, leaves: Sequence[Leaf], plain: bool) -> Program:
        return translate(self.model, self.planner, self.pattern, leaves[0].branch.values, plain)

    def _recorded(self, leaves: Sequence[Leaf], plain: bool, ranking: Ranking | None = None) -> Program:
        return record(self.model, self.planner, self.pattern, leaves, plain, ranking)

    def take(self, program: Program) -> None:
        """Add a way that was learned before."""
        self._take(program, compile_scalar(program, all_answers=True))

    def _take(self, program: Program, every: Callable[..., Any]) -> None:
        self.programs.append(program)
        self.every.append(every)

    def refuse(self, numbers: Sequence[Value], sample: Mapping[str, Value]) -> None:
        """Learn to tell the rows that are refused as this one, of which ``sample`` was computed."""
        if len(self.refusals) >= MAX_WAYS or self.failures >= MAX_FAILURES:
            return
        for program in refusals(self.model, self.planner, self.pattern, sample):
            if compile_scalar(program)(*numbers) is not None:
                self.refusals.append(program)
                return
        self.failures += 1

    def mark(self) -> tuple[int, int, int]:
        """What has been learned so far, for ``forget``."""
        return len(self.programs), len(self.refusals), self.failures

    def forget(self, mark: tuple[int, int, int]) -> None:
        """Go back to what was known at a mark."""
        ways, refusals, self.failures = mark
        del self.programs[ways:]
        del self.every[ways:]
        del self.refusals[refusals:]

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
