"""A sheet as a page in the browser, served only to this machine.

This module has the figures of a sheet for a browser, the points that can be dragged, and the curve
they follow. An input *drives* a figure if moving it alone keeps every link rigid, every pin in
place and every slider on its guide: the angle of a crank does, its length does not. A point that
moves with a driver is a handle. It stands for the variable that leads to it by the fewest rules,
which becomes the input when the point is dragged. The *rail* has every value and every dragged
point over one whole motion.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import partial
from itertools import combinations
from math import cos, dist, hypot, inf, isfinite, radians, sin
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rulesheets.checks import PLACES, marks_of, parts
from rulesheets.model import Model, Value, Values
from rulesheets.syntax.nodes import Figure
from solver.derivatives import Sensitivities
from solver.numerics.one_unknown import lowest_between
from solver.path import equations_of
from solver.path.cases import outcomes
from solver.path.planner import planner
from solver.pictures import Diagram, drawable, variables
from solver.ranking.signs import signs_of
from solver.solution.solving import Result
from solver.sweeps import Plan, prepare
from solver.sweeps.curves import CurveTable
from solver.sweeps.sweep import sweep


def outline(figure: Figure) -> dict[str, Any]:
    """The parts common to all answers: names and kinds of points, strokes between them."""
    marks = marks_of(figure)
    places = [{"name": mark.name, "kind": mark.kind} for mark in marks if mark.kind in PLACES]
    strokes = []
    for mark in (mark for mark in marks if mark.kind not in PLACES):
        named = [node.name for node in parts(mark)[0]]
        strokes.append({"kind": mark.kind, "points": named, "label": mark.name or ""})
    return {
        "name": figure.name,
        "title": figure.comment or figure.name,
        "unit": figure.unit or "",
        "polar": any(mark.kind == "pole" for mark in marks),
        "places": places,
        "strokes": strokes,
    }


def geometry(model: Model, values: Values) -> list[dict[str, Any] | None]:
    """Coordinates of points and directions of strokes of every figure, in the order of its outline.

    None for a figure that the values do not determine.
    """
    found: list[dict[str, Any] | None] = []
    for one in drawable(model.figures, values):
        found.append(None)
        if one is not None:
            places, angles = map(list, one.places.values()), (s.angle for s in one.strokes)
            found[-1] = {"places": list(places), "angles": list(angles)}
    return found


def needed(model: Model, *, polar: bool = True) -> tuple[str, ...]:
    """Full names of the variables that the figures need, with or without ``polar`` ones."""
    return variables(figure for figure in model.figures if polar or not outline(figure)["polar"])


def boxes(
    outlines: Iterable[Mapping[str, Any]], drawn: Collection[Sequence[dict[str, Any] | None] | None]
) -> list[list[float] | None]:
    """The rectangle (left, bottom, right, top) of every figure in all these states, or None.

    A few outliers of a polar figure are ignored: velocities may grow without bound.
    """
    found: list[list[float] | None] = []
    for number, figure in enumerate(outlines):
        there = (one for some in drawn if some and (one := some[number]))
        places = [place for one in there for place in one["places"]]
        share = 3.0 if figure["polar"] else 0.0
        ends = np.percentile(np.array(places), [share, 100.0 - share], axis=0) if places else None
        found.append(None if ends is None else ends.ravel().tolist())
    return found


STEP = 1e-6
"""Relative size of the virtual displacement."""

RIGID = 1e-3
"""Share of the motion by which a length may change: its second order in ``STEP``, and rounding."""

_RIGID_STROKES = ("line", "slot", "body")

Pair = tuple[Diagram, Diagram]
Row = dict[str, Value]


class Handle(NamedTuple):
    """A point of a figure, the input that moves it, and the variable that it stands for."""

    figure: int
    point: str
    driver: str
    variable: str


def handles(result: Result, answer: int = 0) -> tuple[Handle, ...]:
    """Every point of the figures that can be dragged at an answer."""
    model, found = result.model, dict[tuple[int, str], Handle]()
    if not result.solutions or not model.figures:
        return ()
    values = dict(result.solutions[answer])
    drivers = [name for name, value in result.inputs.items() if isinstance(value, float)]
    posted = (n for n, variable in model.variables.items() if variable.posted)
    names = dict.fromkeys(needed(model))
    names |= dict.fromkeys(n for n in posted if isinstance(values.get(n), float))
    slopes = result.sensitivity([n for n in names if n not in result.inputs], drivers, answer)
    before = drawable(model.figures, values)
    for driver in drivers:
        moved = _displaced(slopes, values, driver)
        both = enumerate(zip(before, drawable(model.figures, moved), strict=True))
        pairs = {number: (a, b) for number, (a, b) in both if moved and a and b and not a.polar}
        moves = any(_motion(*pair) for pair in pairs.values())
        if not moves or not all(map(_rigid, pairs.values())):
            continue
        for number, (here, there) in pairs.items():
            most = _motion(here, there)
            for point, kind in here.kinds.items():
                moves = dist(here.places[point], there.places[point]) > 1e-2 * most
                if kind == "point" and moves and (number, point) not in found:
                    figure = model.figures[number]
                    variable = _variable(result, values, slopes, figure, point, driver)
                    found[number, point] = Handle(number, point, driver, variable)
    return tuple(found.values())


def _displaced(slopes: Sensitivities, values: Row, driver: str) -> Row:
    """The values after a small step of one input, to first order; none if a slope is missing."""
    start = float(values[driver])
    step, drawn = STEP * max(abs(start), 1.0), needed(slopes.model)
    moved: Row = {**values, driver: start + step}
    for name in slopes.outputs:
        slope, value = slopes[name, driver], values.get(name)
        if slope is None and name in drawn:
            return {}
        if slope is not None and isinstance(value, float):
            moved[name] = value + step * slope
    return moved


def _variable(
    result: Result, values: Row, slopes: Sensitivities, figure: Figure, point: str, driver: str
) -> str:
    """The variable that a point stands for: the nearest by rules of those next to its coordinates.

    The rules of blocks count squared, and steps with several branches as often. A variable with a
    unit, a comment or a value in the sheet is preferred.
    """
    known, decided = result.model.variables, outcomes(result.model, values, result.inputs)
    alone = tuple(mark for mark in marks_of(figure) if mark.name == point)
    wanted = frozenset(variables([Figure(figure.name, figure.unit, alone)]))
    near = {n for e in result.model.equations if wanted & set(e.names) for n in e.names} | wanted
    reached = dict[str, tuple[bool, int]]()
    moving = (n for n in slopes.outputs if slopes[n, driver] and n in near)
    for name in (n for n in (driver, *moving) if known[n].posted):
        given, variable = frozenset({*result.inputs} - {driver} | {name}), known[name]
        path = planner(result.model).path(given, decided, want=wanted - {name})
        if not wanted & set(path.undetermined):
            counts = ((len(equations_of(s)), getattr(s, "branches", 1)) for s in path.steps)
            silent = not (variable.unit or variable.comment) and variable.value is None
            reached[name] = silent, sum(rules**2 * branches for rules, branches in counts)
    return min(reached, key=reached.__getitem__, default=driver)


def _motion(before: Diagram, after: Diagram) -> float:
    """The largest displacement of a point."""
    return max((dist(before.places[n], after.places[n]) for n in before.places), default=0.0)


def _rigid(pair: Pair) -> bool:
    """Whether links, pins and fixed guides are unchanged after a motion."""
    before, after = (one.places for one in pair)
    pins = (name for name, kind in pair[0].kinds.items() if kind == "pin")
    changes = [dist(before[name], after[name]) for name in pins]
    for stroke in pair[0].strokes:
        first = stroke.points[0]
        if stroke.kind in _RIGID_STROKES:
            ends = combinations(stroke.points, 2)
            changes += [abs(dist(before[a], before[b]) - dist(after[a], after[b])) for a, b in ends]
        elif stroke.kind == "slider":
            (x, y), (u, v), along = before[first], after[first], radians(stroke.angle)
            changes.append(abs((v - y) * cos(along) - (u - x) * sin(along)))
        elif stroke.kind == "trunnion":
            changes.append(dist(before[first], after[first]))
    return max(changes, default=0.0) <= RIGID * _motion(*pair)


def turn(model: Model, name: str) -> float:
    """A full turn of an angle, 0 for other variables."""
    return signs_of(model).angles.get(name, 0.0)


def apart(model: Model, one: Values, other: Values) -> float:
    """The distance between two answers: 0 if all their common values are equal."""
    total = 0.0
    for name in one.keys() & other.keys():
        a, b = one[name], other[name]
        if isinstance(a, float) and isinstance(b, float):
            gap, whole = abs(a - b), turn(model, name)
            if whole:
                gap = min(gap % whole, whole - gap % whole)
            total += (gap / (1.0 + max(abs(a), abs(b)))) ** 2
        else:
            total += a != b
    return total


ROWS = 73
"""Points of the curve: five degrees apart over a turn."""


def rail(model: Model, given: Values, values: Values, handles: Sequence[Handle]) -> dict[str, Any]:
    """The motion through an answer (``values``) of the handles of one driver, the other inputs as
    ``given``, and the rectangles that the figures need over it; nothing if it cannot be followed.

    It has rows of the variables of the handles in order along the curve, ``closed`` if the last
    leads on to the first. ``limits`` are the least and the greatest value of such a variable where
    it turns back; they depend on the inputs that the motion comes ``from``.
    """
    driver = handles[0].driver
    followed = tuple(dict.fromkeys((driver, *(handle.variable for handle in handles))))
    turning = [n for n in followed if turn(model, n) and isinstance(values.get(n), float)]
    parameter = (turning or followed)[0]
    own = {name: None for name, variable in model.variables.items() if variable.value is not None}
    fixed = {n: v for n, v in {**own, **given, driver: None}.items() if n != parameter}
    numbers = {n: v for n, v in values.items() if isinstance(v, float)}
    guesses = {n: v for n, v in numbers.items() if n not in (*fixed, parameter)}
    names = tuple(dict.fromkeys((*followed, *needed(model, polar=False))))
    want = [name for name in names if name != parameter and fixed.get(name) is None]
    along = {parameter: _range(model, parameter, float(values[parameter]))}
    table = sweep(model, along, want=want, follow=True, given=fixed, guesses=guesses)
    assert isinstance(table, CurveTable)
    kept = {name: value for name, value in fixed.items() if value is not None}
    if not (rows := _nearest_branch(model, table, kept, names, values)):
        return {}
    closed = _meets(model, rows[0], rows[-1])
    rows = rows[:-1] if closed else rows
    prepared = partial(prepare, model, [parameter], given=fixed, guesses=guesses)
    limits, plan = {}, prepared(want=want)
    for name in (name for name in followed if name != parameter):
        if all(isinstance(row.get(name), float) for row in rows):
            limits[name] = _limits(plan, name, rows, closed)
    told = {
        "closed": closed,
        "limits": limits,
        "turns": {name: turn(model, name) for name in followed},
        "from": _rests_on(model, fixed, parameter),
        "rows": [{name: row[name] for name in followed} for row in rows],
        "figures": [geometry(model, row) for row in rows],
    }
    more = [n for n in needed(model) if n != parameter and fixed.get(n) is None]
    whole = prepared(want=list(dict.fromkeys((*want, *more))))
    return {"rail": told, "extents": _extents(whole, rows)}


def _nearest_branch(
    model: Model, table: CurveTable, kept: Values, names: Sequence[str], values: Values
) -> list[Row]:
    """The rows that have all ``names``, of the branch that comes nearest to an answer."""
    columns = [table[name].tolist() for name in table]
    every = [{**kept, **dict(zip(table, row, strict=True))} for row in zip(*columns, strict=True)]
    stretches = (every[one.first : one.last] for one in table.branches)
    branches = ([row for row in rows if _whole(row, names)] for rows in stretches)
    solid = [rows for rows in branches if len(rows) > 1]
    return min(solid, key=lambda rows: min(apart(model, r, values) for r in rows), default=[])


def _range(model: Model, name: str, now: float) -> NDArray[np.float64]:
    whole, variable = turn(model, name), model.variables[name]
    reach = whole / 2 if whole else max(1.0, 2 * abs(now))
    start = -reach if whole else now - reach
    low, high = max(variable.low, start), min(variable.high, start + 2 * reach)
    return np.unique(np.append(np.linspace(low, high, ROWS), now))


def _whole(row: Row, names: Sequence[str]) -> bool:
    return all(isinstance(row.get(n), str) or isfinite(float(row.get(n, inf))) for n in names)


def _meets(model: Model, first: Row, last: Row) -> bool:
    """Whether the figures at both ends of the rows are the same."""
    both = zip(drawable(model.figures, first), drawable(model.figures, last), strict=True)
    pairs = [(a, b) for a, b in both if a and b and not a.polar]
    size = max((hypot(*place) for a, _ in pairs for place in a.places.values()), default=0.0)
    return bool(pairs) and all(_motion(a, b) <= 1e-6 * size for a, b in pairs)


def _rests_on(model: Model, fixed: Mapping[str, Value | None], parameter: str) -> tuple[str, ...]:
    """The numbers among the fixed inputs that the figures of the motion depend on."""
    known = frozenset({n for n, v in fixed.items() if v is not None} | {parameter})
    path = planner(model).path(known, {}, want=frozenset(needed(model, polar=False)) - known)
    used = {index for step in path.steps for index in equations_of(step)}
    names = {name for index in used for name in model.equations[index].names}
    return tuple(n for n in model.variables if n in names and isinstance(fixed.get(n), float))


def _limits(
    plan: Plan, name: str, rows: list[Row], closed: bool
) -> tuple[float | None, float | None]:
    """The least and the greatest value that is reached between rows; both join the rows.

    None if it does not turn back: at an end of the rows, and for an angle that makes full turns.
    """
    whole = turn(plan.model, name)
    values = np.array([float(row[name]) for row in rows])
    if whole and abs(np.unwrap([*values, values[0]], period=whole)[-1] - values[0]) > whole / 2:
        return None, None
    at = np.array([float(row[plan.inputs[0]]) for row in (rows[-1], *rows, rows[0])])
    if about := turn(plan.model, plan.inputs[0]):
        at = np.unwrap(at, period=about)
    found: list[float | None] = []
    for sign in (1.0, -1.0):
        place = int(np.argmin(sign * values))
        if closed or 0 < place < len(rows) - 1:
            ends = sorted(at[place : place + 3 : 2].tolist())
            rows[place] = _extreme(plan, name, rows[place], sign, ends)
            found.append(float(rows[place][name]))
        else:
            found.append(None)
    return found[0], found[1]


def _extreme(plan: Plan, name: str, row: Row, sign: float, ends: list[float]) -> Row:
    """The row of the least value (``sign`` -1: greatest) between two of the parameter."""

    def answer(at: float) -> Row:
        return nearest(plan, at, plan.outcome((at,))[1], row)

    def size(at: float) -> float:
        return sign * float(answer(at).get(name, sign * inf))

    return answer(lowest_between(size, *ends)) or row


def nearest(plan: Plan, at: float, answers: Iterable[Sequence[Value]], like: Row) -> Row:
    """The values of the answer of a plan, for its one input, that is nearest to given ones."""
    given = {**plan.given, plan.inputs[0]: at}
    rows = ({**given, **dict(zip(plan.want, one, strict=True))} for one in answers)
    return min(rows, key=lambda row: apart(plan.model, row, like), default={})


def _extents(plan: Plan, along: Sequence[Row]) -> list[list[float] | None]:
    """The rectangle (left, bottom, right, top) that every figure needs over the motion."""
    table, model = plan.sweep([row[plan.inputs[0]] for row in along]), plan.model
    solved = np.flatnonzero(table.solved)
    rows = [{**plan.given, **{n: table[n][k] for n in table}} for k in solved]
    return boxes(map(outline, model.figures), [geometry(model, row) for row in rows])
