"""Curves of sweeps, their panels, and the charts of methods: what matplotlib draws with axes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from math import prod
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from rulesheets.diagnosis import Diagnosis, RuleSheetError, error
from rulesheets.format import readable
from rulesheets.model import Model
from solver.facts import FALSE, Mark
from solver.files.tables import Array, Table
from solver.pictures.page import encode

CURVES = 8
"""Curves that one panel may have, so that each can be told from the others."""


class Lattice(NamedTuple):
    """How the rows of a table hang together: the ``inputs``, and the ``shape`` of their grid.

    Rows side by side, or of a file, have a shape of one number. ``answer`` is the column of the numbers
    of the answers, where a row may have several.
    """

    inputs: tuple[str, ...]
    shape: tuple[int, ...]
    answer: str | None = None


class Curves(NamedTuple):
    """``abscissa`` (n,) are the values of the input ``along`` which the curves run.

    ``heights[name]`` (curves, n) are those of a variable; ``labels`` tell the curves apart.
    """

    along: str
    abscissa: Array
    labels: tuple[str, ...]
    heights: Mapping[str, Array]


class Maps(NamedTuple):
    """``fields[name]`` (lines, columns) are values over two inputs: ``across`` columns, ``up`` lines."""

    across: str
    up: str
    columns: Array
    lines: Array
    fields: Mapping[str, Array]


def arranged(table: Table, lattice: Lattice) -> Curves | Maps:
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

    def __init__(self, table: Table, lattice: Lattice) -> None:
        self.table, self.lattice = table, lattice
        numbers = table[lattice.answer] if lattice.answer else np.ones(len(table.status), dtype=int)
        rows = np.cumsum(numbers < 2) - 1 if lattice.answer else np.arange(len(table.status))
        self.places = np.unravel_index(rows, lattice.shape)
        self.number = np.maximum(numbers, 1) - 1
        self.answers = int(self.number.max(initial=0)) + 1
        skipped = {*lattice.inputs, lattice.answer}
        outputs = {name: column for name, column in table.items() if name not in skipped}
        self.numeric = {name: column for name, column in outputs.items() if column.dtype != object}
        self.axes = dict(enumerate(self._axes()))
        self.lengths = {axis: len(v) for axis, v in self.axes.items() if v.dtype != object}

    def _axes(self) -> list[Array]:
        """The values of each input of a grid; of rows side by side the first input of numbers is the axis."""
        columns = [self.table[name] for name in self.lattice.inputs]
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
        return min(self.lattice.inputs, key=lambda name: self.table[name].dtype == object)

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
        tidy(axes)
        axes.margins(x=0)
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


def tidy(axes: Axes) -> None:
    axes.grid(color=GRID, lw=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize=8)


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


FLOOR, HIGHEST = 1e-17, 1e4
"""Errors are drawn between these: a float that is right to its last bit has up to 1e-16."""
MANY = 40
"""Points of a line from which on they are not marked one by one."""
MARKERS = "oosdP^vX"
RED = "#c0392b"
RING: dict[str, Any] = {"markersize": 9, "mfc": "none", "mec": RED, "zorder": 5, "marker": "o", "lw": 0}
CROSS: dict[str, Any] = {"markersize": 4.5, "color": "#5f6a72", "zorder": 3, "marker": "x", "lw": 0}


def speed_picture(marks: Sequence[Mark], title: str) -> Figure:
    """Time against error; methods with several tolerances joined by a line, the first and last told."""
    figure = Figure(figsize=(8.2, 4.4), layout="constrained")
    axes = figure.subplots()
    for place, family in enumerate(dict.fromkeys(mark.family for mark in marks)):
        mine = [mark for mark in marks if mark.family == family and not math.isnan(mark.error)]
        times, style = [1e6 * mark.seconds for mark in mine], _style(place, len(mine))
        _errors(axes, times, mine, style | {"markersize": 7}, family if mine else f"{family} (no answer)")
        for end in (0, -1) if len(mine) > 1 else ():
            at, told = (times[end], max(mine[end].error, FLOOR)), f"to {mine[end].tolerance:.0e}"
            offset: dict[str, Any] = {"xytext": (7, 5), "textcoords": "offset points"}
            axes.annotate(told, at, fontsize=7, color=style["color"], **offset)
    axes.set_xscale("log")
    _error_axis(axes, marks, title)
    axes.set_xlabel("time of a solve, µs", fontsize=9)
    handles = [*axes.get_legend_handles_labels()[0], *_key(marks)]
    axes.legend(handles=handles, fontsize=8, frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return figure


def stability_picture(
    marks: Sequence[Mark], title: str, label: str, places: dict[float, float] | None = None
) -> Figure:
    """Errors, times, and a line of statuses for each method, over the values of an input.

    ``places`` gives the distance from a limit for each value: then it is drawn over that, shrinking.
    """
    methods = tuple(dict.fromkeys(mark.method for mark in marks))
    heights = [2.5, 1.0, 0.17 * len(methods)]
    figure = Figure(figsize=(7.8, 1.4 + 1.2 * sum(heights)), layout="constrained")
    errors, times, status = figure.subplots(3, 1, sharex=True, height_ratios=heights)
    for row, method in enumerate(methods):
        mine = [mark for mark in marks if mark.method == method]
        x = [places[mark.at] if places else mark.at for mark in mine if mark.at is not None]
        style = _style(row, len(mine))
        _errors(errors, x, mine, style, method)
        times.plot(x, [1e6 * mark.seconds for mark in mine], **style)
        _statuses(status, row, x, mine, style)
    if places:  # the axis is shared
        status.set_xscale("log")
        status.invert_xaxis()
    _error_axis(errors, marks, title)
    times.set_yscale("log")
    times.set_ylabel("time, µs", fontsize=9)
    status.set_ylim(len(methods) - 0.4, -0.6)
    status.set_yticks(range(len(methods)), methods)
    status.set_xlabel(label, fontsize=9, parse_math=False)
    tidy(times)
    tidy(status)
    if entries := _key(marks):
        errors.legend(handles=entries, fontsize=8, frameon=False, loc="best")
    return figure


def _style(place: int, points: int) -> dict[str, Any]:
    """The colour and the marker of a method by its place; the first, our own, has the widest line."""
    size, width = (3.5 if points < MANY else 0), 1.0 if place else 2.4
    color, marker = COLORS[place % len(COLORS)], MARKERS[place % len(MARKERS)]
    return {
        "color": color,
        "marker": marker,
        "linewidth": width,
        "markersize": size,
        "zorder": 2 + (not place),
    }


def _errors(axes: Axes, x: Sequence[float], marks: Sequence[Mark], style: dict[str, Any], label: str) -> None:
    """A line, rings around false answers, bars from errors up to the radii that are proved."""
    shown = [mark.error if math.isnan(mark.error) else max(mark.error, FLOOR) for mark in marks]
    axes.plot(x, shown, label=label, **style)
    for at, height, mark in zip(x, shown, marks, strict=True):
        if mark.status == "false":
            axes.plot(at, height, **RING)
        if mark.radius is not None:
            axes.vlines(at, height, max(mark.radius, FLOOR), color=style["color"], linewidth=1.0)


def _statuses(axes: Axes, row: int, x: Sequence[float], marks: Sequence[Mark], style: dict[str, Any]) -> None:
    """One row: dots where the method was right, rings where it was false, crosses where it gave no answer."""
    dot = {"color": style["color"], "marker": style["marker"], "lw": 0, "markersize": 3.0}
    kinds = [mark.status if mark.status in ("solved", "false") else "silent" for mark in marks]
    for kind, look in (("solved", dot), ("silent", CROSS), ("false", RING)):
        if at := [place for place, found in zip(x, kinds, strict=True) if found == kind]:
            axes.plot(at, [row] * len(at), **look)
    if false := kinds.count("false"):
        beside: dict[str, Any] = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points"}
        axes.annotate(f"{false} false", (1.0, row), (4, 0), fontsize=8, color=RED, va="center", **beside)


def _error_axis(axes: Axes, marks: Sequence[Mark], title: str) -> None:
    """From rounding to nonsense; what floats can't tell from right is shaded."""
    tidy(axes)
    axes.set_title(title, fontsize=10, loc="left", color=INK, parse_math=False)
    axes.set_yscale("log")
    worst = max((mark.error for mark in marks if not math.isnan(mark.error)), default=1.0)
    axes.set_ylim(FLOOR / 3, min(max(10 * worst, 1e-13), HIGHEST))
    axes.axhspan(FLOOR / 3, 2.0**-53, color="#2a7f62", alpha=0.07, linewidth=0)
    axes.set_ylabel("worst relative error", fontsize=9)


def _key(marks: Sequence[Mark]) -> list[Any]:
    """Legend entries for what of this there is: false answers, no answers."""
    entries = []
    if any(mark.status == "false" for mark in marks):
        label = f"called an answer, off by more than {FALSE:.0e}".replace("e-0", "e-")
        entries.append(Line2D([], [], label=label, **RING))
    if any(math.isnan(mark.error) for mark in marks):
        entries.append(Line2D([], [], label="no answer", **CROSS))
    return entries
