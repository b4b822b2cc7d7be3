"""A figure of the sheet and the values of an answer → points and strokes in numbers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from rulesheets.evaluate import Undefined, value
from rulesheets.marks import PLACES, marks_of, parts
from rulesheets.model import Value
from rulesheets.nodes import Expression, Figure, names

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
