"""Every answer of every row, one below the other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rulesheets.model import Value
from solver.files.columns import Array
from solver.plan import Plan
from solver.result import Status
from solver.table import CODES, Table


def every_answer(
    plan: Plan, columns: Sequence[Array], refused: NDArray[np.int8], names: Sequence[str]
) -> Table:
    """A row for each answer, numbered 1, 2, … in its column after the inputs, the primary answer first.

    A row of inputs without an answer keeps one row, numbered 0. ``names`` are those of the columns.
    """
    given = [column.tolist() for column in columns]
    sources: list[int] = []
    numbers: list[int] = []
    answers: list[tuple[Value | None, ...]] = []
    status: list[int] = []
    nothing = (None,) * len(plan.want)
    for row, code in enumerate(refused.tolist()):
        found: list[tuple[Value, ...]] = []
        if code == 0:
            verdict, _ = plan.judged(tuple(values[row] for values in given))
            code = CODES[verdict.status]
            if verdict.status is Status.SOLVED:
                values = (leaf.branch.values for leaf in verdict.leaves)
                found = list(dict.fromkeys(tuple(v[n] for n in plan.want) for v in values))
        numbers.extend(range(1, len(found) + 1) if found else (0,))
        answers.extend(found or (nothing,))
        sources.extend([row] * (len(found) or 1))
        status.extend([code] * (len(found) or 1))
    table: dict[str, NDArray[Any]] = {n: c[sources] for n, c in zip(plan.inputs, columns, strict=True)}
    table[names[len(columns)]] = np.array(numbers, dtype=np.int32)
    for place, name in enumerate(plan.want):
        table.setdefault(name, _column([answer[place] for answer in answers]))
    return Table(table, np.array(status, dtype=np.int8))


def _column(values: Sequence[Value | None]) -> NDArray[Any]:
    if any(isinstance(value, str) for value in values):
        return np.array(values, dtype=object)
    return np.array([np.nan if value is None else value for value in values], dtype=float)
