"""Drawings, plots and charts: the only room that imports matplotlib, used by commands and the page.

This module has a figure at one answer: its strokes and points, its scale, and the places of its
labels.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.checks import PLACES, marks_of, parts
from rulesheets.diagnosis import listed, refusal
from rulesheets.evaluate import Undefined, value
from rulesheets.evaluate.number import rounded
from rulesheets.model import Values
from rulesheets.syntax.nodes import Expression, Figure, names
from solver.files import require_extra

Place = tuple[float, float]

LARGEST = 1e150
"""Coordinates have squares."""


FALSE = 1e-6
"""A relative error beyond which an answer is false (or a thousand tolerances)."""


class Measurement(NamedTuple):
    """One method in one case.

    ``error`` is the largest relative one over the wanted variables, nan without an answer;
    ``status`` is solved, false, or what was reported instead. ``at`` is the value of the varied
    input; ``radius`` the largest relative error that a proof leaves possible.
    """

    method: str
    tolerance: float | None
    at: float | None
    status: str
    error: float
    iterations: int | None
    seconds: float
    radius: float | None = None
    family: str = ""


class Stroke(NamedTuple):
    """A mark at or between named points: ``angle`` is in degrees."""

    kind: str
    points: tuple[str, ...]
    label: str = ""
    angle: float = 0.0


class Diagram(NamedTuple):
    """A figure with its numbers: coordinates and ``kinds`` (point, pin, pole) by name."""

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
    """One state: a title, and its diagrams in order, None for one that cannot be drawn."""

    title: str
    diagrams: tuple[Diagram | None, ...]


def variables(figures: Iterable[Figure]) -> tuple[str, ...]:
    """Full names of the variables that the figures need, in order of appearance."""
    marks = (mark for figure in figures for mark in marks_of(figure))
    reckoned = (part for mark in marks for part in parts(mark)[1])
    return tuple(dict.fromkeys(names(*reckoned)))


def diagram(figure: Figure, values: Values) -> Diagram:
    """The figure at these values. Raises ValueError with a short reason if it lacks one."""
    missing = [name for name in variables([figure]) if name not in values]
    if missing:
        some = " and ".join(missing[:3]) + " …" * (len(missing) > 3)
        raise ValueError(f"{some} has no value")

    def number(part: Expression) -> float:
        try:
            found = value(part, values)
        except (Undefined, TypeError) as undefined:
            raise ValueError(f"a coordinate has no value: {undefined}") from None
        if not isinstance(found, float) or not abs(found) < LARGEST:
            raise ValueError("a coordinate is no number that can be drawn")
        return found

    places: dict[str, Place] = {}
    kinds: dict[str, str] = {}
    strokes: list[Stroke] = []
    for mark in marks_of(figure):
        points, reckoned = parts(mark)
        numbers = list(map(number, reckoned))
        if mark.kind in PLACES and mark.name is not None:
            places[mark.name], kinds[mark.name] = (numbers[0], numbers[1]), mark.kind
        else:
            named = tuple(point.name for point in points)
            strokes.append(Stroke(mark.kind, named, mark.name or "", *numbers))
    return Diagram(figure.name, figure.comment, figure.unit or "", places, kinds, tuple(strokes))


def drawable(figures: Iterable[Figure], values: Values) -> tuple[Diagram | None, ...]:
    """Every figure at these values; None for one that they do not determine."""
    found: list[Diagram | None] = []
    for figure in figures:
        found.append(None)
        with suppress(ValueError):
            found[-1] = diagram(figure, values)
    return tuple(found)


def require_matplotlib() -> None:
    """Raise RuleSheetError (E432) if matplotlib is not installed."""
    require_extra("plot", "drawing needs", "matplotlib", code="E432")


PICTURES = (".png", ".svg", ".pdf")


def picture_kind(
    path: str, kinds: Sequence[str], what: str = "picture", notes: tuple[str, ...] = ()
) -> str:
    """The ending of a picture file. Raises RuleSheetError: E433 for another one, E432."""
    kind = os.path.splitext(path)[1].lower()
    if kind not in kinds:
        raise refusal("E433", f"{path}: a {what} ends in {listed(kinds, 'or')}", None, *notes)
    if kind != ".csv":
        require_matplotlib()
    return kind


_ROUND = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)
_BAR = 14.0
"""The least length of a scale bar in millimetres; rounding makes it less than twice as long."""


def scale(width: float, height: float, room: Place) -> float:
    """The smallest round number of units per millimetre at which width and height fit (mm).

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
    return rounded(found * power)


Array: TypeAlias = NDArray[np.float64]

FONT = 8.0
_POINT = 0.3528
"""Millimetres of a typographic point."""

_ROUNDS = 3
_DIRECTIONS = np.arange(16) * np.pi / 8 + np.pi / 4
_CROSSED, _COVERED, _OUTSIDE, _FAR, _MOVED = 6.0, 3.0, 40.0, 0.35, 0.4
"""Costs: of a mm of line under a label, of a mm² of symbol or (twice) of label under it, of a mm
beyond the window, away from the point, and from the place in an earlier frame."""


class LabelRequest(NamedTuple):
    """A label to be placed: beside a point, or beside a segment (``along``); all in millimetres."""

    text: str
    point: Place
    along: tuple[Place, Place] | None = None


def place(
    label_requests: Mapping[str, LabelRequest],
    segments: Array,
    symbols: Array,
    size: Place,
    before: Mapping[str, Place],
) -> dict[str, Array]:
    """A box for every request by its key, in a window [0, width] × [0, height].

    Boxes (n, 4) are middles and half sides, ``segments`` (n, 2, 2) their ends. ``before`` are the
    offsets of labels from their points in an earlier frame.
    """
    half = np.array(size) / 2
    found = dict.fromkeys(label_requests, np.array([np.inf, np.inf, 0.0, 0.0]))
    costs: dict[str, tuple[Array, Array]] = {}  # of each candidate by itself
    for key, request in label_requests.items():
        boxes = _candidates(request)
        off = boxes[:, :2] - request.point
        beyond = np.abs(boxes[:, :2] - half) + boxes[:, 2:] - half
        cost = _COVERED * overlaps(boxes, symbols).sum(axis=1)
        cost += _CROSSED * inside(boxes, segments).sum(axis=1)
        cost += _OUTSIDE * beyond.clip(0.0).sum(axis=1) + _FAR * np.linalg.norm(off, axis=1)
        if key in before:
            cost += _MOVED * np.linalg.norm(off - before[key], axis=1)
        costs[key] = boxes, cost
    for _ in range(_ROUNDS):
        for key, (boxes, cost) in costs.items():
            others = np.array([box for other, box in found.items() if other != key]).reshape(-1, 4)
            total = cost + 2 * _COVERED * overlaps(boxes, others).sum(axis=1)
            # rounding decides between no two that are alike
            found[key] = boxes[np.argmin(total.round(6))]
    return found


def _candidates(request: LabelRequest) -> Array:
    half = np.array([0.6 * _POINT * FONT * len(request.text) + 0.4, 0.95 * _POINT * FONT]) / 2
    if request.along is None:
        around = np.column_stack([np.cos(_DIRECTIONS), np.sin(_DIRECTIONS)])
        rings = [request.point + around * (half + clear) for clear in (1.4, 2.9, 4.9)]
        middles = np.concatenate(rings)
    else:
        start, step = np.array(request.along[0]), np.subtract(request.along[1], request.along[0])
        normal = step[::-1] * (-1.0, 1.0) / np.hypot(*step)
        off = (abs(normal) @ half + 0.7) * normal
        spots = [start + part * step for part in (0.5, 0.4, 0.6, 0.3, 0.7)]
        middles = np.array([spot + side for spot in spots for side in (off, -off)])
    return np.hstack([middles, np.broadcast_to(half, middles.shape)])


def overlaps(boxes: Array, others: Array) -> Array:
    """The areas (n, m) of the intersections of boxes with others."""
    sides = boxes[:, None, 2:] + others[:, 2:] - np.abs(boxes[:, None, :2] - others[:, :2])
    return np.asarray(sides.clip(0.0).prod(axis=2))


def inside(boxes: Array, segments: Array) -> Array:
    """The lengths (n, m) of segments inside boxes (Liang and Barsky 1984)."""
    start, step = segments[:, 0], segments[:, 1] - segments[:, 0]
    slope = np.where(step == 0.0, 1e-300, step)
    middles, half = boxes[:, None, :2], boxes[:, None, 2:]
    low, high = (middles - half - start) / slope, (middles + half - start) / slope
    enter, leave = np.minimum(low, high).max(axis=2), np.maximum(low, high).min(axis=2)
    share = (leave.clip(max=1.0) - enter.clip(0.0)).clip(0.0)
    return np.asarray(share * np.linalg.norm(step, axis=1))
