"""The states of a sheet to 50 digits: Newton's method on the active rules, in extended precision.

The inputs are taken as the exact numbers that they are. Nothing of the solver's own way to an answer is used
but the answer itself, as the place to start from.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from rulesheets.evaluate import Undefined
from rulesheets.evaluate.digits import context
from rulesheets.model import Equation, Model, Value
from rulesheets.syntax.nodes import subtract
from solver.accuracy.digits import linearized
from solver.derivatives.linearization import active_equations, linearize
from solver.numerics.elimination import eliminate

DIGITS = 60
RIGHT = 50
STEPS = 80
State: TypeAlias = Mapping[str, Any]
"""Numbers of many digits by name, and symbols."""


@dataclass(frozen=True)
class ActiveRules:
    """As many active rules as unknowns, in blocks that are solved one after another; ``active`` are all."""

    equations: tuple[tuple[Equation, ...], ...]
    unknowns: tuple[tuple[str, ...], ...]
    active: tuple[int, ...]

    @property
    def flat_equations(self) -> tuple[int, ...]:
        return tuple(equation.index for block in self.equations for equation in block)

    @property
    def flat_unknowns(self) -> tuple[str, ...]:
        return tuple(name for block in self.unknowns for name in block)


def active_rules(
    model: Model, values: Mapping[str, Value], inputs: Mapping[str, Value]
) -> ActiveRules | None:
    """The regular square part of the rules that hold at an answer; None where it leaves an unknown free."""
    found = linearize(model, values, inputs)
    if not found.blocks:
        return None
    equations = tuple(tuple(model.equations[e] for e in block.equations) for block in found.blocks)
    active = tuple(equation.index for equation in active_equations(model, values, inputs))
    return ActiveRules(equations, tuple(block.unknowns for block in found.blocks), active)


def applies(rules: ActiveRules, model: Model, state: State, inputs: Mapping[str, Value]) -> bool:
    """Whether the same rules are active at a state: conditions may come out otherwise there."""
    values = {name: v if isinstance(v, str) else float(v) for name, v in state.items()}
    return tuple(e.index for e in active_equations(model, values, inputs)) == rules.active


def exact_state(rules: ActiveRules, start: Mapping[str, Value], inputs: Mapping[str, Value]) -> State | None:
    """The state near ``start`` that satisfies the rules to 50 digits; None where Newton fails."""
    state: dict[str, Any] = dict(inputs)
    for equations, unknowns in zip(rules.equations, rules.unknowns, strict=True):
        solved = solve_extended(equations, unknowns, {**start, **state}, DIGITS, RIGHT)
        if solved is None:
            return None
        state.update(zip(unknowns, solved[0], strict=True))
    return state


def solve_extended(
    equations: Sequence[Equation], unknowns: Sequence[str], start: State, digits: int, right: int
) -> tuple[list[Any], int] | None:
    """Newton with ``digits`` digits until a step changes the unknowns by less than 10^-``right``, relatively
    (absolutely where they are as good as 0).

    Returns the values and the number of steps; None where it does not get there.
    """
    mp = context(digits)
    x = [mp.mpf(start[name]) for name in unknowns]
    forms = [subtract(equation.left, equation.right) for equation in equations]
    tolerance, small = mp.mpf(10) ** -right, mp.mpf(10) ** (-right // 2)
    for used in range(1, STEPS + 1):
        here = {**start, **dict(zip(unknowns, x, strict=True))}
        try:
            rows, residual = linearized(forms, unknowns, here, digits)
        except Undefined:
            return None
        change = eliminate(rows, residual)
        if change is None:
            return (x, used) if not any(residual) else None
        x = [v - d for v, d in zip(x, change, strict=True)]
        sizes = [abs(v) if abs(v) > small else 1 for v in x]
        if all(abs(d) <= tolerance * size for d, size in zip(change, sizes, strict=True)):
            return x, used
    return None
