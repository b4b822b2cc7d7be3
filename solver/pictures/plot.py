"""Curves of sweeps, their panels, and the charts of methods, drawn with matplotlib's axes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from math import prod
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rulesheets.diagnosis import RuleSheetError, error
from rulesheets.inputs import readable
from rulesheets.model import Model
from solver.files.tables import Array, Table
from solver.pictures import FALSE, Measurement
from solver.pictures.page import encode

CURVES = 8
"""The most curves of a panel, so that each can be identified."""


class Curves(NamedTuple):
    """``abscissa`` (n,) are the values of the input ``along`` which the curves run.

    ``heights[name]`` (curves, n) are those of a variable; ``labels`` identify the curves.
    """

    along: str
    abscissa: Array
    labels: tuple[str, ...]
    heights: Mapping[str, Array]


class Maps(NamedTuple):
    """``fields[name]`` (lines, columns) are values over two inputs, ``across`` and ``up``."""

    across: str
    up: str
    columns: Array
    lines: Array
    fields: Mapping[str, Array]


def arranged(
    table: Table, inputs: tuple[str, ...], shape: tuple[int, ...], answer: str | None = None
) -> Curves | Maps:
    """Curves along the input with most values, for each value of others and each answer.

    The rows are a grid of this ``shape`` over the ``inputs``; rows side by side, or of a file, have
    a shape of one number. ``answer`` is the column of the numbers of answers, if a row may have
    several. If two inputs of numbers would make too many curves, maps. Raises RuleSheetError (E445)
    if nothing can be drawn.
    """
    rows, number = np.arange(len(table.status)), np.zeros(len(table.status), dtype=int)
    if answer:
        rows, number = np.cumsum(table.begins()) - 1, np.maximum(table[answer], 1) - 1
    places = np.unravel_index(rows, shape)
    answers = int(number.max(initial=0)) + 1
    drawn = {n: v for n, v in table.items() if n not in (*inputs, answer) and v.dtype != object}
    if len(shape) == 1:  # rows side by side, or of a file, run along their first input of numbers
        inputs = (min(inputs, key=lambda name: table[name].dtype == object),)
    grid = zip(inputs, places, shape, strict=True)
    axes = {name: _spread(table[name], (place,), (size,)) for name, place, size in grid}
    lengths = {name: len(values) for name, values in axes.items() if values.dtype != object}
    if not drawn or not lengths:
        raise _nothing("no number is swept" if drawn else "no wanted variable has a number")
    along = max(lengths, key=lengths.__getitem__)
    others = [name for name in inputs if name != along]
    sizes = [len(axes[name]) for name in others]
    count = answers * prod(sizes)
    if count > CURVES:
        if len(inputs) == len(lengths) == 2 and answers == 1:
            return _maps(axes, {n: _spread(v, places, shape) for n, v in drawn.items()})
        raise _nothing(f"{count:,} curves are too many for one picture")
    at = dict(zip(inputs, places, strict=True))
    if others:
        number = number + answers * np.ravel_multi_index([at[name] for name in others], sizes)
    where, size = (number, at[along]), (count, len(axes[along]))
    heights = {n: _spread(v, where, size) for n, v in drawn.items()}
    labels = []
    for place in np.ndindex(*sizes, answers):
        said = [f"{n} = {readable(axes[n][k])}" for n, k in zip(others, place[:-1], strict=True)]
        labels.append(", ".join([*said, f"answer {place[-1] + 1}"] if answers > 1 else said))
    return Curves(along, axes[along], tuple(labels), heights)


def _spread(column: Array, places: tuple[Array, ...], shape: tuple[int, ...]) -> Array:
    """An array of this shape with the column at these places, nan elsewhere."""
    symbols = column.dtype == object
    found = np.full(shape, None if symbols else np.nan, dtype=object if symbols else float)
    found[places] = column
    return found


def _maps(axes: Mapping[str, Array], fields: Mapping[str, Array]) -> Maps:
    """Lines and columns that an interrupted sweep did not reach are left out."""
    (up, lines), (across, columns) = axes.items()
    reached = np.ix_(np.isfinite(lines), np.isfinite(columns))
    fields = {name: field[reached] for name, field in fields.items()}
    return Maps(across, up, columns[np.isfinite(columns)], lines[np.isfinite(lines)], fields)


def broken(abscissa: Array, heights: Array, turn: float | None) -> tuple[Array, Array]:
    """The points of a curve, with a gap (NaN) where an angle jumps by over half a ``turn``."""
    if turn is None:
        return abscissa, heights
    with np.errstate(invalid="ignore"):
        jumps = np.flatnonzero(np.abs(np.diff(heights)) > turn / 2) + 1
    return np.insert(abscissa, jumps, abscissa[jumps]), np.insert(heights, jumps, np.nan)


def _nothing(reason: str) -> RuleSheetError:
    notes = ("sweep one or two numbers, and choose what is drawn by --want",)
    return RuleSheetError(error("E445", f"this sweep cannot be drawn: {reason}", notes=notes))


INK, GRID = "#222222", "#dddddd"
COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#5b3c88", "#222222")
"""Okabe and Ito (2008), which people with any colour vision tell apart; strokes differ too."""
STROKES = ("solid", (0, (5, 1.5)), (0, (1.2, 1.2)), (0, (5, 1.5, 1.2, 1.5)))
WIDTH, PANEL = 7.0, 2.1
"""Inches of a page and of a panel."""


def plotted(
    shown: Curves | Maps, model: Model, turns: Mapping[str, float | None], form: str
) -> bytes:
    inks = ("text.color", "axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color")
    style: dict[Any, Any] = {"font.size": 9.0, "svg.fonttype": "none", **dict.fromkeys(inks, INK)}
    with matplotlib.rc_context({**style, "text.parse_math": False}):  # a dollar in a unit is one
        figure = Figure(layout="constrained")
        if isinstance(shown, Curves):
            _draw_curves(figure, shown, model, turns)
        else:
            _draw_maps(figure, shown, model)
        return encode(figure, form, 150.0)


def panels(names: Sequence[str], model: Model, families: bool) -> list[list[str]]:
    """Variables of one unit share a panel; those without one, and families of curves, do not."""
    shared: dict[str, list[str]] = {}
    for name in names:
        unit = model.variables[name].shown_unit
        shared.setdefault(unit if unit and not families else f" {name}", []).append(name)
    return list(shared.values())


def _draw_curves(
    figure: Figure, curves: Curves, model: Model, turns: Mapping[str, float | None]
) -> None:
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
        look: dict[str, Any] = {"loc": "outside upper center", "frameon": False, "fontsize": 8}
        figure.legend(handles, curves.labels, ncols=4, **look)
    rows[-1, 0].set_xlabel(titled([curves.along], model))
    figure.align_ylabels()


def _curve(axes: Axes, curves: Curves, name: str, row: int, turn: float | None, place: int) -> None:
    """A line if its abscissa is monotone, else dots; a lone point is a dot, too."""
    reached = np.isfinite(curves.abscissa)
    x, y = curves.abscissa[reached], curves.heights[name][row][reached]
    label = curves.labels[row] if len(curves.labels) > 1 else name
    color, stroke = COLORS[place % len(COLORS)], STROKES[place % len(STROKES)]
    steps = np.diff(x)
    if not ((steps >= 0).all() or (steps <= 0).all()):
        axes.plot(x, y, ".", ms=3, color=color, label=label)
        return
    axes.plot(*broken(x, y, turn), color=color, ls=stroke, lw=1.3, label=label)
    there = np.concatenate([[False], np.isfinite(y), [False]])
    lone = np.flatnonzero(there[1:-1] & ~there[:-2] & ~there[2:])  # which no line shows
    axes.plot(x[lone], y[lone], ".", ms=4, color=color)


def tidy(axes: Axes) -> None:
    axes.grid(color=GRID, lw=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize=8)


def _draw_maps(figure: Figure, maps: Maps, model: Model) -> None:
    """A panel for each variable; unsolved places stay white."""
    figure.set_size_inches(WIDTH, 3.2 * len(maps.fields))
    rows: Any = figure.subplots(len(maps.fields), 1, sharex=True, squeeze=False)
    for axes, (name, field) in zip(rows[:, 0], maps.fields.items(), strict=True):
        shown = np.ma.masked_invalid(field)
        low, high, extend = colored(field)
        look = {"shading": "nearest", "rasterized": True, "vmin": low, "vmax": high}
        mesh = axes.pcolormesh(maps.columns, maps.lines, shown, **look)
        figure.colorbar(mesh, ax=axes, label=titled([name], model), extend=extend)
        axes.set_ylabel(titled([maps.up], model))
    rows[-1, 0].set_xlabel(titled([maps.across], model))


def colored(field: Any) -> tuple[float | None, float | None, str]:
    """The ends of the colours, and which of them have values beyond.

    A pole would leave one colour for ordinary values: if the outermost hundredths span more than
    the rest, the colours end there, and the bar has points.
    """
    values = field[np.isfinite(field)]
    if not len(values):
        return None, None, "neither"
    least, low, high, most = (float(v) for v in np.quantile(values, [0.0, 0.01, 0.99, 1.0]))
    below, above = (high - least > 2 * (high - low)), (most - low > 2 * (high - low))
    extend = ("both" if above else "min") if below else ("max" if above else "neither")
    return low if below else least, high if above else most, extend


def titled(names: Sequence[str], model: Model) -> str:
    """``xB [mm]``; for several names their common unit."""
    unit = model.variables[names[0]].shown_unit
    return ", ".join(names) + (f" [{unit}]" if unit else "")


FLOOR, HIGHEST = 1e-17, 1e4
"""Errors are drawn between these: a float that is right to its last bit has up to 1e-16."""
MARKERS = "oosdP^vX"
_SIGN: dict[str, Any] = {"zorder": 5, "lw": 0}
RING = {**_SIGN, "marker": "o", "markersize": 9, "mfc": "none", "mec": "#c0392b"}
CROSS = {**_SIGN, "marker": "x", "markersize": 4.5, "color": "#111111"}


def chart_picture(
    marks: Sequence[Measurement], title: str, label: str = "", towards: bool = False
) -> Figure:
    """Errors over times, a line for each family; or, with a ``label``, both over the values of the
    input that it names (``towards`` its limit), a line for each method, and a cross where a method
    gave no answer."""
    figure = Figure(figsize=(8.2, 5.6 if label else 4.4), layout="constrained")
    two: dict[str, Any] = {"nrows": 2, "sharex": True, "height_ratios": (2, 1)}
    panels: Any = figure.subplots(**two) if label else [figure.subplots()]
    names = dict.fromkeys(mark.method if label else mark.family for mark in marks)
    for place, name in enumerate(names):
        _line(panels, name, [mark for mark in marks if name in (mark.method, mark.family)], place)
    below = panels[-1]
    below.set_xlabel(label or "time of a solve, µs", fontsize=9, parse_math=False)
    if towards or not label:
        below.set_xscale("log")
    if label:
        silent = [mark for mark in marks if math.isnan(mark.error)]
        below.plot([mark.at for mark in silent], [1e6 * mark.seconds for mark in silent], **CROSS)
        if silent:
            panels[0].plot([], [], label="no answer", **CROSS)
        tidy(below)
        below.set_yscale("log")
        below.set_ylabel("time, µs", fontsize=9)
    if towards:
        below.invert_xaxis()
    _framed(panels[0], marks, title)
    return figure


def _line(panels: Sequence[Axes], name: str, marks: Sequence[Measurement], place: int) -> None:
    """One line of errors, rings around false answers, bars from errors up to the proved radii.

    The first line is the widest. Over times the first and the last tolerance are labelled.
    """
    over = len(panels) > 1
    marks = [mark for mark in marks if over or not math.isnan(mark.error)]
    times = [1e6 * mark.seconds for mark in marks]
    size = 7.0 if not over else 3.5 if len(marks) < 40 else 0
    color, marker = COLORS[place % len(COLORS)], MARKERS[place % len(MARKERS)]
    look: dict[str, Any] = {"color": color, "marker": marker, "markersize": size}
    look |= {"lw": 1.0 if place else 2.4, "zorder": 2 + (not place)}
    errors, x = panels[0], [mark.at or 0.0 for mark in marks] if over else times
    shown = [mark.error if math.isnan(mark.error) else max(mark.error, FLOOR) for mark in marks]
    errors.plot(x, shown, label=name if marks else f"{name} (no answer)", **look)
    for at, height, mark in zip(x, shown, marks, strict=True):
        if mark.status == "false":
            errors.plot(at, height, **RING)
        if mark.radius is not None:
            errors.vlines(at, height, max(mark.radius, FLOOR), color=color, linewidth=1.0)
    if over:
        panels[1].plot(x, times, **look)
    for end in (0, -1) if len(marks) > 1 and not over else ():
        there: dict[str, Any] = {"xytext": (7, 5), "textcoords": "offset points", "fontsize": 7}
        point = x[end], shown[end]
        errors.annotate(f"to {marks[end].tolerance:.0e}", point, color=color, **there)


def _framed(axes: Axes, marks: Sequence[Measurement], title: str) -> None:
    """Axes from rounding to nonsense, the band below one ulp shaded, and a legend."""
    tidy(axes)
    axes.set_title(title, fontsize=10, loc="left", color=INK, parse_math=False)
    axes.set_yscale("log")
    worst = max((mark.error for mark in marks if not math.isnan(mark.error)), default=1.0)
    axes.set_ylim(FLOOR / 3, min(max(10 * worst, 1e-13), HIGHEST))
    axes.axhspan(FLOOR / 3, 2.0**-53, color="#2a7f62", alpha=0.07, linewidth=0)
    axes.set_ylabel("worst relative error", fontsize=9)
    if any(mark.status == "false" for mark in marks):
        told = f"called an answer,\noff by more than {FALSE:.0e}".replace("e-0", "e-")
        axes.plot([], [], label=told, **RING)
    axes.legend(fontsize=8, frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
