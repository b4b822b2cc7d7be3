"""The rows of a sweep sorted into curves and maps: numbers along the axes, NaN where there is none."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import prod

import numpy as np

from rulesheets.diagnosis import Diagnosis, RuleSheetError, error
from rulesheets.format import readable
from solver.files.columns import Array, Columns

CURVES = 8
"""Curves that one panel may have, so that each can be told from the others."""


@dataclass(frozen=True)
class Lattice:
    """How the rows of a table hang together: the ``inputs``, and the ``shape`` of their grid.

    Rows side by side, or of a file, have a shape of one number. ``answer`` is the column of the numbers
    of the answers, where a row may have several.
    """

    inputs: tuple[str, ...]
    shape: tuple[int, ...]
    answer: str | None = None


@dataclass(frozen=True)
class Curves:
    """``abscissa`` (n,) are the values of the input ``along`` which the curves run.

    ``heights[name]`` (curves, n) are those of a variable; ``labels`` tell the curves apart.
    """

    along: str
    abscissa: Array
    labels: tuple[str, ...]
    heights: Mapping[str, Array]


@dataclass(frozen=True)
class Maps:
    """``fields[name]`` (lines, columns) are values over two inputs: ``across`` columns, ``up`` lines."""

    across: str
    up: str
    columns: Array
    lines: Array
    fields: Mapping[str, Array]


def arranged(table: Columns, lattice: Lattice) -> Curves | Maps:
    """Curves along the input that takes most values, one for each combination of the others and each answer.

    Where two inputs of numbers would make more curves than can be told apart, maps. Raises
    RuleSheetError (E445) where nothing can be drawn.
    """
    sorting = _Sorting(table, lattice)
    if not sorting.numeric:
        raise RuleSheetError(_nothing("no wanted variable has a number"))
    if not sorting.lengths:
        raise RuleSheetError(_nothing("no number is swept"))
    drawn = max(sorting.lengths, key=lambda axis: sorting.lengths[axis])
    count = sorting.answers * (prod(lattice.shape) // max(1, lattice.shape[drawn]))
    if count <= CURVES:
        return sorting.curves(drawn)
    if len(lattice.shape) == len(sorting.lengths) == 2 and sorting.answers == 1:
        return sorting.maps()
    raise RuleSheetError(_nothing(f"{count:,} curves in one picture cannot be told apart"))


class _Sorting:
    """Where each row of a table stands in the lattice."""

    def __init__(self, table: Columns, lattice: Lattice) -> None:
        self.table, self.lattice = table, lattice
        numbers = table.values[lattice.answer] if lattice.answer else np.ones(len(table), dtype=int)
        rows = np.cumsum(numbers < 2) - 1 if lattice.answer else np.arange(len(table))
        self.places = np.unravel_index(rows, lattice.shape)
        self.number = np.maximum(numbers, 1) - 1
        self.answers = int(self.number.max(initial=0)) + 1
        skipped = {*lattice.inputs, lattice.answer}
        outputs = {name: column for name, column in table.values.items() if name not in skipped}
        self.numeric = {name: column for name, column in outputs.items() if column.dtype != object}
        self.axes = dict(enumerate(self._axes()))
        self.lengths = {axis: len(v) for axis, v in self.axes.items() if v.dtype != object}

    def _axes(self) -> list[Array]:
        """The values of each input of a grid; of rows side by side the first input of numbers is the axis."""
        columns = [self.table.values[name] for name in self.lattice.inputs]
        if len(self.lattice.shape) == 1:
            columns = sorted(columns, key=lambda column: column.dtype == object)[:1]
        return [self._along(axis, column) for axis, column in enumerate(columns)]

    def _along(self, axis: int, column: Array) -> Array:
        empty = None if column.dtype == object else np.nan
        values = np.full(self.lattice.shape[axis], empty, dtype=column.dtype)
        values[self.places[axis]] = column
        return values

    def _name(self, axis: int) -> str:
        """The name of the input whose values an axis has."""
        if len(self.lattice.shape) > 1:
            return self.lattice.inputs[axis]
        values = self.table.values
        return min(self.lattice.inputs, key=lambda name: values[name].dtype == object)

    def curves(self, drawn: int) -> Curves:
        others = [axis for axis in range(len(self.lattice.shape)) if axis != drawn]
        shape = [self.lattice.shape[axis] for axis in others]
        curve = self.number.copy()
        if others:
            curve += self.answers * np.ravel_multi_index([self.places[axis] for axis in others], shape)
        heights = {}
        for name, column in self.numeric.items():
            heights[name] = np.full((self.answers * prod(shape), self.lattice.shape[drawn]), np.nan)
            heights[name][curve, self.places[drawn]] = column
        labels = [self._label(others, place) for place in np.ndindex(*shape)]
        if self.answers > 1:
            numbers = [f"answer {number + 1}" for number in range(self.answers)]
            labels = [", ".join(filter(None, (label, number))) for label in labels for number in numbers]
        return Curves(self._name(drawn), self.axes[drawn], tuple(labels), heights)

    def _label(self, axes: list[int], place: tuple[int, ...]) -> str:
        return ", ".join(
            f"{self._name(axis)} = {readable(self.axes[axis][at])}"
            for axis, at in zip(axes, place, strict=True)
        )

    def maps(self) -> Maps:
        """Lines and columns that an interrupted sweep did not reach are left out."""
        lines, columns = (np.isfinite(self.axes[axis]) for axis in (0, 1))
        fields = {}
        for name, column in self.numeric.items():
            field = np.full(self.lattice.shape, np.nan)
            field[self.places] = column
            fields[name] = field[np.ix_(lines, columns)]
        return Maps(self._name(1), self._name(0), self.axes[1][columns], self.axes[0][lines], fields)


def broken(abscissa: Array, heights: Array, turn: float | None) -> tuple[Array, Array]:
    """The points of a curve, with a gap (NaN) wherever an angle jumps by more than half a ``turn``."""
    if turn is None:
        return abscissa, heights
    with np.errstate(invalid="ignore"):
        jumps = np.flatnonzero(np.abs(np.diff(heights)) > turn / 2) + 1
    return np.insert(abscissa, jumps, abscissa[jumps]), np.insert(heights, jumps, np.nan)


def _nothing(reason: str) -> Diagnosis:
    return error(
        "E445",
        f"this sweep cannot be drawn: {reason}",
        notes=("sweep one or two numbers, and choose what is drawn by --want",),
    )
