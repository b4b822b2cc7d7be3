"""Columns by name, with a status for each row: what a table file holds."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from numpy.typing import NDArray

Array: TypeAlias = NDArray[Any]


@dataclass(frozen=True)
class Columns:
    """``values`` (n,) by name: floats with NaN for nothing, integers, or objects (symbols, floats, None).

    ``status`` (n,) are indices into ``words``. ``whole``: every number is known to be there.
    """

    values: Mapping[str, Array]
    status: Array
    words: Sequence[str]
    whole: bool = False

    def __len__(self) -> int:
        return len(self.status)

    def rows(self, first: int, last: int) -> Columns:
        """Rows ``first`` up to, but without, ``last``."""
        kept = {name: column[first:last] for name, column in self.values.items()}
        return Columns(kept, self.status[first:last], self.words, self.whole)


def joined(parts: Sequence[Columns]) -> Columns:
    """The rows of several pieces of one table, one after another."""
    if len(parts) == 1:
        return parts[0]
    values = {name: stacked([part.values[name] for part in parts]) for name in parts[0].values}
    whole = all(part.whole for part in parts)
    return Columns(values, stacked([part.status for part in parts]), parts[0].words, whole)


def stacked(pieces: Sequence[Array]) -> Array:
    """One column of several pieces. NaN beside symbols is None, as it is within a piece."""
    import numpy as np

    if any(piece.dtype == object for piece in pieces):
        pieces = [piece if piece.dtype == object else objects(piece) for piece in pieces]
    return np.concatenate(pieces)


def objects(column: Array) -> Array:
    """A column of floats as one that may hold symbols, None for NaN."""
    import numpy as np

    return np.array([None if value != value else value for value in column.tolist()], dtype=object)


def free_name(name: str, taken: Iterable[str]) -> str:
    """``name``, with as many ``_`` after it as keep it apart from the variables of the table."""
    names = set(taken)
    while name in names:
        name += "_"
    return name
