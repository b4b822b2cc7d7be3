"""Methods measured on a sheet: how long each takes, and how far its answers are from exact ones.

Exact are the states that satisfy the active rules to 50 digits. Where ``solve`` finds nothing along an input,
Newton's method in many digits follows them, so that every method is also judged there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from timeit import Timer
from typing import Any, NamedTuple, TypeAlias

from rulesheets.deadline import expect_time
from rulesheets.evaluate.digits import context
from rulesheets.model import Model, Value
from solver.accuracy.digits import ManyDigits, Work
from solver.derivatives.linearization import Linearization, active_equations, linearize
from solver.facts import FALSE, Mark, Status, Unsolved
from solver.kernel.block import BlockKernel
from solver.numerics.newton import METHODS, Jacobian, Residual, ScipyRoot, System, scipy_root
from solver.numerics.termination import scaled_norm
from solver.path.planner import planner
from solver.path.steps import SolveBlock
from solver.solution.proof import can_prove
from solver.solving import solve
from solver.sweeps.plan import Plan, prepare

DIGITS = 60
OFF = 0.05
"""How far off the answer iterations begin, relative to each unknown."""
TOLERANCES, FEW = tuple(10.0**-k for k in range(2, 16)), (1e-6, 1e-12)
"""Of Newton's method at one set of inputs, and along an input."""
NONE = 1e-30
"""What a number of 50 digits may be instead of 0; errors beside it are absolute."""
LEAST_TIME, LEAST_RUNS, MOST_RUNS = 0.02, 3, 200

State: TypeAlias = Mapping[str, Any]
"""Numbers of many digits by name, and symbols."""


class Mode(NamedTuple):
    """A regular square part of the rules, and the state that they have."""

    rules: Linearization
    state: State


class Case(NamedTuple):
    """A sheet at its inputs: every exact state, that of the primary answer first.

    ``judged`` are the variables that errors are told of.
    """

    model: Model
    inputs: Mapping[str, Value]
    judged: tuple[str, ...]
    modes: tuple[Mode, ...]

    @property
    def given(self) -> dict[str, Value | None]:
        """All inputs, those of the sheet that are cleared included."""
        return {name: self.inputs.get(name) for name in self.model.variables}


class End(NamedTuple):
    """What one solve came to: ``answers``, none where there is no success; ``said`` is why.

    ``radii``: of every answer, how far each number is proved to be from the exact one at most.
    """

    answers: Sequence[State]
    iterations: int | None = None
    said: str = ""
    radii: Sequence[Mapping[str, float]] = ()


Method: TypeAlias = tuple[str, str, float | None, Callable[[], End]]
"""Its name, the family that it is drawn with, its own tolerance, and what runs it."""


def measure(
    model: Model,
    inputs: Mapping[str, Value | None],
    want: Sequence[str] | None,
    guesses: Mapping[str, float],
    name: str | None = None,
    numbers: Sequence[float] = (),
) -> Iterator[Mark]:
    """Every method at one set of inputs, or at each of the ``numbers`` of the input ``name``.

    Iterations begin at the exact state of the number before, or 5 % off where other rules are active.
    Nothing is measured where the sheet has no regular answer.
    """
    before: Case | None = None
    plan: Plan | None = None
    names = () if name is None else (name,)
    for number in (None,) if name is None else numbers:
        given = dict(inputs) if name is None else {**inputs, name: number}
        case = solved_case(model, given, want, guesses)
        if case is None and before is not None:
            case = _followed(before, {**before.inputs, **dict.fromkeys(names, number)})
        if case is None:
            continue
        plan = plan or prepare(model, names, case.judged, case.given, dict(guesses))
        start = _start(case.modes[0], before and before.modes[0])
        for method in _methods(case, plan, names, start, FEW if names else TOLERANCES):
            yield _mark(case, method, number)
        before = case


# --- exact states ---


def solved_case(
    model: Model, inputs: Mapping[str, Value | None], want: Sequence[str] | None, guesses: Mapping[str, float]
) -> Case | None:
    """The case of the primary answer, with every other answer as another exact state of it."""
    result = solve(model, inputs, want=want, guesses=guesses)
    if result.status is not Status.SOLVED:
        return None
    found = (mode_at(model, solution, result.inputs) for solution in result.solutions)
    modes = tuple(mode for mode in found if mode is not None)
    judged = tuple(n for n in result.wanted if all(n in mode.rules.unknowns for mode in modes))
    return Case(model, result.inputs, judged, modes) if modes else None


def mode_at(model: Model, values: Mapping[str, Value], inputs: Mapping[str, Value]) -> Mode | None:
    """The rules that hold at an answer, and the exact state near it; None where an unknown is free."""
    rules = linearize(model, values, inputs)
    state = _exact_state(model, rules, values, inputs) if rules.blocks else None
    return None if state is None else Mode(rules, state)


def _exact_state(model: Model, rules: Linearization, start: State, inputs: State) -> State | None:
    """The state near ``start`` that satisfies the rules; None where Newton's method fails."""
    state: dict[str, Any] = dict(inputs)
    for block in rules.blocks:
        equations = [model.equations[e] for e in block.equations]
        system = ManyDigits(equations, block.unknowns, {**start, **state}, DIGITS, Work(10**12))
        root = system.newton([start[name] for name in block.unknowns])
        if root is None:
            return None
        state.update(zip(block.unknowns, root, strict=True))
    return state


def _followed(before: Case, inputs: Mapping[str, Any]) -> Case | None:
    """The same rules and states at other inputs; None where other rules are active there."""
    modes = []
    for rules, state in before.modes:
        found = _exact_state(before.model, rules, state, inputs)
        if found is None or _active(before, found, inputs) != _active(before, state, before.inputs):
            return None
        modes.append(Mode(rules, found))
    return before._replace(inputs=inputs, modes=tuple(modes))


def _active(case: Case, state: State, inputs: Mapping[str, Value]) -> list[int]:
    values = {name: v if isinstance(v, str) else float(v) for name, v in state.items()}
    return [equation.index for equation in active_equations(case.model, values, inputs)]


def _start(mode: Mode, before: Mode | None) -> list[float]:
    """Where iterations begin: at the state before, if it has the same rules; else beside the answer."""
    unknowns = mode.rules.unknowns
    if before is not None and sorted(before.rules.equations) == sorted(mode.rules.equations):
        return [float(before.state[name]) for name in unknowns]
    numbers = [float(mode.state[name]) for name in unknowns]
    return [n * (1 + (OFF if k % 2 else -OFF)) if n else OFF for k, n in enumerate(numbers)]


# --- methods ---


def _methods(
    case: Case, plan: Plan, names: Sequence[str], start: Sequence[float], tolerances: Sequence[float]
) -> Iterator[Method]:
    """All of them, for one case. ``names`` are the inputs that the plan takes by position."""
    yield "backsolve", "backsolve", None, lambda: _solved(case, plan)
    yield "backsolve, prepared", "backsolve, prepared", None, lambda: _prepared(case, plan, names)
    if can_prove():
        yield "backsolve, proved", "backsolve, proved", None, lambda: _solved(case, plan, prove=True)
    rules = case.modes[0].rules
    kernel = BlockKernel(planner(case.model).graph, SolveBlock(rules.equations, rules.unknowns, ()))
    known = [v for name in kernel.known if isinstance(v := case.inputs[name], float)]
    residual, jacobian = kernel.residual(known), kernel.jacobian(known)

    def ended(run: Callable[[], ScipyRoot]) -> End:
        root = run()
        answers = [dict(zip(rules.unknowns, root.x, strict=True))] if root.success else []
        return End(answers, root.evaluations, "no convergence")

    for to in tolerances:
        newton = partial(plain_newton, residual, jacobian, start, to)
        yield f"Newton to {to:.0e}", "Newton", to, partial(ended, newton)
    for by in METHODS:
        scipy = partial(scipy_root, residual, jacobian, start, by)
        yield f"scipy {by}", f"scipy {by}", None, partial(ended, scipy)


def plain_newton(
    residual: Residual, jacobian: Jacobian, start: Sequence[float], tolerance: float, most: int = 60
) -> ScipyRoot:
    """Full steps from ``start`` (n,) until one is short; no success where one leaves the domain."""
    system = System(residual, jacobian, [abs(v) or 1.0 for v in start])
    x = list(start)
    for used in range(1, most + 1):
        expect_time()
        point = system.point(x)
        if point is None:
            return ScipyRoot(tuple(x), False, used)
        step = point.correction(point.residual)
        x = [v + d for v, d in zip(x, step, strict=True)]
        if scaled_norm(step, point.weight) <= tolerance:
            return ScipyRoot(tuple(x), True, used)
    return ScipyRoot(tuple(x), False, most)


def _solved(case: Case, plan: Plan, prove: bool = False) -> End:
    """``solver.solve``, from the model on; with ``prove`` an answer is one that is proved."""
    result = solve(case.model, case.given, want=plan.want, guesses=plan.guesses, prove=prove)
    if result.status is not Status.SOLVED:
        return End((), said=str(result.status))
    if not prove:
        return End(result.solutions)
    proved = [s for s in result.solutions if s.proof is not None and s.proof.proved]
    return End(proved, said="not proved", radii=[solution.radius for solution in proved])


def _prepared(case: Case, plan: Plan, names: Sequence[str]) -> End:
    try:
        rows = plan.all(*(case.inputs[name] for name in names))
    except Unsolved as unsolved:
        return End((), said=str(unsolved.status))
    return End([dict(zip(plan.want, row, strict=True)) for row in rows])


# --- marks ---


def _mark(case: Case, method: Method, at: float | None) -> Mark:
    name, family, tolerance, run = method
    end = run()  # once without the clock: what is compiled at first use is compiled
    error = min((_error(case, answer) for answer in end.answers), default=math.nan)
    limit = max(FALSE, 1e3 * (tolerance or 0.0))
    status = end.said if not end.answers else "solved" if error <= limit else "false"
    radii = (
        radius[name] / (abs(float(answer[name])) or 1.0)
        for answer, radius in zip(end.answers, end.radii, strict=False)
        for name in case.judged
    )
    radius = max(radii, default=None)
    return Mark(name, family, tolerance, status, error, end.iterations, _seconds(run), at, radius)


def _seconds(run: Callable[[], End]) -> float:
    """The least of several runs."""
    taken: list[float] = []
    while len(taken) < LEAST_RUNS or (len(taken) < MOST_RUNS and sum(taken) < LEAST_TIME):
        taken.append(Timer(run).timeit(1))
    return min(taken)


def _error(case: Case, answer: State) -> float:
    """The worst relative error over the judged variables, against the state to which it is least."""
    turn = planner(case.model).graph.turn
    return min(
        max((_relative(answer[n], mode.state[n], turn(n)) for n in case.judged), default=0.0)
        for mode in case.modes
    )


def _relative(found: Any, exact: Any, turn: float | None) -> float:
    mp = context(DIGITS)
    miss = mp.mpf(found) - exact
    if turn:
        miss -= turn * mp.nint(miss / turn)
    return float(abs(miss / exact)) if abs(exact) > NONE else float(abs(miss))
