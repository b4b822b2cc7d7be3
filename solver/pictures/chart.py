"""The two charts, drawn: time of a solve against its error, and errors and times along an input."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from solver.facts import FALSE, Mark
from solver.pictures.plot import COLORS, INK, tidy

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
    for at, error, mark in zip(x, shown, marks, strict=True):
        if mark.status == "false":
            axes.plot(at, error, **RING)
        if mark.radius is not None:
            axes.vlines(at, error, max(mark.radius, FLOOR), color=style["color"], linewidth=1.0)


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
