"""What a figure can hold: the kinds of its lines, each with the shape that it is written in."""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple

from rulesheets.syntax.nodes import Expression, Figure, Mark, Name


class Shape(Enum):
    """What stands in the parentheses of a mark."""

    COORDINATES = "two coordinates"
    POINTS = "points of the figure"
    DIRECTED = "a point of the figure and a direction in degrees"


class Kind(NamedTuple):
    """A kind of mark. ``least`` and ``most`` count its arguments; ``example`` is how it is written.

    ``named``: a name before the parentheses is required; else it is a label that may be left out.
    """

    shape: Shape
    what: str
    example: str
    least: int = 2
    most: int | None = 2
    named: bool = False


def _place(what: str, example: str) -> Kind:
    return Kind(Shape.COORDINATES, what, example, named=True)


def _link(what: str, example: str, least: int = 2) -> Kind:
    return Kind(Shape.POINTS, what, example, least, None)


def _arrow(what: str, example: str) -> Kind:
    return Kind(Shape.POINTS, what, example)


def _joint(what: str, example: str) -> Kind:
    return Kind(Shape.DIRECTED, what, example)


KINDS: dict[str, Kind] = {
    "point": _place("a point, with its name beside it", "point A = (xA, yA)"),
    "pin": _place("a point that is pinned to the ground", "pin O = (0, 0)"),
    "pole": _place("the pole of a velocity or acceleration diagram", "pole o = (0, 0)"),
    "line": _link("a link, or a line through several points", "line (O, A)"),
    "slot": _arrow("a link with a slot along it", "slot (C, D)"),
    "body": _link("a rigid link with three corners or more", "body (U, T, W)", 3),
    "slider": _joint("a slider on a fixed straight guide", "slider (B, 0)"),
    "block": _joint("a slider on a moving link", "block (B, thetaCD)"),
    "trunnion": _joint("a guide that turns about a fixed point", "trunnion (E, thetaCD)"),
    "vector": _arrow("an arrow from one point to another", "vector vB = (o, b)"),
    "normal": _arrow("an arrow along a link: a normal acceleration", "normal aAn = (o1, a11)"),
    "tangential": _arrow(
        "an arrow across a link: a relative velocity, a tangential acceleration", "tangential vAB = (a, b)"
    ),
    "sliding": _arrow("an arrow of sliding motion along a link or a guide", "sliding vS = (s, b)"),
    "coriolis": _arrow("an arrow of the Coriolis acceleration", "coriolis (s1, k1)"),
}
"""A table, so that a new kind needs no new grammar."""

PLACES = frozenset(kind for kind, row in KINDS.items() if row.shape is Shape.COORDINATES)
ARROWS = ("vector", "normal", "tangential", "sliding", "coriolis")


def marks_of(figure: Figure) -> tuple[Mark, ...]:
    """The marks of a figure, without the comment lines between them."""
    return tuple(mark for mark in figure.marks if isinstance(mark, Mark))


def parts(mark: Mark) -> tuple[tuple[Name, ...], tuple[Expression, ...]]:
    """The points that a mark names, and the expressions that it evaluates."""
    named = {Shape.COORDINATES: 0, Shape.DIRECTED: 1}.get(KINDS[mark.kind].shape, len(mark.arguments))
    points = tuple(node for node in mark.arguments[:named] if isinstance(node, Name))
    return points, mark.arguments[named:]
