"""Sweeps: one solve a row, a status for each row, and no row that spoils its neighbours."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.model import Model, Value
from solver.plan import Plan, prepare
from solver.result import Status

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

Column: TypeAlias = "ArrayLike"

CODES = {status: code for code, status in enumerate(Status)}


class Table(Mapping[str, NDArray[Any]]):
    """Columns (n,) by name: the inputs that were swept, then the wanted variables.

    A wanted value is NaN where its row is not solved (None in a column of symbols). ``status``
    (n,) holds codes, 0 for solved; ``Table.STATUSES[code]`` is the status.
    """

    STATUSES = tuple(Status)

    def __init__(self, columns: Mapping[str, NDArray[Any]], status: NDArray[np.int8]) -> None:
        self._columns = dict(columns)
        self.status = status

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    @property
    def solved(self) -> NDArray[np.bool_]:
        """Which rows are solved."""
        return np.asarray(self.status == CODES[Status.SOLVED])


def sweep(
    model: Model,
    inputs: Mapping[str, Column],
    want: Iterable[str] | None = None,
    *,
    grid: bool = False,
    given: Mapping[str, Value | None] | None = None,
    guesses: Mapping[str, float] | None = None,
) -> Table:
    """Solve the model for every row of ``inputs``: arrays of one length, or, with ``grid``, every combination.

    Raises RuleSheetError for unknown names and ValueError for arrays of different lengths.
    """
    plan = prepare(model, inputs, want, given, guesses)
    columns = [np.atleast_1d(np.asarray(column)) for column in inputs.values()]
    if grid:
        columns = [axis.ravel() for axis in np.meshgrid(*columns, indexing="ij")]
    return sweep_plan(plan, columns)


def sweep_plan(plan: Plan, columns: Sequence[Column]) -> Table:
    """The table of a plan over columns (n,) in the order of its inputs."""
    arrays = [np.atleast_1d(np.asarray(column)) for column in columns]
    if len({len(array) for array in arrays}) > 1:
        lengths = ", ".join(f"{n}: {len(a)}" for n, a in zip(plan.inputs, arrays, strict=True))
        raise ValueError(f"the columns of a sweep must have one length ({lengths}); or use grid=True")
    count = len(arrays[0]) if arrays else 1
    answers: dict[str, list[Value | None]] = {name: [None] * count for name in plan.want}
    status = np.zeros(count, dtype=np.int8)
    for row in range(count):
        verdict, _ = plan.judged(tuple(_plain(array[row]) for array in arrays))
        status[row] = CODES[verdict.status]
        if verdict.status is Status.SOLVED:
            for name in plan.want:
                answers[name][row] = verdict.leaves[0].branch.values[name]
    table: dict[str, NDArray[Any]] = dict(zip(plan.inputs, arrays, strict=True))
    table.update((name, _column(values)) for name, values in answers.items())
    return Table(table, status)


def _plain(value: Any) -> Value:
    return str(value) if isinstance(value, str) else float(value)


def _column(values: Sequence[Value | None]) -> NDArray[Any]:
    if any(isinstance(value, str) for value in values):
        return np.array(values, dtype=object)
    return np.array([np.nan if value is None else value for value in values], dtype=float)
