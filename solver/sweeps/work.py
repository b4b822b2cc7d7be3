"""One piece of a sweep solved: the unit of work of this process, of its helpers and of a cluster alike."""

from __future__ import annotations

import pickle
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from time import time
from typing import TYPE_CHECKING

import numpy as np

from rulesheets.deadline import time_limit
from rulesheets.model import Model, Value
from solver.files.columns import Array, Columns, free_name
from solver.files.csv_table import csv_rows
from solver.result import Status
from solver.sweeps.answers import every_answer, one_answer
from solver.sweeps.refusals import refusals
from solver.sweeps.ways import Pattern, SteadyPlans
from solver.table import Table

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True)
class Solved:
    """A piece of the table in the order of its rows. ``table`` or ``text`` is there as the work asks.

    ``counts`` are the rows by status code; of the answers of one row the first counts.
    """

    counts: tuple[int, ...]
    table: Columns | None = None
    text: bytes | None = None


@dataclass(frozen=True)
class Work:
    """What has to be known to solve any piece of a sweep.

    ``lessons`` are rows (a column an input) from which compiled ways are learned beforehand. ``every``
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
            return own
        return (*self.inputs, free_name("answer", own), *own[len(self.inputs) :])

    def packed(self) -> bytes:
        """Bytes from which ``unpacked`` makes the same work in any process with the same Backsolve."""
        return pickle.dumps(self, protocol=5)


def unpacked(data: bytes) -> Work:
    work = pickle.loads(data)
    assert isinstance(work, Work)
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
        """Rows whose inputs are missing or out of range get their status, and only the others are solved."""
        table = self.table(columns)
        solved = not table.status.any()  # then inputs and answers are all there
        parts = Columns({name: table[name] for name in self.work.names}, table.status, _WORDS, solved)
        counts = _counts(self._first_answers(table))
        text = csv_rows(parts) if self.work.texted else None
        return Solved(counts, parts if self.work.tabled else None, text)

    def table(self, columns: Sequence[Array]) -> Table:
        """The rows as arrays."""
        refused = refusals(columns, self._inputs)
        answers = every_answer if self.work.every else one_answer
        with self.work.limit():
            return answers(self._plans, columns, refused, self.work.names)

    def _first_answers(self, table: Table) -> NDArray[np.int8]:
        if not self.work.every:
            return table.status
        first: NDArray[np.int8] = table.status[table[self.work.names[len(self.work.inputs)]] < 2]
        return first


_WORDS = tuple(map(str, Status))


def _counts(codes: NDArray[np.int8]) -> tuple[int, ...]:
    if not codes.any():  # most pieces: nothing to be told apart
        return (len(codes), *[0] * (len(_WORDS) - 1))
    return tuple(np.bincount(codes, minlength=len(_WORDS)).tolist())
