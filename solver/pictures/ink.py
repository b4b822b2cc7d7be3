"""The signs of a diagram in matplotlib: links, joints, guides, the ground, arrows and labels.

Axes are in the units of the diagram; signs have the size that they have on paper, whatever the scale.
Colours are those of Okabe and Ito (2008), which people with any colour vision
tell apart; strokes differ too.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes

from rulesheets.marks import ARROWS
from solver.pictures.diagram import FONT, SLOT, Box, Panel, Place, Stroke

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


def shades(steps: int = 16) -> list[tuple[int, int, int]]:
    """Every colour of a drawing with its shades up to that of paper, which smooth the edges of its lines."""
    inks = [INK, *(color for color, _ in _DASHES.values())]
    return [(255, 255, 255)] + [
        (_mixed(ink, 1, step, steps), _mixed(ink, 3, step, steps), _mixed(ink, 5, step, steps))
        for ink in inks
        for step in range(steps)
    ]


def _mixed(color: str, place: int, step: int, steps: int) -> int:
    """One part of a colour ``#rrggbb``, so many steps of the way to white."""
    part = int(color[place : place + 2], 16)
    return part + (255 - part) * step // steps


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
        start = _moved(at, across, off)
        self._line([_moved(start, along, end) for end in ends], 1.0, 1)
        count = max(2, round((ends[1] - ends[0]) / 1.7))
        for step in range(count):
            foot = _moved(start, along, ends[0] + (step + 0.7) * (ends[1] - ends[0]) / count)
            self._line([foot, _moved(_moved(foot, along, -1.1), across, 1.1 * sign)], 0.6, 1)

    def _trunnion(self, at: Place, angle: float) -> None:
        """Two jaws beside the rod, on a pin in the ground."""
        _, across = _axes(angle)
        self._pin(at)
        for side in (1.7, -1.7):
            self._area(_box(_moved(at, across, side), angle, 6.4, 1.3), SHADE, 3.5)

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
        neck = _moved(end, along, -head)
        self._line([start, _moved(end, along, -0.6 * head)], 1.5, 5, color, ls=dashes, dash_capstyle="butt")
        xs, ys = self._in_units([end, _moved(neck, across, 0.3 * head), _moved(neck, across, -0.3 * head)])
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


def _moved(place: Place, along: Place, distance: float) -> Place:
    return place[0] + distance * along[0], place[1] + distance * along[1]


def _box(middle: Place, angle: float, length: float, width: float) -> list[Place]:
    along, across = _axes(angle)
    corners = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    return [_moved(_moved(middle, along, u * length / 2), across, v * width / 2) for u, v in corners]
