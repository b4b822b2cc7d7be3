"""A sweep on its way to a picture."""

from __future__ import annotations

import os
from dataclasses import replace

from rulesheets.diagnosis import Diagnosis, RuleSheetError, error
from rulesheets.model import Model
from rulesheets.units.quantity import shown
from solver.files.columns import Columns, joined
from solver.files.replacing import write_file
from solver.path.planner import planner
from solver.report.drawing.picture import require_matplotlib
from solver.report.plot.curves import Lattice, arranged
from solver.report.plot.page import plotted
from solver.sweeps.shown import shown_columns
from solver.sweeps.work import Solved

LIMIT = 1_000_000
"""Rows that a picture may have: all of them are held."""
PICTURES = (".png", ".svg", ".pdf")


class PlotSink:
    """Holds the rows and draws them when the last has come.

    ``shape`` is that of the grid, None for rows of a file. Raises RuleSheetError: E432 without
    matplotlib, E433 for an ending that is no picture, E445 for a sweep that cannot be drawn, E416.
    """

    def __init__(
        self,
        path: str,
        model: Model,
        inputs: tuple[str, ...],
        shape: tuple[int, ...] | None,
        answer: str | None,
    ) -> None:
        self._path, self._model, self._inputs = path, model, inputs
        self._shape, self._answer = shape, answer
        self._form = os.path.splitext(path)[1].lower()
        self._pieces: list[Columns] = []
        self._rows = 0
        if self._form not in PICTURES:
            raise RuleSheetError(error("E433", f"{path}: a picture ends in .png, .svg or .pdf"))
        require_matplotlib()

    def add(self, piece: Solved) -> None:
        assert piece.table is not None
        self._rows += sum(piece.counts)
        if self._rows <= LIMIT:
            self._pieces.append(piece.table)
        else:
            self._pieces = []

    def close(self) -> None:
        if self._rows > LIMIT:
            raise RuleSheetError(too_many())
        if not self._pieces:
            return
        table = self._drawn(joined(self._pieces))
        lattice = Lattice(self._inputs, self._shape or (self._rows,), self._answer)
        drawn = arranged(table, lattice)
        picture = plotted(
            drawn, self._model, {name: self._turn(name) for name in table.values}, self._form[1:]
        )
        write_file(self._path, picture)

    def _turn(self, name: str) -> float | None:
        turn = planner(self._model).graph.turn(name)
        return turn and shown(turn, self._model.variables[name], difference=True)

    def _drawn(self, table: Columns) -> Columns:
        """The columns of variables, and the numbers of answers where every one is drawn."""
        drawn = (*self._model.variables, self._answer)
        kept = replace(table, values={n: column for n, column in table.values.items() if n in drawn})
        return shown_columns(kept, self._model)

    def discard(self) -> None:
        self._pieces = []


def too_many() -> Diagnosis:
    return error("E445", f"a picture shows at most {LIMIT:,} rows", notes=("take a larger step",))
