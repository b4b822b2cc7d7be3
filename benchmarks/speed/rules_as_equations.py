"""The rules that a solve used, as one square system for fsolve: the same equations, all at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.speed.solvers import fsolve_on
from rulesheets.evaluate import differentiate, holds
from rulesheets.model import Model, Value
from rulesheets.syntax.nodes import subtract
from solver.kernel.emitter import compile_expressions
from solver.path import Evaluate, Select, SolveBlock, equations_of
from solver.solution.verdict import Verdict
from solver.sweeps import Plan


@dataclass(frozen=True)
class System:
    """``unknowns`` in order; ``residual(numbers, *unknowns)`` their equations, ``jacobian`` the
    slopes."""

    unknowns: tuple[str, ...]
    residual: Callable[..., Any]
    jacobian: Callable[..., Any]

    def fsolve(self, with_jacobian: bool = True) -> Callable[[float, Any], Any]:
        """``f(number, start)`` gives the unknowns; raises ArithmeticError where fsolve says it has
        none."""
        flat, n = self.jacobian, len(self.unknowns)
        if not with_jacobian:
            return fsolve_on(self.residual, None)
        return fsolve_on(self.residual, lambda *numbers: np.array(flat(*numbers)).reshape(n, n))

    def start(self, values: Mapping[str, Value]) -> Any:
        return np.array([values[name] for name in self.unknowns])


def system_of(model: Model, plan: Plan, verdict: Verdict) -> System | None:
    """The system of the primary answer of a row; None where it is not one of as many rules as
    numbers."""
    values = verdict.leaves[0].branch.values
    equations: list[int] = []
    unknowns: list[str] = []
    for step in verdict.leaves[0].branch.steps:
        if isinstance(step, Evaluate | Select):
            unknowns.append(step.unknown)
        elif isinstance(step, SolveBlock):
            unknowns += step.unknowns
        else:
            continue
        equations += [e for e in equations_of(step) if _active(model, e, values)][: _room(step)]
    if len(equations) != len(unknowns) or any(isinstance(values[n], str) for n in unknowns):
        return None
    misses = [subtract(model.equations[e].left, model.equations[e].right) for e in equations]
    others = [n for n in values if n not in unknowns and n not in plan.inputs]
    names = (*plan.inputs, *unknowns, *others)
    fixed = tuple(values[n] for n in others)
    residual = compile_expressions(misses, names)
    slopes = compile_expressions(
        [differentiate(miss, n) for miss in misses for n in unknowns], names
    )
    return System(
        tuple(unknowns),
        lambda *numbers: residual(*numbers, *fixed),
        lambda *numbers: slopes(*numbers, *fixed),
    )


def _room(step: object) -> int:
    return len(step.unknowns) if isinstance(step, SolveBlock) else 1


def _active(model: Model, equation: int, values: Mapping[str, Value]) -> bool:
    given = [name for name, value in values.items() if isinstance(value, float)]
    return all(
        holds(model.conditions[p.condition], values, given) == p.holds
        for p in model.equations[equation].guard
    )
