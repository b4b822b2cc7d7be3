"""The rows of a sweep: records for those that decide alike, full solves for the rest."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.model import Model, Value
from rulesheets.spelling import plural
from solver.column import column_of
from solver.files.columns import free_name
from solver.interruption import WATCH, Interrupted
from solver.path.planner import planner
from solver.ranking.branches import kept, points_of
from solver.result import CODES, Column, Status, Table
from solver.trace.answer_rows import Answers, written

if TYPE_CHECKING:
    from solver.plan import Plan

Array: TypeAlias = NDArray[Any]


def sweep_answers(plan: Plan, columns: Sequence[Column], jit: bool) -> tuple[NDArray[np.int8], Answers]:
    """The status codes (n,) of every row, and all its wanted values, the primary answer first.

    The columns (n,) stand in the order of the plan's inputs; without any there is one row. Raises ValueError
    for columns of different lengths.
    """
    arrays = _columns(plan.inputs, columns)
    if not arrays or any(array.dtype != float for array in arrays):
        return _one_by_one(plan, arrays)
    return _numbers(plan, arrays, jit)


def sweep_rows(plan: Plan, columns: Sequence[Column], jit: bool) -> Table:
    """The primary answer of every row: the one that continues a branch, else the one that the rule says."""
    arrays = _columns(plan.inputs, columns)
    status, answers = sweep_answers(plan, arrays, jit)
    inputs = dict(zip(plan.inputs, arrays, strict=True))
    return one_answer(
        inputs, plan.want, status, answers, first_answers(plan.model, plan.want, arrays, answers)
    )


def one_answer(
    inputs: Mapping[str, Array], want: Sequence[str], status: Array, answers: Answers, first: Array
) -> Table:
    """A row for each row of inputs, with the answers at the places ``first`` (n,), -1 for none."""
    found = {name: _picked(values, first) for name, values in zip(want, answers.values, strict=True)}
    columns = {**inputs, **{name: values for name, values in found.items() if name not in inputs}}
    columns[free_name("answers", columns)] = answers.counts
    return Table(columns, status, answers=answers.counts)


def first_answers(
    model: Model,
    want: Sequence[str],
    columns: Sequence[Array],
    answers: Answers,
    place: tuple[int, int, int] | None = None,
) -> Array:
    """The places (n,) of the primary answers of all rows among all answers, -1 where there is none.

    ``place``: rows come in lines of so many, the first one is this row of the sweep, and the first answers of
    so many rows are known to be the primary ones.
    """
    counts = answers.counts
    places = np.where(counts > 0, np.cumsum(counts) - counts, -1)
    if columns and (counts > 1).any():
        points = points_of(answers.values, int(counts.sum()))
        turn = planner(model).graph.turn
        turns = np.array([turn(name) or np.inf for name in want])
        places += kept(columns, counts, points, turns, *(place or (len(counts), 0, 0)))
    return places


def _picked(values: Array, places: Array) -> Array:
    if not (places < 0).any():
        return values if len(values) == len(places) else values[places]
    nothing = None if values.dtype == object else np.nan
    column = np.full(len(places), nothing, dtype=values.dtype)
    column[places >= 0] = values[places[places >= 0]]
    return column


def _columns(names: Sequence[str], columns: Sequence[Column]) -> list[Array]:
    if len(columns) != len(names):
        raise TypeError(f"this plan is prepared for {plural(len(names), 'column')}, not for {len(columns)}")
    arrays = [column_of(column, name) for name, column in zip(names, columns, strict=True)]
    if len({len(array) for array in arrays}) > 1:
        lengths = ", ".join(f"{n}: {len(a)}" for n, a in zip(names, arrays, strict=True))
        raise ValueError(f"the columns of a sweep must have one length ({lengths}); or use grid=True")
    return arrays


def _numbers(plan: Plan, columns: list[Array], jit: bool) -> tuple[NDArray[np.int8], Answers]:
    """Rows of numbers: by records first. Raises Interrupted with the same for an interrupt at a row."""
    status = np.zeros(len(columns[0]), dtype=np.int8)

    def outcome(row: int) -> tuple[Status, list[tuple[Value, ...]]]:
        watch = WATCH.get()
        if watch is not None:
            watch(row)
        return plan.outcome(tuple(float(column[row]) for column in columns))

    def keep(rows: Array, outcome: Status) -> None:
        status[rows] = CODES[outcome]

    try:
        found = plan.sweeper(jit).run(columns, len(plan.want), outcome, keep)
    except Interrupted as reached:
        raise Interrupted(reached.rows, (status, reached.kept)) from None
    return status, found


def _one_by_one(plan: Plan, columns: list[Array]) -> tuple[NDArray[np.int8], Answers]:
    found = [plan.outcome(numbers) for numbers in _rows(columns)]
    status = np.array([CODES[status] for status, _ in found], dtype=np.int8)
    counts = np.array([len(rows) for _, rows in found], dtype=np.int64)
    return status, Answers(counts, written([row for _, rows in found for row in rows], len(plan.want)))


def _rows(columns: list[Array]) -> Iterator[tuple[Value, ...]]:
    if not columns:
        yield ()
    for row in zip(*columns, strict=True):
        yield tuple(v if isinstance(v, str) else np.nan if v is None else float(v) for v in row)
