"""The compiled ways of one pattern of inputs: learned from rows that were solved step by step.

A way is good for every row that decides as the row it was learned from. It is tried on the rows that are
left, and what it does not settle is for the next way; for a row that none settles the step-by-step
way has the word, and a new way may be learned from it. A way that does not return what it was
learned from is not used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from solver.compiled.flow import NotCompilable
from solver.compiled.refusal import refusals
from solver.compiled.scalar import compile_scalar
from solver.compiled.translate import translate
from solver.compiled.way import Pattern

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from typing import Any

    from rulesheets.model import Model, Value
    from solver.compiled.program import Program
    from solver.path.planner import Planner

MAX_WAYS = 24
"""Ways of one pattern; a sheet whose rows decide in more ways than this is solved step by step beyond."""

MAX_FAILURES = 12
AGREEMENT = 1e-6
"""How near a way must come to the row that it was learned from, relative to each number."""


class CompiledPaths:
    """Ways to answer one pattern. ``primary`` gives the first answer of a row, ``every`` all of them.

    ``programs`` are what the first ones follow, ``forks`` what the others do.
    """

    def __init__(self, model: Model, planner: Planner, pattern: Pattern) -> None:
        self.model, self.planner, self.pattern = model, planner, pattern
        self.programs: list[Program] = []
        self.forks: list[Program] = []
        self.primary: list[Callable[..., Any]] = []
        self.every: list[Callable[..., Any]] = []
        self.refusals: list[Program] = []
        self.failures = 0

    def learn(self, numbers: Sequence[Value], answers: Sequence[Mapping[str, Value]]) -> Program | None:
        """A new way from a row that was solved step by step, where there is one and it says the same.

        ``answers`` are the values of every variable in each answer.
        """
        if len(self.programs) >= MAX_WAYS or self.failures >= MAX_FAILURES:
            return None
        for plain in (True,) if self.pattern.as_written else (False, True):
            try:
                program = translate(self.model, self.planner, self.pattern, answers[0], plain)
                every = compile_scalar(program, all_answers=True)
            except NotCompilable:
                break
            if self._agrees(every(*numbers), answers):
                first = self._first(program, numbers, answers, plain)
                self._take(program, first, every)
                return first
        self.failures += 1
        return None

    def take(self, fork: Program, first: Program) -> None:
        """Add a way that was learned before: ``first`` follows the primary answer, ``fork`` all of them."""
        self._take(fork, first, compile_scalar(fork, all_answers=True))

    def _take(self, fork: Program, first: Program, every: Callable[..., Any]) -> None:
        self.forks.append(fork)
        self.programs.append(first)
        self.primary.append(compile_scalar(first))
        self.every.append(every)

    def refuse(self, numbers: Sequence[Value], sample: Mapping[str, Value]) -> Program | None:
        """A program that tells the rows that are refused as this one, of which ``sample`` was computed."""
        if len(self.refusals) >= MAX_WAYS or self.failures >= MAX_FAILURES:
            return None
        for program in refusals(self.model, self.planner, self.pattern, sample):
            if compile_scalar(program)(*numbers) is not None:
                self.refusals.append(program)
                return program
        self.failures += 1
        return None

    def _first(
        self, program: Program, numbers: Sequence[Value], answers: Sequence[Mapping[str, Value]], plain: bool
    ) -> Program:
        """The program that follows the primary answer only, where that can be told early."""
        if len(program.endings) == 1:
            return program
        first = translate(self.model, self.planner, self.pattern, answers[0], plain, first=True)
        found = compile_scalar(first, all_answers=True)(*numbers)
        return first if self._agrees(found, answers[:1]) else program

    def mark(self) -> tuple[int, int, int]:
        """What has been learned so far, for ``forget``."""
        return len(self.programs), len(self.refusals), self.failures

    def forget(self, mark: tuple[int, int, int]) -> None:
        """Go back to what was known at a mark."""
        ways, refusals, self.failures = mark
        for learned in (self.programs, self.forks, self.primary, self.every):
            del learned[ways:]
        del self.refusals[refusals:]

    def _agrees(self, rows: object, answers: Sequence[Mapping[str, Value]]) -> bool:
        if not isinstance(rows, list):
            return False
        wanted = list(dict.fromkeys(tuple(answer[n] for n in self.pattern.want) for answer in answers))
        found = list(dict.fromkeys(rows))
        if len(found) != len(wanted):
            return False
        pairs = (zip(one, other, strict=True) for one, other in zip(found, wanted, strict=True))
        return all(_near(a, b) for pair in pairs for a, b in pair)


def _near(a: Value, b: Value) -> bool:
    if isinstance(a, str) or isinstance(b, str):
        return a == b
    return abs(a - b) <= AGREEMENT * max(abs(a), abs(b)) + 1e-12
