"""Panels on a page: figures side by side for one state, below each other where states stand side by side."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from rulesheets.marks import ARROWS
from solver.report.drawing.diagram import Diagram, Place
from solver.report.drawing.ink import ARROW_NAMES, INK, Pen, style
from solver.report.drawing.panel import MARGIN, Panel
from solver.report.drawing.scale import Window, bar, scale, window
from solver.report.numbers import readable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MM = 1 / 25.4
_ROOM = (58.0, 52.0)
"""Millimetres that the points of a diagram may take up."""

_GAP, _HEAD, _FOOT, _TITLE, _EDGE, _ROW = 5.0, 6.0, 8.0, 7.0, 4.0, 4.5
"""Millimetres between panels, above one, below one, above a column, around the page, of a row of legend."""

_ACROSS = 3
"""Figures that stand in one row at most."""

_NARROW = 48.0
"""Millimetres that a panel has at least, for what stands below it."""


@dataclass(frozen=True)
class View:
    """One state: a title, and its diagrams in the order of the sheet, None where one cannot be drawn."""

    title: str
    diagrams: tuple[Diagram | None, ...]


@dataclass(frozen=True)
class Frame:
    """How one figure of the sheet is seen in every view of it: the size of its window, and its scale."""

    scale: float
    width: float
    height: float


Placed = dict[tuple[int, int], dict[str, Place]]
"""Offsets of labels by row and column of the panel."""


@dataclass(frozen=True)
class Layout:
    """Windows by figure and view, with one scale for each figure. ``travel`` as in :class:`Panel`."""

    frames: tuple[Frame, ...]
    windows: Mapping[tuple[int, int], Window]
    travel: Mapping[tuple[int, int], Mapping[int, tuple[Place, Place]]]

    @property
    def columns(self) -> int:
        return 1 + max(column for _, column in self.windows)


def layout(films: Sequence[Sequence[View | None]]) -> Layout:
    """The layout that fits every view: ``films`` are the views of each frame, one for a still picture."""
    count = max(len(view.diagrams) for views in films for view in views if view)
    columns = max(map(len, films))
    windows: dict[tuple[int, int], Window] = {}
    travel: dict[tuple[int, int], Mapping[int, tuple[Place, Place]]] = {}
    for figure in range(count):
        for column in range(columns):
            seen = [
                diagram
                for views in films
                if column < len(views) and (view := views[column]) and (diagram := view.diagrams[figure])
            ]
            windows[figure, column] = window(seen)
            travel[figure, column] = _travel(seen)
    frames = tuple(_frame([windows[figure, column] for column in range(columns)]) for figure in range(count))
    padded = {
        (figure, column): box.resized(frames[figure].width, frames[figure].height)
        for (figure, column), box in windows.items()
    }
    return Layout(frames, padded, travel)


def _frame(windows: Sequence[Window]) -> Frame:
    width, height = max(w.width for w in windows), max(w.height for w in windows)
    units = scale(width, height, _ROOM)
    return Frame(units, max(width + 2 * MARGIN * units, _NARROW * units), height + 2 * MARGIN * units)


def _travel(seen: Sequence[Diagram]) -> dict[int, tuple[Place, Place]]:
    """The two farthest places of every slider, by the number of its stroke."""
    found: dict[int, tuple[Place, Place]] = {}
    for diagram in seen:
        for number, stroke in enumerate(diagram.strokes):
            if stroke.kind == "slider":
                place = diagram.path(stroke)[0]
                low, high = found.get(number, (place, place))
                found[number] = min(low, place), max(high, place)
    return found


def draw_page(
    figure: Figure,
    views: Sequence[View | None],
    plan: Layout,
    heading: str = "",
    before: Placed | None = None,
) -> Placed:
    """Draw the views into an empty figure, whose size it sets; the places of the labels.

    ``before`` are those of an earlier frame of a film.
    """
    across = plan.columns == 1
    cells = _cells(plan)
    widths, heights = _tracks(plan, cells)
    titled = _TITLE * (any(view.title for view in views if view) + bool(heading))
    width = sum(widths) + _GAP * (len(widths) - 1) + 2 * _EDGE
    kinds = _arrow_kinds(views)
    legend = _ROW * len(_legend_rows(kinds, width - 2 * _EDGE))
    height = sum(heights) + _GAP * (len(heights) - 1) + 2 * _EDGE + titled + legend
    figure.set_size_inches(width * _MM, height * _MM)
    sheet = _Sheet(figure, width, height)
    sheet.legend(kinds, _EDGE)
    placed: Placed = {}
    if heading:
        sheet.text(width / 2, height - _EDGE - _TITLE / 2, heading, size=9.0, weight="bold")
    for column, view in enumerate(views):
        if view is None:
            continue
        if view.title:
            middle = width / 2 if across else _start(widths, column) + widths[column] / 2
            sheet.text(middle, height - _EDGE - titled + _TITLE / 2, view.title, size=9.0, weight="bold")
        for row, diagram in enumerate(view.diagrams):
            if diagram is None:
                continue
            y, x = cells[row, column]
            top = height - titled - _start(heights, y)
            left = _start(widths, x) + (widths[x] - _width(plan.frames[row])) / 2
            panel = _panel(diagram, plan, row, column)
            offsets = (before or {}).get((row, column))
            placed[row, column] = sheet.panel(panel, left, top, row, heights[y], offsets)
    return placed


def _cells(plan: Layout) -> dict[tuple[int, int], tuple[int, int]]:
    """Row and column on the page of each figure and view: the figures of one view fill rows."""
    count = len(plan.frames)
    if plan.columns > 1:
        return {cell: cell for cell in plan.windows}
    wide = count if count <= _ACROSS else -(-count // 2)
    return {(figure, 0): divmod(figure, wide) for figure in range(count)}


def _arrow_kinds(views: Iterable[View | None]) -> list[str]:
    """The kinds of arrows in the views, if there are several, in the order of the legend."""
    drawn = {s.kind for view in views if view for d in view.diagrams if d for s in d.strokes}
    kinds = [kind for kind in ARROWS if kind in drawn]
    return kinds if len(kinds) > 1 else []


def _width(frame: Frame) -> float:
    return frame.width / frame.scale


def _tracks(
    plan: Layout, cells: Mapping[tuple[int, int], tuple[int, int]]
) -> tuple[list[float], list[float]]:
    """Widths of the columns and heights of the rows of the page, in millimetres."""
    widths: dict[int, float] = {}
    heights: dict[int, float] = {}
    for (row, _), (y, x) in cells.items():
        frame = plan.frames[row]
        widths[x] = max(widths.get(x, 0.0), _width(frame))
        heights[y] = max(heights.get(y, 0.0), frame.height / frame.scale + _HEAD + _FOOT)
    return [widths[x] for x in sorted(widths)], [heights[y] for y in sorted(heights)]


def _start(tracks: Sequence[float], number: int) -> float:
    return _EDGE + sum(tracks[:number]) + _GAP * number


def _panel(diagram: Diagram, plan: Layout, row: int, column: int) -> Panel:
    units = plan.frames[row].scale
    travel = {}
    for number, ends in plan.travel[row, column].items():
        at = diagram.path(diagram.strokes[number])[0]
        travel[number] = _along(diagram.strokes[number].angle, at, ends, units)
    return Panel(diagram, plan.windows[row, column], units, travel)


def _along(angle: float, at: Place, ends: tuple[Place, Place], units: float) -> tuple[float, float]:
    from math import cos, radians, sin

    direction = cos(radians(angle)), sin(radians(angle))
    low, high = sorted(
        ((end[0] - at[0]) * direction[0] + (end[1] - at[1]) * direction[1]) / units for end in ends
    )
    return low, high


class _Sheet:
    """A page measured in millimetres from its lower left corner."""

    def __init__(self, figure: Figure, width: float, height: float) -> None:
        self.figure, self.width, self.height = figure, width, height

    def text(self, x: float, y: float, text: str, size: float, **more: Any) -> None:
        more = {"ha": "center", "va": "center", "color": INK, **more}
        self.figure.text(x / self.width, y / self.height, text, fontsize=size, **more)

    def line(self, places: Sequence[Place], width: float, color: str = INK, dashes: Any = "solid") -> None:
        from matplotlib.lines import Line2D

        xs, ys = [x / self.width for x, _ in places], [y / self.height for _, y in places]
        line = Line2D(xs, ys, lw=width, color=color, ls=dashes, transform=self.figure.transFigure)
        self.figure.add_artist(line)

    def panel(
        self,
        panel: Panel,
        left: float,
        top: float,
        row: int,
        height: float,
        before: Mapping[str, Place] | None,
    ) -> dict[str, Place]:
        """A panel with its caption above and its scale below, in a cell of that height."""
        wide, high = panel.size
        bottom = top - _HEAD - (height - _HEAD - _FOOT - high) / 2 - high
        axes = self.figure.add_axes(
            (left / self.width, bottom / self.height, wide / self.width, high / self.height),
            label=f"{panel.diagram.name}",
        )
        axes.set_axis_off()
        axes.set_xlim(panel.window.left, panel.window.right)
        axes.set_ylim(panel.window.bottom, panel.window.top)
        caption = panel.diagram.caption or panel.diagram.name
        self.text(left + wide / 2, top - _HEAD / 2, f"({chr(ord('a') + row % 26)}) {caption}", size=8.5)
        self._scale(panel, left + wide / 2, top - height + _FOOT)
        return Pen(axes, panel).draw(before)

    def _scale(self, panel: Panel, middle: float, top: float) -> None:
        """The scale bar with its length, and the scale in words."""
        length = bar(panel.scale)
        half, y = length / panel.scale / 2, top - 2.0
        self.line([(middle - half, y), (middle + half, y)], 1.2)
        for end in (middle - half, middle + half):
            self.line([(end, y - 0.8), (end, y + 0.8)], 1.2)
        unit = panel.diagram.unit
        self.text(
            middle, y - 2.6, f"{_measure(length, unit)}   (1 mm : {_measure(panel.scale, unit)})", size=7.0
        )

    def legend(self, kinds: Sequence[str], bottom: float) -> None:
        """The kinds of arrows side by side, in as many rows as they need."""
        for number, row in enumerate(_legend_rows(kinds, self.width - 2 * _EDGE)):
            y = bottom + _ROW * (len(_legend_rows(kinds, self.width - 2 * _EDGE)) - number - 0.5)
            x = (self.width - sum(map(_entry, row))) / 2
            for kind in row:
                color, dashes = style(kind)
                self.line([(x, y), (x + 6.0, y)], 1.5, color, dashes)
                self.text(x + 7.0, y, ARROW_NAMES[kind], size=7.0, ha="left")
                x += _entry(kind)


def _measure(number: float, unit: str) -> str:
    """``0.5 m/s²``."""
    written = unit.replace("^2", "²").replace("^3", "³")
    return f"{readable(number)} {written}".rstrip()


def _entry(kind: str) -> float:
    """Width of a kind in the legend."""
    return 10.0 + 1.45 * len(ARROW_NAMES[kind])


def _legend_rows(kinds: Sequence[str], width: float) -> list[list[str]]:
    rows: list[list[str]] = []
    for kind in kinds:
        if rows and sum(map(_entry, rows[-1])) + _entry(kind) <= width:
            rows[-1].append(kind)
        else:
            rows.append([kind])
    return rows
