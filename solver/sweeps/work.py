"""One piece of a sweep solved, here, by helpers or on a cluster alike, and branches kept between pieces."""

from __future__ import annotations

import pickle
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from time import time
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.deadline import Interrupted, time_limit
from rulesheets.model import Model, Value, Variable
from rulesheets.registered import run_python
from solver.facts import Status
from solver.files.tables import CODES, WORDS, Array, Table, free_name, stacked
from solver.ranking.branches import ROOM, Answers, Points, distances, kept, numbers_of, together, wound
from solver.sweeps import Plan, one_answer, sweep_answers
from solver.trace.rows import listed


def refusals(columns: Sequence[Array], inputs: Sequence[Variable]) -> NDArray[np.int8]:
    """The status code of each row (n,), 0 where it can be asked.

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


Key: TypeAlias = tuple[str | None, ...]
"""The symbols of a row, None at the place of a number."""


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
    """

    counts: tuple[int, ...]
    table: Table
    rows: Rows | None = None
    several: int = 0


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

    @property
    def names(self) -> tuple[str, ...]:
        """The columns of the table, the status not among them."""
        own = (*self.inputs, *(name for name in self.want if name not in self.inputs))
        if not self.every:
            return (*own, free_name("answers", own))
        return (*self.inputs, free_name("answer", own), *own[len(self.inputs) :])

    def solved(self, rows: Rows, first: Array) -> Solved:
        """Rows with their primary answers, the ``first`` (n,) of each that has some."""
        inputs = dict(zip(self.inputs, rows.inputs, strict=True))
        table = one_answer(inputs, self.want, rows.codes, rows.answers, first)
        return Solved(_counts(rows.codes), table)

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
    """Solves pieces of one sweep, each from the same state: what it solved before leaves no trace.

    A symbol that is swept is fixed in a plan of its own. Of the lessons of the work records are made
    beforehand, and a plan goes back to these before every piece.
    """

    def __init__(self, work: Work) -> None:
        self.work = work
        self._inputs = [work.model.variables[name] for name in work.inputs]
        asked = refusals(work.lessons, self._inputs) == 0 if work.lessons else ()
        self._lessons = [column[asked] for column in work.lessons]
        self._plans: dict[Key, tuple[Plan, Any]] = {}

    def __call__(self, columns: Sequence[Array]) -> Solved:
        """Rows whose inputs are missing or out of range get their status, and only the others are solved.

        Raises Interrupted with the rows before the one that an interrupt met, solved.
        """
        work, codes = self.work, refusals(columns, self._inputs)
        asked, left = np.flatnonzero(codes == 0), codes == 0
        steady = not work.every and work.line > 1  # a branch is kept: not every row has to be sorted
        parts: list[tuple[Array, Answers]] = []
        with time_limit(None if work.until is None else max(work.until - time(), 1e-9)):
            for key, rows in _by_symbols([column[asked] for column in columns]).items():
                places, plan = asked[rows], self._plan(key)
                done, numbers = len(places), _numbers(columns, key, places)
                try:
                    if numbers:
                        status, answers = sweep_answers(plan, numbers, work.jit, steady)
                    else:  # nothing tells the rows apart
                        one, found = plan.outcome(())
                        status, answers = np.full(done, CODES[one], dtype=np.int8), listed([found] * done)
                except Interrupted as reached:
                    done, (status, answers) = reached.rows, reached.kept
                codes[places] = status
                left[places[:done]] = False
                parts.append((places, answers))
                if done < len(places):
                    break
        every = together(parts, len(codes))
        if not left.any():
            return self._solved(columns, codes, every)
        count = int(np.argmax(left))
        inputs = [column[:count] for column in columns]
        raise Interrupted(count, (self._solved(inputs, codes[:count], every.cut(0, count)),))

    def _plan(self, key: Key) -> Plan:
        if key not in self._plans:
            work = self.work
            fixed = {n: s for n, s in zip(work.inputs, key, strict=True) if s is not None}
            names = tuple(name for name in work.inputs if name not in fixed)
            plan = Plan(work.model, names, work.want, {**work.given, **fixed}, work.guesses)
            rows = _by_symbols(self._lessons).get(key, ()) if self._lessons else ()
            if names and len(rows):
                try:
                    plan.sweep(*_numbers(self._lessons, key, rows), jit=work.jit)
                except Interrupted:  # rows to learn from are none of the piece
                    raise Interrupted(0, ()) from None
            self._plans[key] = plan, plan.records.mark()
        plan, known = self._plans[key]
        plan.records.forget(known)
        return plan

    def _solved(self, columns: Sequence[Array], codes: Array, answers: Answers) -> Solved:
        if self.work.every:
            return Solved(_counts(codes), self._every(columns, codes, answers))
        several, rows = int((answers.counts > 1).sum()), Rows(tuple(columns), codes, answers)
        solved = self.work.solved(rows, np.zeros(len(codes), dtype=np.intp))
        return replace(solved, rows=rows if several else rows.last(), several=several)

    def _every(self, columns: Sequence[Array], codes: Array, answers: Answers) -> Table:
        """A row for each answer, numbered 1, 2, …, the primary answer first.

        A row of inputs without an answer keeps one row, numbered 0.
        """
        work = self.work
        some = answers.counts > 0
        each = np.where(some, answers.counts, 1)
        starts = np.cumsum(each) - each
        pairs = zip(work.inputs, columns, strict=True)
        table: dict[str, Array] = {name: np.repeat(column, each) for name, column in pairs}
        ranks = np.arange(1, each.sum() + 1) - np.repeat(starts, each)
        ranks[starts[~some]] = 0
        table[work.names[len(work.inputs)]] = ranks.astype(np.int32)
        values = answers.listed() or [np.full(len(codes), np.nan) for _ in work.want]
        for name, column in zip(work.want, values, strict=True):
            table.setdefault(name, column)
        return Table(table, np.repeat(codes, each), answers=np.repeat(answers.counts, each))


def _counts(codes: Array) -> tuple[int, ...]:
    if not codes.any():  # most pieces: nothing to be told apart
        return (len(codes), *[0] * (len(WORDS) - 1))
    return tuple(np.bincount(codes, minlength=len(WORDS)).tolist())


class Branches:
    """Replaces the answers that the rule put first by those that continue the branch of the row before.

    A row begins anew where the rows of a line are full: where an outer input of a grid changes.
    """

    def __init__(self, work: Work, turns: Points) -> None:
        self.work, self.turns = work, turns
        self._done = 0
        self._before: Rows | None = None

    def __call__(self, piece: Solved) -> Solved:
        assert piece.rows is not None
        last = piece.rows.last()
        if piece.several:
            before, rows = self._before, piece.rows
            extra = 0 if before is None else len(before.codes)
            if before is not None:
                both = zip(before.inputs, rows.inputs, strict=True)
                codes = np.concatenate([before.codes, rows.codes])
                parts = [(np.arange(extra), before.answers), (np.arange(extra, len(codes)), rows.answers)]
                rows = Rows(tuple(map(stacked, both)), codes, together(parts, len(codes)))
            done, line = self._done - extra, self.work.line
            first = kept(rows.inputs, rows.answers, self.turns, line, done, [0] * extra)
            if first.any():
                piece = replace(self.work.solved(piece.rows, first[extra:]), several=piece.several)
            last = rows.last()
            planes = [[column.copy() for column in plane] for plane in last.answers.planes]
            for row, place in enumerate(first[-2:].tolist()):  # the primary answers before the others
                for values in zip(*planes, strict=True):
                    values[0][row], values[place][row] = values[place][row], values[0][row]
            last = last._replace(answers=Answers(last.answers.counts, planes))
        self._before, self._done = last, self._done + sum(piece.counts)
        return piece


class Follower:
    """Renumbers the answers of each row by those of the row before.

    The answers of two neighbouring rows are paired by the least distance between where a branch is
    heading (on a straight line through its last two rows) and where an answer lies. An answer that
    continues no branch takes the smallest number that is free. Numbers start anew at every ``line``
    rows: where an outer input of a grid changes. The order of the answers within a row stays.
    """

    def __init__(self, column: str, wanted: Sequence[str], turns: Mapping[str, float], line: int) -> None:
        self._column, self._wanted, self._line = column, tuple(wanted), line
        self._turns = np.array([turns.get(name, np.inf) for name in wanted])
        self._row, self._in_order = 0, False
        # the branches of the last row: their numbers, where they are (v, k), and their steps to there
        self._labels: list[int] = []
        self._at: Points = np.zeros((len(self._wanted), 0))
        self._steps = self._at

    def __call__(self, piece: Solved) -> Solved:
        """The next piece, renumbered."""
        table = piece.table
        ranks = table[self._column]
        found = [numbers_of(table[name]) for name in self._wanted]
        points = np.array(found).reshape(len(found), len(ranks))  # also where nothing is wanted
        starts = np.flatnonzero(ranks < 2)
        counts = np.where(ranks[starts] == 0, 0, np.diff(starts, append=len(ranks)))
        plain = self._plain_rows(points, starts, counts)
        ends = np.append(np.flatnonzero(~plain), len(counts))
        numbers, row = ranks.copy(), 0
        while row < len(counts):
            end = row + 1
            if plain[row] and self._in_order:
                end = int(ends[np.searchsorted(ends, row)])
                now, before = (points[:, starts[r] : starts[r] + counts[r]] for r in (end - 1, end - 2))
                self._at, self._steps = now, self._apart(now, before)
            else:
                self._one(points[:, starts[row] : starts[row] + counts[row]])
            places = slice(starts[row], starts[row] + len(self._labels) * (end - row))
            numbers[places] = np.tile(self._labels, end - row)
            self._row, row = self._row + end - row, end
        return replace(piece, table=table.having({**table, self._column: numbers}))

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
        """Rows in which each answer is nearer to the one of its place in the row before than to any other.

        Pairing them one by one would come to the same, if the row before them came in the order of the
        one before that; which is so for all rows but a few.
        """
        alike = (np.arange(self._row, self._row + len(counts)) % self._line >= 2) | (counts == 0)
        alike[:2] = False
        alike[2:] &= (counts[2:] == counts[1:-1]) & (counts[2:] == counts[:-2])
        for count in np.unique(counts[alike & (counts > 1)]).tolist():  # a single answer has no rival
            same, places = np.flatnonzero(alike & (counts == count)), np.arange(count)
            for rows in np.array_split(same, 1 + len(same) // ROOM):
                now, before, earlier = (
                    points[:, starts[rows - back] + places[:, None]] for back in (0, 1, 2)
                )
                apart = distances(before + self._apart(before, earlier), now, self._turns)
                own = apart[places, places].copy()
                apart[places, places] = np.inf
                alike[rows] = (own < np.minimum(apart.min(axis=0), apart.min(axis=1))).all(axis=0)
        return np.asarray(alike)

    def _apart(self, there: Points, here: Points) -> Points:
        """The differences of numbers of the variables (v, …), by whole turns as small as they get."""
        return wound(there - here, self._turns.reshape(-1, *(1,) * (there.ndim - 1)))
