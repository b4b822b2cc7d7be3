"""The two charts, drawn: time of a solve against its error, and error and iterations over an input."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from solver.chart.measure import Mark

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FLOOR = 1e-17
"""Smaller errors are drawn here: a float that is right to its last bit has up to 1e-16."""
HIGHEST = 1e4
NOTHING = 10.0
"""Where a point without an answer is drawn on the axis of errors."""

STYLES = {
    "backsolve": ("#1b4f72", "o", 2.4),
    "backsolve, prepared": ("#5dade2", "o", 1.8),
    "Newton": ("#7d8a97", "s", 1.0),
    "extended precision": ("#2a7f62", "D", 1.2),
    "scipy hybr": ("#d68910", "^", 1.0),
    "scipy lm": ("#af601a", "v", 1.0),
    "scipy least_squares": ("#8e44ad", "P", 1.0),
}
"""Colour, marker and line width by family."""
FALSE = "#c0392b"


def speed_picture(marks: Sequence[Mark], title: str) -> Figure:
    """Time against error; methods with several tolerances joined by a line, the first and last told."""
    figure, (axes,) = _page(1, (7.2, 4.6))
    for family in dict.fromkeys(mark.family for mark in marks):
        colour, marker, width = STYLES[family]
        mine = [mark for mark in marks if mark.family == family and not math.isnan(mark.error)]
        bold = family == "backsolve"
        axes.plot(
            [1e6 * mark.seconds for mark in mine],
            [max(mark.error, FLOOR) for mark in mine],
            color=colour,
            marker=marker,
            markersize=11 if bold else 6,
            linewidth=width if len(mine) > 1 else 0,
            label=family if mine else f"{family} (no answer)",
            zorder=3 if bold else 2,
        )
        for mark in (mine[0], mine[-1]) if len(mine) > 1 else ():
            place = 1e6 * mark.seconds, max(mark.error, FLOOR)
            axes.annotate(f"{mark.tolerance:.0e}", place, (7, 5), textcoords="offset points", fontsize=7)
        _ring(axes, [(1e6 * m.seconds, m.error) for m in mine if m.status == "false"])
    axes.set_xscale("log")
    _errors(axes, marks)
    axes.set_xlabel("time of a solve, µs")
    axes.set_title(title, fontsize=10, loc="left")
    axes.legend(fontsize=8, frameon=False, loc="upper right")
    figure.tight_layout()
    return figure


def stability_picture(
    marks: Sequence[Mark], title: str, label: str, places: dict[float, float] | None = None
) -> Figure:
    """Error above, iterations below, over the values of an input.

    ``places`` gives the distance from a limit for each value: then it is drawn over that, shrinking.
    """
    figure, (top, bottom) = _page(2, (7.6, 6.0))
    for method in dict.fromkeys(mark.method for mark in marks):
        mine = [mark for mark in marks if mark.method == method and mark.at is not None]
        colour, marker, width = STYLES[mine[0].family]
        loose = mine[0].tolerance is not None and mine[0].tolerance > 1e-9
        style: dict[str, Any] = {
            "color": colour,
            "linewidth": width,
            "linestyle": ":" if loose else "-",
            "marker": marker,
            "markersize": 4 if len(mine) < 60 else 0,
            "zorder": 3 if method == "backsolve" else 2,
        }
        x = [_place(mark, places) for mark in mine]
        top.plot(x, [max(m.error, FLOOR) for m in mine], label=method, **style)
        missing = [place for place, m in zip(x, mine, strict=True) if math.isnan(m.error)]
        top.plot(missing, [NOTHING] * len(missing), "x", color=colour, markersize=5)
        _ring(top, [(place, m.error) for place, m in zip(x, mine, strict=True) if m.status == "false"])
        if any(m.iterations is not None for m in mine):
            bottom.plot(x, [m.iterations if m.iterations is not None else math.nan for m in mine], **style)
    if places:  # the axis is shared
        bottom.set_xscale("log")
        bottom.invert_xaxis()
    _errors(top, marks)
    bottom.set_ylabel("iterations")
    bottom.set_yscale("log")
    bottom.set_xlabel(label)
    top.set_title(title, fontsize=10, loc="left")
    handles, labels = top.get_legend_handles_labels()
    figure.legend(handles, labels, fontsize=8, frameon=False, ncols=4, loc="lower center")
    figure.tight_layout(rect=(0, 0.08, 1, 1))
    return figure


def _place(mark: Mark, places: dict[float, float] | None) -> float:
    assert mark.at is not None
    return places[mark.at] if places else mark.at


def _page(rows: int, size: tuple[float, float]) -> tuple[Figure, list[Axes]]:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=size)
    FigureCanvasAgg(figure)
    heights = [2.2, 1.0] if rows == 2 else [1.0]
    axes = figure.subplots(rows, 1, sharex=True, squeeze=False, gridspec_kw={"height_ratios": heights})
    for one in axes[:, 0]:
        one.spines[["top", "right"]].set_visible(False)
        one.grid(True, color="#e6e6e6", linewidth=0.6)
        one.set_axisbelow(True)
    return figure, list(axes[:, 0])


def _errors(axes: Axes, marks: Sequence[Mark]) -> None:
    """The axis of errors, from rounding to nonsense."""
    axes.set_yscale("log")
    worst = max((mark.error for mark in marks if not math.isnan(mark.error)), default=1.0)
    silent = any(math.isnan(mark.error) for mark in marks)
    highest = min(max(10 * worst, 1e-13, 5 * NOTHING if silent else 0.0), HIGHEST)
    axes.set_ylim(FLOOR / 3, highest)
    axes.set_ylabel("worst relative error" + (" (× no answer)" if silent else ""))


def _ring(axes: Axes, points: Sequence[tuple[float, float]]) -> None:
    """False answers, ringed."""
    if points:
        axes.plot(
            [x for x, _ in points],
            [y for _, y in points],
            "o",
            markersize=10,
            markerfacecolor="none",
            markeredgecolor=FALSE,
            markeredgewidth=1.2,
            zorder=4,
        )
