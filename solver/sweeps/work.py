"""One piece of a sweep solved: the unit of work of this process, of its helpers and of a cluster alike."""

from __future__ import annotations

import pickle
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from time import time

import numpy as np
from numpy.typing import NDArray

from rulesheets.deadline import time_limit
from rulesheets.functions.registered import run_python
from rulesheets.model import Model, Value, Variable
from solver.facts import Status
from solver.files.columns import Array, Columns, csv_rows, free_name
from solver.interruption import Interrupted
from solver.plan import Plan, one_answer
from solver.result import CODES, Table
from solver.trace.rows import Answers, together, written


def refusals(columns: Sequence[Array], inputs: Sequence[Variable]) -> NDArray[np.int8]:
    """The status code of each row (n,), 0 where it can be asked.

    A row that lacks an input (blank, NaN, infinite) is ``partial``, one with an input outside the
    declared range ``infeasible``: no solution lies in the range.
    """
    codes = np.zeros(len(columns[0]) if columns else 1, dtype=np.int8)
    lacking = np.zeros(len(codes), dtype=bool)
    for column, variable in zip(columns, inputs, strict=True):
        numbers = _numbers(column)
        lacking |= ~np.isfinite(numbers) & ~_symbols(column)
        codes[_outside(numbers, variable)] = CODES[Status.INFEASIBLE]
    codes[lacking] = CODES[Status.PARTIAL]
    return codes


def _numbers(column: Array) -> Array:
    """The column as floats, NaN for nothing."""
    if column.dtype != object:
        return column
    return np.array([np.nan if v is None or isinstance(v, str) else v for v in column.tolist()])


def _symbols(column: Array) -> NDArray[np.bool_]:
    if column.dtype != object:
        return np.zeros(len(column), dtype=bool)
    return np.array([isinstance(value, str) for value in column.tolist()], dtype=bool)


def _outside(numbers: Array, variable: Variable) -> NDArray[np.bool_]:
    """A symbol lies outside of no range, nor does what is missing."""
    below = numbers <= variable.low if variable.low_open else numbers < variable.low
    above = numbers >= variable.high if variable.high_open else numbers > variable.high
    return np.asarray(below | above)


@dataclass(frozen=True)
class Pattern:
    """What is the same for all rows of a plan: its inputs and outputs, and the inputs that are fixed.

    With ``jit`` its records are compiled to machine code.
    """

    model: Model
    inputs: tuple[str, ...]
    want: tuple[str, ...]
    given: Mapping[str, Value]
    guesses: Mapping[str, float]
    jit: bool = False


class SteadyPlan:
    """Solves pieces of one pattern, every one by the same records."""

    def __init__(self, pattern: Pattern, lessons: Sequence[Array]) -> None:
        self._plan = Plan(pattern.model, pattern.inputs, pattern.want, pattern.given, pattern.guesses)
        self._jit = pattern.jit
        if lessons and len(lessons[0]):
            self._plan.sweep(*lessons, jit=pattern.jit)
        self._known = self._plan.records.mark()

    def _forget(self) -> None:
        """Go back to what the lessons taught."""
        self._plan.records.forget(self._known)

    def every(self, columns: Sequence[Array]) -> tuple[NDArray[np.int8], Answers]:
        """The status codes of the rows and all their answers, for one or more columns (n,) of numbers."""
        self._forget()
        return self._plan.sweep_all(*columns, jit=self._jit)

    def alone(self) -> tuple[Status, list[tuple[Value, ...]]]:
        """The status of the one row of a plan without inputs, and its answers, the primary first."""
        self._forget()
        return self._plan.outcome(())


class SteadyPlans:
    """Plans by the symbols of a row: a symbol that is swept is fixed in a plan of its own."""

    def __init__(self, pattern: Pattern, lessons: Sequence[Array]) -> None:
        self._pattern = pattern
        self._lessons = tuple(lessons) or tuple(np.zeros(0) for _ in pattern.inputs)
        self._plans: dict[tuple[str | None, ...], SteadyPlan] = {}

    @property
    def want(self) -> tuple[str, ...]:
        return self._pattern.want

    def groups(self, columns: Sequence[Array]) -> list[tuple[SteadyPlan, NDArray[np.intp], list[Array]]]:
        """The rows by their plans: which they are, and their columns of numbers."""
        symbols = _pattern_of_rows(columns)
        if symbols is None:
            everything = np.arange(len(columns[0]) if columns else 1)
            return [(self._plan((None,) * len(columns)), everything, list(columns))]
        rows: dict[tuple[str | None, ...], list[int]] = {}
        for row, key in enumerate(symbols):
            rows.setdefault(key, []).append(row)
        return [
            (self._plan(k), np.array(found), _numbers_of_rows(columns, k, found)) for k, found in rows.items()
        ]

    def _plan(self, key: tuple[str | None, ...]) -> SteadyPlan:
        if key not in self._plans:
            symbols = _pattern_of_rows(self._lessons)
            if symbols is None:
                symbols = [(None,) * len(key)] * len(self._lessons[0])
            lessons = _numbers_of_rows(
                self._lessons, key, [row for row, other in enumerate(symbols) if other == key]
            )
            fixed = {n: s for n, s in zip(self._pattern.inputs, key, strict=True) if s is not None}
            names = tuple(name for name in self._pattern.inputs if name not in fixed)
            given = {**self._pattern.given, **fixed}
            self._plans[key] = SteadyPlan(replace(self._pattern, inputs=names, given=given), lessons)
        return self._plans[key]


def _pattern_of_rows(columns: Sequence[Array]) -> list[tuple[str | None, ...]] | None:
    """The symbols of each row, None at the place of a number; None where no column has any."""
    if all(column.dtype != object for column in columns):
        return None
    kinds = [
        [value if isinstance(value, str) else None for value in column.tolist()]
        if column.dtype == object
        else [None] * len(column)
        for column in columns
    ]
    return list(zip(*kinds, strict=True))


def _numbers_of_rows(columns: Sequence[Array], key: tuple[str | None, ...], rows: list[int]) -> list[Array]:
    return [column[rows].astype(float) for column, symbol in zip(columns, key, strict=True) if symbol is None]


def solved_answers(
    plans: SteadyPlans, columns: Sequence[Array], refused: NDArray[np.int8]
) -> tuple[NDArray[np.int8], Answers]:
    """The status codes (n,) of rows, and all their answers, the primary ones of each row first.

    ``refused`` (n,) has the status code of a row that is not asked, or 0. Raises Interrupted with the same
    for an interrupt while a row is solved.
    """
    codes = refused.copy()
    asked = np.flatnonzero(refused == 0)
    parts: list[tuple[Array, Answers]] = []
    left = refused == 0
    for plan, rows, numbers in plans.groups(_asked(columns, refused)):
        places = asked[rows]
        done = len(places)
        try:
            status, answers = plan.every(numbers) if numbers else _alike(plan, done, len(plans.want))
        except Interrupted as reached:
            done, (status, answers) = reached.rows, reached.kept
        codes[places] = status
        left[places[:done]] = False
        parts.append((places, answers))
        if done < len(places):
            break
    found = codes, together(parts, len(codes), len(plans.want))
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
    for name, values in zip(want, answers.values, strict=True):
        table.setdefault(name, values if some.all() else _spread(values, ranks > 0))
    return Table(table, np.repeat(codes, each), answers=np.repeat(answers.counts, each))


def _alike(plan: SteadyPlan, count: int, wanted: int) -> tuple[Array, Answers]:
    """So many rows that have no numbers to tell them apart."""
    status, answers = plan.alone()
    columns = [np.tile(column, count) for column in written(answers, wanted)]
    return np.full(count, CODES[status], dtype=np.int8), Answers(np.full(count, len(answers)), columns)


def _spread(values: Array, there: NDArray[np.bool_]) -> Array:
    """A column with gaps where there is no answer."""
    symbols = values.dtype == object
    column: Array = np.full(len(there), None if symbols else np.nan, dtype=object if symbols else float)
    column[there] = values
    return column


def _asked(columns: Sequence[Array], refused: NDArray[np.int8]) -> Sequence[Array]:
    if not refused.any():
        return columns
    return [column[refused == 0] for column in columns]


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
