"""Cases and measurements: one set of inputs, or many along a line of one of them."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

from rulesheets.deadline import expect_time
from rulesheets.evaluate import Undefined
from rulesheets.evaluate.digits import context
from rulesheets.model import Equation, Model, Value
from rulesheets.syntax.nodes import subtract
from solver.accuracy.digits import linearized
from solver.derivatives.linearization import active_equations, linearize
from solver.facts import Status
from solver.kernel.block import BlockKernel
from solver.numerics.elimination import eliminate
from solver.numerics.newton import METHODS, Jacobian, Residual, ScipyRoot, System, scipy_root
from solver.numerics.termination import scaled_norm
from solver.path.planner import planner
from solver.path.steps import SolveBlock
from solver.plan import Plan, Unsolved, prepare
from solver.solution.proof import can_prove
from solver.solving import solve

MOST = 60
CUTS = 12


def plain_newton(
    residual: Residual,
    jacobian: Jacobian,
    start: Sequence[float],
    scale: Sequence[float],
    tolerance: float,
) -> ScipyRoot:
    """Full steps from ``start`` (n,), halved only to stay in the domain, until one is short."""
    system = System(residual, jacobian, [abs(s) or 1.0 for s in scale])
    point = system.point([float(v) for v in start])
    for used in range(1, MOST + 1):
        expect_time()
        if point is None:
            return ScipyRoot(tuple(start), False, used)
        step = point.correction(point.residual)
        norm, share = scaled_norm(step, point.weight), 1.0
        following = None
        for _ in range(CUTS):
            following = system.point([v + share * d for v, d in zip(point.x, step, strict=True)])
            if following is not None:
                break
            share /= 2
        if following is not None and norm <= tolerance and share == 1.0:
            return ScipyRoot(tuple(following.x), True, used)
        if following is None:
            return ScipyRoot(tuple(point.x), False, used)
        point = following
    return ScipyRoot(tuple(point.x) if point else tuple(start), False, MOST)


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


FALSE = 1e-6
"""A relative error beyond which what is called an answer is a false one (or a thousand tolerances)."""
OFF = 0.05
"""How far off the answer iterations begin, relative to each unknown."""
FEW = (1e-6, 1e-12)
"""The tolerances of a chart over an input."""
NONE = 1e-30
"""What a number of 50 digits may be instead of 0; errors beside it are absolute."""
LEAST_TIME = 0.02
SLOW = 1e-3
"""Seconds from which on other processes may well interrupt: processor time is taken instead."""
LEAST_RUNS, MOST_RUNS = 3, 200


@dataclass(frozen=True, slots=True)
class Mark:
    """One method on one case.

    ``error`` is the worst relative one over the wanted variables, nan where there is no answer; ``status``
    is solved, false, or what was said instead. ``at`` is the value of the varied input; ``radius`` the
    worst relative error that a proof leaves possible.
    """

    method: str
    family: str
    tolerance: float | None
    status: str
    error: float
    iterations: int | None
    seconds: float
    at: float | None = None
    radius: float | None = None


def measure(
    model: Model, inputs: Mapping[str, Value | None], want: Sequence[str] | None, guesses: Mapping[str, float]
) -> tuple[Mark, ...]:
    """Every method at one set of inputs; empty where the sheet has no regular answer there."""
    case = first_case(model, inputs, want, guesses)
    if case is None:
        return ()
    plan = _plan(case, guesses, ())
    return tuple(_mark(case, method, None) for method in methods(case, plan, (), TOLERANCES))


def measure_along(
    model: Model,
    inputs: Mapping[str, Value | None],
    want: Sequence[str] | None,
    guesses: Mapping[str, float],
    name: str,
    numbers: Sequence[float],
) -> Iterator[Mark]:
    """Every method at each of the ``numbers`` of the input ``name``.

    Iterations begin at the exact state of the number before, the first 5 % off.
    """
    previous: Case | None = None
    plan: Plan | None = None
    for number in numbers:
        here = {**inputs, name: number}
        case = _next_case(previous, name, number) or first_case(model, here, want, guesses)
        if case is None:
            continue
        plan = plan or _plan(case, guesses, (name,))
        for method in methods(case, plan, (name,), FEW):
            yield _mark(case, method, number)
        start = {**case.start, **{n: float(case.states[0][n]) for n in case.rules.flat_unknowns}}
        previous = replace(case, start=start)


def first_case(
    model: Model, inputs: Mapping[str, Value | None], want: Sequence[str] | None, guesses: Mapping[str, float]
) -> Case | None:
    """The case of the primary answer, with every other answer as another exact state of it."""
    result = solve(model, inputs, want=want, guesses=guesses)
    if result.status is not Status.SOLVED:
        return None
    modes: list[tuple[ActiveRules, State]] = []
    for solution in result.solutions:
        found = active_rules(model, solution, result.inputs)
        state = found and exact_state(found, solution, result.inputs)
        if found and state:
            modes.append((found, state))
    if not modes:
        return None
    (rules, state), *_ = modes
    judged = tuple(n for n in result.wanted if all(n in found.flat_unknowns for found, _ in modes))
    start = {name: _off(float(state[name]), place) for place, name in enumerate(rules.flat_unknowns)}
    return Case(model, result.inputs, judged, tuple(modes), start)


def _off(number: float, place: int) -> float:
    return number * (1 + (OFF if place % 2 else -OFF)) if number else OFF


def _next_case(previous: Case | None, name: str, number: float) -> Case | None:
    """The same rules and states at the next value of an input, followed with many digits."""
    if previous is None:
        return None
    given = {**previous.inputs, name: number}
    modes: list[tuple[ActiveRules, State]] = []
    for rules, before in previous.modes:
        state = exact_state(rules, before, given)
        if state is None or not applies(rules, previous.model, state, given):
            return None
        modes.append((rules, state))
    if _merged([state for _, state in modes], previous.judged):
        return None
    return replace(previous, inputs=given, modes=tuple(modes))


def _merged(states: Sequence[State], names: Sequence[str]) -> bool:
    """Whether two states that were apart have become one: a step too long to follow them."""
    return any(
        all(abs(one[n] - other[n]) <= abs(one[n]) * 1e-40 for n in names)
        for k, one in enumerate(states)
        for other in states[:k]
    )


def _plan(case: Case, guesses: Mapping[str, float], names: Sequence[str]) -> Plan:
    given: dict[str, Value | None] = {name: case.inputs.get(name) for name in case.model.variables}
    return prepare(case.model, names, case.judged, given, dict(guesses))


def _mark(case: Case, method: Method, at: float | None) -> Mark:
    began = time.perf_counter()
    end = method.run()  # once without the clock: what is compiled at first use is compiled
    slow = time.perf_counter() - began > SLOW
    seconds = _time(method, time.process_time if slow else time.perf_counter)
    errors = [_error(case, answer) for answer in end.answers]
    error = min(errors, default=math.nan)
    limit = max(FALSE, 1e3 * (method.tolerance or 0.0))
    status = _status(end, error, limit)
    radius = _radius(case, end)
    name, family = method.name, method.family
    return Mark(name, family, method.tolerance, status, error, end.iterations, seconds, at, radius)


def _radius(case: Case, end: End) -> float | None:
    """The worst relative radius of the judged numbers of all answers; None where nothing is proved."""
    shares = (
        radius[name] / abs(number) if (number := float(answer[name])) else radius[name]
        for answer, radius in zip(end.answers, end.radii, strict=False)
        for name in case.judged
    )
    return max(shares, default=None)


def _status(end: End, error: float, limit: float) -> str:
    if not end.answers:
        return end.said
    return "solved" if error <= limit else "false"


def _time(method: Method, clock: Callable[[], float]) -> float:
    """The least of several runs."""
    best, longest, spent = math.inf, 0.0, 0.0
    for run in range(1, MOST_RUNS + 1):
        began = clock()
        method.run()
        taken = clock() - began
        best, longest, spent = min(best, taken), max(longest, taken), spent + taken
        if spent - longest >= LEAST_TIME and run >= LEAST_RUNS:
            break
    return best


def _error(case: Case, answer: State) -> float:
    """The worst relative error over the judged variables, against the state to which it is least."""
    graph = planner(case.model).graph
    return min(
        max((_relative(answer[n], state[n], graph.turn(n)) for n in case.judged), default=0.0)
        for state in case.states
    )


def _relative(found: Any, exact: Any, turn: float | None) -> float:
    mp = context(60)
    miss = mp.mpf(found) - exact
    if turn:
        miss -= turn * mp.nint(miss / turn)
    return float(abs(miss / exact)) if abs(exact) > NONE else float(abs(miss))
