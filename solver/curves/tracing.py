"""From one answer to the whole branch that it lies on."""

from __future__ import annotations

from dataclasses import dataclass, replace

from rulesheets.deadline import expect_time
from solver.curves.system import CoreSystem
from solver.numerics.continuation import CurvePoint, End, Problem, Trace, Vector, follow, point_at, start

MEETS = 1e-6
"""Share of its terms by which a rule may miss where it takes over from another."""

CHANGES = 200
"""Changes of rules that one branch may go through."""


@dataclass(frozen=True)
class Piece:
    """A stretch of a branch on which the same rules hold."""

    problem: Problem
    points: tuple[CurvePoint, ...]


@dataclass(frozen=True)
class Curve:
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


def traced(system: CoreSystem, seed: Vector, scale: Vector) -> Curve | None:
    """The branch through ``seed``; None where the rules have no single curve there."""
    problem = system.problem(seed, scale)
    ahead = None if problem is None else start(problem, seed)
    if problem is None or ahead is None:
        return None
    forward, end = _onward(system, problem, ahead, ahead)
    if end is End.CLOSED:
        return Curve(tuple(forward), end, end)
    behind = replace(ahead, tangent=-ahead.tangent, orientation=_reversed(ahead))
    backward, first_end = _onward(system, problem, behind, behind)
    return Curve(_joined(backward, forward), first_end, end)


def _reversed(point: CurvePoint) -> int:
    """Turning the tangent around changes the sign of the bordered determinant."""
    return -point.orientation


def _onward(
    system: CoreSystem, problem: Problem, first: CurvePoint, home: CurvePoint
) -> tuple[list[Piece], End]:
    """Follow a curve through changes of its rules, as long as the answer goes on."""
    pieces: list[Piece] = []
    for _ in range(CHANGES):
        expect_time()
        trace: Trace = follow(problem, first, home)
        pieces.append(Piece(problem, trace.points))
        if trace.end is not End.CHANGED:
            return pieces, trace.end
        taken_over = _taken_over(system, problem, trace.points[-1])
        if taken_over is None:
            return pieces, End.CHANGED
        problem, first = taken_over
    return pieces, End.LIMIT


def _taken_over(system: CoreSystem, problem: Problem, last: CurvePoint) -> tuple[Problem, CurvePoint] | None:
    """The rules that hold beyond, and the point where they take over; None where they do not hold there."""
    beyond = last.z + 1e-7 * problem.scale * last.tangent
    if not system.holds(beyond, MEETS):
        return None
    following = system.problem(beyond, problem.scale)
    if following is None:
        return None
    point = point_at(following, last.z, last.tangent, last.arc)
    return None if point is None else (following, point)


def _joined(backward: list[Piece], forward: list[Piece]) -> tuple[Piece, ...]:
    """One run through both: the backward one turned around, arc lengths counted from its far end."""
    length = backward[-1].points[-1].arc
    pieces = []
    for piece in reversed(backward):
        turned = (
            replace(p, tangent=-p.tangent, orientation=-p.orientation, arc=length - p.arc)
            for p in reversed(piece.points)
        )
        pieces.append(Piece(piece.problem, tuple(turned)))
    shifted = [
        Piece(piece.problem, tuple(replace(p, arc=p.arc + length) for p in piece.points)) for piece in forward
    ]
    return (*pieces, *shifted)
