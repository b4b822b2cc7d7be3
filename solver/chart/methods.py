"""The methods that are measured on a sheet: ours as they are, the same to looser tolerances, and scipy's."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from rulesheets.model import Model, Value
from solver.chart.plain_newton import plain_newton
from solver.chart.reference import ActiveRules, State
from solver.kernel.block import BlockKernel
from solver.numerics.newton import METHODS, ScipyRoot, scipy_root
from solver.path.planner import planner
from solver.path.steps import SolveBlock
from solver.plan import Plan, Unsolved
from solver.result import Status
from solver.solution.proof import can_prove
from solver.solving import solve

TOLERANCES = tuple(10.0**-k for k in range(2, 16))
SOLVE, PREPARED, PROVED = "backsolve", "backsolve, prepared", "backsolve, proved"


@dataclass(frozen=True, slots=True)
class End:
    """What one solve came to: ``answers`` are states, none where there is no success; ``said`` is why.

    ``radii``: of every answer, how far each number is proved to be from the exact one at most.
    """

    answers: tuple[State, ...]
    iterations: int | None = None
    said: str = ""
    radii: tuple[Mapping[str, float], ...] = ()


Run: TypeAlias = Callable[[], End]


@dataclass(frozen=True, slots=True)
class Method:
    """``family`` is what it is drawn with; ``tolerance`` that of a method that has one of its own."""

    name: str
    family: str
    run: Run
    tolerance: float | None = None


@dataclass(frozen=True)
class Case:
    """A sheet at its inputs: every exact state with the rules active there, and where iterations begin.

    ``judged`` are the variables that errors are told of, ``start`` is near the first state.
    """

    model: Model
    inputs: Mapping[str, Value]
    judged: tuple[str, ...]
    modes: tuple[tuple[ActiveRules, State], ...]
    start: Mapping[str, float]

    @property
    def rules(self) -> ActiveRules:
        """Those of the first state, which iterations are about."""
        return self.modes[0][0]

    @property
    def states(self) -> tuple[State, ...]:
        return tuple(state for _, state in self.modes)


def methods(case: Case, plan: Plan, names: Sequence[str], tolerances: Sequence[float]) -> Iterator[Method]:
    """All of them, for one case. ``names`` are the inputs that the plan takes by position."""
    numbers = tuple(case.inputs[name] for name in names)
    yield Method(SOLVE, SOLVE, lambda: _solved(case, plan))
    yield Method(PREPARED, PREPARED, lambda: _prepared(plan, numbers))
    if can_prove():
        yield Method(PROVED, PROVED, lambda: _solved(case, plan, prove=True))
    block = SolveBlock(case.rules.flat_equations, case.rules.flat_unknowns, ())
    kernel = BlockKernel(planner(case.model).graph, block)
    known = [v for name in kernel.known if isinstance(v := case.inputs[name], float)]
    residual, jacobian = kernel.residual(known), kernel.jacobian(known)
    start = [case.start[name] for name in block.unknowns]

    def named(end: ScipyRoot) -> End:
        answers = (dict(zip(block.unknowns, end.x, strict=True)),) if end.success else ()
        return End(answers, end.evaluations, "" if end.success else "no convergence")

    def newton_to(tolerance: float) -> Run:
        return lambda: named(plain_newton(residual, jacobian, start, start, tolerance))

    def scipy_by(method: str) -> Run:
        return lambda: named(scipy_root(residual, jacobian, start, method))

    for tolerance in tolerances:
        yield Method(f"Newton to {tolerance:.0e}", "Newton", newton_to(tolerance), tolerance)
    for method in METHODS:
        yield Method(f"scipy {method}", f"scipy {method}", scipy_by(method))


def _solved(case: Case, plan: Plan, prove: bool = False) -> End:
    """``solver.solve``, from the model on; with ``prove`` an answer is one that is proved."""
    given: dict[str, Value | None] = {name: case.inputs.get(name) for name in case.model.variables}
    result = solve(case.model, given, want=plan.want, guesses=plan.guesses, prove=prove)
    if result.status is not Status.SOLVED:
        return End((), said=str(result.status))
    if not prove:
        return End(result.solutions)
    proved = [s for s in result.solutions if s.proof is not None and s.proof.proved]
    return End(tuple(proved), said="not proved", radii=tuple(solution.radius for solution in proved))


def _prepared(plan: Plan, numbers: tuple[Value, ...]) -> End:
    try:
        rows = plan.all(*numbers)
    except Unsolved as unsolved:
        return End((), said=str(unsolved.status))
    return End(tuple(dict(zip(plan.want, row, strict=True)) for row in rows))
