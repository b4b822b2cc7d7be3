"""Curves of answers: the unknowns that a curve is followed in, and every branch through its
folds."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache, partial
from itertools import groupby
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from rulesheets.deadline import expect_time
from rulesheets.model import Model, Value, Values
from rulesheets.syntax.nodes import degree
from solver.facts import Status
from solver.files.tables import CODES, column_of, free_name
from solver.leaves import Leaf
from solver.numerics.continuation import CurvePoint, End
from solver.numerics.linear_algebra import Array
from solver.path import Assume, Evaluate, Select, Step, equations_of, given_by
from solver.path.building import read_by
from solver.path.graph import ModelGraph
from solver.path.planner import planner
from solver.sweeps import Plan, prepare
from solver.sweeps.tracing import Branch, Curve, CurveSystem, CurveTable, Limit, curve_rows, traced


def _curve_unknowns(
    graph: ModelGraph, steps: Sequence[Step], parameter: str
) -> tuple[tuple[str, ...], frozenset[str]]:
    """The unknowns that span the curve, and all variables that change with the parameter, itself
    included.

    They are the unknowns of the steps that can have several values, and the changing variables that
    these need, in the order of the steps: none if every step has one value, and no case was
    assumed.
    """
    made = [(step, names, {*read_by(graph, step)}) for step in steps if (names := given_by(step))]
    assumed = {name for step in steps if isinstance(step, Assume) for name in read_by(graph, step)}
    moving = {parameter}
    for _, names, read in made:
        if not moving.isdisjoint(read.difference(names)):
            moving.update(names)
    needed: set[str] = set()
    for step, names, read in reversed(made):
        if moving.isdisjoint(names):
            continue
        if _forks(graph, step) or not (needed | assumed).isdisjoint(names):
            needed.update(names, read & moving)
    spanning = tuple(n for _, names, _ in made for n in names if n in needed & moving)
    return spanning, frozenset(moving)


def _forks(graph: ModelGraph, step: Step) -> bool:
    """Whether a step can have several values; a block of linear rules has one answer, none or
    all."""
    if isinstance(step, Evaluate | Select):
        return step.branches > 1
    rules = (graph.model.equations[index] for index in equations_of(step))
    return any(degree(rule.form, given_by(step)) > 1.0 for rule in rules)


STEEP = 0.8
"""Share of a change in one half of an interval at which it is examined closely."""
VANISHED = 1e-3
"""Share of its largest change by which a continuous value still changes at the end."""
ROUNDING = 2.0**-49
"""Share of a value by which it changes for no other reason than its digits."""
HALVINGS = 80
GROWN = 1e9
"""The growth of a value near a pole, relative to the rows."""
LAST = 10
STILL_GROWN = 4.0
"""How many times larger it is there than so many halvings before."""


def is_discontinuous(
    start: float, end: float, value: Callable[[float], float | None], turn: float | None = None
) -> bool:
    """Whether a value jumps, has a pole, or is missing (None) between two places where it is known.

    It is examined closely only if its middle lies outside of those at the ends, or next to one of
    them. ``turn``: the whole turn of an angle, which makes no difference.
    """

    def apart(one: float, other: float) -> float:
        return abs(other - one) if turn is None else abs(math.remainder(other - one, turn))

    a, between, b = value(start), value(0.5 * (start + end)), value(end)
    if a is None or b is None or between is None:
        return a is not None and b is not None
    most, largest = max(apart(a, between), apart(between, b)), max(abs(a), abs(b))
    if most <= STEEP * apart(a, b):
        return False
    most, low, high = max(most, apart(a, b)), start, end
    for _ in range(HALVINGS):  # does the change of the value vanish with the interval?
        place = 0.5 * (low + high)
        middle = None if place in (low, high) else value(place)
        if middle is None:
            return True
        left, right = apart(a, middle), apart(middle, b)
        most = max(most, left, right)
        low, a, high, b = (low, a, place, middle) if left >= right else (place, middle, high, b)
        if apart(a, b) <= max(VANISHED * most, ROUNDING * max(abs(a), abs(b))):
            peak = turn is None and abs(between) > largest
            return peak and _grows(start, end, value, GROWN * largest)
    return True


def _grows(start: float, end: float, value: Callable[[float], float | None], most: float) -> bool:
    """Whether a value grows without bound, or vanishes, at its largest: at a maximum it does not,
    however small it is at the ends."""
    reached: list[float] = []
    for _ in range(HALVINGS):
        if not start < (place := 0.5 * (start + end)) < end:
            break
        places = start, 0.5 * (start + place), place, 0.5 * (place + end), end
        sizes = [abs(number) for at in places[1:4] if (number := value(at)) is not None]
        if len(sizes) < 3:
            return True
        reached.append(max(sizes))
        peak = sizes.index(reached[-1])
        start, end = places[peak], places[peak + 2]
    return len(reached) > LAST and reached[-1] > max(most, STILL_GROWN * reached[-1 - LAST])


BREAK = "a value jumps or grows without bound"
"""Why a branch of values that are only computed ends between two rows."""
SAME = 1e-6
"""Scaled distance below which an answer lies on a known branch."""


def follow_sweep(
    model: Model,
    name: str,
    values: ArrayLike,
    want: Iterable[str] | None = None,
    given: Mapping[str, Value | None] | None = None,
    guesses: Mapping[str, float] | None = None,
) -> CurveTable:
    """Every branch of answers at some value of the swept variable, followed to its ends.

    Branches are numbered in the order in which they are found, from the first value on. Raises
    RuleSheetError for unknown names, ValueError if there is no finite value to sweep.
    """
    plan = prepare(model, (name,), want, given, guesses)
    swept = np.atleast_1d(np.asarray(values, dtype=np.float64))
    if not swept.size or not np.isfinite(swept).all():
        raise ValueError("a sweep that is followed needs finite numbers to sweep over")
    answers: list[tuple[float, Leaf]] = []
    for value in swept.tolist():
        verdict, _ = plan.judged((value,))
        answers += ((value, leaf) for leaf in verdict.leaves if verdict.status is Status.SOLVED)
    sizes: dict[str, float] = {}
    for _, leaf in answers:
        for key, number in leaf.branch.values.items():
            if isinstance(number, float):
                sizes[key] = max(sizes.get(key, 0.0), abs(number))
    found: list[_Found] = []
    for value, leaf in answers:
        if not any(branch.passes(leaf, value) for branch in found):
            found += _followed(plan, name, swept, leaf, value, sizes)
    return _table(plan, name, found)


def _followed(
    plan: Plan, name: str, values: Array, leaf: Leaf, value: float, sizes: Mapping[str, float]
) -> Iterator[_Found]:
    """The branch of an answer, if its rules leave a single curve."""
    graph, span = planner(plan.model).graph, (float(values.min()), float(values.max()))
    unknowns, moving = _curve_unknowns(graph, leaf.branch.steps, name)
    names = (*unknowns, name)
    fixed = {n: v for n, v in leaf.branch.values.items() if n not in moving}
    system = CurveSystem(graph, names, fixed, frozenset((*plan.given, name)), span)
    point = np.array([*(leaf.branch.values[n] for n in unknowns), value], dtype=np.float64)
    scale = np.array([sizes.get(n) or 1.0 for n in names])
    scale[-1] = span[1] - span[0] or scale[-1]
    scale = np.where(np.isfinite(system.turn), system.turn / (2 * np.pi), scale)
    curve = traced(system, point, scale)
    if curve is not None:
        yield _Found(curve, system, tuple(curve_rows(curve, np.unique(values))))


class _Found(NamedTuple):
    """A branch, the system it was followed in, and its rows."""

    curve: Curve
    system: CurveSystem
    rows: tuple[tuple[CurvePoint, bool], ...]

    def passes(self, leaf: Leaf, value: float) -> bool:
        """Whether an answer at a swept value lies on the branch."""
        known = leaf.branch.values.get
        at = [known(name) for name in self.system.names[:-1]]
        # what does not change with the swept variable agrees as well
        if not all(_same(known(name), number) for name, number in self.system.fixed.items()):
            return False
        if not all(isinstance(v, float) for v in at):
            return False
        point, problem = np.array([*at, value]), self.curve.pieces[0].problem
        apart = (problem.apart(row.z, point) for row, _ in self.rows if row.z[-1] == value)
        return any(float(np.linalg.norm(off)) <= SAME * (1 + len(point)) for off in apart)


def _same(one: Value | None, other: Value) -> bool:
    if isinstance(one, float) and isinstance(other, float):
        return abs(one - other) <= SAME * max(abs(one), abs(other))
    return one == other


def _table(plan: Plan, name: str, found: Sequence[_Found]) -> CurveTable:
    want = tuple(n for n in plan.want if n != name)
    rows, branches = list[_Row](), list[Branch]()
    for run, closed, start, end in (run for one in found for run in _runs(one, want)):
        folds = [(place, row) for place, row in enumerate(run, len(rows)) if row.point.fold]
        limits = tuple(Limit(float(row.point.z[-1]), row.greatest, place) for place, row in folds)
        last = len(rows) + len(run)
        branches.append(Branch(len(branches) + 1, len(rows), last, closed, start, end, limits))
        rows += run
    columns = {name: np.array([row.point.z[-1] for row in rows], dtype=np.float64)}
    columns |= {n: column_of([row.values.get(n) for row in rows], n) for n in want}
    labels = free_name("branch", columns), free_name("arc", columns)
    sizes = [branch.last - branch.first for branch in branches]
    columns[labels[0]] = np.repeat(np.arange(1, len(branches) + 1), sizes)
    columns[labels[1]] = np.array([row.point.arc for row in rows], dtype=np.float64)
    status = np.array([CODES[row.status] for row in rows], dtype=np.int8)
    return CurveTable(columns, status, name, tuple(branches), labels, plan.model.files)


class _Row(NamedTuple):
    """A row with its wanted values; ``greatest``: the swept variable rises before it."""

    point: CurvePoint
    greatest: bool
    status: Status
    values: Values


_Run: TypeAlias = tuple[Sequence[_Row], bool, str, str]
"""Rows that are connected, whether they close, and why there are none before and after."""


def _runs(found: _Found, want: Sequence[str]) -> Iterator[_Run]:
    """The rows of a branch, separated where there is no answer if nothing can have several
    values."""
    curve, system = found.curve, found.system
    scale = curve.pieces[0].problem.scale
    rows = [_Row(*row, *system.filled(row[0], want, scale)) for row in found.rows]
    start = _end(curve.first_end, rows[0].point.z, system)
    end = _end(curve.last_end, rows[-1].point.z, system)
    if len(system.names) > 1:
        # an end where the rules do not hold to rounding goes: a curve only comes near to it
        for edge in () if curve.closed else (-1, 0):
            if rows and not (rows[edge].point.fold or rows[edge].status is Status.SOLVED):
                del rows[edge]
        if rows:
            yield rows, curve.closed, start, end
        return

    @cache
    def answer(place: float) -> Values:
        status, values = system.filled(rows[0].point._replace(z=np.array([place])), want, scale)
        return values if status is Status.SOLVED else {}

    def value(name: str, place: float) -> float | None:
        """The value; symbols count as 0, since only a missing one matters."""
        found = answer(place).get(name)
        return 0.0 if isinstance(found, str) else found

    turn = system.graph.single_turn
    solved = groupby(enumerate(rows), key=lambda item: item[1].status is Status.SOLVED)
    for run in [list(group) for there, group in solved if there]:
        first, last = run[0][0], run[-1][0]
        begins = start if first == 0 else End.DOMAIN.value
        for place in range(first, last):
            expect_time()
            ends_at = float(rows[place].point.z[-1]), float(rows[place + 1].point.z[-1])
            if any(is_discontinuous(*ends_at, partial(value, name), turn(name)) for name in want):
                yield rows[first : place + 1], False, begins, BREAK
                first, begins = place + 1, BREAK
        ends = end if last == len(rows) - 1 else End.DOMAIN.value
        yield rows[first : last + 1], False, begins, ends


def _end(end: End, z: Array, system: CurveSystem) -> str:
    """Why a branch ends there, with the variable whose range ends."""
    if end is not End.BOUNDARY:
        return str(end.value)
    apart = np.minimum(np.abs(z - system.low), np.abs(z - system.high)) / (1.0 + np.abs(z))
    place = int(np.argmin(apart))
    return f"{system.names[place]} reaches {z[place] + 0.0:.10g}"
