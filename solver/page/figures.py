"""The figures of a sheet at an answer, as numbers that a browser can draw."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from rulesheets.marks import PLACES, marks_of, parts
from rulesheets.model import Model, Value
from rulesheets.syntax.nodes import Figure
from solver.pictures.diagram import Diagram, Place, diagram, lacking, variables

__all__ = ["Diagram", "coordinates", "diagrams", "geometry", "needed", "outline", "rectangle"]


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


def diagrams(model: Model, values: Mapping[str, Value]) -> list[Diagram | None]:
    """Every figure at these values; None for one that they do not determine."""
    return [None if lacking(figure, values) else diagram(figure, values) for figure in model.figures]


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
