"""All branches of the answers over the range of a sweep."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rulesheets.model import Model, Value
from solver.curves.core import core_of
from solver.curves.rows import CurveRow, Filling, curve_rows
from solver.curves.system import CoreSystem
from solver.curves.table import Branch, CurveTable, Limit
from solver.curves.tracing import Curve, traced
from solver.files.columns import free_name
from solver.leaves import Leaf
from solver.numerics.continuation import End
from solver.numerics.curve import Vector
from solver.plan import Plan, prepare
from solver.result import Status
from solver.solution import planner
from solver.table import CODES

SAME = 1e-6
"""Scaled distance below which an answer lies on a branch that is known."""


def follow_sweep(
    model: Model,
    name: str,
    values: ArrayLike,
    want: Iterable[str] | None = None,
    given: Mapping[str, Value | None] | None = None,
    guesses: Mapping[str, float] | None = None,
) -> CurveTable:
    """Every branch of answers that some value of the swept variable has an answer on, followed to its ends.

    Branches are numbered in the order in which they are found, from the first value on. Raises RuleSheetError
    for unknown names, ValueError where there is no finite value to sweep.
    """
    plan = prepare(model, (name,), want, given, guesses)
    swept = np.atleast_1d(np.asarray(values, dtype=np.float64))
    if not swept.size or not np.isfinite(swept).all():
        raise ValueError("a sweep that is followed needs finite numbers to sweep over")
    return _Following(plan, name, swept).run()


@dataclass(frozen=True)
class _Found:
    """A branch, the system it was followed in, and its rows."""

    curve: Curve
    system: CoreSystem
    rows: tuple[CurveRow, ...]

    def passes(self, leaf: Leaf, value: float) -> bool:
        """Whether an answer at a swept value lies on the branch."""
        at = [leaf.branch.values.get(name) for name in self.system.names[:-1]]
        if not all(isinstance(v, float) for v in at):
            return False
        point = np.array([*at, value], dtype=np.float64)
        problem = self.curve.pieces[0].problem
        return any(
            float(np.linalg.norm(problem.apart(row.point.z, point))) <= SAME * (1 + len(point))
            for row in self.rows
            if row.point.z[-1] == value
        )


class _Following:
    def __init__(self, plan: Plan, name: str, values: Vector) -> None:
        self.plan, self.name, self.values = plan, name, values
        self.model = plan.model
        self.span = float(values.min()), float(values.max())
        self.found: list[_Found] = []

    def run(self) -> CurveTable:
        answers = {value: self._answers(value) for value in self.values.tolist()}
        sizes = _magnitudes(leaf for leaves in answers.values() for leaf in leaves)
        for value, leaves in answers.items():
            for leaf in leaves:
                if not any(found.passes(leaf, value) for found in self.found):
                    self._seed(leaf, value, sizes)
        return self._table()

    def _answers(self, value: float) -> tuple[Leaf, ...]:
        verdict, _ = self.plan.judged((value,))
        return verdict.leaves if verdict.status is Status.SOLVED else ()

    def _seed(self, leaf: Leaf, value: float, sizes: Mapping[str, float]) -> None:
        """Follow the branch that an answer lies on, if its rules leave it one way to go."""
        core = core_of(self.model, leaf.branch.steps, self.name)
        names = (*core.names, self.name)
        fixed = {n: v for n, v in leaf.branch.values.items() if n not in core.moving}
        inputs = frozenset((*self.plan.given, self.name))
        system = CoreSystem(planner(self.model).graph, names, fixed, inputs, self.span)
        point = np.array([*(leaf.branch.values[n] for n in core.names), value], dtype=np.float64)
        scale = np.array([sizes.get(name) or 1.0 for name in names])
        scale[-1] = self.span[1] - self.span[0] or scale[-1]
        scale = np.where(np.isfinite(system.turn), system.turn / (2 * np.pi), scale)
        curve = traced(system, point, scale)
        if curve is not None:
            rows = tuple(curve_rows(curve, np.unique(self.values)))
            self.found.append(_Found(curve, system, rows))

    # --- the table ---

    def _table(self) -> CurveTable:
        want = tuple(n for n in self.plan.want if n != self.name)
        columns: dict[str, list[Any]] = {name: [] for name in (self.name, *want)}
        numbers: list[int] = []
        arcs: list[float] = []
        status: list[int] = []
        branches: list[Branch] = []
        for number, found in enumerate(self.found, start=1):
            first = len(status)
            filling = Filling(self.model, found.system, self.plan.given, want)
            for row in found.rows:
                outcome, values = filling(row.point)
                columns[self.name].append(float(row.point.z[-1]))
                for name in want:
                    columns[name].append(values.get(name))
                numbers.append(number)
                arcs.append(row.point.arc)
                status.append(CODES[outcome])
            branches.append(_branch(number, first, found))
        labels = free_name("branch", columns), free_name("arc", columns)
        table = {name: _column(values) for name, values in columns.items()}
        table[labels[0]] = np.array(numbers, dtype=np.int64)
        table[labels[1]] = np.array(arcs, dtype=np.float64)
        return CurveTable(table, np.array(status, dtype=np.int8), self.name, tuple(branches), labels)


def _magnitudes(leaves: Iterable[Leaf]) -> dict[str, float]:
    """The largest absolute value that each variable has in any answer."""
    sizes: dict[str, float] = {}
    for leaf in leaves:
        for name, value in leaf.branch.values.items():
            if isinstance(value, float):
                sizes[name] = max(sizes.get(name, 0.0), abs(value))
    return sizes


def _branch(number: int, first: int, found: _Found) -> Branch:
    limits = tuple(
        Limit(float(row.point.z[-1]), row.greatest, first + place)
        for place, row in enumerate(found.rows)
        if row.point.fold
    )
    curve = found.curve
    start = _end(curve.first_end, found.rows[0].point.z, found.system)
    end = _end(curve.last_end, found.rows[-1].point.z, found.system)
    return Branch(number, first, first + len(found.rows), curve.closed, start, end, limits)


def _end(end: End, z: Vector, system: CoreSystem) -> str:
    """Why a branch ends there, the variable named whose range is at its end."""
    if end is not End.BOUNDARY:
        return str(end.value)
    apart = np.minimum(np.abs(z - system.low), np.abs(z - system.high)) / (1.0 + np.abs(z))
    place = int(np.argmin(apart))
    return f"{system.names[place]} reaches {z[place] + 0.0:.10g}"


def _column(values: list[Any]) -> NDArray[Any]:
    if any(isinstance(value, str) for value in values):
        return np.array(values, dtype=object)
    return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
