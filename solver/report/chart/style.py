"""What the charts have in common: colours, the page, the axis of errors, and the marks of what went wrong."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from solver.chart.measure import FALSE as FALSE_ERROR
from solver.chart.measure import Mark

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

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
    from matplotlib.lines import Line2D

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
