"""The curve that a mechanism moves along: every value and every dragged point over one whole motion."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from math import hypot, inf, isfinite, pi, sqrt
from typing import Any, NamedTuple

import numpy as np

from rulesheets.model import Model, Value
from solver.facts import Unsolved
from solver.page.figures import Handle, diagrams, needed, rectangle
from solver.path.planner import planner
from solver.path.steps import equations_of
from solver.sweeps.plan import Plan, prepare
from solver.sweeps.sweep import sweep

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
    return _Motion(model, given, values, driver, (turning or choices)[0], choices).rail()


class _Motion:
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
