"""The table of a followed sweep: rows in the order of the curve, and what is known of every branch."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solver.result import Table


@dataclass(frozen=True, slots=True)
class Limit:
    """A limit position: the swept variable turns back at ``value``, its ``greatest`` or least, in ``row``."""

    value: float
    greatest: bool
    row: int


@dataclass(frozen=True, slots=True)
class Branch:
    """One connected branch: its rows ``first`` up to, but without, ``last``.

    ``closed``: it comes back to where it began (the last row is the first one again). Otherwise ``start`` and
    ``end`` say why it does not go on before its first and after its last row.
    """

    number: int
    first: int
    last: int
    closed: bool
    start: str
    end: str
    limits: tuple[Limit, ...]


class CurveTable(Table):
    """Columns by name: the swept variable, the wanted ones, then ``branch`` (1, 2, …) and ``arc``.

    ``arc`` is the length of the curve from the first row of its branch, every variable of the curve in units
    of its magnitude and angles in radians: a number that grows along the branch. Rows at limit positions have
    the status ``singular``, and the values that are determined there.
    """

    def __init__(
        self,
        columns: Mapping[str, NDArray[Any]],
        status: NDArray[np.int8],
        swept: str,
        branches: tuple[Branch, ...],
        labels: tuple[str, str],
        files: tuple[str, ...] = (),
    ) -> None:
        super().__init__(columns, status, files)
        self.swept, self.branches = swept, branches
        self._labels = labels

    @property
    def branch(self) -> NDArray[np.int64]:
        """The number of the branch of every row."""
        return self[self._labels[0]]

    @property
    def arc(self) -> NDArray[np.float64]:
        """The arc length of every row."""
        return self[self._labels[1]]
