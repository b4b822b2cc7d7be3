"""The table of a sweep, and of samples drawn within tolerances."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import import_module
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from solver.facts import Status, UnknownName
from solver.files.replacing import expect_no_input
from solver.files.tables import Columns, free_name, write_table
from solver.path.steps import Shown

Column: TypeAlias = ArrayLike

CODES = {status: code for code, status in enumerate(Status)}


class Table(Mapping[str, NDArray[Any]], Shown):
    """Columns (n,) by name: the inputs that were swept, then the wanted variables.

    A wanted value is NaN where its row is not solved (None in a column of symbols). ``status``
    (n,) holds codes, 0 for solved; ``Table.STATUSES[code]`` is the status. ``answers`` (n,) tells how many
    answers of each row are known.
    """

    STATUSES = tuple(Status)

    def __init__(
        self,
        columns: Mapping[str, NDArray[Any]],
        status: NDArray[np.int8],
        files: tuple[str, ...] = (),
        answers: NDArray[np.int64] | None = None,
    ) -> None:
        self._columns = dict(columns)
        self.status = status
        self._files = files
        self.answers = self.solved.astype(np.int64) if answers is None else answers

    def __getitem__(self, name: str) -> NDArray[Any]:
        if name not in self._columns:
            raise UnknownName(name, self._columns)
        return self._columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def to_pandas(self) -> Any:
        """The columns and the status as a ``pandas.DataFrame``. Raises ImportError where pandas is absent."""
        return import_module("pandas").DataFrame(self._frame())

    def to_polars(self) -> Any:
        """The columns and the status as a ``polars.DataFrame``. Raises ImportError where polars is absent."""
        return import_module("polars").DataFrame(self._frame())

    def _frame(self) -> dict[str, Any]:
        return {**self._columns, free_name("status", self._columns): self.words()}

    def words(self) -> list[str]:
        """The status of each row, as a word."""
        return [str(self.STATUSES[code]) for code in self.status]

    def __repr__(self) -> str:
        names = ", ".join(self._columns)
        return f"<{type(self).__name__} of {len(self.status)} rows, {self.solved.sum()} solved: {names}>"

    @property
    def solved(self) -> NDArray[np.bool_]:
        """Which rows are solved."""
        return np.asarray(self.status == CODES[Status.SOLVED])

    def write(self, path: str) -> None:
        """Write a file by its ending, ``.csv`` or ``.parquet`` (with the extra ``parquet``).

        It is written as a whole or not at all. Numbers read back as the same floats, the status is a
        text, and where a row has no value there is nothing. Raises RuleSheetError: E416, E441, E442,
        and E418 for a file that the model was read from.
        """
        expect_no_input(path, self._files)
        write_table(path, Columns(self._columns, self.status, tuple(map(str, self.STATUSES))))


SPREADS = {"uniform": 3**-0.5, "normal": 1 / 3}
"""The standard deviation of an input in units of its tolerance.

``uniform``: anywhere within the tolerance alike. ``normal``: the tolerance is three standard deviations.
"""


class Samples(NamedTuple):
    """``table`` has one row a sample: the inputs drawn, and the outputs, NaN where it is not solved.

    ``spread`` is the standard deviation of an input in units of its tolerance.
    """

    table: Table
    tolerances: Mapping[str, float]
    outputs: tuple[str, ...]
    distribution: str
    seed: int

    @property
    def spread(self) -> float:
        """The standard deviation of an input, in units of its tolerance."""
        return SPREADS[self.distribution]

    def solved(self, name: str) -> NDArray[np.float64]:
        """The values of an output, of the samples that are solved."""
        column: NDArray[np.float64] = np.asarray(self.table[name], dtype=np.float64)
        return np.compress(np.isfinite(column), column)

    def statistics(self, name: str) -> tuple[float, float, float, float] | None:
        """Mean, standard deviation, least and greatest value of an output; None of fewer than two samples."""
        column = self.solved(name)
        if len(column) < 2:
            return None
        return float(column.mean()), float(column.std(ddof=1)), float(column.min()), float(column.max())

    @property
    def counts(self) -> dict[Status, int]:
        """How many samples came out with each status."""
        codes, numbers = np.unique(self.table.status, return_counts=True)
        return {self.table.STATUSES[code]: int(n) for code, n in zip(codes, numbers, strict=True)}
