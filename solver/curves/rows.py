"""Points of a branch as rows: the swept values in the order of the curve, its ends and its turning points."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from rulesheets.model import Model, Value
from solver.curves.system import CoreSystem
from solver.curves.tracing import Curve, Piece
from solver.numerics.continuation import CurvePoint, Problem, Vector, crossing
from solver.result import Status
from solver.solution.explore import explore
from solver.verdicts.verdict import judge

NOUGHT = 1e-15
"""Share of its magnitude below which a coordinate may be what is left of an exact 0."""


@dataclass(frozen=True)
class CurveRow:
    """One row before it is filled in."""

    point: CurvePoint
    greatest: bool = False


def curve_rows(curve: Curve, values: Vector) -> Iterator[CurveRow]:
    """The first point, every swept value that the branch passes, every fold, the last point."""
    first, last = curve.points[0], curve.points[-1]
    yield CurveRow(first, _rises(first))
    for piece in curve.pieces:
        for here, there in zip(piece.points, piece.points[1:], strict=False):
            yield from _between(piece, here, there, values)
            swept = bool((values == there.z[-1]).any())
            if there is not last and (there.fold or swept):
                yield CurveRow(there, _rises(here))
    if len(curve.points) > 1:
        yield CurveRow(last, _rises(last))


def _rises(point: CurvePoint) -> bool:
    return bool(point.tangent[-1] > 0)


def _between(piece: Piece, here: CurvePoint, there: CurvePoint, values: Vector) -> Iterator[CurveRow]:
    """Swept values strictly between two neighbours, in the order of the curve."""
    a, b = float(here.z[-1]), float(there.z[-1])
    inside = values[(values > min(a, b)) & (values < max(a, b))].tolist()
    for value in sorted(inside, reverse=b < a):
        found = _crossing(piece.problem, here, there, value)
        if found is not None:
            yield CurveRow(found)


def _crossing(problem: Problem, here: CurvePoint, there: CurvePoint, value: float) -> CurvePoint | None:
    """From the end whose tangent is the steeper: that of a fold does not reach to the swept value."""
    if here.fold:
        back = CurvePoint(there.z, -there.tangent, 0.0, -there.orientation)
        reach = float((here.z - there.z) / problem.scale @ back.tangent)
        found = crossing(problem, back, reach, value)
        if found is None:
            return None
        return CurvePoint(found.z, -found.tangent, there.arc - found.arc, -found.orientation)
    reach = float((there.z - here.z) / problem.scale @ here.tangent)
    return crossing(problem, here, reach, value)


class Filling:
    """Computes what is wanted at a point of the curve, by an ordinary solve with the core given.

    So is all that does not move along the curve: of several answers it is that of the branch.
    """

    def __init__(self, model: Model, system: CoreSystem, want: Sequence[str], scale: Vector) -> None:
        self.model, self.system, self.want, self.scale = model, system, tuple(want), scale

    def __call__(self, point: CurvePoint) -> tuple[Status, dict[str, Value]]:
        """The status and the wanted values that are determined. A fold is ``singular``."""
        status, values = self._solved(point.z)
        if status is not Status.SOLVED and not point.fold:
            cleared = np.where(np.abs(point.z) <= NOUGHT * self.scale, 0.0, point.z)
            if not np.array_equal(cleared, point.z):
                status, values = self._solved(cleared)
        return Status.SINGULAR if point.fold else status, values

    def _solved(self, z: Vector) -> tuple[Status, dict[str, Value]]:
        inputs = {**self.system.fixed, **self.wrapped(z)}
        found = explore(self.model, inputs, self.want, {}, self.want)
        verdict = judge(self.model, found, inputs, {})
        values = verdict.leaves[0].branch.values if verdict.leaves else inputs
        return verdict.status, {name: values[name] for name in self.want if name in values}

    def wrapped(self, z: Vector) -> dict[str, float]:
        """The core with angles in (-180, 180], as far as its rules admit it."""
        plain = dict(zip(self.system.names, z.tolist(), strict=True))
        moved = z.copy()
        for place, turn in enumerate(self.system.turn):
            if math.isfinite(turn):
                moved[place] -= turn * math.ceil(moved[place] / turn - 0.5)
        if np.array_equal(moved, z) or not self.system.holds(moved, 1e-12):
            return plain
        return dict(zip(self.system.names, moved.tolist(), strict=True))
