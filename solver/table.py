"""A table of solves: columns of inputs and answers, and a status for every row."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rulesheets.model import Value
from solver.files.columns import Columns
from solver.result import Status

Column: TypeAlias = ArrayLike

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

    def write(self, path: str) -> None:
        """Write a file by its ending, ``.csv`` or ``.parquet`` (with the extra ``parquet``).

        It is written as a whole or not at all. Numbers read back as the same floats, the status is a
        text, and where a row has no value there is nothing. Raises RuleSheetError: E416, E441, E442.
        """
        from solver.files.tables import write_table

        write_table(path, Columns(self._columns, self.status, tuple(map(str, self.STATUSES))))


def rows(
    inputs: Sequence[str],
    want: Sequence[str],
    columns: Sequence[Column],
    answer: Callable[[tuple[Value, ...]], tuple[Status, Sequence[Value]]],
) -> Table:
    """One call of ``answer`` for each row of the columns (n,), which stand in the order of ``inputs``.

    Raises ValueError for columns of different lengths.
    """
    arrays = [np.atleast_1d(np.asarray(column)) for column in columns]
    if len({len(array) for array in arrays}) > 1:
        lengths = ", ".join(f"{n}: {len(a)}" for n, a in zip(inputs, arrays, strict=True))
        raise ValueError(f"the columns of a sweep must have one length ({lengths}); or use grid=True")
    count = len(arrays[0]) if arrays else 1
    answers: list[list[Value | None]] = [[None] * count for _ in want]
    status = np.zeros(count, dtype=np.int8)
    for row in range(count):
        outcome, values = answer(tuple(_plain(array[row]) for array in arrays))
        status[row] = CODES[outcome]
        for column, value in zip(answers, values, strict=False):
            column[row] = value
    table: dict[str, NDArray[Any]] = dict(zip(inputs, arrays, strict=True))
    table.update((name, _column(values)) for name, values in zip(want, answers, strict=True))
    return Table(table, status)


def _plain(value: Any) -> Value:
    return str(value) if isinstance(value, str) else float(value)


def _column(values: Sequence[Value | None]) -> NDArray[Any]:
    if any(isinstance(value, str) for value in values):
        return np.array(values, dtype=object)
    return np.array([np.nan if value is None else value for value in values], dtype=float)
