"""One branch of a curve traced point by point, and its points as rows of a table."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rulesheets.deadline import expect_time
from rulesheets.evaluate import Undefined
from rulesheets.functions import TABLE
from rulesheets.model import Equation, Value, Values
from rulesheets.syntax.nodes import Call
from solver.accuracy.rule_sides import sides, size
from solver.derivatives.linearization import active_equations, slopes
from solver.facts import Status
from solver.files.tables import Table
from solver.kernel.block import kernel_of
from solver.leaves import Asked
from solver.numerics.continuation import CurvePoint, End, Problem, crossing, follow, point_at, start
from solver.numerics.elimination import independent_rows
from solver.numerics.linear_algebra import Array
from solver.path import SolveBlock
from solver.path.graph import ModelGraph
from solver.solution.explore import explore
from solver.solution.verdict import judge


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


class Piece(NamedTuple):
    """A stretch of a branch on which the same rules hold."""

    problem: Problem
    points: tuple[CurvePoint, ...]


class Curve(NamedTuple):
    """One branch: pieces in the order of the arc length, and why it ends on either side."""

    pieces: tuple[Piece, ...]
    first_end: End
    last_end: End

    @property
    def closed(self) -> bool:
        return self.last_end is End.CLOSED

    @property
    def points(self) -> tuple[CurvePoint, ...]:
        return tuple(point for piece in self.pieces for point in piece.points)


def traced(system: CurveSystem, seed: Array, scale: Array) -> Curve | None:
    """The branch through ``seed``; None if the rules have no single curve there."""
    problem = system.problem(seed, scale)
    ahead = None if problem is None else start(problem, seed)
    if problem is None or ahead is None:
        return None
    forward, end = _onward(system, problem, ahead)
    if end is End.CLOSED:
        return Curve(tuple(forward), end, end)
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
    return Curve(tuple(moved), first_end, end)


def _turned(point: CurvePoint) -> CurvePoint:
    """The same point on the way back: turning the tangent changes the sign of the bordered
    determinant."""
    return point._replace(tangent=-point.tangent, arc=-point.arc, orientation=-point.orientation)


def _onward(system: CurveSystem, problem: Problem, home: CurvePoint) -> tuple[list[Piece], End]:
    """Follow a curve through changes of its rules, as long as the answer continues."""
    pieces, first = list[Piece](), home
    for _ in range(CHANGES):
        expect_time()
        trace = follow(problem, first, home)
        pieces.append(Piece(problem, trace.points))
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


def curve_rows(curve: Curve, values: Array) -> Iterator[tuple[CurvePoint, bool]]:
    """The first point, every swept value that the branch passes, every fold, the last point.

    Each with whether the swept variable increases before it: where it turns back it is then the
    greatest.
    """
    first, last = curve.points[0], curve.points[-1]
    yield first, bool(first.tangent[-1] > 0)
    for piece in curve.pieces:
        for here, there in pairwise(piece.points):
            a, b = float(here.z[-1]), float(there.z[-1])
            inside = values[(values > min(a, b)) & (values < max(a, b))].tolist()
            # from the end with the steeper tangent: that of a fold does not reach the swept value
            begin, end = (_turned(there), here) if here.fold else (here, there)
            reach = float((end.z - begin.z) / piece.problem.scale @ begin.tangent)
            for value in sorted(inside, reverse=b < a):
                found = crossing(piece.problem, begin, reach, value)
                if found is not None:
                    yield _turned(found) if here.fold else found, False
            if there is not last and (there.fold or bool((values == b).any())):
                yield there, bool(here.tangent[-1] > 0)
    if len(curve.points) > 1:
        yield last, bool(last.tangent[-1] > 0)


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
