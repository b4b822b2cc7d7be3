"""The two charts, drawn: time of a solve against its error, and errors and times along an input."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from solver.chart.measure import FALSE as FALSE_ERROR
from solver.chart.measure import Mark

FLOOR = 1e-17
"""Smaller errors are drawn here: a float that is right to its last bit has up to 1e-16."""
HIGHEST = 1e4

STYLES = {
    "backsolve": ("#1b4f72", "o", 2.4),
    "backsolve, prepared": ("#3f9bd8", "o", 1.8),
    "backsolve, proved": ("#16a085", "d", 1.6),
    "Newton": ("#7d8a97", "s", 1.0),
    "extended precision": ("#7cb342", "D", 1.2),
    "scipy hybr": ("#d68910", "^", 1.0),
    "scipy lm": ("#af601a", "v", 1.0),
    "scipy least_squares": ("#8e44ad", "P", 1.0),
}
"""Colour, marker and line width by family."""
OTHERS = ("#c2185b", "#00838f", "#6d4c41", "#5c6bc0", "#ef6c00", "#9e9d24")
FALSE = "#c0392b"
SILENT = "#5f6a72"
INK = "#333333"
OURS = "backsolve"


def style_of(family: str) -> tuple[str, str, float]:
    """Colour, marker and line width; one of its own for a family that is not among ours."""
    if family not in STYLES:
        STYLES[family] = (OTHERS[len(STYLES) % len(OTHERS)], "X", 1.0)
    return STYLES[family]


def page(size: tuple[float, float], heights: Sequence[float]) -> tuple[Figure, list[Axes]]:
    """A figure with one plot above the other, of these relative heights, over one axis."""
    figure = Figure(figsize=size)
    FigureCanvasAgg(figure)
    ratios = {"height_ratios": heights}
    axes = figure.subplots(len(heights), 1, sharex=True, squeeze=False, gridspec_kw=ratios)
    for one in axes[:, 0]:
        one.spines[["top", "right"]].set_visible(False)
        one.spines[["left", "bottom"]].set_color("#9a9a9a")
        one.tick_params(color="#9a9a9a", labelcolor=INK, labelsize=8)
        one.grid(True, color="#ececec", linewidth=0.7)
        one.set_axisbelow(True)
    return figure, list(axes[:, 0])


def error_axis(axes: Axes, marks: Sequence[Mark]) -> None:
    """From rounding to nonsense; what floats can't tell from right is shaded."""
    axes.set_yscale("log")
    worst = max((mark.error for mark in marks if not math.isnan(mark.error)), default=1.0)
    axes.set_ylim(FLOOR / 3, min(max(10 * worst, 1e-13), HIGHEST))
    axes.axhspan(FLOOR / 3, 2.0**-53, color="#2a7f62", alpha=0.07, linewidth=0)
    axes.set_ylabel("worst relative error", fontsize=9)


def shown(error: float) -> float:
    """Where an error is drawn; nan stays nan."""
    return max(error, FLOOR) if error == error else error


def ring(axes: Axes, points: Sequence[tuple[float, float]]) -> None:
    """False answers, ringed."""
    if points:
        x, y = zip(*points, strict=True)
        axes.plot(x, y, "o", **RING)


RING: dict[str, Any] = {
    "markersize": 9,
    "markerfacecolor": "none",
    "markeredgecolor": FALSE,
    "markeredgewidth": 1.3,
    "zorder": 5,
}
CROSS: dict[str, Any] = {"markersize": 4.5, "color": SILENT, "markeredgewidth": 1.2, "zorder": 3}


def radii(axes: Axes, points: Sequence[tuple[float, float, float]], colour: str) -> None:
    """From each error up to the radius that is proved: (x, error, radius)."""
    if points:
        x, errors, reach = zip(*points, strict=True)
        axes.vlines(x, [shown(e) for e in errors], [shown(r) for r in reach], color=colour, linewidth=1.0)
        axes.plot(x, [shown(r) for r in reach], "_", color=colour, markersize=6, markeredgewidth=1.0)


def key(marks: Sequence[Mark]) -> list[Any]:
    """Legend entries for what of this there is: radii, false answers, no answers."""
    entries = []
    if any(mark.radius is not None for mark in marks):
        colour = STYLES["backsolve, proved"][0]
        style: dict[str, Any] = {"marker": "_", "color": colour, "markersize": 8, "linewidth": 0}
        entries.append(Line2D([], [], label="radius of the proof", **style))
    if any(mark.status == "false" for mark in marks):
        label = f"called an answer, off by more than {FALSE_ERROR:.0e}".replace("e-0", "e-")
        entries.append(Line2D([], [], marker="o", linewidth=0, label=label, **RING))
    if any(math.isnan(mark.error) for mark in marks):
        entries.append(Line2D([], [], marker="x", linewidth=0, label="no answer", **CROSS))
    return entries


MANY = 40
"""Points of a line from which on they are not marked one by one."""


def speed_picture(marks: Sequence[Mark], title: str) -> Figure:
    """Time against error; methods with several tolerances joined by a line, the first and last told."""
    figure, (axes,) = page((8.2, 4.4), [1.0])
    for family in dict.fromkeys(mark.family for mark in marks):
        colour, marker, width = style_of(family)
        mine = [mark for mark in marks if mark.family == family and not math.isnan(mark.error)]
        axes.plot(
            [1e6 * mark.seconds for mark in mine],
            [shown(mark.error) for mark in mine],
            color=colour,
            marker=marker,
            markersize=10 if family == OURS else 6,
            linewidth=width if len(mine) > 1 else 0,
            label=family if mine else f"{family} (no answer)",
            zorder=3 if family == OURS else 2,
        )
        proved = [(1e6 * m.seconds, m.error, m.radius) for m in mine if m.radius is not None]
        radii(axes, proved, colour)
        for mark in (mine[0], mine[-1]) if len(mine) > 1 else ():
            place = 1e6 * mark.seconds, shown(mark.error)
            style: dict[str, Any] = {"textcoords": "offset points", "fontsize": 7, "color": colour}
            axes.annotate(f"to {mark.tolerance:.0e}", place, (7, 5), **style)
        ring(axes, [(1e6 * m.seconds, m.error) for m in mine if m.status == "false"])
    axes.set_xscale("log")
    error_axis(axes, marks)
    axes.set_xlabel("time of a solve, µs", fontsize=9)
    axes.set_title(title, fontsize=10, loc="left", color=INK, parse_math=False)
    handles, _ = axes.get_legend_handles_labels()
    beside: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (1.0, 1.0)}
    axes.legend(handles=[*handles, *key(marks)], fontsize=8, frameon=False, labelcolor=INK, **beside)
    figure.tight_layout()
    return figure


def stability_picture(
    marks: Sequence[Mark], title: str, label: str, places: dict[float, float] | None = None
) -> Figure:
    """Errors, times, iterations, and a line of statuses for each method, over the values of an input.

    ``places`` gives the distance from a limit for each value: then it is drawn over that, shrinking.
    """
    methods = tuple(dict.fromkeys(mark.method for mark in marks))
    counted = any(mark.iterations is not None for mark in marks)
    heights = [2.5, 1.0, *([1.0] if counted else []), 0.17 * len(methods)]
    figure, (errors, times, *counts, status) = page((7.8, 1.4 + 1.2 * sum(heights)), heights)
    for row, method in enumerate(methods):
        mine = [mark for mark in marks if mark.method == method and mark.at is not None]
        x = [_place(mark, places) for mark in mine]
        style = _line(mine)
        errors.plot(x, [shown(m.error) for m in mine], label=method, **style)
        proved = [(at, m.error, m.radius) for at, m in zip(x, mine, strict=True) if m.radius is not None]
        radii(errors, proved, style["color"])
        ring(errors, [(at, m.error) for at, m in zip(x, mine, strict=True) if m.status == "false"])
        times.plot(x, [1e6 * m.seconds for m in mine], **style)
        for iterations in counts if any(m.iterations is not None for m in mine) else ():
            iterations.plot(x, [math.nan if m.iterations is None else m.iterations for m in mine], **style)
        _statuses(status, row, x, mine)
    if places:  # the axis is shared
        status.set_xscale("log")
        status.invert_xaxis()
    error_axis(errors, marks)
    _count_axis(times, "time, µs")
    for iterations in counts:
        _count_axis(iterations, "iterations")
    _status_axis(status, methods, marks)
    status.set_xlabel(label, fontsize=9, parse_math=False)
    entries = key(marks)
    above = 20 if entries else 6
    errors.set_title(title, fontsize=10, loc="left", color=INK, pad=above, parse_math=False)
    if entries:
        layout: dict[str, Any] = {"loc": "lower left", "ncols": len(entries), "borderaxespad": 0.2}
        spaces: dict[str, Any] = {"columnspacing": 1.6, "handletextpad": 0.2, "borderpad": 0.0}
        text: dict[str, Any] = {"fontsize": 8, "labelcolor": INK, "frameon": False}
        errors.legend(handles=entries, bbox_to_anchor=(0.0, 1.01), **layout, **spaces, **text)
    figure.tight_layout()
    figure.align_ylabels((errors, times, *counts))
    return figure


def _line(mine: Sequence[Mark]) -> dict[str, Any]:
    colour, marker, width = style_of(mine[0].family)
    loose = mine[0].tolerance is not None and mine[0].tolerance > 1e-9
    return {
        "color": colour,
        "linewidth": width,
        "linestyle": ":" if loose else "-",
        "marker": marker,
        "markersize": 3.5 if len(mine) < MANY else 0,
        "zorder": 3 if mine[0].family == OURS else 2,
    }


def _statuses(axes: Axes, row: int, x: Sequence[float], mine: Sequence[Mark]) -> None:
    """One row: dots where the method was right, rings where it was false, crosses where it gave no answer."""
    colour, marker, _ = style_of(mine[0].family)
    size = 4.0 if len(mine) < MANY else 2.2

    def at(*statuses: str) -> list[float]:
        return [place for place, m in zip(x, mine, strict=True) if m.status in statuses]

    right, false = at("solved"), at("false")
    axes.plot(right, [row] * len(right), marker, color=colour, markersize=size, linewidth=0)
    silent = [place for place in x if place not in {*right, *false}]
    axes.plot(silent, [row] * len(silent), "x", **CROSS)
    ring(axes, [(place, row) for place in false])


def _status_axis(axes: Axes, methods: Sequence[str], marks: Sequence[Mark]) -> None:
    """The names of the methods, with how often each was false."""
    axes.set_ylim(len(methods) - 0.4, -0.6)
    axes.set_yticks(range(len(methods)), methods)
    families = {mark.method: mark.family for mark in marks}
    for name, tick in zip(methods, axes.get_yticklabels(), strict=True):
        tick.set_color(style_of(families[name])[0])
        tick.set_fontweight("bold" if name == OURS else "normal")
    axes.grid(False, axis="x")
    axes.tick_params(axis="y", length=0)
    for row, name in enumerate(methods):
        false = sum(mark.method == name and mark.status == "false" for mark in marks)
        if false:
            style: dict[str, Any] = {"va": "center", "fontsize": 8, "color": FALSE}
            axes.annotate(
                f"{false} false",
                (1.0, row),
                (4, 0),
                xycoords=("axes fraction", "data"),
                textcoords="offset points",
                **style,
            )


def _count_axis(axes: Axes, label: str) -> None:
    """A logarithmic axis of numbers that are read as such."""
    axes.set_yscale("log")
    low, high = axes.get_ylim()
    parts = (1.0, 2.0, 5.0) if high < 60 * low else (1.0,)
    axes.yaxis.set_major_locator(LogLocator(subs=parts, numticks=6))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.10g}"))
    axes.set_ylabel(label, fontsize=9)


def _place(mark: Mark, places: dict[float, float] | None) -> float:
    assert mark.at is not None
    return places[mark.at] if places else mark.at
