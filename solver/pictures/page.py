"""Figures in matplotlib: the layout of panels, the signs of a diagram, pages and films.

Axes are in the units of the diagram; signs have their size on paper, whatever the scale. Colours
are those of Okabe and Ito (2008), which people with any colour vision can distinguish; strokes
differ too.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from io import BytesIO
from itertools import accumulate, pairwise
from typing import Any, NamedTuple, TypeAlias

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.transforms import Bbox
from PIL import Image

from rulesheets.checks import ARROWS
from rulesheets.inputs import readable
from solver.pictures import (
    FONT,
    Diagram,
    LabelRequest,
    Place,
    Stroke,
    View,
    bar,
    place,
    scale,
)

GAP, HEAD, FOOT, TITLE, EDGE, ROW, KIND = 5.0, 6.0, 8.0, 7.0, 4.0, 4.5, 26.0
"""Millimetres between panels, above and below one, above a column, around the page; of a row and a
column of the legend."""

MARGIN = 9.0
"""Millimetres around the points for symbols and labels."""

CAPTION, BOLD, LEGEND = 8.5, 9.0, 7.0
"""Sizes of captions, of titles and of texts below a panel, in points."""

_ROOM = (58.0, 50.0)
"""Millimetres for the points of a diagram: three fit A4 across, twice three upright."""

_FINEST = 1e-9
"""The least extent of a figure that is seen as one, relative to the coordinates."""

_NARROW = 48.0
"""Millimetres that a panel has at least, for its scale."""

_ACROSS = 3
"""Figures that stand in one row at most."""

Cell: TypeAlias = tuple[int, int]
"""A figure (row) of a view (column)."""


class Room(NamedTuple):
    """The rectangle of the page for a figure of a view, caption and scale included, in millimetres.

    It shows a ``window`` at ``scale`` units per millimetre. ``travel`` has the two farthest places
    of every slider, by the number of its stroke.
    """

    place: Bbox
    window: Bbox
    scale: float
    travel: Mapping[int, tuple[Place, Place]]


class Layout(NamedTuple):
    """A page of rooms by cell, in millimetres from its lower left corner.

    ``middles`` are those of the views, ``legend`` has the kinds of arrows to be explained.
    """

    size: Place
    rooms: Mapping[Cell, Room]
    middles: tuple[float, ...]
    legend: tuple[str, ...]


def layout(frames: Sequence[Sequence[View | None]], *, headed: bool = False) -> Layout:
    """The layout that fits every view of ``frames``, a single one for a still picture.

    Above the panels is room for the titles of views, and for a heading if ``headed``.
    """
    count = max(map(len, frames))
    shown = [[v for views in frames if k < len(views) and (v := views[k])] for k in range(count)]
    views = [view for column in shown for view in column]
    rows, seen = range(len(views[0].diagrams)), []
    for row in rows:
        seen.append([[d for view in column if (d := view.diagrams[row])] for column in shown])
    extents = list(map(_extent, seen))
    # figures below each other where there are several views; the figures of one view fill rows
    wide = len(rows) if len(rows) <= _ACROSS else -(-len(rows) // 2)
    every = ((row, k) for row in rows for k in range(count))
    cells = {cell: cell if count > 1 else divmod(cell[0], wide) for cell in every}
    widths, heights = dict[int, float](), dict[int, float]()
    for (row, column), (y, x) in cells.items():
        units, width, height = extents[row]
        titles = [text_width(view.title, BOLD) for view in shown[column] if count > 1]
        widths[x] = max(widths.get(x, 0.0), width / units, *titles)
        heights[y] = max(heights.get(y, 0.0), height / units + HEAD + FOOT)
    lefts, tops = (
        list(accumulate(sizes.values(), lambda at, size: at + size + GAP, initial=EDGE))
        for sizes in (widths, heights)
    )
    across = lefts[-1] - GAP + EDGE
    legend = _kinds(views)
    above = TITLE * (any(view.title for view in views) + headed)
    up = tops[-1] - GAP + EDGE + above + ROW * -(-len(legend) // _beside(across))
    rooms = {}
    for (row, column), (y, x) in cells.items():
        units, *size = extents[row]
        top, diagrams = up - above - tops[y], seen[row][column]
        box = Bbox.from_bounds(lefts[x], top - heights[y], widths[x], heights[y])
        around = _resized(window(diagrams), *size)
        rooms[row, column] = Room(box, around, units, _travel(diagrams))
    middles = [left + width / 2 for left, width in zip(lefts, widths.values(), strict=False)]
    return Layout((across, up), rooms, tuple(middles) if count > 1 else (across / 2,), legend)


def text_width(text: str, points: float) -> float:
    """The approximate width of a text in millimetres, in matplotlib's own font."""
    return 0.215 * points * len(text)


def window(diagrams: Iterable[Diagram]) -> Bbox:
    """The least window that holds every point of the diagrams."""
    places = [place for diagram in diagrams for place in diagram.places.values()] or [(0.0, 0.0)]
    return Bbox([np.min(places, axis=0), np.max(places, axis=0)])


def _resized(box: Bbox, width: float, height: float) -> Bbox:
    """The box of that size with the same middle."""
    x, y = (box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2
    return Bbox([(x - width / 2, y - height / 2), (x + width / 2, y + height / 2)])


def _extent(seen: Sequence[Sequence[Diagram]]) -> tuple[float, float, float]:
    """The scale and the size of the window, in units, of one figure of the sheet in all views."""
    windows = [window(diagrams) for diagrams in seen]
    width, height = max(w.width for w in windows), max(w.height for w in windows)
    reach = float(np.abs(windows).max())
    least = reach * (_FINEST if max(width, height) > 0.0 else 1.0)
    units = scale(max(width, least), height, _ROOM)
    captions = {f"(a) {diagram.title}" for diagrams in seen for diagram in diagrams}
    narrow = max([_NARROW, *(text_width(caption, CAPTION) for caption in captions)])
    return units, max(width + 2 * MARGIN * units, narrow * units), height + 2 * MARGIN * units


def _travel(seen: Sequence[Diagram]) -> dict[int, tuple[Place, Place]]:
    found: dict[int, tuple[Place, Place]] = {}
    for diagram in seen:
        for number, stroke in enumerate(diagram.strokes):
            if stroke.kind == "slider":
                place = diagram.path(stroke)[0]
                low, high = found.get(number, (place, place))
                found[number] = min(low, place), max(high, place)
    return found


def _kinds(views: Sequence[View]) -> tuple[str, ...]:
    """The kinds of arrows in the views, if there are several."""
    diagrams = (diagram for view in views for diagram in view.diagrams if diagram)
    drawn = {stroke.kind for diagram in diagrams for stroke in diagram.strokes}
    kinds = tuple(kind for kind in ARROWS if kind in drawn)
    return kinds if len(kinds) > 1 else ()


INK, SHADE, PAPER = "#222222", "#e4e4e4", "#ffffff"
STYLES: dict[str, tuple[str, str, Any]] = {
    "vector": ("absolute", "#0072b2", "solid"),
    "normal": ("normal", "#d55e00", (0, (4.0, 1.4))),
    "tangential": ("tangential", "#007a5a", (0, (7.0, 1.4, 1.4, 1.4))),
    "sliding": ("sliding", "#a0507c", (0, (1.4, 1.2))),
    "coriolis": ("Coriolis", "#6a3d9a", (0, (4.0, 1.2, 1.2, 1.2, 1.2, 1.2))),
}
"""Name, colour and stroke of each kind of arrow."""

SLOT = 3.2
"""Width of a slotted link in millimetres."""

_SAME = 0.7
"""Millimetres within which points share one label."""

_LEAST, _SHORT = 1.8, 6.0
"""Millimetres of a stroke with a label at least, and of one labelled anywhere around."""


class Pen:
    """Draws the signs of one panel. Places are complex, in millimetres from its lower left corner.

    Labels keep clear of the ``lines`` and of the ``joints`` that are drawn.
    """

    def __init__(self, axes: Axes, diagram: Diagram, room: Room) -> None:
        self.axes, self.diagram, self.room = axes, diagram, room
        corner = complex(*room.window.p0)
        places = diagram.places.items()
        self.spots = {name: (complex(*at) - corner) / room.scale for name, at in places}
        self.lines: list[tuple[complex, complex]] = []
        self.joints: list[tuple[float, float, float, float]] = []

    def draw(self, before: Mapping[str, Place]) -> dict[str, Place]:
        """Everything; the offsets of the labels from their points, for the next frame of a film."""
        diagram, (_, window, scale, _) = self.diagram, self.room
        for number, stroke in enumerate(diagram.strokes):
            self._stroke(number, stroke)
        for name, kind in sorted(diagram.kinds.items(), key=lambda item: item[1] == "pole"):
            if not name.startswith("_"):
                self._point(self.spots[name], kind)
        lines = np.array(self.lines, complex).view(float).reshape(-1, 2, 2)
        joints = np.array(self.joints).reshape(-1, 4)
        size = window.width / scale, window.height / scale
        offsets, label_requests = {}, self.label_requests()
        for key, box in place(label_requests, lines, joints, size, before).items():
            request, (sign, _, number_of) = label_requests[key], key.partition(" ")
            drawn = diagram.strokes[int(number_of)].kind if sign == "stroke" else ""
            offsets[key] = float(box[0] - request.point[0]), float(box[1] - request.point[1])
            (x,), (y,) = self._in_units([complex(*box[:2])])
            color, style = STYLES.get(drawn, ("", INK, ""))[1], "italic" if drawn else "normal"
            look: dict[str, Any] = {"color": color, "style": style, "fontsize": FONT}
            look |= {"ha": "center", "va": "center", "zorder": 8, "parse_math": False}
            self.axes.text(x, y, request.text, **look)
        return offsets

    def label_requests(self) -> dict[str, LabelRequest]:
        """The labels, at points, shared by points at the same place, and at strokes."""
        groups: dict[str, list[str]] = {}
        for name, at in self.spots.items():
            if not name.startswith("_"):
                near = (n for n in groups if abs(self.spots[n] - at) < _SAME)
                groups.setdefault(next(near, name), []).append(name)
        found = {}
        for name, alike in groups.items():
            found[f"point {name}"] = LabelRequest(", ".join(alike), _pair(self.spots[name]))
        for number, stroke in enumerate(self.diagram.strokes):
            start, end = (self.spots[name] for name in (stroke.points * 2)[:2])
            if stroke.label and abs(end - start) > _LEAST:
                along = (_pair(start), _pair(end)) if abs(end - start) > _SHORT else None
                middle = _pair((start + end) / 2)
                found[f"stroke {number}"] = LabelRequest(stroke.label, middle, along)
        return found

    # --- the elements, in millimetres ---

    def _in_units(self, places: Sequence[complex]) -> tuple[list[float], list[float]]:
        (left, bottom), scale = self.room.window.p0, self.room.scale
        xs, ys = ([left + at.real * scale for at in places], [at.imag for at in places])
        return xs, [bottom + y * scale for y in ys]

    def _line(
        self, places: Sequence[complex], width: float, layer: float, color: str = INK, **more: Any
    ) -> None:
        self.lines += pairwise(places)
        more = {"solid_capstyle": "round", **more}
        self.axes.plot(*self._in_units(places), color=color, lw=width, zorder=layer, **more)

    def _area(self, places: Sequence[complex], fill: str, layer: float, width: float = 1.0) -> None:
        self.lines += pairwise([*places, places[0]])
        look: dict[str, Any] = {"facecolor": fill, "edgecolor": INK, "joinstyle": "round"}
        self.axes.fill(*self._in_units(places), lw=width, zorder=layer, **look)

    # --- signs ---

    def _stroke(self, number: int, stroke: Stroke) -> None:
        path = [self.spots[name] for name in stroke.points]
        along = cmath.rect(1.0, math.radians(stroke.angle))
        # a block on its guide, hatched on the side that is below or to the right
        match stroke.kind:
            case "line":
                self._line(path, 0.8 if self.diagram.polar else 2.2, 3)
            case "body":
                self._area(path, SHADE, 2, 1.8)
            case "slot":
                self._line(path, SLOT * 72 / 25.4, 2)
                self._line(path, SLOT * 72 / 25.4 - 2.4, 2.1, PAPER)
                length, angle = cmath.polar(path[1] - path[0])
                edge = _box((path[0] + path[1]) / 2, cmath.rect(1.0, angle), length + SLOT, SLOT)
                self.lines += pairwise([*edge, edge[0]])
            case "slider":
                self._area(_box(path[0], along, 6.4, 4.0), PAPER, 2.5)
                side = -2.0 if along.real >= -1e-9 else 2.0
                here = complex(*self.diagram.path(stroke)[0])
                ends = ((complex(*end) - here) / along for end in self.room.travel[number])
                low, high = sorted(end.real / self.room.scale for end in ends)
                self._ground(path[0], along, side, (low - 6.0, high + 6.0))
            case "block":
                self._area(_box(path[0], along, 5.6, 3.4), PAPER, 4)
            case "trunnion":  # two jaws beside the rod, on a pin in the ground
                self._pin(path[0])
                for off in (1.7, -1.7):
                    self._area(_box(path[0] + off * 1j * along, along, 6.4, 1.3), SHADE, 3.5)
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
        if self.diagram.polar:
            pole = kind == "pole"
            look = {"ms": 4.4 if pole else 2.4, "mfc": PAPER if pole else INK, "zorder": 7}
        elif kind == "pin":
            self._pin(at)
        self.joints.append((at.real, at.imag, 0.9, 0.9))
        self.axes.plot(*self._in_units([at]), "o", mec=INK, mew=1.0, **look)

    def _arrow(self, kind: str, start: complex, end: complex) -> None:
        """A shaft in the stroke of its kind and a head, smaller where the arrow is short."""
        (_, color, dashes), length = STYLES[kind], abs(end - start)
        if length < 0.05:
            return
        along = min(2.6, 0.6 * length) * (end - start) / length
        self._line([start, end - 0.6 * along], 1.5, 5, color, ls=dashes, dash_capstyle="butt")
        head = [end, end + (-1 + 0.3j) * along, end + (-1 - 0.3j) * along]
        self.axes.fill(*self._in_units(head), color=color, lw=0, zorder=5.5)


def _pair(at: complex) -> Place:
    return at.real, at.imag


def _box(middle: complex, along: complex, length: float, width: float) -> list[complex]:
    corners = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    return [middle + complex(u * length / 2, v * width / 2) * along for u, v in corners]


_DATES = {"png": "Software", "svg": "Date", "pdf": "CreationDate"}
"""Metadata that would make two files of one picture differ."""


def encode(figure: Figure, form: str, dpi: float) -> bytes:
    """The page as ``png``, ``svg`` or ``pdf``: the same bytes for the same picture."""
    file = BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "backsolve"}):
        figure.savefig(file, format=form, dpi=dpi, metadata={_DATES[form]: None})
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
    """Draw the views into an empty figure, set its size, and return the places of the labels.

    ``before`` are those of an earlier frame of a film.
    """
    sheet, top = _Sheet(figure, plan), plan.size[1] - EDGE - TITLE / 2
    sheet.legend()
    if heading:
        sheet.text(plan.size[0] / 2, top, heading, BOLD, weight="bold")
        top -= TITLE
    placed: Placed = {}
    for column, view in enumerate(views):
        if view and view.title:
            sheet.text(plan.middles[column], top, view.title, BOLD, weight="bold")
        for row, diagram in enumerate(view.diagrams if view else ()):
            if diagram is not None:
                axes = sheet.panel(diagram, row, plan.rooms[row, column])
                pen = Pen(axes, diagram, plan.rooms[row, column])
                placed[row, column] = pen.draw((before or {}).get((row, column), {}))
    return placed


class _Sheet:
    """A page measured in millimetres from its lower left corner."""

    def __init__(self, figure: Figure, plan: Layout) -> None:
        self.figure, self.plan = figure, plan
        self.width, self.height = plan.size
        figure.set_size_inches(self.width / _INCH, self.height / _INCH)

    def text(self, x: float, y: float, text: str, points: float, **more: Any) -> None:
        look = {"ha": "center", "va": "center", "color": INK, "parse_math": False, **more}
        self.figure.text(x / self.width, y / self.height, text, fontsize=points, **look)

    def panel(self, diagram: Diagram, row: int, room: Room) -> Axes:
        """The axes of a diagram in the middle of its room, between its caption and its scale."""
        wide, high = room.window.width / room.scale, room.window.height / room.scale
        middle, foot = (room.place.x0 + room.place.x1) / 2, room.place.y0 + FOOT
        left, bottom = middle - wide / 2, (foot + room.place.y1 - HEAD - high) / 2
        place = left / self.width, bottom / self.height, wide / self.width, high / self.height
        axes = self.figure.add_axes(place, label=diagram.name)
        axes.set_axis_off()
        axes.set_xlim(room.window.intervalx)
        axes.set_ylim(room.window.intervaly)
        letter = chr(ord("a") + row % 26)
        self.text(middle, room.place.y1 - HEAD / 2, f"({letter}) {diagram.title}", CAPTION)
        # the scale bar with its length, and the scale in words
        length, unit = bar(room.scale), diagram.unit.replace("^2", "²").replace("^3", "³")
        half, y = length / room.scale / 2, foot - 2.0
        xs, ys = [(middle - half) / self.width, (middle + half) / self.width], [y / self.height] * 2
        look: dict[str, Any] = {"lw": 1.2, "marker": "|", "ms": 4.5, "mew": 1.2, "color": INK}
        self.figure.add_artist(Line2D(xs, ys, transform=self.figure.transFigure, **look))
        along, scale = (f"{readable(number)} {unit}".rstrip() for number in (length, room.scale))
        self.text(middle, y - 2.6, f"{along}   (1 mm : {scale})", LEGEND)
        return axes

    def legend(self) -> None:
        """The kinds of arrows side by side, at the foot of the page."""
        kinds = (STYLES[kind] for kind in self.plan.legend)
        lines = [Line2D([], [], lw=1.5, color=c, ls=s, label=name) for name, c, s in kinds]
        if lines:
            place = (0.5, EDGE / self.height)
            look: dict[str, Any] = {"loc": "lower center", "bbox_to_anchor": place}
            look |= {"fontsize": LEGEND, "labelcolor": INK, "handlelength": 2.5}
            look |= {"frameon": False, "borderpad": 0.0, "borderaxespad": 0.0}
            self.figure.legend(handles=lines, ncols=_beside(self.width), **look)


def _beside(width: float) -> int:
    """How many kinds of arrows stand beside each other on a page of this width."""
    return max(1, int((width - 2 * EDGE) / KIND))


MILLISECONDS = 60
"""How long a frame is shown."""


Frame: TypeAlias = tuple[str, Sequence[View | None]]
"""One instant: its name, and its views, None for one without an answer."""


def images(film: Sequence[Frame], dpi: float) -> Iterator[Image.Image]:
    """The frames as pictures of one size. Labels keep their side of a point if possible."""
    plan = layout([views for _, views in film], headed=True)
    before: Placed | None = None
    for heading, views in film:
        figure = Figure(dpi=dpi)
        before = draw_page(figure, views, plan, heading, before)
        pixels = BytesIO()
        figure.savefig(pixels, format="rgba", dpi=dpi)
        size = figure.canvas.get_width_height()
        yield Image.frombytes("RGBA", size, pixels.getvalue()).convert("RGB")


def gif(pictures: Iterable[Image.Image]) -> bytes:
    """An endless GIF of the pictures, in the colours of a drawing and their shades up to that of
    paper, which smooth the edges of its lines."""
    inks = [to_rgb(ink) for ink in (INK, *(color for _, color, _ in STYLES.values()))]
    shades = (part + (1 - part) * step / 16 for ink in inks for step in range(16) for part in ink)
    colors = Image.new("P", (1, 1))
    colors.putpalette([255, 255, 255, *(int(255 * shade) for shade in shades)])
    none = Image.Dither.NONE
    first, *others = (picture.quantize(palette=colors, dither=none) for picture in pictures)
    file = BytesIO()
    first.save(file, "GIF", save_all=True, append_images=others, duration=MILLISECONDS, loop=0)
    return file.getvalue()
