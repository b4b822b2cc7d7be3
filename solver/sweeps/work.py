"""One piece of a sweep solved: the unit of work of this process, of its helpers and of a cluster alike."""

from __future__ import annotations

import pickle
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from time import time
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.deadline import time_limit
from rulesheets.model import Model, Value, Variable
from rulesheets.registered import run_python
from solver.facts import Status
from solver.files.columns import Array, Columns, free_name
from solver.interruption import Interrupted
from solver.ranking.branches import Answers, together
from solver.sweeps.plan import Plan, one_answer, sweep_answers
from solver.table import CODES, Table
from solver.trace.rows import listed


def refusals(columns: Sequence[Array], inputs: Sequence[Variable]) -> NDArray[np.int8]:
    """The status code of each row (n,), 0 where it can be asked.

    A row that lacks an input (blank, NaN, infinite) is ``partial``, one with an input outside the
    declared range ``infeasible``: no solution lies in the range.
    """
    codes = np.zeros(len(columns[0]) if columns else 1, dtype=np.int8)
    lacking = np.zeros(len(codes), dtype=bool)
    for column, variable in zip(columns, inputs, strict=True):
        symbols = _symbols(column)
        numbers = np.where(symbols, np.nan, column).astype(float)
        below = numbers <= variable.low if variable.low_open else numbers < variable.low
        above = numbers >= variable.high if variable.high_open else numbers > variable.high
        codes[below | above] = CODES[Status.INFEASIBLE]
        lacking |= ~np.isfinite(numbers) & ~symbols
    codes[lacking] = CODES[Status.PARTIAL]
    return codes


def _symbols(column: Array) -> NDArray[np.bool_]:
    if column.dtype != object:
        return np.zeros(len(column), dtype=bool)
    return np.array([isinstance(value, str) for value in column.tolist()], dtype=bool)


Key: TypeAlias = tuple[str | None, ...]
"""The symbols of a row, None at the place of a number."""


class SteadyPlans:
    """Plans of one work by the symbols of a row: a symbol that is swept is fixed in a plan of its own.

    ``lessons`` (n,) an input are rows of which records are made beforehand. A plan goes back to these before
    every piece: what it solved before leaves no trace.
    """

    def __init__(self, work: Work, lessons: Sequence[Array]) -> None:
        self.work, self._lessons = work, lessons
        self._plans: dict[Key, tuple[Plan, Any]] = {}

    def groups(self, columns: Sequence[Array]) -> Iterator[tuple[Plan, Array, list[Array]]]:
        """The rows by their plans: which they are, and their columns of numbers."""
        for key, rows in _by_symbols(columns).items():
            yield self._plan(key), rows, _numbers(columns, key, rows)

    def _plan(self, key: Key) -> Plan:
        if key not in self._plans:
            work = self.work
            fixed = {n: s for n, s in zip(work.inputs, key, strict=True) if s is not None}
            names = tuple(name for name in work.inputs if name not in fixed)
            plan = Plan(work.model, names, work.want, {**work.given, **fixed}, work.guesses)
            rows = _by_symbols(self._lessons).get(key, ()) if self._lessons else ()
            if names and len(rows):
                plan.sweep(*_numbers(self._lessons, key, rows), jit=work.jit)
            self._plans[key] = plan, plan.records.mark()
        plan, known = self._plans[key]
        plan.records.forget(known)
        return plan


def _by_symbols(columns: Sequence[Array]) -> dict[Key, Array]:
    """The rows (m,) by the symbols that are in them."""
    if all(column.dtype != object for column in columns):
        return {(None,) * len(columns): np.arange(len(columns[0]) if columns else 1)}
    kinds = ([value if isinstance(value, str) else None for value in column.tolist()] for column in columns)
    rows: dict[Key, list[int]] = {}
    for row, key in enumerate(zip(*kinds, strict=True)):
        rows.setdefault(key, []).append(row)
    return {key: np.array(found) for key, found in rows.items()}


def _numbers(columns: Sequence[Array], key: Key, rows: Any) -> list[Array]:
    return [
        c[rows].astype(float, copy=False) for c, symbol in zip(columns, key, strict=True) if symbol is None
    ]


def solved_answers(
    plans: SteadyPlans, columns: Sequence[Array], refused: NDArray[np.int8]
) -> tuple[NDArray[np.int8], Answers]:
    """The status codes (n,) of rows, and all their answers, the primary ones of each row first.

    ``refused`` (n,) has the status code of a row that is not asked, or 0. Raises Interrupted with the same
    for an interrupt while a row is solved.
    """
    codes, work = refused.copy(), plans.work
    asked = np.flatnonzero(refused == 0)
    parts: list[tuple[Array, Answers]] = []
    left = refused == 0
    for plan, rows, numbers in plans.groups([column[asked] for column in columns]):
        places = asked[rows]
        done = len(places)
        try:
            status, answers = (
                sweep_answers(plan, numbers, work.jit, work.steady) if numbers else _alike(plan, done)
            )
        except Interrupted as reached:
            done, (status, answers) = reached.rows, reached.kept
        codes[places] = status
        left[places[:done]] = False
        parts.append((places, answers))
        if done < len(places):
            break
    found = codes, together(parts, len(codes))
    if left.any():
        raise Interrupted(int(np.argmax(left)), found)
    return found


def every_answer(
    inputs: Mapping[str, Array], want: Sequence[str], codes: Array, answers: Answers, number: str
) -> Table:
    """A row for each answer, numbered 1, 2, … in the column ``number``, the primary answer first.

    A row of inputs without an answer keeps one row, numbered 0.
    """
    some = answers.counts > 0
    each = np.where(some, answers.counts, 1)
    starts = np.cumsum(each) - each
    table: dict[str, Array] = {name: np.repeat(column, each) for name, column in inputs.items()}
    ranks = np.arange(1, each.sum() + 1) - np.repeat(starts, each)
    ranks[starts[~some]] = 0
    table[number] = ranks.astype(np.int32)
    values = answers.listed() or [np.full(len(codes), np.nan) for _ in want]
    for name, column in zip(want, values, strict=True):
        table.setdefault(name, column)
    return Table(table, np.repeat(codes, each), answers=np.repeat(answers.counts, each))


def _alike(plan: Plan, count: int) -> tuple[Array, Answers]:
    """So many rows that have no numbers to tell them apart."""
    status, answers = plan.outcome(())
    return np.full(count, CODES[status], dtype=np.int8), listed([answers] * count)


class Rows(NamedTuple):
    """The inputs of rows, their status codes (n,), and all their answers."""

    inputs: tuple[Array, ...]
    codes: Array
    answers: Answers

    def last(self) -> Rows:
        """The last two rows, which a branch goes on from."""
        rows = len(self.codes)
        inputs = tuple(column[-2:] for column in self.inputs)
        return Rows(inputs, self.codes[-2:], self.answers.cut(max(rows - 2, 0), rows))


@dataclass(frozen=True)
class Solved:
    """A piece of the ``table`` in the order of its rows.

    ``counts`` are the rows by status code, ``several`` those that have several answers and show one. ``rows``
    are all of them where there are such, else the last ones: they tell which branch an answer belongs to.
    ``answers`` (rows of the table,) are the numbers of answers that are known.
    """

    counts: tuple[int, ...]
    table: Columns
    rows: Rows | None = None
    several: int = 0
    answers: Array = field(default_factory=lambda: np.zeros(0, dtype=np.int64))


ENDLESS = 2**62
"""Rows of a line without an end."""


class Work(NamedTuple):
    """What has to be known to solve any piece of a sweep.

    ``lessons`` are rows (a column an input) of which records are made beforehand. ``every``
    asks for all answers of a row instead of the primary one, ``jit`` for machine code. The primary
    answer keeps its branch within ``line`` rows. ``until`` is the end of the time by the clock of the system:
    rows that are solved later fail.
    """

    model: Model
    inputs: tuple[str, ...]
    want: tuple[str, ...]
    given: Mapping[str, Value]
    guesses: Mapping[str, float]
    lessons: tuple[Array, ...] = ()
    every: bool = False
    jit: bool = False
    line: int = ENDLESS
    until: float | None = None

    def limit(self) -> AbstractContextManager[None]:
        """What is left of the time."""
        return time_limit(None if self.until is None else max(self.until - time(), 1e-9))

    @property
    def steady(self) -> bool:
        """Whether only a branch of answers has to be kept, and not every row to be sorted."""
        return not self.every and self.line > 1

    @property
    def names(self) -> tuple[str, ...]:
        """The columns of the table, the status not among them."""
        own = (*self.inputs, *(name for name in self.want if name not in self.inputs))
        if not self.every:
            return (*own, free_name("answers", own))
        return (*self.inputs, free_name("answer", own), *own[len(self.inputs) :])

    def columns(self, table: Table) -> Columns:
        """A table in the order of ``names``."""
        return Columns({name: table[name] for name in self.names}, table.status, _WORDS)

    def solved(self, rows: Rows, first: Array) -> Solved:
        """Rows with their primary answers, the ``first`` (n,) of each that has some."""
        inputs = dict(zip(self.inputs, rows.inputs, strict=True))
        parts = self.columns(one_answer(inputs, self.want, rows.codes, rows.answers, first))
        return Solved(_counts(rows.codes), parts, answers=rows.answers.counts)

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
        self._plans = SteadyPlans(work, [column[asked] for column in work.lessons])

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
            kept = (self._solved(inputs, codes[:count], answers.cut(0, count)),)
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
        rows = Rows(tuple(columns), codes, answers)
        solved = self.work.solved(rows, np.zeros(len(codes), dtype=np.intp))
        return replace(solved, rows=rows if several else rows.last(), several=several)


_WORDS = tuple(map(str, Status))


def _counts(codes: Array) -> tuple[int, ...]:
    if not codes.any():  # most pieces: nothing to be told apart
        return (len(codes), *[0] * (len(_WORDS) - 1))
    return tuple(np.bincount(codes, minlength=len(_WORDS)).tolist())
