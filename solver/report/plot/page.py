"""Curves and maps on a page, in matplotlib."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from rulesheets.model import Model
from solver.report.drawing.output import encode
from solver.report.plot.curves import Curves, Maps, broken, thinned

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK, GRID = "#222222", "#dddddd"
COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#5b3c88", "#222222")
"""Okabe and Ito (2008), which people with any colour vision tell apart; strokes differ too."""
STROKES = ("solid", (0, (5, 1.5)), (0, (1.2, 1.2)), (0, (5, 1.5, 1.2, 1.5)))
WIDTH, PANEL = 7.0, 2.1
"""Inches of a page and of a panel."""
POINTS = 8_000
"""Points of a curve that a page of this size can show."""


def plotted(shown: Curves | Maps, model: Model, turns: Mapping[str, float | None], form: str) -> bytes:
    """The picture as ``png``, ``svg`` or ``pdf``."""
    import matplotlib
    from matplotlib.figure import Figure

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
    axes.plot(*thinned(*broken(x, y, turn), POINTS), color=color, ls=stroke, lw=1.3, label=label)
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
