"""The answers of rows as a table: the primary one of each, or every one, one below the other."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from solver.files.columns import Array
from solver.interruption import Interrupted
from solver.result import CODES, Table
from solver.sweeps.steady import SteadyPlan, SteadyPlans
from solver.trace.rows import Answers, together, written


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
