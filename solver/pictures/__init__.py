"""Drawings, plots and charts: the one room of matplotlib, entered by commands and the page alone.

Here is a figure at one answer: its strokes and points, and where its labels go.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

from rulesheets.checks.marks import PLACES, marks_of, parts
from rulesheets.evaluate import Undefined, value
from rulesheets.model import Value
from rulesheets.syntax.nodes import Expression, Figure, names

Place = tuple[float, float]

LARGEST = 1e150
"""Coordinates have squares."""


class Stroke(NamedTuple):
    """What is drawn at or between points, which are named: ``angle`` is in degrees."""

    kind: str
    points: tuple[str, ...]
    label: str = ""
    angle: float = 0.0


class Diagram(NamedTuple):
    """A figure with its numbers. ``places`` are the coordinates by name, ``kinds`` point, pin or pole."""

    name: str
    caption: str
    unit: str
    places: Mapping[str, Place]
    kinds: Mapping[str, str]
    strokes: tuple[Stroke, ...]

    @property
    def title(self) -> str:
        return self.caption or self.name

    @property
    def polar(self) -> bool:
        """Whether it is a velocity or acceleration diagram, drawn from a pole."""
        return "pole" in self.kinds.values()

    def path(self, stroke: Stroke) -> list[Place]:
        return [self.places[name] for name in stroke.points]


class View(NamedTuple):
    """One state: a title, and its diagrams in the order of the sheet, None where one cannot be drawn."""

    title: str
    diagrams: tuple[Diagram | None, ...]


def expressions(figure: Figure) -> Iterator[Expression]:
    """Every coordinate and direction of a figure."""
    for mark in marks_of(figure):
        yield from parts(mark)[1]


def variables(figures: Iterable[Figure]) -> tuple[str, ...]:
    """Full names of the variables that the figures need, in order of appearance."""
    found = (name for figure in figures for part in expressions(figure) for name in names(part))
    return tuple(dict.fromkeys(found))


def lacking(figure: Figure, values: Mapping[str, Value]) -> str:
    """Why a figure cannot be drawn from these values, in a few words; empty where it can."""
    missing = [name for name in variables([figure]) if name not in values]
    if missing:
        return f"{' and '.join(missing[:3])}{' …' if len(missing) > 3 else ''} has no value"
    for part in expressions(figure):
        try:
            number = value(part, values)
        except (Undefined, TypeError) as undefined:
            return f"a coordinate has no value: {undefined}"
        if not isinstance(number, float) or not abs(number) < LARGEST:
            return "a coordinate is no number that can be drawn"
    return ""


def drawable(figures: Iterable[Figure], values: Mapping[str, Value]) -> tuple[Diagram | None, ...]:
    """Every figure at these values; None for one that they do not determine."""
    return tuple(None if lacking(figure, values) else diagram(figure, values) for figure in figures)


def diagram(figure: Figure, values: Mapping[str, Value]) -> Diagram:
    """The figure at these values, which must suffice (``lacking`` tells)."""
    places: dict[str, Place] = {}
    kinds: dict[str, str] = {}
    strokes: list[Stroke] = []
    for mark in marks_of(figure):
        points, reckoned = parts(mark)
        numbers = [float(value(part, values)) for part in reckoned]
        if mark.kind in PLACES and mark.name is not None:
            places[mark.name], kinds[mark.name] = (numbers[0], numbers[1]), mark.kind
        else:
            named = tuple(point.name for point in points)
            strokes.append(Stroke(mark.kind, named, mark.name or "", *numbers))
    return Diagram(figure.name, figure.comment, figure.unit or "", places, kinds, tuple(strokes))


_ROUND = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)
_BAR = 14.0
"""Millimetres that a scale bar should at least have; a round length makes it less than twice as long."""


class Window(NamedTuple):
    """A rectangle of the plane of a diagram."""

    left: float
    bottom: float
    right: float
    top: float

    @property
    def width(self) -> float:
        return self.right - self.left

    @property
    def height(self) -> float:
        return self.top - self.bottom

    @property
    def reach(self) -> float:
        """The size of the largest coordinate."""
        return max(map(abs, (self.left, self.bottom, self.right, self.top)))

    def resized(self, width: float, height: float) -> Window:
        """The window of that size about the same middle."""
        x, y = (self.left + self.right) / 2, (self.bottom + self.top) / 2
        return Window(x - width / 2, y - height / 2, x + width / 2, y + height / 2)


def window(diagrams: Iterable[Diagram]) -> Window:
    """The least window that holds every point of the diagrams."""
    places = [place for diagram in diagrams for place in diagram.places.values()]
    xs, ys = zip(*(places or [(0.0, 0.0)]), strict=True)
    return Window(min(xs), min(ys), max(xs), max(ys))


def scale(width: float, height: float, room: Place) -> float:
    """The smallest round number of units a millimetre that fits width and height into the room (mm).

    A diagram without extent has the scale 1.
    """
    least = max(width / room[0], height / room[1])
    return _round_from(least, _ROUND) if 0.0 < least < math.inf else 1.0


def bar(units_per_mm: float) -> float:
    """A round length in units for the scale bar."""
    return _round_from(_BAR * units_per_mm, (1.0, 2.0, 5.0))


def _round_from(least: float, figures: Sequence[float]) -> float:
    """The smallest number of those figures, times a power of ten, that is not below ``least``."""
    power = 10.0 ** math.floor(math.log10(least))
    found = next(figure for figure in (*figures, 10.0) if figure * power >= least * (1 - 1e-12))
    return float(f"{found * power:.6g}")


Segment = tuple[Place, Place]

_ROUNDS = 3
_DIRECTIONS = 16
_CROSSED, _COVERED, _OUTSIDE, _FAR = 6.0, 3.0, 40.0, 0.35
"""Costs: of a mm of line under a label, of a mm² of label or symbol under it, of a mm beyond the window,
of a mm away from the point."""


class Box(NamedTuple):
    """A rectangle by its middle and half its sides."""

    x: float
    y: float
    half_width: float
    half_height: float

    def overlap(self, other: Box) -> float:
        """The common area."""
        wide = self.half_width + other.half_width - abs(self.x - other.x)
        high = self.half_height + other.half_height - abs(self.y - other.y)
        return wide * high if wide > 0.0 and high > 0.0 else 0.0

    def inside(self, segment: Segment) -> float:
        """The length of the part of a segment that lies inside (Liang and Barsky 1984)."""
        (x0, y0), (x1, y1) = segment
        dx, dy = x1 - x0, y1 - y0
        enter, leave = 0.0, 1.0
        for step, low, high in (
            (dx, self.x - self.half_width - x0, self.x + self.half_width - x0),
            (dy, self.y - self.half_height - y0, self.y + self.half_height - y0),
        ):
            if step == 0.0:
                if low > 0.0 or high < 0.0:
                    return 0.0
                continue
            near, far = sorted((low / step, high / step))
            enter, leave = max(enter, near), min(leave, far)
        return max(0.0, leave - enter) * math.hypot(dx, dy)


class Wish(NamedTuple):
    """A label that wants a place: beside a point, or beside a segment (``along``).

    ``width`` and ``height`` are those of its ``text``, ``clear`` how far from the point it has to stay.
    """

    key: str
    width: float
    height: float
    point: Place
    along: Segment | None = None
    text: str = ""
    clear: float = 1.4


def place(
    wishes: Sequence[Wish],
    segments: Sequence[Segment],
    symbols: Sequence[Box],
    size: Place,
    before: Mapping[str, Place] | None = None,
) -> dict[str, Box]:
    """A box for every wish by its key, in a window [0, width] × [0, height].

    ``before`` are offsets from the point that labels had in an earlier frame, which they keep where they can.
    """
    alone: dict[str, list[tuple[float, Box]]] = {}  # what each candidate costs by itself, ascending
    for wish in wishes:
        earlier = (before or {}).get(wish.key)
        costs = ((_cost(box, wish, segments, symbols, size, earlier), box) for box in _candidates(wish))
        alone[wish.key] = sorted(costs, key=lambda candidate: candidate[0])
    placed: dict[str, Box] = {}
    for _ in range(_ROUNDS):
        for wish in wishes:
            others = [box for key, box in placed.items() if key != wish.key]
            best = math.inf
            for cost, box in alone[wish.key]:
                if cost >= best:
                    break
                total = cost + 2 * _COVERED * sum(box.overlap(other) for other in others)
                if total < best:
                    best, placed[wish.key] = total, box
    return placed


def _candidates(wish: Wish) -> Iterator[Box]:
    half_width, half_height = wish.width / 2, wish.height / 2
    if wish.along is not None:
        (x0, y0), (x1, y1) = wish.along
        length = math.dist(*wish.along) or 1.0
        normal = (y0 - y1) / length, (x1 - x0) / length
        off = abs(normal[0]) * half_width + abs(normal[1]) * half_height + 0.7
        for part in (0.5, 0.4, 0.6, 0.3, 0.7):
            x, y = x0 + part * (x1 - x0), y0 + part * (y1 - y0)
            for side in (off, -off):
                yield Box(x + side * normal[0], y + side * normal[1], half_width, half_height)
        return
    for clear in (wish.clear, wish.clear + 1.5, wish.clear + 3.5):
        for step in range(_DIRECTIONS):
            angle = 2 * math.pi * step / _DIRECTIONS + math.pi / 4
            x = wish.point[0] + math.cos(angle) * (clear + half_width)
            y = wish.point[1] + math.sin(angle) * (clear + half_height)
            yield Box(x, y, half_width, half_height)


def _cost(
    box: Box,
    wish: Wish,
    segments: Sequence[Segment],
    symbols: Sequence[Box],
    size: Place,
    before: Place | None,
) -> float:
    """What a place costs, other labels not counted."""
    covered = sum(box.overlap(symbol) for symbol in symbols)
    crossed = sum(box.inside(segment) for segment in segments)
    outside = sum(
        max(0.0, half - middle, middle + half - limit)
        for middle, half, limit in ((box.x, box.half_width, size[0]), (box.y, box.half_height, size[1]))
    )
    away = math.hypot(box.x - wish.point[0], box.y - wish.point[1])
    cost = _COVERED * covered + _CROSSED * crossed + _OUTSIDE * outside + _FAR * away
    if before is not None:
        cost += 0.4 * math.hypot(box.x - wish.point[0] - before[0], box.y - wish.point[1] - before[1])
    return round(cost, 6)  # so that rounding decides between no two places that are alike


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
            elif stroke.kind == "slider":  # its guide as far as it is seen beside it: below, or on the right
                along = cmath.rect(1.0, math.radians(stroke.angle))
                foot = complex(*path[0]) + (-2.6j if along.real >= -1e-9 else 2.6j) * along
                path = [_place(foot + end * along) for end in (-6.0, 6.0)]
            found.extend(pairwise(path))
            if stroke.kind == "slot":
                start, end = (complex(*at) for at in path)
                off = SLOT / 2 * 1j * (end - start) / (abs(end - start) or 1.0)
                found.extend((_place(start + side), _place(end + side)) for side in (off, -off))
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
            x, y = self.path(stroke)[0]
            if stroke.kind in ("slider", "block"):
                boxes.append(Box(x, y, 3.0, 2.6))
            elif stroke.kind == "trunnion":
                boxes += [Box(x, y, 3.0, 3.4), Box(x, y - 3.6, 2.6, 2.0)]
        return boxes

    def groups(self) -> dict[str, str]:
        """Labels of points by the name of the first of those that share a place: ``o`` to ``o, g``."""
        groups: dict[str, str] = {}
        spots = {name: self.on_paper(spot) for name, spot in self.diagram.places.items()}
        for name, (x, y) in spots.items():
            if not name.startswith("_"):
                near = (n for n in groups if max(abs(spots[n][0] - x), abs(spots[n][1] - y)) < _SAME)
                first = next(near, name)
                groups[first] = f"{groups[first]}, {name}" if first in groups else name
        return groups

    def wishes(self) -> list[Wish]:
        """Every label by a key of its own, at the point or in the middle of the stroke that it names."""

        def wish(key: str, text: str, point: Place, along: Segment | None = None) -> Wish:
            return Wish(key, 0.6 * FONT * _POINT * len(text) + 0.4, 0.95 * FONT * _POINT, point, along, text)

        found = []
        for name, text in self.groups().items():
            found.append(wish(f"point {name}", text, self.on_paper(self.diagram.places[name])))
        for number, stroke in enumerate(self.diagram.strokes):
            path = self.path(stroke)
            if stroke.label and (length := math.dist(path[0], path[1])) > _LEAST:
                middle = (path[0][0] + path[1][0]) / 2, (path[0][1] + path[1][1]) / 2
                along = (path[0], path[1]) if length > _SHORT else None
                found.append(wish(f"stroke {number}", stroke.label, middle, along))
        return found

    def labels(self, before: Mapping[str, Place] | None = None) -> dict[str, Box]:
        """Where each label goes; ``before`` as in :func:`place`."""
        return place(self.wishes(), self.segments(), self.symbols(), self.size, before)


def _place(at: complex) -> Place:
    return at.real, at.imag
