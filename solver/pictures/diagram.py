"""A figure of the sheet and the values of an answer → points and strokes in numbers; its scale and window.

Scales are the round ones of a drawing office: 1, 1.5, 2, 2.5, 3, 4, 5, 6 or 8 times a power of ten.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from rulesheets.evaluate import Undefined, value
from rulesheets.marks import PLACES, marks_of, parts
from rulesheets.model import Value
from rulesheets.syntax.nodes import Expression, Figure, names

Place = tuple[float, float]

LARGEST = 1e150
"""Coordinates have squares."""


@dataclass(frozen=True)
class Stroke:
    """What is drawn at or between points, which are named: ``angle`` is in degrees."""

    kind: str
    points: tuple[str, ...]
    label: str = ""
    angle: float = 0.0


@dataclass(frozen=True)
class Diagram:
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


@dataclass(frozen=True)
class Window:
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
    return _around(places or [(0.0, 0.0)])


def _around(places: list[Place]) -> Window:
    xs, ys = zip(*places, strict=True)
    return Window(min(xs), min(ys), max(xs), max(ys))


def scale(width: float, height: float, room: Place) -> float:
    """The smallest round number of units a millimetre that fits width and height into the room (mm).

    A diagram without extent has the scale 1.
    """
    least = max(width / room[0], height / room[1])
    if least <= 0.0 or not math.isfinite(least):
        return 1.0
    power = math.floor(math.log10(least)) - 1
    candidates = (figure * 10.0**exponent for exponent in range(power, power + 4) for figure in _ROUND)
    return next(rounded(number) for number in candidates if number >= least * (1 - 1e-12))


def bar(units_per_mm: float) -> float:
    """A round length in units for the scale bar."""
    least = _BAR * units_per_mm
    power = 10.0 ** math.floor(math.log10(least))
    return rounded(
        next(figure * power for figure in (1.0, 2.0, 5.0, 10.0) if figure * power >= least * (1 - 1e-12))
    )


def rounded(number: float) -> float:
    """Without the noise of the power of ten."""
    return float(f"{number:.6g}")
