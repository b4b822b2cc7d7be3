"""One piece of a sweep solved, here, by workers or on a cluster alike; branches are kept between
pieces."""

from __future__ import annotations

import pickle
from collections.abc import Mapping, Sequence
from time import time
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rulesheets.deadline import time_limit
from rulesheets.model import Model, Values, Variable
from rulesheets.registered import run_python
from solver.facts import Status
from solver.files.tables import CODES, Array, Table, free_name, stacked
from solver.ranking.branches import (
    ROOM,
    Answers,
    Points,
    distances,
    kept,
    numbers_of,
    together,
    without_turns,
)
from solver.sweeps import Plan, one_answer, sweep_answers, turns_of


def refusals(columns: Sequence[Array], inputs: Sequence[Variable]) -> NDArray[np.int8]:
    """The status code of each row (n,), 0 if it can be solved.

    A row that lacks an input (blank, NaN, infinite) is ``partial``, one with an input outside the
    declared range ``infeasible``: no solution lies in the range.
    """
    codes = np.zeros(len(columns[0]) if columns else 1, dtype=np.int8)
    lacking = np.zeros(len(codes), dtype=bool)
    for column, variable in zip(columns, inputs, strict=True):
        symbols = np.zeros(len(column), dtype=bool)
        if column.dtype == object:
            symbols = np.array([isinstance(value, str) for value in column.tolist()], dtype=bool)
        numbers = np.where(symbols, np.nan, column).astype(float)
        below = numbers <= variable.low if variable.low_open else numbers < variable.low
        above = numbers >= variable.high if variable.high_open else numbers > variable.high
        codes[below | above] = CODES[Status.INFEASIBLE]
        lacking |= ~np.isfinite(numbers) & ~symbols
    codes[lacking] = CODES[Status.PARTIAL]
    return codes


class Rows(NamedTuple):
    """A piece in progress: inputs of rows, their status codes (n,), and all their answers."""

    inputs: tuple[Array, ...]
    codes: Array
    answers: Answers

    def cut(self, start: int, end: int) -> Rows:
        """Some of the rows."""
        inputs = tuple(column[start:end] for column in self.inputs)
        return Rows(inputs, self.codes[start:end], self.answers.cut(start, end))


ENDLESS = 2**62
"""Rows of a line without an end."""


class Work(NamedTuple):
    """Everything needed to solve any piece of a sweep.

    ``warmup`` are rows (a column for each input) that are recorded in advance. ``every`` requests
    all answers of a row instead of the primary one, ``jit`` machine code. The primary answer keeps
    its branch within ``line`` rows. ``until`` is the time limit by the system clock: rows that are
    solved later fail.
    """

    model: Model
    inputs: tuple[str, ...]
    want: tuple[str, ...]
    given: Values
    guesses: Mapping[str, float]
    warmup: tuple[Array, ...] = ()
    every: bool = False
    jit: bool = False
    line: int = ENDLESS
    until: float | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """The columns of the table without the status."""
        wanted = tuple(name for name in self.want if name not in self.inputs)
        if self.answer is None:
            return (*self.inputs, *wanted, free_name("answers", (*self.inputs, *wanted)))
        return (*self.inputs, self.answer, *wanted)

    @property
    def answer(self) -> str | None:
        """The column with the numbers of answers, if each has a row of its own."""
        return free_name("answer", (*self.inputs, *self.want)) if self.every else None

    def packed(self) -> bytes:
        """Bytes from which ``unpacked`` makes the same work in any process with the same
        Backsolve."""
        return pickle.dumps(self, protocol=5)


def unpacked(data: bytes) -> Work:
    work = pickle.loads(data)
    assert isinstance(work, Work)
    for file in work.model.python:
        run_python(file)
    return work


class Solver:
    """Solves pieces of one sweep, each from the same state: earlier pieces have no influence.

    The warm-up rows are recorded in advance; the plan goes back to these records before every
    piece.
    """

    def __init__(self, work: Work) -> None:
        self.work = work
        self._inputs = [work.model.variables[name] for name in work.inputs]
        self._plan = Plan(work.model, work.inputs, work.want, work.given, work.guesses)
        self._known: Any = None

    def __call__(self, columns: Sequence[Array]) -> Rows:
        """Rows whose inputs are missing or out of range get their status, and only the others are
        solved."""
        work, codes = self.work, refusals(columns, self._inputs)
        places = np.flatnonzero(codes == 0)
        # a branch is kept: not every row has to be sorted
        steady = not work.every and work.line > 1
        with time_limit(None if work.until is None else max(work.until - time(), 1e-9)):
            if self._known is not None:
                self._plan.forget(self._known)
            else:  # only the records of the warm-up rows
                warmup = work.warmup
                if warmup and (asked := refusals(warmup, self._inputs) == 0).any():
                    self._plan.sweep(*(column[asked] for column in warmup), jit=work.jit)
                self._known = self._plan.mark()
            here = [column if len(places) == len(column) else column[places] for column in columns]
            codes[places], answers = sweep_answers(self._plan, here, work.jit, steady)
        return Rows(tuple(columns), codes, together([(places, answers)], len(codes)))


class Primary:
    """Pieces as tables with one answer a row: the one that continues the branch of the row before,
    else the first of the ranking.

    A branch begins anew after the rows of a line: where an outer input of a grid changes.
    """

    def __init__(self, work: Work) -> None:
        self.work, self.turns = work, turns_of(work.model, work.want)
        self._done = 0
        self._before: tuple[Rows, list[int]] | None = None

    def __call__(self, rows: Rows) -> Table:
        count, work = len(rows.codes), self.work
        first, here = np.zeros(count, dtype=np.intp), rows
        if (rows.answers.counts > 1).any():
            first, here = self._continued(rows)
        # the last two rows, which a branch continues
        last = here.cut(max(len(here.codes) - 2, 0), len(here.codes))
        self._before, self._done = (last, first[-2:].tolist()), self._done + count
        inputs = dict(zip(work.inputs, rows.inputs, strict=True))
        return one_answer(inputs, work.want, rows.codes, rows.answers, first[-count:])

    def _continued(self, rows: Rows) -> tuple[Array, Rows]:
        """The rows after the last two before them, and the number of the first answer of each."""
        known: list[int] = []
        if self._before is not None:
            before, known = self._before
            extra, count = len(known), len(known) + len(rows.codes)
            parts = [(np.arange(extra), before.answers), (np.arange(extra, count), rows.answers)]
            inputs = tuple(map(stacked, zip(before.inputs, rows.inputs, strict=True)))
            rows = Rows(inputs, np.concatenate([before.codes, rows.codes]), together(parts, count))
        at = self._done - len(known)
        return kept(rows.inputs, rows.answers, self.turns, self.work.line, at, known), rows


class Every:
    """Pieces as tables with a row for each answer, which has a number that stays with its branch.

    A row of inputs without an answer keeps one row, with the number 0.
    """

    def __init__(self, work: Work) -> None:
        self.work = work
        self._number, *self._wanted = work.names[len(work.inputs) :]
        self._follow = Follower(turns_of(work.model, self._wanted), work.line)

    def __call__(self, rows: Rows) -> Table:
        work, counts = self.work, rows.answers.counts
        each = np.maximum(counts, 1)
        pairs = zip(work.inputs, rows.inputs, strict=True)
        table: dict[str, Array] = {name: np.repeat(column, each) for name, column in pairs}
        values = rows.answers.listed() or [np.full(len(each), np.nan) for _ in work.want]
        found = dict(zip(work.want, values, strict=True))
        points = np.array([numbers_of(found[name]) for name in self._wanted])
        table[self._number] = self._follow(points.reshape(len(self._wanted), each.sum()), counts)
        table.update((name, found[name]) for name in self._wanted)
        return Table(table, np.repeat(rows.codes, each), answers=np.repeat(counts, each))


class Follower:
    """Numbers the answers of each row by those of the row before; each variable has a whole
    ``turn``.

    The answers of two neighbouring rows are paired by the least distance between the extrapolation
    of a branch (a straight line through its last two rows) and an answer. An answer that continues
    no branch takes the smallest free number. Numbers start anew at every ``line`` rows: where an
    outer input of a grid changes. The order of the answers within a row stays.
    """

    def __init__(self, turns: Array, line: int) -> None:
        self._turns, self._line = turns, line
        self._row, self._in_order = 0, False
        # the branches of the last row: their numbers, where they are (v, k), and their steps to
        # there
        self._labels: list[int] = []
        self._at: Points = np.zeros((len(turns), 0))
        self._steps = self._at

    def __call__(self, points: Points, counts: Array) -> NDArray[np.int32]:
        """The numbers of the answers (v, m) of the next rows, so many each; 0 for a row without
        one."""
        each = np.maximum(counts, 1)
        starts = np.cumsum(each) - each
        plain = self._plain_rows(points, starts, counts)
        ends = np.append(np.flatnonzero(~plain), len(counts))
        numbers, row = np.zeros(points.shape[1], dtype=np.int32), 0
        while row < len(counts):
            end = row + 1
            if plain[row] and self._in_order:
                end = int(ends[np.searchsorted(ends, row)])
                now, before = (
                    points[:, starts[r] : starts[r] + counts[r]] for r in (end - 1, end - 2)
                )
                self._at, self._steps = now, self._apart(now, before)
            else:
                self._one(points[:, starts[row] : starts[row] + counts[row]])
            places = slice(starts[row], starts[row] + len(self._labels) * (end - row))
            numbers[places] = np.tile(self._labels, end - row)
            self._row, row = self._row + end - row, end
        return numbers

    def _one(self, found: Points) -> None:
        """Number the answers (v, j) of one row by the row before."""
        if self._row % self._line == 0:
            self._labels = []
        count, before = found.shape[1], self._labels
        labels: dict[int, int] = {}
        steps: Points = np.zeros(found.shape)
        heading = (self._at + self._steps)[..., None]
        apart = distances(heading, found[..., None], self._turns) if before and count else None
        for flat in [] if apart is None else np.argsort(apart, axis=None, kind="stable").tolist():
            branch, place = divmod(flat, count)
            if place not in labels and before[branch] not in labels.values():
                labels[place] = before[branch]
                steps[:, place] = self._apart(found[:, [place]], self._at[:, [branch]])[:, 0]
        free = (n for n in range(1, 2 * count + 1) if n not in labels.values())
        self._labels = [labels[place] if place in labels else next(free) for place in range(count)]
        self._in_order = self._labels == before
        self._at, self._steps = found, steps

    def _plain_rows(self, points: Points, starts: Array, counts: Array) -> NDArray[np.bool_]:
        """Rows in which each answer is nearer to the one at its place in the row before than to any
        other.

        Pairing them one by one would give the same, if the row before them is in the order of the
        one before that; which is so for all rows but a few.
        """
        alike = (np.arange(self._row, self._row + len(counts)) % self._line >= 2) | (counts == 0)
        alike[:2] = False
        alike[2:] &= (counts[2:] == counts[1:-1]) & (counts[2:] == counts[:-2])
        several = alike & (counts > 1)  # a single answer has no rival
        for count in np.unique(counts[several]).tolist():
            same, places = np.flatnonzero(alike & (counts == count)), np.arange(count)
            for rows in np.array_split(same, 1 + len(same) // ROOM):
                every = (starts[rows - back] + places[:, None] for back in (0, 1, 2))
                now, before, earlier = (points[:, there] for there in every)
                apart = distances(before + self._apart(before, earlier), now, self._turns)
                own = apart[places, places].copy()
                apart[places, places] = np.inf
                alike[rows] = (own < np.minimum(apart.min(axis=0), apart.min(axis=1))).all(axis=0)
        return np.asarray(alike)

    def _apart(self, there: Points, here: Points) -> Points:
        """The differences of the variables (v, …), reduced by whole turns."""
        return without_turns(there - here, self._turns.reshape(-1, *(1,) * (there.ndim - 1)))
