"""A sweep on its way to a picture: curves over one swept input, maps over two."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rulesheets.diagnosis import Diagnosis, RuleSheetError, error
from rulesheets.model import Model
from rulesheets.units.quantity import shown
from solver.files.columns import Columns, joined
from solver.files.replacing import write_file
from solver.path.planner import planner
from solver.pictures.curves import Curves, Lattice, Maps, arranged, broken
from solver.pictures.page import encode
from solver.sweeps.shown import shown_columns
from solver.sweeps.work import Solved

INK, GRID = "#222222", "#dddddd"
COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#5b3c88", "#222222")
"""Okabe and Ito (2008), which people with any colour vision tell apart; strokes differ too."""
STROKES = ("solid", (0, (5, 1.5)), (0, (1.2, 1.2)), (0, (5, 1.5, 1.2, 1.5)))
WIDTH, PANEL = 7.0, 2.1
"""Inches of a page and of a panel."""


def plotted(shown: Curves | Maps, model: Model, turns: Mapping[str, float | None], form: str) -> bytes:
    """The picture as ``png``, ``svg`` or ``pdf``."""
    style: dict[Any, Any] = {
        "font.size": 9.0,
        "text.color": INK,
        "axes.labelcolor": INK,
        "axes.edgecolor": INK,
        "text.parse_math": False,  # a dollar in a unit is one
    }
    with matplotlib.rc_context({**style, "xtick.color": INK, "ytick.color": INK, "svg.fonttype": "none"}):
        figure = Figure(layout="constrained")
        if isinstance(shown, Curves):
            _draw_curves(figure, shown, model, turns)
        else:
            _draw_maps(figure, shown, model)
        return encode(figure, form, 150.0)


def panels(names: Sequence[str], model: Model, families: bool) -> list[list[str]]:
    """Variables of one unit share a panel; those without a unit, and families of curves, have their own."""
    shared: dict[str, list[str]] = {}
    for name in names:
        unit = model.variables[name].shown_unit
        shared.setdefault(unit if unit and not families else f" {name}", []).append(name)
    return list(shared.values())


def _draw_curves(figure: Figure, curves: Curves, model: Model, turns: Mapping[str, float | None]) -> None:
    groups = panels(list(curves.heights), model, len(curves.labels) > 1)
    figure.set_size_inches(WIDTH, PANEL * len(groups) + 0.8)
    rows: Any = figure.subplots(len(groups), 1, sharex=True, squeeze=False)
    for axes, names in zip(rows[:, 0], groups, strict=True):
        lines = [(name, row) for name in names for row in range(len(curves.labels))]
        for place, (name, row) in enumerate(lines):
            _curve(axes, curves, name, row, turns.get(name), place)
        axes.set_ylabel(titled(names, model))
        if len(names) > 1:
            axes.legend(frameon=False, fontsize=8)
        _tidy(axes)
    if len(curves.labels) > 1:
        handles, _ = rows[0, 0].get_legend_handles_labels()
        figure.legend(handles, curves.labels, loc="outside upper center", ncols=4, frameon=False, fontsize=8)
    rows[-1, 0].set_xlabel(titled([curves.along], model))
    figure.align_ylabels()


def _curve(axes: Axes, curves: Curves, name: str, row: int, turn: float | None, place: int) -> None:
    """A line where its abscissa runs one way, dots where it goes to and fro; a lone point is a dot, too."""
    reached = np.isfinite(curves.abscissa)
    x, y = curves.abscissa[reached], curves.heights[name][row][reached]
    label = curves.labels[row] if len(curves.labels) > 1 else name
    color, stroke = COLORS[place % len(COLORS)], STROKES[place % len(STROKES)]
    steps = np.diff(x)
    if not ((steps >= 0).all() or (steps <= 0).all()):
        axes.plot(x, y, ".", ms=3, color=color, label=label)
        return
    axes.plot(*broken(x, y, turn), color=color, ls=stroke, lw=1.3, label=label)
    lone = _lone(y)
    axes.plot(x[lone], y[lone], ".", ms=4, color=color)


def _lone(heights: Any) -> Any:
    """Points without a neighbour, which no line shows."""
    there = np.concatenate([[False], np.isfinite(heights), [False]])
    return np.flatnonzero(there[1:-1] & ~there[:-2] & ~there[2:])


def _tidy(axes: Axes) -> None:
    axes.grid(color=GRID, lw=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.margins(x=0)


def _draw_maps(figure: Figure, maps: Maps, model: Model) -> None:
    """A panel a variable; what is not solved stays white."""
    figure.set_size_inches(WIDTH, 3.2 * len(maps.fields))
    rows: Any = figure.subplots(len(maps.fields), 1, sharex=True, squeeze=False)
    for axes, (name, field) in zip(rows[:, 0], maps.fields.items(), strict=True):
        shown = np.ma.masked_invalid(field)
        low, high, extend = colored(field)
        mesh = axes.pcolormesh(
            maps.columns, maps.lines, shown, shading="nearest", rasterized=True, vmin=low, vmax=high
        )
        figure.colorbar(mesh, ax=axes, label=titled([name], model), extend=extend)
        axes.set_ylabel(titled([maps.up], model))
    rows[-1, 0].set_xlabel(titled([maps.across], model))


def colored(field: Any) -> tuple[float | None, float | None, str]:
    """The ends of the colours, and which of them have values beyond.

    A pole beside ordinary values would leave one colour for these: where the outermost hundredths span
    more than the rest, the colours end there, and the bar has points.
    """
    values = field[np.isfinite(field)]
    if not len(values):
        return None, None, "neither"
    least, low, high, most = (float(v) for v in np.quantile(values, [0.0, 0.01, 0.99, 1.0]))
    below, above = (high - least > 2 * (high - low)), (most - low > 2 * (high - low))
    extend = {(True, True): "both", (True, False): "min", (False, True): "max"}.get((below, above), "neither")
    return low if below else least, high if above else most, extend


def titled(names: Sequence[str], model: Model) -> str:
    """``xB [mm]``; of several names the unit that they share."""
    unit = model.variables[names[0]].shown_unit
    title = names[0] if len(names) == 1 else ", ".join(names)
    return f"{title} [{unit}]" if unit else title


LIMIT = 1_000_000
"""Rows that a picture may have: all of them are held."""
PICTURES = (".png", ".svg", ".pdf")


class PlotSink:
    """Holds the rows and draws them when the last has come.

    ``shape`` is that of the grid, None for rows of a file. Raises RuleSheetError: E433 for an
    ending that is no picture, E445 for a sweep that cannot be drawn, E416.
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
