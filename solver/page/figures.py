"""The figures of a sheet at an answer, as a browser draws them, and the points of them that can be dragged.

An input *drives* a figure if moving it alone keeps every link rigid, every pin in place and every
slider on its guide: the angle of a crank does, its length does not. A point that moves with a driver
is a handle. It stands for the variable that leads to it by the fewest rules, which becomes the
input when the point is dragged.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from math import cos, dist, radians, sin
from typing import Any, NamedTuple

import numpy as np

from rulesheets.checks.marks import PLACES, marks_of, parts
from rulesheets.model import Model, Value
from rulesheets.syntax.nodes import Figure
from solver.path.cases import outcomes
from solver.path.planner import planner
from solver.path.steps import equations_of
from solver.pictures.diagram import Diagram, Place, drawable, variables
from solver.result import Result


def outline(figure: Figure) -> dict[str, Any]:
    """What stays the same at every answer: names and kinds of points, strokes between them."""
    places, strokes = [], []
    for mark in marks_of(figure):
        named, _ = parts(mark)
        if mark.kind in PLACES:
            places.append({"name": mark.name, "kind": mark.kind})
        else:
            strokes.append(
                {"kind": mark.kind, "points": [node.name for node in named], "label": mark.name or ""}
            )
    return {
        "name": figure.name,
        "title": figure.comment or figure.name,
        "unit": figure.unit or "",
        "polar": any(place["kind"] == "pole" for place in places),
        "places": places,
        "strokes": strokes,
    }


def diagrams(model: Model, values: Mapping[str, Value]) -> tuple[Diagram | None, ...]:
    """Every figure at these values; None for one that they do not determine."""
    return drawable(model.figures, values)


def geometry(model: Model, values: Mapping[str, Value]) -> list[dict[str, Any] | None]:
    """Coordinates of points and directions of strokes of every figure, in the order of its outline."""
    return [
        None
        if one is None
        else {
            "places": [list(place) for place in one.places.values()],
            "angles": [stroke.angle for stroke in one.strokes],
        }
        for one in diagrams(model, values)
    ]


def needed(model: Model, *, polar: bool = True) -> tuple[str, ...]:
    """Full names of the variables that the figures are drawn from; ``polar`` ones left out where False."""
    return variables(figure for figure in model.figures if polar or not outline(figure)["polar"])


def coordinates(figure: Figure, point: str) -> tuple[str, ...]:
    """Names of the variables in the coordinates of one point."""
    alone = tuple(mark for mark in marks_of(figure) if mark.name == point)
    return variables([Figure(figure.name, figure.unit, alone)]) if alone else ()


def rectangle(places: Sequence[Place], polar: bool) -> list[float]:
    """Left, bottom, right and top of places; of a ``polar`` figure all but the most distant few.

    Velocities and accelerations may grow without bound.
    """
    share = 3.0 if polar else 0.0
    low, high = np.percentile(np.array(places), [share, 100.0 - share], axis=0)
    return [*low.tolist(), *high.tolist()]


STEP = 1e-6
"""Relative size of the virtual displacement."""

RIGID = 1e-3
"""Share of the motion by which a length may change: its second order in ``STEP``, and rounding."""

_RIGID_STROKES = ("line", "slot", "body")


class Handle(NamedTuple):
    """A point of a figure, the input that moves it, and the variable that it stands for."""

    figure: int
    point: str
    driver: str
    variable: str


def handles(result: Result, answer: int = 0) -> tuple[Handle, ...]:
    """Every point of the figures that can be dragged at an answer."""
    if not result.solutions or not result.model.figures:
        return ()
    return tuple(_Motion(result, answer).handles())


class _Motion:
    def __init__(self, result: Result, answer: int) -> None:
        self.result, self.model = result, result.model
        self.values = dict(result.solutions[answer])
        self.inputs = [name for name, value in result.inputs.items() if isinstance(value, float)]
        names = tuple(dict.fromkeys((*needed(self.model), *_posted_numbers(self.model, self.values))))
        moving = [name for name in names if name not in result.inputs]
        self.slopes = result.sensitivity(moving, self.inputs, answer)
        self.before = diagrams(self.model, self.values)
        self.decided = outcomes(self.model, self.values, result.inputs)

    def handles(self) -> Iterator[Handle]:
        taken: set[tuple[int, str]] = set()
        for driver in self.inputs:
            after = self._displaced(driver)
            if after is None or not _drives(self.before, after):
                continue
            for number, point in self._moved(after):
                if (number, point) not in taken:
                    taken.add((number, point))
                    figure = self.model.figures[number]
                    yield Handle(number, point, driver, self._variable(figure, point, driver))

    def _displaced(self, driver: str) -> Sequence[Diagram | None] | None:
        """The figures after a small step of one input, to first order; None where a slope is missing."""
        start = self.values[driver]
        assert isinstance(start, float)
        step = STEP * max(abs(start), 1.0)
        values: dict[str, Value] = {**self.values, driver: start + step}
        for name in self.slopes.outputs:
            slope, value = self.slopes[name, driver], self.values.get(name)
            if slope is None and name in needed(self.model):
                return None
            if slope is not None and isinstance(value, float):
                values[name] = value + step * slope
        return diagrams(self.model, values)

    def _moved(self, after: Sequence[Diagram | None]) -> Iterator[tuple[int, str]]:
        for number, (here, there) in enumerate(zip(self.before, after, strict=True)):
            if here is None or there is None or here.polar:
                continue
            most = _motion(here, there)
            for point, kind in here.kinds.items():
                if kind == "point" and dist(here.places[point], there.places[point]) > 1e-2 * most:
                    yield number, point

    def _variable(self, figure: Figure, point: str, driver: str) -> str:
        """The variable that a point stands for: of those beside its coordinates, the one nearest by rules."""
        wanted = coordinates(figure, point)
        near = {n for e in self.model.equations if set(e.names) & set(wanted) for n in e.names} | {*wanted}
        names = [driver, *(n for n in self.slopes.outputs if self.slopes[n, driver] and n in near)]
        lengths = {n: self._length(n, driver, wanted) for n in names if self.model.variables[n].posted}
        reached = {n: length for n, length in lengths.items() if length is not None}
        return min(reached, key=lambda n: (not self._declared(n), reached[n])) if reached else driver

    def _declared(self, name: str) -> bool:
        """Whether the sheet says something of a variable: its unit, its comment or its value."""
        variable = self.model.variables[name]
        return bool(variable.unit or variable.comment) or variable.value is not None

    def _length(self, name: str, driver: str, wanted: tuple[str, ...]) -> int | None:
        """The rules that lead from a variable as the input to the coordinates; None where they do not.

        Those of blocks count squared, and steps with several branches as often.
        """
        known = frozenset({*self.result.inputs} - {driver} | {name})
        asked = frozenset(wanted) - {name}
        path = planner(self.model).path(known, self.decided, want=asked)
        if asked & set(path.undetermined):
            return None
        return sum(len(equations_of(step)) ** 2 * getattr(step, "branches", 1) for step in path.steps)


def _posted_numbers(model: Model, values: Mapping[str, Value]) -> list[str]:
    return [n for n, v in model.variables.items() if v.posted and isinstance(values.get(n), float)]


def _drives(before: Sequence[Diagram | None], after: Sequence[Diagram | None]) -> bool:
    pairs = [(a, b) for a, b in zip(before, after, strict=True) if a and b and not a.polar]
    return any(_motion(a, b) > 0.0 for a, b in pairs) and all(_rigid(a, b) for a, b in pairs)


def _motion(before: Diagram, after: Diagram) -> float:
    """How far the point goes that goes farthest."""
    return max((dist(before.places[n], after.places[n]) for n in before.places), default=0.0)


def _rigid(before: Diagram, after: Diagram) -> bool:
    slack = RIGID * _motion(before, after)
    return all(change <= slack for change in _changes(before, after))


def _changes(before: Diagram, after: Diagram) -> Iterator[float]:
    """What rigid links, pins and fixed guides keep at 0."""
    for name, kind in before.kinds.items():
        if kind == "pin":
            yield dist(before.places[name], after.places[name])
    for here in before.strokes:
        if here.kind in _RIGID_STROKES:
            for a, b in combinations(here.points, 2):
                yield abs(dist(before.places[a], before.places[b]) - dist(after.places[a], after.places[b]))
        elif here.kind == "slider":
            (x, y), (u, v) = before.places[here.points[0]], after.places[here.points[0]]
            along = radians(here.angle)
            yield abs((v - y) * cos(along) - (u - x) * sin(along))
        elif here.kind == "trunnion":
            yield dist(before.places[here.points[0]], after.places[here.points[0]])
