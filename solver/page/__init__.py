"""A sheet as a page in the browser, served on this machine alone.

Here are the figures of a sheet as a browser draws them, the points that can be dragged, and the curve they
follow. An input *drives* a figure if moving it alone keeps every link rigid, every pin in place and every
slider on its guide: the angle of a crank does, its length does not. A point that moves with a driver is a
handle. It stands for the variable that leads to it by the fewest rules, which becomes the input when the
point is dragged. The *rail* has every value and every dragged point over one whole motion.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import combinations
from math import cos, dist, hypot, inf, isfinite, pi, radians, sin, sqrt
from typing import Any, NamedTuple

import numpy as np

from rulesheets.checks.marks import PLACES, marks_of, parts
from rulesheets.model import Model, Value
from rulesheets.syntax.nodes import Figure
from solver.facts import Unsolved
from solver.path import equations_of
from solver.path.cases import outcomes
from solver.path.planner import planner
from solver.pictures import Diagram, Place, drawable, variables
from solver.result import Result
from solver.sweeps import Plan, prepare
from solver.sweeps.sweep import sweep


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


_TURNS = {"deg": 360.0, "°": 360.0, "rad": 2 * pi}

Row = dict[str, Value]


def turn(model: Model, name: str) -> float:
    """A full turn of an angle, 0 for what is none."""
    return _TURNS.get(model.variables[name].unit or "", 0.0)


def nearest(plan: Plan, at: float, like: Mapping[str, Value]) -> Row | None:
    """The answer of a plan with one input that is nearest to given values."""
    try:
        answers = plan.all(at)
    except Unsolved:
        return None
    rows = [
        dict(plan.given) | {plan.inputs[0]: at} | dict(zip(plan.want, one, strict=True)) for one in answers
    ]
    return min(rows, key=lambda row: apart(plan.model, row, like), default=None)


def apart(model: Model, one: Mapping[str, Value], other: Mapping[str, Value]) -> float:
    """A measure of how far two answers are from each other: 0 where all that both have is equal."""
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


def golden_section(size: Callable[[float], float], low: float, high: float) -> float:
    """Where a function with one minimum between ``low`` and ``high`` has it (Kiefer 1953).

    Its value there is as good as a float can be; the place to half of the digits, as for any method.
    """
    share = (sqrt(5.0) - 1.0) / 2.0
    while abs(high - low) > 1e-9 * (abs(low) + abs(high) + 1e-9):
        left, right = high - share * (high - low), low + share * (high - low)
        if size(left) <= size(right):
            high = right
        else:
            low = left
    return (low + high) / 2.0


ROWS = 73
"""Points of the curve: five degrees apart over a turn."""


class Rail(NamedTuple):
    """Rows in order along the curve, ``closed`` if the last leads on to the first.

    Each has the ``followed`` variables. ``limits`` are the least and the greatest value of a handle's
    variable where it turns back; they depend on the inputs that the motion ``rests_on``.
    """

    parameter: str
    followed: tuple[str, ...]
    rows: tuple[Row, ...]
    closed: bool
    limits: Mapping[str, tuple[float | None, float | None]]
    rests_on: tuple[str, ...]
    plan: Plan


def rail(
    model: Model,
    given: Mapping[str, Value],
    values: Mapping[str, Value],
    handles: Sequence[Handle],
) -> Rail | None:
    """The motion through an answer (``values``), the other inputs as ``given``.

    None where it cannot be followed.
    """
    driver = handles[0].driver
    choices = list(dict.fromkeys((driver, *(h.variable for h in handles if h.driver == driver))))
    turning = [n for n in choices if turn(model, n) and isinstance(values.get(n), float)]
    return _Course(model, given, values, driver, (turning or choices)[0], choices).rail()


class _Course:
    def __init__(
        self,
        model: Model,
        given: Mapping[str, Value],
        values: Mapping[str, Value],
        driver: str,
        parameter: str,
        followed: Sequence[str],
    ) -> None:
        self.model, self.values, self.parameter, self.followed = model, values, parameter, followed
        self.names = tuple(dict.fromkeys((*followed, *needed(model, polar=False))))
        own = {name: None for name, variable in model.variables.items() if variable.value is not None}
        self.fixed: dict[str, Value | None] = {**own, **given}
        self.fixed[driver] = None
        self.fixed.pop(parameter, None)
        self.guesses = {n: v for n, v in values.items() if isinstance(v, float) and n not in self.fixed}
        self.guesses.pop(parameter, None)

    def rail(self) -> Rail | None:
        want = [name for name in self.names if name != self.parameter and self.fixed.get(name) is None]
        table = sweep(
            self.model,
            {self.parameter: self._range()},
            want=want,
            follow=True,
            given=self.fixed,
            guesses=self.guesses,
        )
        kept = {name: value for name, value in self.fixed.items() if value is not None}
        branches = [
            [
                {
                    **kept,
                    **{n: table[n][k].item() if hasattr(table[n][k], "item") else table[n][k] for n in table},
                }
                for k in range(branch.first, branch.last)
            ]
            for branch in table.branches  # type: ignore[attr-defined]
        ]
        solid = [[row for row in rows if _whole(row, self.names)] for rows in branches]
        solid = [rows for rows in solid if len(rows) > 1]
        if not solid:
            return None
        rows = min(solid, key=lambda some: min(apart(self.model, row, self.values) for row in some))
        closed = self._meets(rows[0], rows[-1])
        return self._with_limits(rows[:-1] if closed else rows, closed, want)

    def _range(self) -> np.ndarray[Any, np.dtype[np.float64]]:
        now, whole = float(self.values[self.parameter]), turn(self.model, self.parameter)
        variable = self.model.variables[self.parameter]
        reach = whole / 2 if whole else max(1.0, 2 * abs(now))
        start = -reach if whole else now - reach
        low, high = max(variable.low, start), min(variable.high, start + 2 * reach)
        return np.unique(np.append(np.linspace(low, high, ROWS), now))

    def _meets(self, first: Row, last: Row) -> bool:
        """Whether the figures at both ends of the rows are the same."""
        here, there = diagrams(self.model, first), diagrams(self.model, last)
        pairs = [(a, b) for a, b in zip(here, there, strict=True) if a and b and not a.polar]
        size = max((hypot(*place) for a, _ in pairs for place in a.places.values()), default=0.0)
        return bool(pairs) and all(
            hypot(a.places[n][0] - b.places[n][0], a.places[n][1] - b.places[n][1]) <= 1e-6 * size
            for a, b in pairs
            for n in a.places
        )

    # --- where a variable turns back ---

    def _with_limits(self, rows: list[Row], closed: bool, want: Sequence[str]) -> Rail:
        limits: dict[str, tuple[float | None, float | None]] = {}
        more = [n for n in needed(self.model) if n != self.parameter and self.fixed.get(n) is None]
        want = tuple(dict.fromkeys((*want, *more)))
        plan = prepare(self.model, [self.parameter], want=want, given=self.fixed, guesses=self.guesses)
        for name in self.followed:
            if name != self.parameter and all(isinstance(row.get(name), float) for row in rows):
                limits[name] = self._limits(plan, name, rows, closed)
        return Rail(self.parameter, tuple(self.followed), tuple(rows), closed, limits, self._rests_on(), plan)

    def _rests_on(self) -> tuple[str, ...]:
        """The numbers among the fixed inputs that the figures of the motion depend on."""
        fixed = {name for name, value in self.fixed.items() if isinstance(value, float)}
        known = frozenset({n for n, v in self.fixed.items() if v is not None} | {self.parameter})
        path = planner(self.model).path(known, {}, want=frozenset(needed(self.model, polar=False)) - known)
        used = {index for step in path.steps for index in equations_of(step)}
        names = {name for index in used for name in self.model.equations[index].names}
        return tuple(name for name in self.model.variables if name in names & fixed)

    def _limits(
        self, plan: Plan, name: str, rows: list[Row], closed: bool
    ) -> tuple[float | None, float | None]:
        """The least and the greatest value that is reached between rows; both join the rows."""
        if turn(self.model, name) and _winds(rows, name, turn(self.model, name)):
            return None, None
        found: list[float | None] = []
        for sign in (1.0, -1.0):
            place = min(range(len(rows)), key=lambda k: sign * float(rows[k][name]))
            if not closed and place in (0, len(rows) - 1):
                found.append(None)
                continue
            row = self._extreme(plan, name, rows, place, sign)
            if row is not None:
                rows[place] = row
            found.append(float(rows[place][name]))
        return found[0], found[1]

    def _extreme(self, plan: Plan, name: str, rows: list[Row], place: int, sign: float) -> Row | None:
        whole = turn(self.model, self.parameter)
        middle = float(rows[place][self.parameter])
        low = middle - _gap(rows, place, place - 1, self.parameter, whole)
        high = middle + _gap(rows, place + 1, place, self.parameter, whole)

        def size(at: float) -> float:
            row = nearest(plan, at, rows[place])
            return inf if row is None else sign * float(row[name])

        return nearest(plan, golden_section(size, low, high), rows[place])


def extents(model: Model, curve: Rail) -> list[list[float] | None]:
    """The rectangle (left, bottom, right, top) that every figure needs over the motion.

    Of velocities and accelerations the largest few are left out: they may grow without bound.
    """
    drawn = [diagrams(model, row) for row in _spread(curve)]
    found: list[list[float] | None] = []
    for number in range(len(model.figures)):
        figures = [some[number] for some in drawn]
        places = [place for one in figures if one for place in one.places.values()]
        polar = any(one.polar for one in figures if one)
        found.append(rectangle(places, polar) if places else None)
    return found


def _spread(curve: Rail) -> Iterator[Row]:
    table = curve.plan.sweep([row[curve.parameter] for row in curve.rows])
    for number in np.flatnonzero(table.solved):
        yield {**curve.plan.given, **{name: table[name][number] for name in table}}


def _whole(row: Mapping[str, Value], names: Sequence[str]) -> bool:
    return all(isinstance(row.get(n), str) or isfinite(float(row.get(n, inf))) for n in names)


def _winds(rows: Sequence[Row], name: str, whole: float) -> bool:
    """Whether an angle goes round as the curve does."""
    total = 0.0
    for here, there in zip(rows, (*rows[1:], rows[0]), strict=True):
        step = float(there[name]) - float(here[name])
        total += step - whole * round(step / whole)
    return abs(total) > whole / 2


def _gap(rows: Sequence[Row], upper: int, lower: int, name: str, whole: float) -> float:
    step = float(rows[upper % len(rows)][name]) - float(rows[lower][name])
    return step - whole * round(step / whole) if whole else step
