"""The rows of a sweep: compiled ways for those that decide alike, the step-by-step way for the rest."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.model import Value
from rulesheets.spelling import plural
from solver.column import column_of
from solver.compiled.answer_rows import Answers, AnswerSweeper
from solver.compiled.rows import Sweeper
from solver.result import Status
from solver.table import CODES, Column, Table

if TYPE_CHECKING:
    from solver.compiled.program import Program
    from solver.plan import Plan

Array: TypeAlias = NDArray[Any]


def sweep_rows(plan: Plan, sweeper: Sweeper, columns: Sequence[Column]) -> Table:
    """Solve every row of the columns (n,), which stand in the order of the plan's inputs.

    Raises ValueError for columns of different lengths.
    """
    arrays = _columns(plan.inputs, columns)
    count = len(arrays[0]) if arrays else 1
    status = np.zeros(count, dtype=np.int8)
    if arrays and all(array.dtype == float for array in arrays):
        answers = _numbers(plan, sweeper, arrays, status)
    else:
        answers = _one_by_one(plan, arrays, status)
    table = dict(zip(plan.inputs, arrays, strict=True))
    table.update(zip(plan.want, answers, strict=True))
    return Table(table, status)


def sweep_answers(
    plan: Plan, sweeper: AnswerSweeper, columns: Sequence[Column]
) -> tuple[NDArray[np.int8], Answers]:
    """The status codes (n,) of every row of numbers, and all their answers; there are one or more columns."""
    arrays = _columns(plan.inputs, columns)
    status = np.zeros(len(arrays[0]), dtype=np.int8)

    def outcome(row: int) -> tuple[Status, list[tuple[Value, ...]]]:
        return plan.outcome(tuple(float(column[row]) for column in arrays))

    def keep(rows: Array, outcome: Status) -> None:
        status[rows] = CODES[outcome]

    return status, sweeper.run(arrays, len(plan.want), outcome, keep)


def _columns(names: Sequence[str], columns: Sequence[Column]) -> list[Array]:
    if len(columns) != len(names):
        raise TypeError(f"this plan is prepared for {plural(len(names), 'column')}, not for {len(columns)}")
    arrays = [column_of(column, name) for name, column in zip(names, columns, strict=True)]
    if len({len(array) for array in arrays}) > 1:
        lengths = ", ".join(f"{n}: {len(a)}" for n, a in zip(names, arrays, strict=True))
        raise ValueError(f"the columns of a sweep must have one length ({lengths}); or use grid=True")
    return arrays


def _numbers(plan: Plan, sweeper: Sweeper, columns: list[Array], status: Array) -> list[Array]:
    """Rows of numbers: by compiled ways first."""

    def solve(row: int) -> tuple[Status, tuple[Value, ...], Program | None]:
        numbers = tuple(float(column[row]) for column in columns)
        verdict, found = plan.judged(numbers)
        values: tuple[Value, ...] = ()
        if verdict.status is Status.SOLVED:
            values = tuple(verdict.leaves[0].branch.values[name] for name in plan.want)
        return verdict.status, values, plan.learn(numbers, verdict, found)

    def keep(rows: Array, outcome: Status) -> None:
        status[rows] = CODES[outcome]

    return sweeper.run(columns, len(plan.want), solve, keep)


def _one_by_one(plan: Plan, columns: list[Array], status: Array) -> list[Array]:
    found: list[list[Value | None]] = [[None] * len(status) for _ in plan.want]
    for row, numbers in enumerate(_rows(columns)):
        verdict, _ = plan.judged(numbers)
        status[row] = CODES[verdict.status]
        if verdict.status is Status.SOLVED:
            for column, name in zip(found, plan.want, strict=True):
                column[row] = verdict.leaves[0].branch.values[name]
    return [_column(values) for values in found]


def _rows(columns: list[Array]) -> Iterator[tuple[Value, ...]]:
    if not columns:
        yield ()
    for row in zip(*columns, strict=True):
        yield tuple(v if isinstance(v, str) else np.nan if v is None else float(v) for v in row)


def _column(values: Sequence[Value | None]) -> Array:
    if any(isinstance(value, str) for value in values):
        return np.array(values, dtype=object)
    return np.array([np.nan if value is None else value for value in values], dtype=float)
