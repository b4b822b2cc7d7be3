"""One diagram on paper: its window, its scale, and a place of every point in millimetres."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise

from solver.pictures.diagram import Diagram, Place, Stroke, Window
from solver.pictures.labels import Box, Segment, Wish, place

MARGIN = 9.0
"""Millimetres around the points for symbols and labels."""

FONT = 8.0
_POINT = 0.3528
"""Millimetres of a typographic point."""

_SAME = 0.7
"""Millimetres within which points share one label."""


_LEAST = 1.8
"""Millimetres that a stroke has at least if it has a label."""

_SHORT = 6.0
"""Millimetres below which the label of a stroke may stand anywhere around it."""

SLOT = 3.2
"""Width of a slotted link in millimetres."""


@dataclass(frozen=True)
class Panel:
    """A diagram seen through a window (which has its margin) at ``scale`` units a millimetre.

    ``travel`` is, for the strokes of sliders by number, how far along its guide each gets: ends
    in millimetres from where it is now.
    """

    diagram: Diagram
    window: Window
    scale: float
    travel: Mapping[int, tuple[float, float]] = field(default_factory=dict)

    @property
    def size(self) -> Place:
        """Width and height in millimetres."""
        return self.window.width / self.scale, self.window.height / self.scale

    def on_paper(self, place: Place) -> Place:
        """Millimetres from the lower left corner."""
        return (place[0] - self.window.left) / self.scale, (place[1] - self.window.bottom) / self.scale

    def path(self, stroke: Stroke) -> list[Place]:
        return [self.on_paper(place) for place in self.diagram.path(stroke)]

    def segments(self) -> list[Segment]:
        """Every straight piece of a link, an arrow or a guide."""
        found: list[Segment] = []
        for stroke in self.diagram.strokes:
            path = self.path(stroke)
            if stroke.kind == "body":
                path = [*path, path[0]]
            elif stroke.kind == "slider":
                path = guide(path[0], stroke.angle)
            found.extend(pairwise(path))
            if stroke.kind == "slot":
                found.extend(_edges(path[0], path[1], SLOT / 2))
        return found

    def symbols(self) -> list[Box]:
        """What joints, guides and the ground cover."""
        boxes = []
        for name, kind in self.diagram.kinds.items():
            x, y = self.on_paper(self.diagram.places[name])
            boxes.append(Box(x, y, 0.9, 0.9))
            if kind == "pin":
                boxes.append(Box(x, y - 2.6, 2.6, 2.0))
        for stroke in self.diagram.strokes:
            if stroke.kind in ("slider", "block", "trunnion"):
                x, y = self.path(stroke)[0]
                boxes.append(Box(x, y, 3.0, 3.4 if stroke.kind == "trunnion" else 2.6))
                if stroke.kind == "trunnion":
                    boxes.append(Box(x, y - 3.6, 2.6, 2.0))
        return boxes

    def groups(self) -> dict[str, str]:
        """Labels of points by the name of the first of those that share a place: ``o`` to ``o, g``."""
        groups: dict[str, list[str]] = {}
        written = {name: spot for name, spot in self.diagram.places.items() if not name.startswith("_")}
        for name, spot in written.items():
            x, y = self.on_paper(spot)
            for first in groups:
                other = self.on_paper(self.diagram.places[first])
                if abs(other[0] - x) < _SAME and abs(other[1] - y) < _SAME:
                    groups[first].append(name)
                    break
            else:
                groups[name] = [name]
        return {first: ", ".join(together) for first, together in groups.items()}

    def texts(self) -> dict[str, str]:
        """Every label by a key of its own."""
        labels = {
            f"stroke {number}": stroke.label
            for number, stroke in enumerate(self.diagram.strokes)
            if stroke.label and _length(self.path(stroke)) > _LEAST
        }
        return {**{f"point {name}": text for name, text in self.groups().items()}, **labels}

    def labels(self, before: Mapping[str, Place] | None = None) -> dict[str, Box]:
        """Where each label goes; ``before`` as in :func:`labels.place`."""
        wishes = [self._wish(key, text) for key, text in self.texts().items()]
        return place(wishes, self.segments(), self.symbols(), self.size, before)

    def anchor(self, key: str) -> Place:
        """The point that a label belongs to: of a stroke its middle."""
        kind, _, name = key.partition(" ")
        if kind == "point":
            return self.on_paper(self.diagram.places[name])
        path = self.path(self.diagram.strokes[int(name)])
        return (path[0][0] + path[1][0]) / 2, (path[0][1] + path[1][1]) / 2

    def _wish(self, key: str, text: str) -> Wish:
        width, height = 0.6 * FONT * _POINT * len(text) + 0.4, 0.95 * FONT * _POINT
        kind, _, name = key.partition(" ")
        if kind == "point":
            return Wish(key, width, height, self.anchor(key))
        path = self.path(self.diagram.strokes[int(name)])
        along = (path[0], path[1]) if _length(path) > _SHORT else None
        return Wish(key, width, height, self.anchor(key), along)


def guide(at: Place, angle: float) -> list[Place]:
    """The guide of a slider as far as it is seen beside it: below, or on the right."""
    along = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    side = -2.6 if along[0] >= -1e-9 else 2.6
    foot = at[0] - side * along[1], at[1] + side * along[0]
    return [(foot[0] + end * along[0], foot[1] + end * along[1]) for end in (-6.0, 6.0)]


def _edges(start: Place, end: Place, off: float) -> list[Segment]:
    """Lines beside a segment, at that distance on either side."""
    length = math.dist(start, end) or 1.0
    x, y = off * (start[1] - end[1]) / length, off * (end[0] - start[0]) / length
    return [
        ((start[0] + side * x, start[1] + side * y), (end[0] + side * x, end[1] + side * y))
        for side in (1, -1)
    ]


def _length(path: list[Place]) -> float:
    """The length of the first piece of a stroke."""
    return math.dist(path[0], path[1])
