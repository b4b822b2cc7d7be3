"""Figures in matplotlib: the signs of a diagram, a page of them, and the frames of a film.

Axes are in the units of the diagram; signs have the size that they have on paper, whatever the scale.
Colours are those of Okabe and Ito (2008), which people with any colour vision
tell apart; strokes differ too."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from io import BytesIO
from typing import Any, NamedTuple

import matplotlib
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from PIL import Image

from rulesheets.checks.marks import ARROWS
from rulesheets.format import readable
from solver.pictures import FONT, SLOT, Box, Diagram, Panel, Place, Stroke, bar
from solver.pictures.layout import (
    ARROW_NAMES,
    BOLD,
    CAPTION,
    EDGE,
    FOOT,
    HEAD,
    LEGEND,
    ROW,
    TITLE,
    Layout,
    View,
    layout,
    legend_width,
)

INK, SHADE, PAPER = "#222222", "#e4e4e4", "#ffffff"
_DASHES: dict[str, tuple[str, Any]] = {
    "vector": ("#0072b2", "solid"),
    "normal": ("#d55e00", (0, (4.0, 1.4))),
    "tangential": ("#007a5a", (0, (7.0, 1.4, 1.4, 1.4))),
    "sliding": ("#a0507c", (0, (1.4, 1.2))),
    "coriolis": ("#6a3d9a", (0, (4.0, 1.2, 1.2, 1.2, 1.2, 1.2))),
}


def style(kind: str) -> tuple[str, Any]:
    """Colour and stroke of a kind of arrow."""
    return _DASHES[kind]


def palette() -> list[int]:
    """Every colour of a drawing with its shades up to that of paper, which smooth the edges of its lines."""
    inks = [to_rgb(ink) for ink in (INK, *(color for color, _ in _DASHES.values()))]
    shades = (part + (1 - part) * step / 16 for ink in inks for step in range(16) for part in ink)
    return [255, 255, 255, *(int(255 * shade) for shade in shades)]


class Pen:
    """Draws the signs of one panel. Places are in millimetres, from the lower left corner of the panel."""

    def __init__(self, axes: Axes, panel: Panel) -> None:
        self.axes, self.panel = axes, panel

    def draw(self, before: Mapping[str, Place] | None = None) -> dict[str, Place]:
        """Everything; the offsets of the labels from their points, for the next frame of a film."""
        for number, stroke in enumerate(self.panel.diagram.strokes):
            self._stroke(stroke, self.panel.travel.get(number, (0.0, 0.0)))
        kinds = self.panel.diagram.kinds
        for name, kind in sorted(kinds.items(), key=lambda item: item[1] == "pole"):
            if name.startswith("_"):
                continue
            self._point(self.panel.on_paper(self.panel.diagram.places[name]), kind)
        return self._labels(before)

    # --- the elements, in millimetres ---

    def _in_units(self, places: Sequence[Place]) -> tuple[list[float], list[float]]:
        window, scale = self.panel.window, self.panel.scale
        return [window.left + x * scale for x, _ in places], [window.bottom + y * scale for _, y in places]

    def _line(
        self, places: Sequence[Place], width: float, layer: float, color: str = INK, **more: Any
    ) -> None:
        xs, ys = self._in_units(places)
        self.axes.plot(xs, ys, color=color, lw=width, zorder=layer, solid_capstyle="round", **more)

    def _area(self, places: Sequence[Place], fill: str, layer: float, width: float = 1.0) -> None:
        xs, ys = self._in_units(places)
        self.axes.fill(xs, ys, facecolor=fill, edgecolor=INK, lw=width, zorder=layer, joinstyle="round")

    def _disc(self, place: Place, diameter: float, fill: str, layer: float) -> None:
        """``diameter`` in typographic points."""
        xs, ys = self._in_units([place])
        self.axes.plot(xs, ys, "o", ms=diameter, mfc=fill, mec=INK, mew=1.0, zorder=layer)

    # --- signs ---

    def _stroke(self, stroke: Stroke, travel: tuple[float, float]) -> None:
        path = self.panel.path(stroke)
        match stroke.kind:
            case "line":
                thin = self.panel.diagram.polar
                self._line(path, 0.8 if thin else 2.2, 3)
            case "body":
                self._area(path, SHADE, 2, 1.8)
            case "slot":
                self._line(path, SLOT * 72 / 25.4, 2)
                self._line(path, SLOT * 72 / 25.4 - 2.4, 2.1, PAPER)
            case "slider":
                self._slider(path[0], stroke.angle, travel)
            case "block":
                self._area(_box(path[0], stroke.angle, 5.6, 3.4), PAPER, 4)
            case "trunnion":
                self._trunnion(path[0], stroke.angle)
            case _:
                self._arrow(stroke.kind, *path)

    def _slider(self, at: Place, angle: float, travel: tuple[float, float]) -> None:
        """A block on its guide, hatched on the side that is below or to the right."""
        self._area(_box(at, angle, 6.4, 4.0), PAPER, 2.5)
        side = -1.0 if math.cos(math.radians(angle)) >= -1e-9 else 1.0
        self._ground(at, angle, side * 2.0, (travel[0] - 6.0, travel[1] + 6.0))

    def _ground(self, at: Place, angle: float, off: float, ends: tuple[float, float]) -> None:
        """A line in that direction, ``off`` to its left, hatched on the side away from ``at``."""
        along, across = _axes(angle)
        sign = math.copysign(1.0, off)
        start = _shifted(at, across, off)
        self._line([_shifted(start, along, end) for end in ends], 1.0, 1)
        count = max(2, round((ends[1] - ends[0]) / 1.7))
        for step in range(count):
            foot = _shifted(start, along, ends[0] + (step + 0.7) * (ends[1] - ends[0]) / count)
            self._line([foot, _shifted(_shifted(foot, along, -1.1), across, 1.1 * sign)], 0.6, 1)

    def _trunnion(self, at: Place, angle: float) -> None:
        """Two jaws beside the rod, on a pin in the ground."""
        _, across = _axes(angle)
        self._pin(at)
        for side in (1.7, -1.7):
            self._area(_box(_shifted(at, across, side), angle, 6.4, 1.3), SHADE, 3.5)

    def _pin(self, at: Place) -> None:
        foot = at[1] - 3.6
        self._area([at, (at[0] - 2.0, foot), (at[0] + 2.0, foot)], PAPER, 1.5)
        self._ground((at[0], foot), 0.0, -1e-9, (-3.0, 3.0))

    def _point(self, at: Place, kind: str) -> None:
        if self.panel.diagram.polar:
            self._disc(at, 4.4 if kind == "pole" else 2.4, PAPER if kind == "pole" else INK, 7)
            return
        if kind == "pin":
            self._pin(at)
        self._disc(at, 4.6, PAPER, 6)

    def _arrow(self, kind: str, start: Place, end: Place) -> None:
        """A shaft in the stroke of its kind and a head, smaller where the arrow is short."""
        color, dashes = style(kind)
        length = math.hypot(end[0] - start[0], end[1] - start[1])
        if length < 0.05:
            return
        head = min(2.6, 0.6 * length)
        angle = math.degrees(math.atan2(end[1] - start[1], end[0] - start[0]))
        along, across = _axes(angle)
        neck = _shifted(end, along, -head)
        self._line([start, _shifted(end, along, -0.6 * head)], 1.5, 5, color, ls=dashes, dash_capstyle="butt")
        xs, ys = self._in_units(
            [end, _shifted(neck, across, 0.3 * head), _shifted(neck, across, -0.3 * head)]
        )
        self.axes.fill(xs, ys, color=color, lw=0, zorder=5.5)

    def _labels(self, before: Mapping[str, Place] | None) -> dict[str, Place]:
        texts = self.panel.texts()
        boxes = self.panel.labels(before)
        for key, box in boxes.items():
            self._text(key, texts[key], box)
        anchors = {key: self.panel.anchor(key) for key in boxes}
        return {key: (box.x - anchors[key][0], box.y - anchors[key][1]) for key, box in boxes.items()}

    def _text(self, key: str, text: str, box: Box) -> None:
        kind, _, number = key.partition(" ")
        color = INK
        if kind == "stroke" and (drawn := self.panel.diagram.strokes[int(number)].kind) in ARROWS:
            color = style(drawn)[0]
        xs, ys = self._in_units([(box.x, box.y)])
        look: dict[str, Any] = {
            "color": color,
            "style": "italic" if kind == "stroke" else "normal",
            "fontsize": FONT,
        }
        middle: dict[str, Any] = {"ha": "center", "va": "center"}
        self.axes.text(xs[0], ys[0], text, zorder=8, parse_math=False, **look, **middle)


def _axes(angle: float) -> tuple[Place, Place]:
    """Unit vectors along a direction and to its left."""
    cos, sin = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    return (cos, sin), (-sin, cos)


def _shifted(place: Place, along: Place, distance: float) -> Place:
    return place[0] + distance * along[0], place[1] + distance * along[1]


def _box(middle: Place, angle: float, length: float, width: float) -> list[Place]:
    along, across = _axes(angle)
    corners = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    return [_shifted(_shifted(middle, along, u * length / 2), across, v * width / 2) for u, v in corners]


_DATES: dict[str, dict[str, Any]] = {
    "png": {"Software": None},
    "svg": {"Date": None},
    "pdf": {"CreationDate": None},
}
"""What would make two files of one picture differ."""


def encode(figure: Figure, form: str, dpi: float) -> bytes:
    """The page as ``png``, ``svg`` or ``pdf``: the same bytes for the same picture."""
    file = BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "backsolve"}):
        figure.savefig(file, format=form, dpi=dpi, metadata=_DATES[form])
    return file.getvalue()


_INCH = 25.4

Placed = dict[tuple[int, int], dict[str, Place]]
"""Offsets of labels by figure and view."""


def compose(shown: Sequence[View]) -> Figure:
    """A page with these views side by side."""
    page = Figure()
    draw_page(page, shown, layout([shown]))
    return page


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
    sheet = _Sheet(figure, plan.size)
    sheet.legend(plan.legend)
    top = plan.size[1] - EDGE
    if heading:
        sheet.text(plan.size[0] / 2, top - TITLE / 2, heading, BOLD, weight="bold")
        top -= TITLE
    placed: Placed = {}
    for column, view in enumerate(views):
        if view is None:
            continue
        if view.title:
            sheet.text(plan.middle(column), top - TITLE / 2, view.title, BOLD, weight="bold")
        for row, diagram in enumerate(view.diagrams):
            if diagram is not None:
                panel = _panel(diagram, plan, row, column)
                placed[row, column] = sheet.panel(panel, plan, row, column, (before or {}).get((row, column)))
    return placed


def _panel(diagram: Diagram, plan: Layout, row: int, column: int) -> Panel:
    units = plan.extents[row].scale
    travel = {}
    for number, ends in plan.travel[row, column].items():
        at = diagram.path(diagram.strokes[number])[0]
        travel[number] = _along(diagram.strokes[number].angle, at, ends, units)
    return Panel(diagram, plan.windows[row, column], units, travel)


def _along(angle: float, at: Place, ends: tuple[Place, Place], units: float) -> tuple[float, float]:
    """How far the ends are from a place in a direction, in millimetres, the one behind it first."""
    x, y = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    low, high = sorted(((end[0] - at[0]) * x + (end[1] - at[1]) * y) / units for end in ends)
    return low, high


class _Sheet:
    """A page measured in millimetres from its lower left corner."""

    def __init__(self, figure: Figure, size: Place) -> None:
        self.figure = figure
        self.width, self.height = size
        figure.set_size_inches(self.width / _INCH, self.height / _INCH)

    def text(self, x: float, y: float, text: str, points: float, **more: Any) -> None:
        more = {"ha": "center", "va": "center", "color": INK, **more}
        self.figure.text(x / self.width, y / self.height, text, fontsize=points, parse_math=False, **more)

    def line(self, places: Sequence[Place], width: float, color: str = INK, dashes: Any = "solid") -> None:
        xs, ys = [x / self.width for x, _ in places], [y / self.height for _, y in places]
        line = Line2D(xs, ys, lw=width, color=color, ls=dashes, transform=self.figure.transFigure)
        self.figure.add_artist(line)

    def panel(
        self, panel: Panel, plan: Layout, row: int, column: int, before: Mapping[str, Place] | None
    ) -> dict[str, Place]:
        """A panel in the middle of its cell, with its caption above and its scale below."""
        left, top = plan.corner(row, column)
        y, x = plan.cells[row, column]
        wide, high = panel.size
        left += (plan.widths[x] - wide) / 2
        foot = top - plan.heights[y] + FOOT
        bottom = foot + (plan.heights[y] - HEAD - FOOT - high) / 2
        axes = self.figure.add_axes(
            (left / self.width, bottom / self.height, wide / self.width, high / self.height),
            label=panel.diagram.name,
        )
        axes.set_axis_off()
        axes.set_xlim(panel.window.left, panel.window.right)
        axes.set_ylim(panel.window.bottom, panel.window.top)
        letter = chr(ord("a") + row % 26)
        self.text(left + wide / 2, top - HEAD / 2, f"({letter}) {panel.diagram.title}", CAPTION)
        self._scale(panel, left + wide / 2, foot)
        return Pen(axes, panel).draw(before)

    def _scale(self, panel: Panel, middle: float, top: float) -> None:
        """The scale bar with its length, and the scale in words."""
        length, unit = bar(panel.scale), panel.diagram.unit
        half, y = length / panel.scale / 2, top - 2.0
        self.line([(middle - half, y), (middle + half, y)], 1.2)
        for end in (middle - half, middle + half):
            self.line([(end, y - 0.8), (end, y + 0.8)], 1.2)
        words = f"{_measure(length, unit)}   (1 mm : {_measure(panel.scale, unit)})"
        self.text(middle, y - 2.6, words, LEGEND)

    def legend(self, rows: Sequence[Sequence[str]]) -> None:
        """The kinds of arrows side by side, at the foot of the page."""
        for number, row in enumerate(reversed(rows)):
            y = EDGE + ROW * (number + 0.5)
            x = (self.width - sum(map(legend_width, row))) / 2
            for kind in row:
                color, dashes = style(kind)
                self.line([(x, y), (x + 6.0, y)], 1.5, color, dashes)
                self.text(x + 7.0, y, ARROW_NAMES[kind], LEGEND, ha="left")
                x += legend_width(kind)


def _measure(number: float, unit: str) -> str:
    """``0.5 m/s²``."""
    written = unit.replace("^2", "²").replace("^3", "³")
    return f"{readable(number)} {written}".rstrip()


MILLISECONDS = 60
"""How long a frame is shown."""


class Frame(NamedTuple):
    """One instant: what it is called, and its views, None in the place of one without an answer."""

    heading: str
    views: tuple[View | None, ...]


def images(film: Sequence[Frame], dpi: float) -> Iterator[Image.Image]:
    """The frames as pictures of one size. Labels stay on the same side of their points where they can."""
    plan = layout([frame.views for frame in film], headed=True)
    before: Placed | None = None
    for frame in film:
        figure = Figure(dpi=dpi)
        before = draw_page(figure, frame.views, plan, frame.heading, before)
        pixels = BytesIO()
        figure.savefig(pixels, format="rgba", dpi=dpi)
        size = figure.canvas.get_width_height()
        yield Image.frombytes("RGBA", size, pixels.getvalue()).convert("RGB")


def gif(pictures: Iterable[Image.Image]) -> bytes:
    """An endless GIF of the pictures, in the colours that there are in a drawing."""
    colors = Image.new("P", (1, 1))
    colors.putpalette(palette())
    none = Image.Dither.NONE
    first, *others = (picture.quantize(palette=colors, dither=none) for picture in pictures)
    file = BytesIO()
    first.save(file, "GIF", save_all=True, append_images=others, duration=MILLISECONDS, loop=0)
    return file.getvalue()
