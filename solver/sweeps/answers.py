"""The answers of rows as a table: the primary one of each, or every one, one below the other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rulesheets.model import Value
from solver.files.columns import Array, objects
from solver.sweeps.ways import Answers, SteadyPlans
from solver.table import CODES, Table


def one_answer(
    plans: SteadyPlans, columns: Sequence[Array], refused: NDArray[np.int8], names: Sequence[str]
) -> Table:
    """A row for each row of inputs. ``refused`` (n,) has the status code of a row that is not asked, or 0."""
    groups = plans.groups(_asked(columns, refused))
    inputs, wanted = dict(zip(names, columns, strict=False)), names[len(columns) :]
    if len(groups) == 1 and not refused.any():
        plan, _, numbers = groups[0]
        if numbers:
            table = plan.primary(numbers)
            return Table({**inputs, **{name: table[name] for name in wanted}}, table.status)
    status = refused.copy()
    found: dict[str, Array] = {name: np.full(len(status), np.nan) for name in wanted}
    places = np.flatnonzero(refused == 0)
    for plan, rows, numbers in groups:
        here = places[rows]
        table = plan.primary(numbers)
        status[here] = table.status
        for name in wanted:
            if table[name].dtype == object and found[name].dtype != object:
                found[name] = objects(found[name])
            found[name][here] = table[name]
    return Table({**inputs, **found}, status)


def every_answer(
    plans: SteadyPlans, columns: Sequence[Array], refused: NDArray[np.int8], names: Sequence[str]
) -> Table:
    """A row for each answer, numbered 1, 2, … in its column after the inputs, the primary answer first.

    A row of inputs without an answer keeps one row, numbered 0. ``names`` are those of the columns.
    """
    answers: list[Answers] = [(Table.STATUSES[code], []) for code in refused.tolist()]
    for plan, rows, numbers in plans.groups(_asked(columns, refused)):
        found = plan.every(numbers)
        for number, place in enumerate(np.flatnonzero(refused == 0)[rows].tolist()):
            answers[place] = found[number if numbers else 0]
    counts = [len(values) for _, values in answers]
    sources = np.repeat(np.arange(len(answers)), np.maximum(np.array(counts, dtype=int), 1))
    wanted = plans.want
    nothing: list[tuple[Value | None, ...]] = [(None,) * len(wanted)]
    values = [row or nothing for _, row in answers]
    table: dict[str, NDArray[Any]] = {n: c[sources] for n, c in zip(names, columns, strict=False)}
    numbered = [number for count in counts for number in (range(1, count + 1) if count else (0,))]
    table[names[len(columns)]] = np.array(numbered, dtype=np.int32)
    for place, name in enumerate(wanted):
        table.setdefault(name, _column([answer[place] for row in values for answer in row]))
    codes = np.array([CODES[status] for status, _ in answers], dtype=np.int8)
    return Table(table, codes[sources])


def _asked(columns: Sequence[Array], refused: NDArray[np.int8]) -> Sequence[Array]:
    if not refused.any():
        return columns
    return [column[refused == 0] for column in columns]


def _column(values: Sequence[Value | None]) -> NDArray[Any]:
    if any(isinstance(value, str) for value in values):
        return np.array(values, dtype=object)
    return np.array([np.nan if value is None else value for value in values], dtype=float)
