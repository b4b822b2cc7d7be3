"""The rows of a sweep, and how they are cut into pieces: a matter of the rows alone, never of the clock.

A row can be solved from where its neighbour ended, so pieces decide the last bits. Cut alike, a sweep
gives the same bytes in one process, in several, and on a cluster."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import lcm, prod
from typing import Any, Protocol, TypeAlias

import numpy as np

from solver.files.columns import Array, stacked

_EXACT = 2**53
"""Integers below this are floats."""


class Axis(Protocol):
    """The values of one input."""

    def __len__(self) -> int: ...

    def cut(self, first: int, last: int) -> Array:
        """The values at the places ``first`` up to, but without, ``last``."""


@dataclass(frozen=True)
class Stretch:
    """``start``, ``start + step``, …: ``count`` values, each the float nearest to the exact one."""

    start: Fraction
    step: Fraction
    count: int

    def __len__(self) -> int:
        return self.count

    def cut(self, first: int, last: int) -> Array:
        """Where numerator and denominator are exact floats (below 2^53), one division rounds once."""
        import numpy as np

        bottom = lcm(self.start.denominator, self.step.denominator)
        begin, each = int(self.start * bottom), int(self.step * bottom)
        span = each * (self.count - 1)
        if max(bottom, abs(begin), abs(span), abs(begin + span)) < _EXACT:
            places = np.arange(first, last, dtype=float)
            places *= each
            places += begin
            places /= bottom
            return places
        return np.array([float(self.start + self.step * place) for place in range(first, last)])


@dataclass(frozen=True, eq=False)
class Listed:
    """Values one by one: floats, or objects where symbols are among them."""

    values: Array

    def __len__(self) -> int:
        return len(self.values)

    def cut(self, first: int, last: int) -> Array:
        return self.values[first:last]


@dataclass(frozen=True)
class Grid:
    """Every combination of the axes, the last one running fastest; nothing is held but the axes."""

    axes: tuple[Axis, ...]

    def __len__(self) -> int:
        return prod(map(len, self.axes))

    @property
    def shape(self) -> tuple[int, ...]:
        """The last number is that of the rows of a line, along which only the last input changes."""
        return tuple(map(len, self.axes))

    def columns(self, first: int, last: int) -> tuple[Array, ...]:
        """The inputs of the rows ``first`` up to, but without, ``last``."""
        columns, each = [], len(self)
        for axis in self.axes:
            each //= max(1, len(axis))
            columns.append(_repeated(axis, each, first, last))
        return tuple(columns)


def _repeated(axis: Axis, each: int, first: int, last: int) -> Array:
    """Rows of an axis whose every value stands ``each`` times, over and over: made once where it stands."""
    import numpy as np

    if first == last:
        return axis.cut(0, 0)
    start, end = first // each, -(-last // each)
    values = _cycled(axis, start % len(axis), end - start)
    if each == 1:
        return values
    counts = np.full(len(values), each)
    counts[-1] -= end * each - last
    counts[0] -= first - start * each
    return np.repeat(values, counts)


def _cycled(axis: Axis, first: int, count: int) -> Array:
    """So many values from the place ``first`` on; after the last one comes the first one."""
    import numpy as np

    ahead = min(count, len(axis) - first)
    if ahead == count:
        return axis.cut(first, first + count)
    rounds, rest = divmod(count - ahead, len(axis))
    whole = [axis.cut(0, len(axis))] * rounds
    return np.concatenate([axis.cut(first, first + ahead), *whole, axis.cut(0, rest)])


@dataclass(frozen=True)
class Zipped:
    """The axes side by side: row k has the value k of each. All have one length."""

    axes: tuple[Axis, ...]

    def __len__(self) -> int:
        return len(self.axes[0])

    @property
    def shape(self) -> tuple[int, ...]:
        return (len(self),)

    def columns(self, first: int, last: int) -> tuple[Array, ...]:
        return tuple(axis.cut(first, last) for axis in self.axes)


Rows: TypeAlias = Grid | Zipped


def listed(values: Any, name: str = "the input") -> Listed:
    """An axis of the values that ``name`` is given. Raises ValueError for what is no column."""
    from solver.column import column_of

    return Listed(column_of(values, name))


def one_length(names: Sequence[str], axes: Sequence[Axis]) -> None:
    """Raises ValueError for columns of different lengths."""
    if len(set(map(len, axes))) > 1:
        lengths = ", ".join(f"{name}: {len(axis)}" for name, axis in zip(names, axes, strict=True))
        raise ValueError(f"the columns of a sweep must have one length ({lengths}); or use grid=True")


SMALLEST, LARGEST = 256, 65_536
LESSONS = 256

Chunk = tuple[Array, ...]
"""The inputs of some rows, a column each."""


def size(done: int, total: int | None) -> int:
    """Rows of the next piece: few at first, so that slow rows show soon, and many of many."""
    limit = LARGEST if total is None else min(LARGEST, total // 16)
    return max(SMALLEST, min(limit, done // 4))


def grid_chunks(rows: Rows) -> Iterator[Chunk]:
    """Pieces of a grid, each made when it is asked for."""
    total, done = len(rows), 0
    while done < total:
        end = min(total, done + size(done, total))
        yield rows.columns(done, end)
        done = end


def grid_lessons(rows: Rows) -> Chunk:
    """Some rows from all over a grid, to learn from; of a short one none."""
    count = lessons(len(rows))
    places = np.linspace(0, len(rows) - 1, count).astype(np.int64) if count else ()
    made = [rows.columns(int(place), int(place) + 1) for place in places]
    return _joined(made) if made else ()


def first_lessons(chunk: Chunk) -> Chunk:
    """Some rows of the first piece, where nothing is known of the others."""
    count = lessons(16 * len(chunk[0])) if chunk else 0
    places = np.linspace(0, len(chunk[0]) - 1, count).astype(np.int64) if count else ()
    return tuple(column[places] for column in chunk) if count else ()


def lessons(total: int) -> int:
    """Rows to learn from: as many as do not weigh among so many."""
    return min(LESSONS, total // 64)


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
