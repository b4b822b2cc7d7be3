"""Curves of answers: every branch followed point by point through its folds, and its points as rows
of a table."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, partial
from itertools import groupby, pairwise
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rulesheets.deadline import expect_time
from rulesheets.evaluate import Undefined
from rulesheets.functions import TABLE
from rulesheets.model import Equation, Model, Value, Values
from rulesheets.syntax.nodes import Call, degree
from solver.accuracy.rule_sides import sides, size
from solver.derivatives.linearization import active_equations, slopes
from solver.facts import Status
from solver.files.tables import CODES, Table, column_of, free_name
from solver.kernel.block import kernel_of
from solver.leaves import Asked, Leaf
from solver.numerics.continuation import (
    CurvePoint,
    End,
    Problem,
    Trace,
    crossing,
    follow,
    point_at,
    start,
)
from solver.numerics.elimination import independent_rows
from solver.numerics.linear_algebra import Array
from solver.path import Assume, Evaluate, Select, SolveBlock, Step, equations_of, given_by
from solver.path.building import read_by
from solver.path.graph import ModelGraph
from solver.path.planner import planner
from solver.solution.explore import explore
from solver.solution.verdict import judge
from solver.sweeps import Plan, prepare


class CurveSystem:
    """The rules between ``names``: the unknowns of the curve, then the parameter; others are
    ``fixed``."""

    def __init__(
        self,
        graph: ModelGraph,
        names: tuple[str, ...],
        fixed: Values,
        inputs: frozenset[str],
        span: tuple[float, float],
    ) -> None:
        self.model, self.graph, self.names = graph.model, graph, names
        self.fixed, self.inputs = fixed, inputs
        known = {*fixed, *names}
        whole = (e for e in self.model.equations if known.issuperset(e.names))
        self.candidates = [e for e in whole if not set(names).isdisjoint(e.names)]
        self.guarded = any(e.guard for e in self.candidates)
        directions = {e.index: found for e in self.candidates if (found := _direction(e))}
        self.jump = {index: turn for index, (_, turn) in directions.items()}
        jumps = dict(directions.values())
        turns = [jumps.get(name) or graph.turn(name) for name in names[:-1]]
        ranges = [(v.low, v.high) for v in map(self.model.variables.__getitem__, names)]
        self.low, self.high = np.array(ranges).T.copy()
        self.turn = np.array([turn or np.inf for turn in turns] + [np.inf])
        self.turn[np.isfinite(self.low) | np.isfinite(self.high)] = np.inf
        self.low[-1], self.high[-1] = max(self.low[-1], span[0]), min(self.high[-1], span[1])

    def values(self, z: Array) -> dict[str, Value]:
        """The known values at a point of the curve."""
        return {**self.fixed, **dict(zip(self.names, z.tolist(), strict=True))}

    def regime(self, z: Array) -> tuple[int, ...]:
        """The candidates that are active at a point."""
        return tuple(e.index for e in self.active(z)) if self.guarded else ()

    def active(self, z: Array) -> list[Equation]:
        chosen = {e.index for e in self.candidates}
        every = active_equations(self.model, self.values(z), self.inputs)
        return [equation for equation in every if equation.index in chosen]

    def problem(self, at: Array, scale: Array) -> Problem | None:
        """The problem of the rules that are active at ``at``; None if they leave more than a
        curve."""
        values, rows, equations = self.values(at), [], []
        for equation in self.active(at):
            if (row := slopes(equation, values)) is not None:
                rows.append([row.get(name, 0.0) for name in self.names])
                equations.append(equation)
        kept = independent_rows(rows, scale).rows if rows else ()
        if len(kept) != len(self.names) - 1:
            return None
        equations = [equations[i] for i in kept]
        block = SolveBlock(tuple(e.index for e in equations), self.names, ())
        kernel = kernel_of(self.graph, block)
        jumps = [self.jump.get(e.index, math.inf) for e in equations]
        known: list[Any] = [self.fixed[name] for name in kernel.known]
        misses, derivatives = kernel.residual(known), kernel.jacobian(known)

        def residual(z: Array) -> Array:
            pairs = zip(misses(z.tolist()), jumps, strict=True)
            return np.array([math.remainder(miss, jump) for miss, jump in pairs], dtype=np.float64)

        def jacobian(z: Array) -> Array:
            return np.array(derivatives(z.tolist()), dtype=np.float64).reshape(-1, len(self.names))

        ranges = (self.low, self.high)
        return Problem(residual, jacobian, scale, self.turn, *ranges, self.regime, self.regime(at))

    def holds(self, z: Array, within: float) -> bool:
        """Whether every active rule of the curve holds at a point, up to a share of its terms."""
        values = self.values(z)
        for equation in self.active(z):
            try:
                left, right, *_ = sides(equation, values)
            except Undefined:
                return False
            miss = math.remainder(left - right, self.jump.get(equation.index, math.inf))
            if abs(miss) > within * max(size(equation, values), abs(left), abs(right)):
                return False
        return True

    def filled(
        self, point: CurvePoint, want: Sequence[str], scale: Array
    ) -> tuple[Status, dict[str, Value]]:
        """The status and the wanted values that are determined, by an ordinary solve with the
        curve's unknowns given.

        So is everything that does not change along the curve: of several answers it is that of the
        branch. A fold is ``singular``.
        """
        status, values = self._solved(point.z, want)
        if status is not Status.SOLVED and not point.fold:
            cleared = np.where(np.abs(point.z) <= NOUGHT * scale, 0.0, point.z)
            if not np.array_equal(cleared, point.z):
                status, values = self._solved(cleared, want)
        return Status.SINGULAR if point.fold else status, values

    def _solved(self, z: Array, want: Sequence[str]) -> tuple[Status, dict[str, Value]]:
        """With angles in (-180, 180], as far as the rules of the curve allow it."""
        finite = np.isfinite(self.turn)
        turn = np.where(finite, self.turn, 1.0)
        moved = np.where(finite, z - turn * np.ceil(z / turn - 0.5), z)
        inputs = self.values(moved if self.holds(moved, 1e-12) else z)
        asked = Asked(self.model, inputs, want, {}, want)
        verdict = judge(asked, explore(asked))
        values = verdict.leaves[0].branch.values if verdict.leaves else inputs
        return verdict.status, {name: values[name] for name in want if name in values}


def _direction(equation: Equation) -> tuple[str, float] | None:
    """The angle of a rule ``angle = atan2d(…)``, and the turn by which it jumps at 180."""
    for name, by in equation.definitions:
        if (
            isinstance(by, Call)
            and TABLE[by.function].direction
            and (turn := TABLE[by.function].angle)
        ):
            return name, turn
    return None


NOUGHT = 1e-15
"""Share of its magnitude below which a coordinate may be the rounding of an exact 0."""
MEETS = 1e-6
"""Share of its terms by which a rule may miss where it takes over from another."""
CHANGES = 200
"""Changes of rules that one branch may go through."""


SAME = 1e-6
"""Scaled distance below which an answer lies on a known branch."""


@dataclass(frozen=True, eq=False)
class Curve:
    """One branch: its pieces, each with rules of its own, in the order of the arc length, and why
    it ends on either side. It has rows at these ``values`` of the swept variable."""

    system: CurveSystem
    values: Array
    pieces: tuple[Trace, ...]
    first_end: End
    last_end: End

    @property
    def closed(self) -> bool:
        return self.last_end is End.CLOSED

    @cached_property
    def rows(self) -> tuple[tuple[CurvePoint, bool], ...]:
        """The first point, every swept value that the branch passes, every fold, the last point.

        Each with whether the swept variable increases before it: where it turns back it is then the
        greatest.
        """
        return tuple(self._rows())

    def _rows(self) -> Iterator[tuple[CurvePoint, bool]]:
        first, last = self.pieces[0].points[0], self.pieces[-1].points[-1]
        values = self.values
        yield first, bool(first.tangent[-1] > 0)
        for piece in self.pieces:
            for here, there in pairwise(piece.points):
                a, b = float(here.z[-1]), float(there.z[-1])
                inside = values[(values > min(a, b)) & (values < max(a, b))].tolist()
                # from the end with the steeper tangent: that of a fold does not reach the value
                begin, end = (_turned(there), here) if here.fold else (here, there)
                reach = float((end.z - begin.z) / piece.problem.scale @ begin.tangent)
                for value in sorted(inside, reverse=b < a):
                    found = crossing(piece.problem, begin, reach, value)
                    if found is not None:
                        yield _turned(found) if here.fold else found, False
                if there is not last and (there.fold or b in values):
                    yield there, bool(here.tangent[-1] > 0)
        if last is not first:
            yield last, bool(last.tangent[-1] > 0)

    def passes(self, leaf: Leaf, value: float) -> bool:
        """Whether an answer at a swept value lies on the branch."""
        known = leaf.branch.values.get
        at = [known(name) for name in self.system.names[:-1]]
        # what does not change with the swept variable agrees as well
        if not all(_same(known(name), number) for name, number in self.system.fixed.items()):
            return False
        if not all(isinstance(v, float) for v in at):
            return False
        point, problem = np.array([*at, value]), self.pieces[0].problem
        apart = (problem.apart(row.z, point) for row, _ in self.rows if row.z[-1] == value)
        return any(float(np.linalg.norm(off)) <= SAME * (1 + len(point)) for off in apart)


def traced(system: CurveSystem, values: Array, seed: Array, scale: Array) -> Curve | None:
    """The branch through ``seed``; None if the rules have no single curve there."""
    problem = system.problem(seed, scale)
    ahead = None if problem is None else start(problem, seed)
    if problem is None or ahead is None:
        return None
    forward, end = _onward(system, problem, ahead)
    if end is End.CLOSED:
        return Curve(system, values, tuple(forward), end, end)
    backward, first_end = _onward(system, problem, _turned(ahead))
    # one run through both: the backward one turned around, arc lengths counted from its far end
    pieces = [
        piece._replace(points=tuple(map(_turned, piece.points[::-1]))) for piece in backward[::-1]
    ]
    length = backward[-1].points[-1].arc
    moved = []
    for piece in (*pieces, *forward):
        points = (point._replace(arc=point.arc + length) for point in piece.points)
        moved.append(piece._replace(points=tuple(points)))
    return Curve(system, values, tuple(moved), first_end, end)


def _turned(point: CurvePoint) -> CurvePoint:
    """The same point on the way back: turning the tangent changes the sign of the bordered
    determinant."""
    return point._replace(tangent=-point.tangent, arc=-point.arc, orientation=-point.orientation)


def _onward(system: CurveSystem, problem: Problem, home: CurvePoint) -> tuple[list[Trace], End]:
    """Follow a curve through changes of its rules, as long as the answer continues."""
    pieces, first = list[Trace](), home
    for _ in range(CHANGES):
        expect_time()
        trace = follow(problem, first, home)
        pieces.append(trace)
        if trace.end is not End.CHANGED:
            return pieces, trace.end
        # the rules that hold beyond, and the point where they take over
        last = trace.points[-1]
        beyond = last.z + 1e-7 * problem.scale * last.tangent
        following = system.problem(beyond, problem.scale) if system.holds(beyond, MEETS) else None
        point = None if following is None else point_at(following, last.z, last.tangent, last.arc)
        if following is None or point is None:
            return pieces, End.CHANGED
        problem, first = following, point
    return pieces, End.LIMIT


class Limit(NamedTuple):
    """A limit position: the swept variable turns back at ``value``, its ``greatest`` or least, in
    ``row``."""

    value: float
    greatest: bool
    row: int


class Branch(NamedTuple):
    """One connected branch: its rows from ``first`` up to ``last``, exclusive.

    ``closed``: it returns to its start (the last row is the first one again). Otherwise ``start``
    and ``end`` say why it does not continue before its first and after its last row.
    """

    number: int
    first: int
    last: int
    closed: bool
    start: str
    end: str
    limits: tuple[Limit, ...]


class CurveTable(Table):
    """Columns by name: the swept variable, the wanted ones, then ``branch`` (1, 2, …) and ``arc``.

    ``arc`` is the length of the curve from the first row of its branch, every variable of the curve
    in units of its magnitude and angles in radians. Rows at limit positions have the status
    ``singular``, and the values that are determined there.
    """

    def __init__(
        self,
        columns: Mapping[str, NDArray[Any]],
        status: NDArray[np.int8],
        swept: str,
        branches: tuple[Branch, ...],
        labels: tuple[str, str],
        files: tuple[str, ...] = (),
    ) -> None:
        super().__init__(columns, status, files)
        self.swept, self.branches = swept, branches
        self.branch, self.arc = (self[label] for label in labels)


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
    found: list[Curve] = []
    for value, leaf in answers:
        if not any(branch.passes(leaf, value) for branch in found):
            curve = _followed(plan, name, swept, leaf, value, sizes)
            found += [] if curve is None else [curve]
    return _table(plan, name, found)


def _followed(
    plan: Plan, name: str, values: Array, leaf: Leaf, value: float, sizes: Mapping[str, float]
) -> Curve | None:
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
    return traced(system, np.unique(values), point, scale)


def _same(one: Value | None, other: Value) -> bool:
    if isinstance(one, float) and isinstance(other, float):
        return abs(one - other) <= SAME * max(abs(one), abs(other))
    return one == other


def _table(plan: Plan, name: str, found: Sequence[Curve]) -> CurveTable:
    want = tuple(n for n in plan.want if n != name)
    rows, branches = list[_Row](), list[Branch]()
    for run, closed, begins, ends in (run for one in found for run in _runs(one, want)):
        folds = [(place, row) for place, row in enumerate(run, len(rows)) if row.point.fold]
        limits = tuple(Limit(float(row.point.z[-1]), row.greatest, place) for place, row in folds)
        last = len(rows) + len(run)
        branches.append(Branch(len(branches) + 1, len(rows), last, closed, begins, ends, limits))
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


def _runs(curve: Curve, want: Sequence[str]) -> Iterator[_Run]:
    """The rows of a branch, separated where there is no answer if nothing can have several
    values."""
    system, scale = curve.system, curve.pieces[0].problem.scale
    rows = [_Row(*row, *system.filled(row[0], want, scale)) for row in curve.rows]
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
