"""The records of one pattern of inputs, each made from a row that was solved step by step.

A record is valid for every row with the same decisions as the row it was made from. It is tried on
the remaining rows, and the next one gets those it does not cover; a row that none covers is solved
in full, and a new record may be made of it. A record that does not reproduce its own row is not
used.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from itertools import chain
from typing import Any

from rulesheets.deadline import TimeIsUp
from rulesheets.model import Model, Row, Value, Values
from solver.leaves import Exploration, Leaf
from solver.path.planner import planner
from solver.ranking.ranking import Ranking, settled
from solver.trace.folds import ConstantRootCount
from solver.trace.graph import NotCompilable
from solver.trace.guards import Pattern
from solver.trace.nearby import Nearby
from solver.trace.program import Program
from solver.trace.python import compile_scalar
from solver.trace.record import MAX_DEAD, Recording
from solver.trace.steps import Proof

MAX_RECORDS = 24
"""Records of one pattern; a sheet whose rows decide otherwise more often is solved step by step
beyond."""

MAX_FAILURES = 12
MAX_VAIN = 3
"""Rows of which no refusal could be made: further ones are not tried."""
SOON = 3
"""Calls for a first answer that are worth a program for it alone."""
AGREEMENT = 1e-6
"""The relative distance of a record from the row it was made from."""


class Records:
    """The records of one pattern: ``every`` gives all answers of a row by each of the ``programs``,
    and ``refused`` is not None for a row that is infeasible by one of the ``refusals``."""

    def __init__(self, model: Model, pattern: Pattern) -> None:
        self.model, self.pattern = model, pattern
        self.programs: list[Program] = []
        self.every: list[Callable[..., Any]] = []
        self.refusals: list[Program] = []
        self.refused: list[Callable[..., Any]] = []
        self.failures = self.vain = 0
        self.useful = 0
        """The place of the record that last covered a row that no earlier one did."""
        self.rows: dict[Row, list[Row]] = {}
        """The answers of rows that cannot be recorded, such as those of a double root."""
        self._primary: dict[int, tuple[Callable[..., Any], ...]] = {}
        self._nearby: dict[int, Nearby] = {}
        self._asked = 0
        self._samples: list[Sequence[Value]] = []
        self._proofs = list[Proof]()
        self.learned = 0
        """Rows from which something was learned."""

    @property
    def order(self) -> list[int]:
        """The order in which records are tried: more answers first, then the last useful one."""
        places = range(len(self.programs))
        return sorted(places, key=lambda at: (-len(self.programs[at].endings), at != self.useful))

    def first(self) -> tuple[Callable[..., Any], ...]:
        """The records for calls of the first answer, in order; none if the order is unknown."""
        near = self._nearby.get(self.useful)
        if near is not None and near.call is not None:
            return (near.call,)
        if self.programs[self.useful].ranked and near is None:
            return ()
        places = self.order[: self.order.index(self.useful) + 1]
        for place in places:
            if place not in self._primary:
                program = self.programs[place]
                forms = (program,) if program.brief is None else (program.brief, program)
                self._primary[place] = tuple(map(compile_scalar, forms))
        return tuple(chain.from_iterable(self._primary[place] for place in places))

    def near(self, numbers: Row) -> None:
        """Note that the useful record covered a row of which the first answer was wanted."""
        place = self.useful
        if numbers in self.rows or not self.programs[place].ranked:
            return
        self._asked += 1
        if place in self._nearby:
            self._nearby[place].move(numbers)
        elif self._asked >= SOON:
            before = [self.every[one] for one in self.order[: self.order.index(place)]]
            self._nearby[place] = Nearby(
                self.programs[place],
                tuple(self._samples[place]),
                lambda row: all(every(*row) is None for every in before),
            )

    def known(self, numbers: Row) -> list[Row] | None:
        """All answers of a row by the first record that covers it, which becomes the useful one."""
        if numbers in self.rows:
            return self.rows[numbers].copy()
        for place in self.order:
            found: list[Row] | None = self.every[place](*numbers)
            if found is not None:
                self.useful = place
                return found
        return None

    def add(
        self, numbers: Sequence[Value], leaves: Sequence[Leaf], refused: Sequence[Leaf]
    ) -> bool:
        """Make a record of a row that was solved step by step, or note its answers; False if
        neither.

        A new record is added if it reproduces the row and no other does.
        """
        answers = [leaf.branch.values for leaf in leaves]
        if any(self._agrees(every(*numbers), answers) for every in self.every):
            return True
        if self._reaches(numbers, answers):
            return True
        if len(self.programs) >= MAX_RECORDS or self.failures >= MAX_FAILURES:
            return False
        want, pattern = self.pattern.want, self.pattern
        names = (*want, *(name for name in answers[0] if name not in want))
        known = settled(self.model, (*pattern.inputs, *pattern.given), answers)
        ranking = Ranking(self.model, known, names, pattern.guesses)
        for corrects in (False, True):
            # the answers are known, whatever becomes of a record
            with suppress(NotCompilable, TimeIsUp):
                recording = Recording(self.model, pattern, leaves, corrects, self._proofs)
                program = recording.run(refused, ranking)
                every = compile_scalar(program, all_answers=True)
                if self._agrees(every(*numbers), answers):
                    self._nearby.clear()
                    self.programs.append(program)
                    self.every.append(every)
                    self._samples.append(tuple(numbers))
                    return True
        self.failures += 1
        return False

    def _reaches(self, numbers: Sequence[Value], answers: Sequence[Values]) -> bool:
        """Whether a record gives the answers of a row that its proofs do not cover: they are too
        weak."""
        for program, every in zip(self.programs, self.every, strict=True):
            folds = [
                finder for finder in program.flow.finders if isinstance(finder, ConstantRootCount)
            ]
            before = [_copied(vars(fold)) for fold in folds]
            for fold in folds:
                fold.weak = True
            agrees = self._agrees(every(*numbers), answers)
            for fold, state in zip(folds, before, strict=True):
                vars(fold).update({"weak": False} if agrees else state)
            if agrees:
                return True
        return False

    def remember(self, numbers: Row, rows: list[Row]) -> None:
        """Keep the answers of one row, of which no record was made; zeros have signs."""
        if len(self.rows) < MAX_RECORDS and 0.0 not in numbers:
            self.rows[numbers] = rows.copy()

    def refuse(self, numbers: Sequence[Value], found: Exploration) -> None:
        """Add a refusal for rows that are refused as this one."""
        if len(self.refusals) >= MAX_RECORDS or self.vain >= MAX_VAIN:
            return
        ends = (*found.leaves, *found.open_cases, *found.outside_case)
        with suppress(NotCompilable, TimeIsUp):
            if 1 <= len(ends) <= MAX_DEAD and not found.contradicted:
                program = Recording(self.model, self.pattern, ends, False, []).refused()
                refused = compile_scalar(program)
                if refused(*numbers) is not None:
                    self.refusals.append(program)
                    self.refused.append(refused)
                    return
        self.vain += 1

    def mark(self) -> list[tuple[Any, dict[str, Any]]]:
        """The present state of the records, for ``forget``."""
        programs = (*self.programs, *self.refusals)
        finders = (finder for program in programs for finder in program.flow.finders)
        return [(one, _copied(vars(one))) for one in (self, *finders)]

    def forget(self, mark: list[tuple[Any, dict[str, Any]]]) -> None:
        """Go back to a marked state."""
        for one, state in mark:
            vars(one).update(_copied(state))
        self._primary.clear()
        self._nearby.clear()

    def _agrees(self, rows: object, answers: Sequence[Values]) -> bool:
        if not isinstance(rows, list):
            return False
        names = self.pattern.want
        turns = list(map(planner(self.model).graph.turn, names))
        wanted = [tuple(answer.get(name, math.nan) for name in names) for answer in answers]

        def same(one: Sequence[Value], other: Sequence[Value]) -> bool:
            return all(map(_near, one, other, turns))

        known = all(any(same(one, row) for row in rows) for one in wanted)
        return known and all(any(same(one, row) for one in wanted) for row in rows)


def _copied(state: Mapping[str, Any]) -> dict[str, Any]:
    return {name: v.copy() if isinstance(v, list | dict) else v for name, v in state.items()}


def _near(a: Value, b: Value, turn: float | None) -> bool:
    """Whether two values are the same, also on both sides of the half turn."""
    if isinstance(a, str) or isinstance(b, str):
        return a == b
    apart, limit = abs(a - b), AGREEMENT * max(abs(a), abs(b)) + 1e-12
    if turn is not None:
        apart = min(apart, abs(apart - turn))
    return apart <= limit or (math.isnan(a) and math.isnan(b))
