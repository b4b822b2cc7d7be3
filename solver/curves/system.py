"""The active rules of a core as a problem of numbers: residual, Jacobian, ranges, and when they change."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from rulesheets.evaluate import NotDifferentiable, Undefined, derivatives, differentiate
from rulesheets.functions import TABLE
from rulesheets.model import Equation, Model, Value
from rulesheets.syntax.nodes import Call, Name, subtract
from solver.derivatives.linearization import active_equations
from solver.kernel.emitter import compile_expressions
from solver.numerics.continuation import Problem, Vector
from solver.numerics.linear_algebra import independent_rows
from solver.path.graph import ModelGraph


class CoreSystem:
    """The rules between ``names``: the unknowns of the core, then the parameter; all else is ``fixed``."""

    def __init__(
        self,
        graph: ModelGraph,
        names: tuple[str, ...],
        fixed: Mapping[str, Value],
        inputs: frozenset[str],
        span: tuple[float, float],
    ) -> None:
        self.model, self.graph, self.names = graph.model, graph, names
        self.fixed, self.inputs = fixed, inputs
        known = {*fixed, *names}
        self.candidates = [
            e for e in self.model.equations if known.issuperset(e.names) and set(names).intersection(e.names)
        ]
        self.guarded = any(e.guard for e in self.candidates)
        jumps = dict(filter(None, map(_direction, self.candidates)))
        turns = [jumps.get(name) or graph.turn(name) for name in names[:-1]]
        low, high = zip(*(_range(self.model, name) for name in names), strict=True)
        self.turn = np.array([turn or np.inf for turn in turns] + [np.inf])
        self.low, self.high = np.array(low), np.array(high)
        self.turn[np.isfinite(self.low) | np.isfinite(self.high)] = np.inf
        self.low[-1], self.high[-1] = max(self.low[-1], span[0]), min(self.high[-1], span[1])

    def values(self, z: Vector) -> dict[str, Value]:
        """What is known at a point of the curve."""
        return {**self.fixed, **dict(zip(self.names, z.tolist(), strict=True))}

    def regime(self, z: Vector) -> tuple[int, ...]:
        """The candidates that are active at a point."""
        if not self.guarded:
            return ()
        return tuple(e.index for e in self.active(z))

    def active(self, z: Vector) -> list[Equation]:
        chosen = {e.index for e in self.candidates}
        return [e for e in active_equations(self.model, self.values(z), self.inputs) if e.index in chosen]

    def problem(self, at: Vector, scale: Vector) -> Problem | None:
        """The problem of the rules that are active at ``at``; None where they leave more than a curve."""
        equations = self._independent(at, scale)
        if equations is None:
            return None
        residual, jacobian = self._residual(equations), self._jacobian(equations)
        ranges = (self.low, self.high)
        return Problem(residual, jacobian, scale, self.turn, *ranges, self.regime, self.regime(at))

    def _independent(self, at: Vector, scale: Vector) -> list[Equation] | None:
        rows, usable = [], []
        for equation in self.active(at):
            try:
                row = self._slopes(equation, self.values(at))
            except Undefined:
                continue
            if np.isfinite(row).all():
                rows.append(row)
                usable.append(equation)
        if not rows:
            return [] if len(self.names) == 1 else None
        found = independent_rows(rows, scale)
        return [usable[i] for i in found.rows] if len(found.rows) == len(self.names) - 1 else None

    def holds(self, z: Vector, within: float) -> bool:
        """Whether every active rule of the core holds at a point, to a share of its terms."""
        values = self.values(z)
        for equation in self.active(z):
            try:
                left, by_left = derivatives(equation.left, values)
                right, by_right = derivatives(equation.right, values)
            except Undefined:
                return False
            size = sum(abs(s * v) for by in (by_left, by_right) for n, s in by.items() if (v := values[n]))  # type: ignore[operator]
            miss = math.remainder(left - right, _jump(equation) or math.inf)
            if abs(miss) > within * max(size, abs(left), abs(right)):
                return False
        return True

    # --- numbers ---

    def _constants(self) -> dict[str, float]:
        return {name: value for name, value in self.fixed.items() if isinstance(value, float)}

    def _residual(self, equations: Sequence[Equation]) -> Callable[[Vector], Vector]:
        constants = self._constants()
        forms = [subtract(e.left, e.right) for e in equations]
        function = compile_expressions(forms, (*self.names, *constants))
        jumps = [_jump(e) for e in equations]
        known = tuple(constants.values())

        def residual(z: Vector) -> Vector:
            values = function(*z.tolist(), *known)
            pairs = zip(values, jumps, strict=True)
            return np.array([math.remainder(v, jump) if jump else v for v, jump in pairs], dtype=np.float64)

        return residual

    def _jacobian(self, equations: Sequence[Equation]) -> Callable[[Vector], NDArray[np.float64]]:
        constants = self._constants()
        known, shape = tuple(constants.values()), (len(equations), len(self.names))
        try:
            partials = [differentiate(subtract(e.left, e.right), n) for e in equations for n in self.names]
        except NotDifferentiable:
            return lambda z: np.array([self._slopes(e, self.values(z)) for e in equations])
        function = compile_expressions(partials, (*self.names, *constants))
        return lambda z: np.array(function(*z.tolist(), *known), dtype=np.float64).reshape(shape)

    def _slopes(self, equation: Equation, values: Mapping[str, Value]) -> list[float]:
        left, right = (derivatives(side, values)[1] for side in (equation.left, equation.right))
        return [left.get(name, 0.0) - right.get(name, 0.0) for name in self.names]


def _range(model: Model, name: str) -> tuple[float, float]:
    variable = model.variables[name]
    return variable.low, variable.high


def _direction(equation: Equation) -> tuple[str, float] | None:
    """The angle of a rule ``angle = atan2d(…)``, and the turn by which it jumps where that passes 180."""
    sides = (equation.left, equation.right)
    for one, other in (sides, sides[::-1]):
        if isinstance(one, Name) and isinstance(other, Call):
            row = TABLE[other.function]
            if row.direction and row.angle is not None:
                return one.name, row.angle
    return None


def _jump(equation: Equation) -> float | None:
    found = _direction(equation)
    return None if found is None else found[1]
