"""One piece of a sweep solved: the unit of work of this process, of its helpers and of a cluster alike."""

from __future__ import annotations

import pickle
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from time import time

import numpy as np

from rulesheets.deadline import time_limit
from rulesheets.functions.registered import run_python
from rulesheets.model import Model, Value
from solver.files.columns import Array, Columns, csv_rows, free_name
from solver.interruption import Interrupted
from solver.plan import one_answer
from solver.result import Status, Table
from solver.sweeps.answers import every_answer, solved_answers
from solver.sweeps.refusals import refusals
from solver.sweeps.steady import Pattern, SteadyPlans
from solver.trace.rows import Answers


@dataclass(frozen=True)
class Rows:
    """The inputs of rows, their status codes (n,), and all their answers."""

    inputs: tuple[Array, ...]
    codes: Array
    answers: Answers

    def last(self) -> Rows:
        """The last two rows, which a branch goes on from."""
        counts = self.answers.counts
        few = int(counts[-2:].sum())
        values = [column[len(column) - few :] for column in self.answers.values]
        inputs = tuple(column[-2:] for column in self.inputs)
        return Rows(inputs, self.codes[-2:], Answers(counts[-2:], values))


@dataclass(frozen=True)
class Solved:
    """A piece of the table in the order of its rows. ``table`` or ``text`` is there as the work asks.

    ``counts`` are the rows by status code, ``several`` those that have several answers and show one. ``rows``
    are all of them where there are such, else the last ones: they tell which branch an answer belongs to.
    ``answers`` (rows of the table,) are the numbers of answers that are known.
    """

    counts: tuple[int, ...]
    table: Columns | None = None
    text: bytes | None = None
    rows: Rows | None = None
    several: int = 0
    answers: Array = field(default_factory=lambda: np.zeros(0, dtype=np.int64))


@dataclass(frozen=True)
class Work:
    """What has to be known to solve any piece of a sweep.

    ``lessons`` are rows (a column an input) of which records are made beforehand. ``every``
    asks for all answers of a row instead of the primary one, ``tabled`` for arrays, ``texted`` for
    lines of CSV (which are worth making where the rows are solved), ``jit`` for machine code. ``until``
    is the end of its time by the clock of the system: rows that are solved later fail.
    """

    model: Model
    inputs: tuple[str, ...]
    want: tuple[str, ...]
    given: Mapping[str, Value]
    guesses: Mapping[str, float]
    lessons: tuple[Array, ...] = ()
    every: bool = False
    tabled: bool = True
    texted: bool = False
    jit: bool = False
    until: float | None = None

    def limit(self) -> AbstractContextManager[None]:
        """What is left of the time."""
        return time_limit(None if self.until is None else max(self.until - time(), 1e-9))

    @property
    def names(self) -> tuple[str, ...]:
        """The columns of the table, the status not among them."""
        own = (*self.inputs, *(name for name in self.want if name not in self.inputs))
        if not self.every:
            return (*own, free_name("answers", own))
        return (*self.inputs, free_name("answer", own), *own[len(self.inputs) :])

    def columns(self, table: Table) -> Columns:
        """A table in the order of ``names``."""
        solved = not table.status.any()  # then inputs and answers are all there
        return Columns({name: table[name] for name in self.names}, table.status, _WORDS, solved)

    def solved(self, rows: Rows, first: Array) -> Solved:
        """Rows with their primary answers, which stand at the places ``first`` among all."""
        inputs = dict(zip(self.inputs, rows.inputs, strict=True))
        parts = self.columns(one_answer(inputs, self.want, rows.codes, rows.answers, first))
        text = csv_rows(parts) if self.texted else None
        table = parts if self.tabled else None
        return Solved(_counts(rows.codes), table, text, answers=rows.answers.counts)

    def packed(self) -> bytes:
        """Bytes from which ``unpacked`` makes the same work in any process with the same Backsolve."""
        return pickle.dumps(self, protocol=5)


def unpacked(data: bytes) -> Work:
    work = pickle.loads(data)
    assert isinstance(work, Work)
    for file in work.model.python:
        run_python(file)
    return work


class Solver:
    """Solves pieces of one sweep, each from the same state: what it solved before leaves no trace."""

    def __init__(self, work: Work) -> None:
        self.work = work
        self._inputs = [work.model.variables[name] for name in work.inputs]
        asked = refusals(work.lessons, self._inputs) == 0 if work.lessons else ()
        pattern = Pattern(work.model, work.inputs, work.want, work.given, work.guesses, work.jit)
        with work.limit():
            self._plans = SteadyPlans(pattern, [column[asked] for column in work.lessons])

    def __call__(self, columns: Sequence[Array]) -> Solved:
        """Rows whose inputs are missing or out of range get their status, and only the others are solved.

        Raises Interrupted with the rows before the one that an interrupt met, solved.
        """
        try:
            with self.work.limit():
                found = solved_answers(self._plans, columns, refusals(columns, self._inputs))
        except Interrupted as reached:
            count, (codes, answers) = reached.rows, reached.kept
            inputs = [column[:count] for column in columns]
            kept = (self._solved(inputs, codes[:count], answers.first(count)),)
            raise Interrupted(count, kept) from None
        return self._solved(columns, *found)

    def _solved(self, columns: Sequence[Array], codes: Array, answers: Answers) -> Solved:
        several = int((answers.counts > 1).sum())
        if self.work.every:
            inputs = dict(zip(self.work.inputs, columns, strict=True))
            number = self.work.names[len(self.work.inputs)]
            table = every_answer(inputs, self.work.want, codes, answers, number)
            parts = self.work.columns(table)
            return Solved(_counts(codes), parts, answers=table.answers)
        starts = np.cumsum(answers.counts) - answers.counts
        rows = Rows(tuple(columns), codes, answers)
        solved = self.work.solved(rows, np.where(answers.counts > 0, starts, -1))
        return replace(solved, rows=rows if several else rows.last(), several=several)


_WORDS = tuple(map(str, Status))


def _counts(codes: Array) -> tuple[int, ...]:
    if not codes.any():  # most pieces: nothing to be told apart
        return (len(codes), *[0] * (len(_WORDS) - 1))
    return tuple(np.bincount(codes, minlength=len(_WORDS)).tolist())
