"""The rows of a sweep, and how they are cut into pieces: a matter of the rows alone, never of the clock.

A row can be solved from where its neighbour ended, so pieces decide the last bits. Cut alike, a sweep
gives the same bytes in one process, in several, and on a cluster."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence, Sized
from dataclasses import dataclass
from fractions import Fraction
from math import lcm, prod
from typing import Any, TypeAlias

import numpy as np

from solver.files.tables import Array, column_of, stacked

Chunk: TypeAlias = tuple[Array, ...]
"""The inputs of some rows, a column each."""

_EXACT = 2**53
"""Integers below this are floats."""


class Axis(ABC):
    """The values of one input."""

    @abstractmethod
    def __len__(self) -> int: ...

    @abstractmethod
    def at(self, places: Array) -> Array:
        """The values at these places (n,)."""

    def cut(self, first: int, last: int) -> Array:
        """The values at the places ``first`` up to, but without, ``last``."""
        return self.at(np.arange(first, last))


@dataclass(frozen=True)
class Stretch(Axis):
    """``start``, ``start + step``, …: ``count`` values, each the float nearest to the exact one."""

    start: Fraction
    step: Fraction
    count: int

    def __len__(self) -> int:
        return self.count

    def at(self, places: Array) -> Array:
        """Where numerator and denominator are exact floats (below 2^53), one division rounds once."""
        bottom = lcm(self.start.denominator, self.step.denominator)
        begin, each = int(self.start * bottom), int(self.step * bottom)
        span = each * (self.count - 1)
        if max(bottom, abs(begin), abs(span), abs(begin + span)) < _EXACT:
            return np.asarray((places * float(each) + begin) / bottom)
        return np.array([float(self.start + self.step * place) for place in places.tolist()])


@dataclass(frozen=True, eq=False)
class Listed(Axis):
    """Values one by one: floats, or objects where symbols are among them."""

    values: Array

    def __len__(self) -> int:
        return len(self.values)

    def at(self, places: Array) -> Array:
        return self.values[places]


@dataclass(frozen=True)
class Grid:
    """Every combination of the axes, the last one running fastest; nothing is held but the axes.

    ``zipped``: the axes side by side instead, row k with the value k of each; all have one length.
    """

    axes: tuple[Axis, ...]
    zipped: bool = False

    def __len__(self) -> int:
        return prod(self.shape)

    @property
    def shape(self) -> tuple[int, ...]:
        """The last number is that of the rows of a line, along which only the last input changes."""
        return tuple(map(len, self.axes[:1] if self.zipped else self.axes))

    def at(self, places: Array) -> Chunk:
        """The inputs of these rows."""
        along = [places] * len(self.axes) if self.zipped else np.unravel_index(places, self.shape)
        return tuple(axis.at(there) for axis, there in zip(self.axes, along, strict=True))


def listed(values: Any, name: str = "the input") -> Listed:
    """An axis of the values that ``name`` is given. Raises ValueError for what is no column."""
    return Listed(column_of(values, name))


def one_length(names: Sequence[str], axes: Sequence[Sized]) -> None:
    """Raises ValueError for columns of different lengths."""
    if len(set(map(len, axes))) > 1:
        lengths = ", ".join(f"{name}: {len(axis)}" for name, axis in zip(names, axes, strict=True))
        raise ValueError(f"the columns of a sweep must have one length ({lengths}); or use grid=True")


SMALLEST, LARGEST = 256, 65_536
LESSONS = 256


def size(done: int, total: int | None) -> int:
    """Rows of the next piece: few at first, so that slow rows show soon, and many of many."""
    limit = LARGEST if total is None else min(LARGEST, total // 16)
    return max(SMALLEST, min(limit, done // 4))


def grid_chunks(rows: Grid) -> Iterator[Chunk]:
    """Pieces of a grid, each made when it is asked for."""
    total, done = len(rows), 0
    while done < total:
        end = min(total, done + size(done, total))
        yield rows.at(np.arange(done, end))
        done = end


def grid_lessons(rows: Grid) -> Chunk:
    """Some rows from all over a grid, to learn from; of a short one none."""
    places = lessons(len(rows), len(rows))
    return rows.at(places) if len(places) else ()


def first_lessons(chunk: Chunk) -> Chunk:
    """Some rows of the first piece, where nothing is known of the others."""
    if not chunk:
        return ()
    places = lessons(16 * len(chunk[0]), len(chunk[0]))
    return tuple(column[places] for column in chunk) if len(places) else ()


def lessons(total: int, there: int) -> Array:
    """The places of rows to learn from, of those that are there: so few that they do not weigh."""
    return np.linspace(0, there - 1, min(LESSONS, total // 64)).astype(np.int64)


def file_chunks(pieces: Iterable[Chunk], total: int | None) -> Iterator[Chunk]:
    """Pieces of a file, however it was cut when it was read."""
    done, waiting, held = 0, list[Chunk](), 0
    for piece in pieces:
        waiting.append(piece)
        held += len(piece[0])
        while held >= size(done, total):
            whole = _joined(waiting)
            count = size(done, total)
            yield tuple(column[:count] for column in whole)
            done, held = done + count, held - count
            waiting = [tuple(column[count:] for column in whole)]
    if held:
        yield _joined(waiting)


def _joined(pieces: list[Chunk]) -> Chunk:
    return tuple(stacked(columns) for columns in zip(*pieces, strict=True))
