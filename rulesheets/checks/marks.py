"""The lines of figures: their kinds, the shape of each, and the names in them."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from enum import Enum
from functools import partial
from typing import NamedTuple

from rulesheets.checks import check_builtin, name_in
from rulesheets.diagnosis import (
    Diagnosis,
    closest,
    error,
    error_at,
    labels,
    meant,
    plural,
    suggestion,
)
from rulesheets.syntax import Span
from rulesheets.syntax.nodes import Call, Expression, Figure, Mark, Name, Symbol
from rulesheets.syntax.program import Program, walk


class Arguments(Enum):
    """The arguments that a line of a figure takes."""

    COORDINATES = "two coordinates"
    POINTS = "points of the figure"
    DIRECTED = "a point of the figure and a direction in degrees"


class Kind(NamedTuple):
    """A kind of line of a figure, with an example and ``least`` and ``most`` arguments.

    ``named``: a name before the parentheses is required; otherwise it is an optional label.
    """

    shape: Arguments
    example: str
    least: int = 2
    most: int | None = 2
    named: bool = False


_place = partial(Kind, Arguments.COORDINATES, named=True)
_link = partial(Kind, Arguments.POINTS, most=None)
_arrow = partial(Kind, Arguments.POINTS)
_joint = partial(Kind, Arguments.DIRECTED)

KINDS: dict[str, Kind] = {
    "point": _place("point A = (xA, yA)"),
    "pin": _place("pin O = (0, 0)"),  # to the ground
    "pole": _place("pole o = (0, 0)"),  # of a velocity or acceleration diagram
    "line": _link("line (O, A)"),  # a link, or a line through several points
    "slot": _arrow("slot (C, D)"),  # a link with a slot along it
    "body": _link("body (U, T, W)", 3),  # a rigid link with three corners or more
    "slider": _joint("slider (B, 0)"),  # on a fixed straight guide
    "block": _joint("block (B, thetaCD)"),  # a slider on a moving link
    "trunnion": _joint("trunnion (E, thetaCD)"),  # a guide that turns about a fixed point
    "vector": _arrow("vector vB = (o, b)"),
    "normal": _arrow("normal aAn = (o1, a11)"),  # along a link: a normal acceleration
    "tangential": _arrow("tangential vAB = (a, b)"),  # across a link: a velocity or an acceleration
    "sliding": _arrow("sliding vS = (s, b)"),  # along a link or a guide
    "coriolis": _arrow("coriolis (s1, k1)"),
}
"""A table, so that a new kind needs no new grammar."""

PLACES = frozenset(kind for kind, row in KINDS.items() if row.shape is Arguments.COORDINATES)
ARROWS = ("vector", "normal", "tangential", "sliding", "coriolis")


MARK_SHAPE = "a line of a figure reads point A = (x, y), line (O, A) or slider (B, 0)"


def marks_of(figure: Figure) -> tuple[Mark, ...]:
    """The lines of a figure without comment lines."""
    return tuple(mark for mark in figure.marks if isinstance(mark, Mark))


def parts(mark: Mark) -> tuple[tuple[Name, ...], tuple[Expression, ...]]:
    """The points that a line names, and the expressions that it evaluates."""
    shape = KINDS[mark.kind].shape
    named = {Arguments.COORDINATES: 0, Arguments.DIRECTED: 1}.get(shape, len(mark.arguments))
    points = tuple(node for node in mark.arguments[:named] if isinstance(node, Name))
    return points, mark.arguments[named:]


# --- names ----------------------------------------------------------------------


def check_figures(program: Program, variables: Collection[str]) -> Iterator[Diagnosis]:
    """Check that names in figures are variables, or points of the figure.

    ``variables`` are all variables of the model by their full names, locals of calls included.
    """
    first: dict[str, Figure] = {}
    for figure in program.sheet.figures:
        earlier = first.setdefault(figure.name, figure)
        if earlier is not figure:
            places = (one.span and one.span.part(0, len("figure")) for one in (figure, earlier))
            yield _twice("figure", figure.name, *places)
        points: dict[str, Mark] = {}
        for mark in marks_of(figure):
            if mark.kind in PLACES and mark.name is not None:
                before = points.setdefault(mark.name, mark)
                if before is not mark:
                    yield _twice("point", mark.name, mark.span, before.span)
        for mark in marks_of(figure):
            named, reckoned = parts(mark)
            for name in named:
                if name.name not in points:
                    notes = suggestion(name.name, points) or (f"add point {name.name} = (x, y)",)
                    message = f"the figure {figure.name} has no point {name.name}"
                    yield error_at("E231", message, name.span, *notes)
            for expression in reckoned:
                yield from _check_expression(expression, variables, program.functions)


def _check_expression(
    expression: Expression, variables: Collection[str], functions: Collection[str]
) -> Iterator[Diagnosis]:
    for node in walk(expression):
        if isinstance(node, Name) and node.name not in variables:
            notes = meant(node.name, variables) or ("a figure names variables of the rules",)
            yield error_at("E230", f"there is no variable {node.name}", node.span, *notes)
        elif isinstance(node, Call) and node.function in functions:
            message = f"a figure cannot call {node.function}, which is a function of rules"
            note = "call it in a rule, and name its results here"
            yield error_at("E201", message, name_in(node), note)
        elif isinstance(node, Call):
            yield from check_builtin(node, (), variables)
        elif isinstance(node, Symbol):
            message = f"the symbol '{node.name} is not a coordinate"
            yield error_at("E233", message, node.span, "a figure is drawn from numbers")


def _twice(what: str, name: str, again: Span | None, first: Span | None) -> Diagnosis:
    places = labels((again, "again"), (first, "first here"))
    note = "give one of the two another name"
    return error("E232", f"the {what} {name} is defined twice", *places, notes=(note,))


def wrong_mark(mark: Mark) -> Diagnosis | None:
    """The mistake in a line of a figure that the grammar accepts: its kind, or a missing part."""
    kind = KINDS.get(mark.kind)
    if kind is None:
        near = closest(mark.kind, KINDS)
        note = f"did you mean {near}?" if near else f"the kinds are {', '.join(KINDS)}"
        place = mark.span and mark.span.part(0, len(mark.kind))
        return error_at("E130", f"a figure has no `{mark.kind}`", place, note)
    count, message = len(mark.arguments), ""
    if kind.named and mark.name is None:
        message = f"this {mark.kind} has no name"
    elif kind.shape is Arguments.DIRECTED and mark.name is not None:
        message = f"a {mark.kind} has no name of its own"
    elif count < kind.least or (kind.most is not None and count > kind.most):
        points = plural(kind.least, "point") + ("" if kind.most else " or more")
        expected = points if kind.shape is Arguments.POINTS else kind.shape.value
        message = f"a {mark.kind} takes {expected}, not {count or 'none'}"
    if message:
        return error_at("E131", message, mark.span, f"write {kind.example}")
    count = {Arguments.POINTS: count, Arguments.DIRECTED: 1}.get(kind.shape, 0)
    for argument in mark.arguments[:count]:
        if not isinstance(argument, Name) or "." in argument.name:
            note = f"name a point of the figure, as in {kind.example}"
            return error_at("E131", "this is not the name of a point", argument.span, note)
    return None
