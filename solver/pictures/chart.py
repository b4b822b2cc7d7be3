"""The two charts, drawn: time of a solve against its error, and errors and times along an input."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from solver.chart.measure import FALSE, Mark

FLOOR, HIGHEST = 1e-17, 1e4
"""Errors are drawn between these: a float that is right to its last bit has up to 1e-16."""
MANY = 40
"""Points of a line from which on they are not marked one by one."""
OURS, INK, RED = "backsolve", "#333333", "#c0392b"

STYLES = {
    "backsolve": ("#1b4f72", "o", 2.4),
    "backsolve, prepared": ("#3f9bd8", "o", 1.8),
    "backsolve, proved": ("#16a085", "d", 1.6),
    "Newton": ("#7d8a97", "s", 1.0),
    "scipy hybr": ("#d68910", "^", 1.0),
    "scipy lm": ("#af601a", "v", 1.0),
    "scipy least_squares": ("#8e44ad", "P", 1.0),
}
"""Colour, marker and line width by family."""
OTHERS = ("#c2185b", "#00838f", "#6d4c41", "#5c6bc0", "#ef6c00", "#9e9d24")

_RING: dict[str, Any] = {"markersize": 9, "markerfacecolor": "none", "markeredgecolor": RED, "zorder": 5}
_CROSS: dict[str, Any] = {"markersize": 4.5, "color": "#5f6a72", "zorder": 3}


def speed_picture(marks: Sequence[Mark], title: str) -> Figure:
    """Time against error; methods with several tolerances joined by a line, the first and last told."""
    figure, (axes,) = _page((8.2, 4.4), [1.0])
    for family in dict.fromkeys(mark.family for mark in marks):
        mine = [mark for mark in marks if mark.family == family and not math.isnan(mark.error)]
        times = [1e6 * mark.seconds for mark in mine]
        style = _style(family, len(mine)) | {"markersize": 10 if family == OURS else 6}
        axes.plot(times, _shown(mine), label=family if mine else f"{family} (no answer)", **style)
        _exceptional(axes, times, mine, style["color"])
        for mark in (mine[0], mine[-1]) if len(mine) > 1 else ():
            place = 1e6 * mark.seconds, max(mark.error, FLOOR)
            offset: dict[str, Any] = {"xytext": (7, 5), "textcoords": "offset points"}
            axes.annotate(f"to {mark.tolerance:.0e}", place, fontsize=7, color=style["color"], **offset)
    axes.set_xscale("log")
    _error_axis(axes, marks)
    axes.set_xlabel("time of a solve, µs", fontsize=9)
    axes.set_title(title, fontsize=10, loc="left", color=INK, parse_math=False)
    handles, _ = axes.get_legend_handles_labels()
    beside: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (1.0, 1.0)}
    axes.legend(handles=[*handles, *_key(marks)], fontsize=8, frameon=False, **beside)
    figure.tight_layout()
    return figure


def stability_picture(
    marks: Sequence[Mark], title: str, label: str, places: dict[float, float] | None = None
) -> Figure:
    """Errors, times, and a line of statuses for each method, over the values of an input.

    ``places`` gives the distance from a limit for each value: then it is drawn over that, shrinking.
    """
    methods = tuple(dict.fromkeys(mark.method for mark in marks))
    heights = [2.5, 1.0, 0.17 * len(methods)]
    figure, (errors, times, status) = _page((7.8, 1.4 + 1.2 * sum(heights)), heights)
    for row, method in enumerate(methods):
        mine = [mark for mark in marks if mark.method == method and mark.at is not None]
        x = [places[mark.at] if places else mark.at for mark in mine if mark.at is not None]
        style = _style(mine[0].family, len(mine))
        if mine[0].tolerance is not None and mine[0].tolerance > 1e-9:
            style["linestyle"] = ":"
        errors.plot(x, _shown(mine), label=method, **style)
        _exceptional(errors, x, mine, style["color"])
        times.plot(x, [1e6 * mark.seconds for mark in mine], **style)
        _statuses(status, row, x, mine)
    if places:  # the axis is shared
        status.set_xscale("log")
        status.invert_xaxis()
    _error_axis(errors, marks)
    times.set_yscale("log")
    times.set_ylabel("time, µs", fontsize=9)
    _status_axis(status, methods)
    status.set_xlabel(label, fontsize=9, parse_math=False)
    entries = _key(marks)
    errors.set_title(title, fontsize=10, loc="left", color=INK, pad=20 if entries else 6, parse_math=False)
    if entries:
        above: dict[str, Any] = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.01), "borderaxespad": 0.2}
        errors.legend(handles=entries, ncols=len(entries), fontsize=8, frameon=False, **above)
    figure.tight_layout()
    figure.align_ylabels((errors, times))
    return figure


def _page(size: tuple[float, float], heights: Sequence[float]) -> tuple[Figure, list[Axes]]:
    """A figure with one plot above the other, of these relative heights, over one axis."""
    figure = Figure(figsize=size)
    FigureCanvasAgg(figure)
    axes = figure.subplots(
        len(heights), 1, sharex=True, squeeze=False, gridspec_kw={"height_ratios": heights}
    )
    for one in axes[:, 0]:
        one.spines[["top", "right"]].set_visible(False)
        one.tick_params(labelsize=8)
        one.grid(True, color="#ececec", linewidth=0.7)
        one.set_axisbelow(True)
    return figure, list(axes[:, 0])


def _style(family: str, points: int) -> dict[str, Any]:
    """How a line is drawn; a family that is not among ours has a colour of its own."""
    if family not in STYLES:
        STYLES[family] = (OTHERS[len(STYLES) % len(OTHERS)], "X", 1.0)
    color, marker, width = STYLES[family]
    size, layer = 3.5 if points < MANY else 0, 3 if family == OURS else 2
    line = {"linewidth": width, "markersize": size, "zorder": layer}
    return {"color": color, "marker": marker, **line}


def _shown(marks: Sequence[Mark]) -> list[float]:
    """Where errors are drawn; NaN stays NaN."""
    return [mark.error if math.isnan(mark.error) else max(mark.error, FLOOR) for mark in marks]


def _exceptional(axes: Axes, x: Sequence[float], marks: Sequence[Mark], color: str) -> None:
    """Rings around false answers, bars from errors up to the radii that are proved."""
    points = list(zip(x, marks, _shown(marks), strict=True))
    false = [(at, error) for at, mark, error in points if mark.status == "false"]
    proved = [(at, error, max(m.radius, FLOOR)) for at, m, error in points if m.radius is not None]
    if false:
        axes.plot(*zip(*false, strict=True), "o", **_RING)
    if proved:
        at, low, high = zip(*proved, strict=True)
        axes.vlines(at, low, high, color=color, linewidth=1.0)


def _statuses(axes: Axes, row: int, x: Sequence[float], marks: Sequence[Mark]) -> None:
    """One row: dots where the method was right, rings where it was false, crosses where it gave no answer."""
    color, marker, _ = STYLES[marks[0].family]
    at: dict[str, list[float]] = {"solved": [], "false": [], "silent": []}
    for place, mark in zip(x, marks, strict=True):
        at[mark.status if mark.status in at else "silent"].append(place)
    size = 4.0 if len(marks) < MANY else 2.2
    axes.plot(at["solved"], [row] * len(at["solved"]), marker, color=color, markersize=size)
    axes.plot(at["silent"], [row] * len(at["silent"]), "x", **_CROSS)
    if at["false"]:
        axes.plot(at["false"], [row] * len(at["false"]), "o", **_RING)
        beside: dict[str, Any] = {
            "xycoords": ("axes fraction", "data"),
            "textcoords": "offset points",
            "va": "center",
        }
        axes.annotate(f"{len(at['false'])} false", (1.0, row), (4, 0), fontsize=8, color=RED, **beside)


def _status_axis(axes: Axes, methods: Sequence[str]) -> None:
    axes.set_ylim(len(methods) - 0.4, -0.6)
    axes.set_yticks(range(len(methods)), methods)
    axes.tick_params(axis="y", length=0)
    axes.grid(False, axis="x")


def _error_axis(axes: Axes, marks: Sequence[Mark]) -> None:
    """From rounding to nonsense; what floats can't tell from right is shaded."""
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
        entries.append(Line2D([], [], marker="o", linewidth=0, label=label, **_RING))
    if any(math.isnan(mark.error) for mark in marks):
        entries.append(Line2D([], [], marker="x", linewidth=0, label="no answer", **_CROSS))
    return entries
