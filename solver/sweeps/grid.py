"""The rows of a sweep before they are made: axes, and how they are combined."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import lcm, prod
from typing import Any, Protocol, TypeAlias

from solver.files.columns import Array

_EXACT = 2**53
"""Integers below this are floats."""


class Axis(Protocol):
    """The values of one input."""

    def __len__(self) -> int: ...

    def take(self, places: Array) -> Array:
        """The values at integer places (n,), each 0 or more and less than the length."""

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

    def take(self, places: Array) -> Array:
        """Where numerator and denominator are exact floats (below 2^53), one division rounds once."""
        import numpy as np

        bottom = lcm(self.start.denominator, self.step.denominator)
        first, each = int(self.start * bottom), int(self.step * bottom)
        if max(bottom, abs(first), abs(first + each * (self.count - 1))) < _EXACT:
            return (places * each + first) / float(bottom)
        return np.array([float(self.start + self.step * int(k)) for k in places])

    def cut(self, first: int, last: int) -> Array:
        import numpy as np

        return self.take(np.arange(first, last))


@dataclass(frozen=True, eq=False)
class Listed:
    """Values one by one: floats, or objects where symbols are among them."""

    values: Array

    def __len__(self) -> int:
        return len(self.values)

    def take(self, places: Array) -> Array:
        taken: Array = self.values[places]
        return taken

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
        import numpy as np

        rows = np.arange(first, last)
        columns, each = [], len(self)
        for axis in self.axes:
            each //= max(1, len(axis))
            columns.append(axis.take(rows // each % len(axis)))
        return tuple(columns)


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


def listed(values: Any) -> Listed:
    """An axis of numbers and symbols (a single one counts as a list of one); None is no value."""
    import numpy as np

    column = np.atleast_1d(np.asarray(values))
    if column.dtype.kind in "biuf":
        return Listed(column.astype(float))
    plain = [
        v.removeprefix("'") if isinstance(v, str) else None if v is None else float(v)
        for v in column.tolist()
    ]
    if any(isinstance(v, str) for v in plain):
        return Listed(np.array(plain, dtype=object))
    return Listed(np.array([np.nan if v is None else v for v in plain]))


def _plain(value: Any) -> float | str | None:
    if isinstance(value, str):
        return value.removeprefix("'")
    return None if value is None else float(value)


def one_length(names: Sequence[str], axes: Sequence[Axis]) -> None:
    """Raises ValueError for columns of different lengths."""
    if len(set(map(len, axes))) > 1:
        lengths = ", ".join(f"{name}: {len(axis)}" for name, axis in zip(names, axes, strict=True))
        raise ValueError(f"the columns of a sweep must have one length ({lengths}); or use grid=True")
