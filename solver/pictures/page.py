"""Figures in matplotlib: where panels go, the signs of a diagram, a page of them, the frames of a film.

Axes are in the units of the diagram; signs have the size that they have on paper, whatever the scale.
Colours are those of Okabe and Ito (2008), which people with any colour vision
tell apart; strokes differ too."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from io import BytesIO
from typing import Any, NamedTuple, TypeAlias

import matplotlib
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from PIL import Image

from rulesheets.checks.marks import ARROWS
from rulesheets.format import readable
from solver.pictures import (
    FONT,
    MARGIN,
    SLOT,
    Diagram,
    Panel,
    Place,
    Stroke,
    View,
    Window,
    bar,
    scale,
    window,
)

GAP, HEAD, FOOT, TITLE, EDGE, ROW = 5.0, 6.0, 8.0, 7.0, 4.0, 4.5
"""Millimetres between panels, above one, below one, above a column, around the page, of a row of legend."""

CAPTION, BOLD, LEGEND = 8.5, 9.0, 7.0
"""Sizes of captions, of titles and of what stands below a panel, in points."""

ARROW_NAMES = {
    "vector": "absolute",
    "normal": "normal",
    "tangential": "tangential",
    "sliding": "sliding",
    "coriolis": "Coriolis",
}

_ROOM = (58.0, 50.0)
"""Millimetres that the points of a diagram may take up: three diagrams fit A4 across, twice three upright."""

_FINEST = 1e-9
"""The least extent of a figure that is seen as one, relative to the coordinates."""

_NARROW = 48.0
"""Millimetres that a panel has at least, for its scale."""

_ACROSS = 3
"""Figures that stand in one row at most."""


class Extent(NamedTuple):
    """How one figure of the sheet is seen in every view: its scale, and the size of its window in units."""

    scale: float
    width: float
    height: float


Cell: TypeAlias = tuple[int, int]
"""A figure (row) of a view (column)."""


class Layout(NamedTuple):
    """A page of panels, one for each cell, in millimetres from its lower left corner.

    ``travel`` has the two farthest places of every slider of a cell, by the number of its stroke. ``places``
    are the rectangles that cells have, caption and scale included; ``middles`` are those of the views.
    ``legend`` has rows of kinds of arrows.
    """

    size: Place
    extents: tuple[Extent, ...]
    windows: Mapping[Cell, Window]
    travel: Mapping[Cell, Mapping[int, tuple[Place, Place]]]
    places: Mapping[Cell, Window]
    middles: tuple[float, ...]
    legend: tuple[tuple[str, ...], ...]


def layout(frames: Sequence[Sequence[View | None]], *, headed: bool = False) -> Layout:
    """The layout that fits every view: ``frames`` are the views of each frame, one for a still picture.

    Above the panels is room for the titles that views have, and for a heading where it is ``headed``.
    """
    count = max(map(len, frames))
    shown = [[v for views in frames if k < len(views) and (v := views[k])] for k in range(count)]
    views = [view for column in shown for view in column]
    seen = {
        (row, column): [diagram for view in shown[column] if (diagram := view.diagrams[row])]
        for row in range(len(views[0].diagrams))
        for column in range(count)
    }
    least = {cell: window(diagrams) for cell, diagrams in seen.items()}
    extents = []
    for row in range(len(views[0].diagrams)):
        titles = [diagram.title for column in range(count) for diagram in seen[row, column]]
        extents.append(_extent([least[row, column] for column in range(count)], titles))
    # figures below each other where there are several views; the figures of one view fill rows
    wide = len(extents) if len(extents) <= _ACROSS else -(-len(extents) // 2)
    cells = {cell: cell if count > 1 else divmod(cell[0], wide) for cell in seen}
    widths, heights = dict[int, float](), dict[int, float]()
    for (row, column), (y, x) in cells.items():
        units, width, height = extents[row]
        title = max((text_width(view.title, BOLD) for view in shown[column] if count > 1), default=0.0)
        widths[x] = max(widths.get(x, 0.0), width / units, title)
        heights[y] = max(heights.get(y, 0.0), height / units + HEAD + FOOT)
    across, up = _start(widths, len(widths)) - GAP + EDGE, _start(heights, len(heights)) - GAP + EDGE
    legend = _legend(views, across - 2 * EDGE)
    above = TITLE * (any(view.title for view in views) + headed)
    up += above + ROW * len(legend)
    places = {}
    for cell, (y, x) in cells.items():
        left, top = _start(widths, x), up - above - _start(heights, y)
        places[cell] = Window(left, top - heights[y], left + widths[x], top)
    middles = [_start(widths, column) + widths[column] / 2 for column in range(count)]
    windows = {cell: box.resized(*extents[cell[0]][1:]) for cell, box in least.items()}
    travel = {cell: _travel(diagrams) for cell, diagrams in seen.items()}
    middles = middles if count > 1 else [across / 2]
    return Layout((across, up), tuple(extents), windows, travel, places, tuple(middles), legend)


def text_width(text: str, points: float) -> float:
    """About how wide a text is, in millimetres, in the font that matplotlib brings along."""
    return 0.215 * points * len(text)


def legend_width(kind: str) -> float:
    """Width of a kind of arrow in the legend."""
    return 10.0 + text_width(ARROW_NAMES[kind], LEGEND)


def _extent(windows: Sequence[Window], captions: Iterable[str]) -> Extent:
    width, height = max(w.width for w in windows), max(w.height for w in windows)
    reach = max(w.reach for w in windows)
    least = reach * (_FINEST if max(width, height) > 0.0 else 1.0)
    units = scale(max(width, least), height, _ROOM)
    narrow = max([_NARROW, *(text_width(f"(a) {caption}", CAPTION) for caption in captions)])
    return Extent(units, max(width + 2 * MARGIN * units, narrow * units), height + 2 * MARGIN * units)


def _travel(seen: Sequence[Diagram]) -> dict[int, tuple[Place, Place]]:
    found: dict[int, tuple[Place, Place]] = {}
    for diagram in seen:
        for number, stroke in enumerate(diagram.strokes):
            if stroke.kind == "slider":
                place = diagram.path(stroke)[0]
                low, high = found.get(number, (place, place))
                found[number] = min(low, place), max(high, place)
    return found


def _start(tracks: Mapping[int, float], number: int) -> float:
    """Where a column or row of the page begins, from its left or upper edge."""
    return EDGE + sum(tracks[place] + GAP for place in range(number))


def _legend(views: Sequence[View], width: float) -> tuple[tuple[str, ...], ...]:
    """The kinds of arrows in the views, if there are several, in rows of that width."""
    drawn = {
        stroke.kind for view in views for diagram in view.diagrams if diagram for stroke in diagram.strokes
    }
    kinds = [kind for kind in ARROWS if kind in drawn]
    rows: list[tuple[str, ...]] = []
    for kind in kinds if len(kinds) > 1 else ():
        if rows and sum(map(legend_width, (*rows[-1], kind))) <= width:
            rows[-1] = (*rows[-1], kind)
        else:
            rows.append((kind,))
    return tuple(rows)


INK, SHADE, PAPER = "#222222", "#e4e4e4", "#ffffff"
STYLES: dict[str, tuple[str, Any]] = {
    "vector": ("#0072b2", "solid"),
    "normal": ("#d55e00", (0, (4.0, 1.4))),
    "tangential": ("#007a5a", (0, (7.0, 1.4, 1.4, 1.4))),
    "sliding": ("#a0507c", (0, (1.4, 1.2))),
    "coriolis": ("#6a3d9a", (0, (4.0, 1.2, 1.2, 1.2, 1.2, 1.2))),
}
"""Colour and stroke of each kind of arrow."""


class Pen:
    """Draws the signs of one panel. Places are complex, in millimetres from its lower left corner."""

    def __init__(self, axes: Axes, panel: Panel) -> None:
        self.axes, self.panel = axes, panel

    def draw(self, before: Mapping[str, Place] | None = None) -> dict[str, Place]:
        """Everything; the offsets of the labels from their points, for the next frame of a film."""
        panel, diagram = self.panel, self.panel.diagram
        for number, stroke in enumerate(diagram.strokes):
            self._stroke(stroke, panel.travel.get(number, (0.0, 0.0)))
        for name, kind in sorted(diagram.kinds.items(), key=lambda item: item[1] == "pole"):
            if not name.startswith("_"):
                self._point(complex(*panel.on_paper(diagram.places[name])), kind)
        offsets, boxes = {}, panel.labels(before)
        for wish in panel.wishes():
            box = boxes[wish.key]
            offsets[wish.key] = box.x - wish.point[0], box.y - wish.point[1]
            sign, _, place = wish.key.partition(" ")
            drawn = diagram.strokes[int(place)].kind if sign == "stroke" else ""
            look: dict[str, Any] = {
                "color": STYLES[drawn][0] if drawn in ARROWS else INK,
                "style": "italic" if drawn else "normal",
                "fontsize": FONT,
                "ha": "center",
                "va": "center",
            }
            (x,), (y,) = self._in_units([complex(box.x, box.y)])
            self.axes.text(x, y, wish.text, zorder=8, parse_math=False, **look)
        return offsets

    # --- the elements, in millimetres ---

    def _in_units(self, places: Sequence[complex]) -> tuple[list[float], list[float]]:
        window, scale = self.panel.window, self.panel.scale
        return [window.left + p.real * scale for p in places], [
            window.bottom + p.imag * scale for p in places
        ]

    def _line(
        self, places: Sequence[complex], width: float, layer: float, color: str = INK, **more: Any
    ) -> None:
        more = {"solid_capstyle": "round", **more}
        self.axes.plot(*self._in_units(places), color=color, lw=width, zorder=layer, **more)

    def _area(self, places: Sequence[complex], fill: str, layer: float, width: float = 1.0) -> None:
        look: dict[str, Any] = {"facecolor": fill, "edgecolor": INK, "joinstyle": "round"}
        self.axes.fill(*self._in_units(places), lw=width, zorder=layer, **look)

    # --- signs ---

    def _stroke(self, stroke: Stroke, travel: tuple[float, float]) -> None:
        path = [complex(*place) for place in self.panel.path(stroke)]
        along = _direction(stroke.angle)
        match stroke.kind:
            case "line":
                self._line(path, 0.8 if self.panel.diagram.polar else 2.2, 3)
            case "body":
                self._area(path, SHADE, 2, 1.8)
            case "slot":
                self._line(path, SLOT * 72 / 25.4, 2)
                self._line(path, SLOT * 72 / 25.4 - 2.4, 2.1, PAPER)
            case "slider":  # a block on its guide, hatched on the side that is below or to the right
                self._area(_box(path[0], along, 6.4, 4.0), PAPER, 2.5)
                side = -2.0 if along.real >= -1e-9 else 2.0
                self._ground(path[0], along, side, (travel[0] - 6.0, travel[1] + 6.0))
            case "block":
                self._area(_box(path[0], along, 5.6, 3.4), PAPER, 4)
            case "trunnion":  # two jaws beside the rod, on a pin in the ground
                self._pin(path[0])
                for side in (1.7, -1.7):
                    self._area(_box(path[0] + side * 1j * along, along, 6.4, 1.3), SHADE, 3.5)
            case _:
                self._arrow(stroke.kind, *path)

    def _ground(self, at: complex, along: complex, off: float, ends: tuple[float, float]) -> None:
        """A line in that direction, ``off`` to its left, hatched on the side away from ``at``."""
        start, hatch = at + off * 1j * along, (-1.1 + math.copysign(1.1, off) * 1j) * along
        self._line([start + end * along for end in ends], 1.0, 1)
        count = max(2, round((ends[1] - ends[0]) / 1.7))
        for step in range(count):
            foot = start + (ends[0] + (step + 0.7) * (ends[1] - ends[0]) / count) * along
            self._line([foot, foot + hatch], 0.6, 1)

    def _pin(self, at: complex) -> None:
        foot = at - 3.6j
        self._area([at, foot - 2.0, foot + 2.0], PAPER, 1.5)
        self._ground(foot, 1.0, -1e-9, (-3.0, 3.0))

    def _point(self, at: complex, kind: str) -> None:
        look: dict[str, Any] = {"ms": 4.6, "mfc": PAPER, "zorder": 6}
        if self.panel.diagram.polar:
            pole = kind == "pole"
            look = {"ms": 4.4 if pole else 2.4, "mfc": PAPER if pole else INK, "zorder": 7}
        elif kind == "pin":
            self._pin(at)
        self.axes.plot(*self._in_units([at]), "o", mec=INK, mew=1.0, **look)

    def _arrow(self, kind: str, start: complex, end: complex) -> None:
        """A shaft in the stroke of its kind and a head, smaller where the arrow is short."""
        (color, dashes), length = STYLES[kind], abs(end - start)
        if length < 0.05:
            return
        along = min(2.6, 0.6 * length) * (end - start) / length
        self._line([start, end - 0.6 * along], 1.5, 5, color, ls=dashes, dash_capstyle="butt")
        head = [end, end + (-1 + 0.3j) * along, end + (-1 - 0.3j) * along]
        self.axes.fill(*self._in_units(head), color=color, lw=0, zorder=5.5)


def _direction(angle: float) -> complex:
    """The unit vector in a direction in degrees; times 1j the one to its left."""
    return cmath.rect(1.0, math.radians(angle))


def _box(middle: complex, along: complex, length: float, width: float) -> list[complex]:
    corners = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    return [middle + complex(u * length / 2, v * width / 2) * along for u, v in corners]


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

Placed = dict[Cell, dict[str, Place]]
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
    sheet, top = _Sheet(figure, plan), plan.size[1] - EDGE - TITLE / 2
    sheet.legend()
    if heading:
        sheet.text(plan.size[0] / 2, top, heading, BOLD, weight="bold")
        top -= TITLE
    placed: Placed = {}
    for column, view in enumerate(views):
        if view is None:
            continue
        if view.title:
            sheet.text(plan.middles[column], top, view.title, BOLD, weight="bold")
        for row, diagram in enumerate(view.diagrams):
            if diagram is not None:
                cell, units, travel = (row, column), plan.extents[row].scale, {}
                for number, ends in plan.travel[cell].items():  # how far along its guide a slider gets, in mm
                    along = _direction(diagram.strokes[number].angle).conjugate()
                    at = complex(*diagram.path(diagram.strokes[number])[0])
                    low, high = sorted(((complex(*end) - at) * along).real / units for end in ends)
                    travel[number] = low, high
                panel = Panel(diagram, plan.windows[cell], units, travel)
                placed[cell] = sheet.panel(panel, cell, (before or {}).get(cell))
    return placed


class _Sheet:
    """A page measured in millimetres from its lower left corner."""

    def __init__(self, figure: Figure, plan: Layout) -> None:
        self.figure, self.plan = figure, plan
        self.width, self.height = plan.size
        figure.set_size_inches(self.width / _INCH, self.height / _INCH)

    def text(self, x: float, y: float, text: str, points: float, **more: Any) -> None:
        more = {"ha": "center", "va": "center", "color": INK, **more}
        self.figure.text(x / self.width, y / self.height, text, fontsize=points, parse_math=False, **more)

    def line(self, places: Sequence[Place], width: float, color: str = INK, dashes: Any = "solid") -> None:
        xs, ys = [x / self.width for x, _ in places], [y / self.height for _, y in places]
        line = Line2D(xs, ys, lw=width, color=color, ls=dashes, transform=self.figure.transFigure)
        self.figure.add_artist(line)

    def panel(self, panel: Panel, cell: Cell, before: Mapping[str, Place] | None) -> dict[str, Place]:
        """A panel in the middle of its cell, with its caption above and its scale below."""
        room, (wide, high) = self.plan.places[cell], panel.size
        middle, foot = (room.left + room.right) / 2, room.bottom + FOOT
        left, bottom = middle - wide / 2, (foot + room.top - HEAD - high) / 2
        place = left / self.width, bottom / self.height, wide / self.width, high / self.height
        axes = self.figure.add_axes(place, label=panel.diagram.name)
        axes.set_axis_off()
        axes.set_xlim(panel.window.left, panel.window.right)
        axes.set_ylim(panel.window.bottom, panel.window.top)
        letter = chr(ord("a") + cell[0] % 26)
        self.text(middle, room.top - HEAD / 2, f"({letter}) {panel.diagram.title}", CAPTION)
        # the scale bar with its length, and the scale in words
        length, unit = bar(panel.scale), panel.diagram.unit.replace("^2", "²").replace("^3", "³")
        half, y = length / panel.scale / 2, foot - 2.0
        self.line([(middle - half, y), (middle + half, y)], 1.2)
        for end in (middle - half, middle + half):
            self.line([(end, y - 0.8), (end, y + 0.8)], 1.2)
        along, scale = (f"{readable(number)} {unit}".rstrip() for number in (length, panel.scale))
        self.text(middle, y - 2.6, f"{along}   (1 mm : {scale})", LEGEND)
        return Pen(axes, panel).draw(before)

    def legend(self) -> None:
        """The kinds of arrows side by side, at the foot of the page."""
        for number, row in enumerate(reversed(self.plan.legend)):
            y = EDGE + ROW * (number + 0.5)
            x = (self.width - sum(map(legend_width, row))) / 2
            for kind in row:
                self.line([(x, y), (x + 6.0, y)], 1.5, *STYLES[kind])
                self.text(x + 7.0, y, ARROW_NAMES[kind], LEGEND, ha="left")
                x += legend_width(kind)


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
    """An endless GIF of the pictures, in the colours of a drawing and their shades up to that of paper, which
    smooth the edges of its lines."""
    inks = [to_rgb(ink) for ink in (INK, *(color for color, _ in STYLES.values()))]
    shades = (part + (1 - part) * step / 16 for ink in inks for step in range(16) for part in ink)
    colors = Image.new("P", (1, 1))
    colors.putpalette([255, 255, 255, *(int(255 * shade) for shade in shades)])
    none = Image.Dither.NONE
    first, *others = (picture.quantize(palette=colors, dither=none) for picture in pictures)
    file = BytesIO()
    first.save(file, "GIF", save_all=True, append_images=others, duration=MILLISECONDS, loop=0)
    return file.getvalue()
