"""Methods measured on a sheet: how long each takes, and how far its answers are from exact ones.

Exact are the states that satisfy the active rules to 50 digits. Along an input they are followed by Newton's
method in many digits, so that a method is also judged where ``solve`` itself finds nothing.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from timeit import Timer
from typing import Any, TypeAlias

from rulesheets.deadline import expect_time
from rulesheets.evaluate.digits import context
from rulesheets.model import Model, Value
from solver.accuracy.digits import ManyDigits, Work
from solver.derivatives.linearization import Linearization, active_equations, linearize
from solver.facts import Status
from solver.kernel.block import BlockKernel
from solver.numerics.newton import METHODS, Jacobian, Residual, ScipyRoot, System, scipy_root
from solver.numerics.termination import scaled_norm
from solver.path.planner import planner
from solver.path.steps import SolveBlock
from solver.plan import Plan, Unsolved, prepare
from solver.solution.proof import can_prove
from solver.solving import solve

DIGITS = 60
FALSE = 1e-6
"""A relative error beyond which what is called an answer is a false one (or a thousand tolerances)."""
OFF = 0.05
"""How far off the answer iterations begin, relative to each unknown."""
TOLERANCES, FEW = tuple(10.0**-k for k in range(2, 16)), (1e-6, 1e-12)
"""Of Newton's method at one set of inputs, and along an input."""
NONE = 1e-30
"""What a number of 50 digits may be instead of 0; errors beside it are absolute."""
LEAST_TIME, LEAST_RUNS, MOST_RUNS = 0.02, 3, 200
SLOW = 1e-3
"""Seconds from which on other processes may well interrupt: processor time is taken instead."""

State: TypeAlias = Mapping[str, Any]
"""Numbers of many digits by name, and symbols."""


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


@dataclass(frozen=True)
class Mode:
    """A regular square part of the rules, all the rules that are ``active``, and the state that they have."""

    rules: Linearization
    active: tuple[int, ...]
    state: State


@dataclass(frozen=True)
class Case:
    """A sheet at its inputs: every exact state, and where iterations begin, near the first of them.

    ``judged`` are the variables that errors are told of.
    """

    model: Model
    inputs: Mapping[str, Value]
    judged: tuple[str, ...]
    modes: tuple[Mode, ...]
    start: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class End:
    """What one solve came to: ``answers``, none where there is no success; ``said`` is why.

    ``radii``: of every answer, how far each number is proved to be from the exact one at most.
    """

    answers: tuple[State, ...]
    iterations: int | None = None
    said: str = ""
    radii: tuple[Mapping[str, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Method:
    """``family`` is what it is drawn with; ``tolerance`` that of a method that has one of its own."""

    name: str
    family: str
    run: Callable[[], End]
    tolerance: float | None = None


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
    case: Case | None = None
    plan: Plan | None = None
    for number in numbers:
        before = case
        case = _next_case(before, name, number) or first_case(model, {**inputs, name: number}, want, guesses)
        if case is None:
            case = before
            continue
        plan = plan or _plan(case, guesses, (name,))
        for method in methods(case, plan, (name,), FEW):
            yield _mark(case, method, number)
        first = case.modes[0]
        case = replace(case, start={**case.start, **{n: float(first.state[n]) for n in first.rules.unknowns}})


# --- exact states ---


def first_case(
    model: Model, inputs: Mapping[str, Value | None], want: Sequence[str] | None, guesses: Mapping[str, float]
) -> Case | None:
    """The case of the primary answer, with every other answer as another exact state of it."""
    result = solve(model, inputs, want=want, guesses=guesses)
    if result.status is not Status.SOLVED:
        return None
    found = (mode_at(model, solution, result.inputs) for solution in result.solutions)
    modes = tuple(mode for mode in found if mode is not None)
    if not modes:
        return None
    judged = tuple(n for n in result.wanted if all(n in mode.rules.unknowns for mode in modes))
    start = {}
    for place, name in enumerate(modes[0].rules.unknowns):
        number = float(modes[0].state[name])
        start[name] = number * (1 + (OFF if place % 2 else -OFF)) if number else OFF
    return Case(model, result.inputs, judged, modes, start)


def mode_at(model: Model, values: Mapping[str, Value], inputs: Mapping[str, Value]) -> Mode | None:
    """The rules that hold at an answer, and the exact state near it; None where an unknown is free."""
    rules = linearize(model, values, inputs)
    state = _exact_state(model, rules, values, inputs) if rules.blocks else None
    return None if state is None else Mode(rules, _active(model, values, inputs), state)


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


def _active(model: Model, state: State, inputs: Mapping[str, Value]) -> tuple[int, ...]:
    values = {name: v if isinstance(v, str) else float(v) for name, v in state.items()}
    return tuple(equation.index for equation in active_equations(model, values, inputs))


def _next_case(before: Case | None, name: str, number: float) -> Case | None:
    """The same rules and states at the next value of an input; None where other rules are active there."""
    if before is None:
        return None
    given, modes = {**before.inputs, name: number}, []
    for mode in before.modes:
        state = _exact_state(before.model, mode.rules, mode.state, given)
        if state is None or _active(before.model, state, given) != mode.active:
            return None
        modes.append(replace(mode, state=state))
    if _merged([mode.state for mode in modes], before.judged):
        return None
    return replace(before, inputs=given, modes=tuple(modes))


def _merged(states: Sequence[State], names: Sequence[str]) -> bool:
    """Whether two states that were apart have become one: a step too long to follow them."""
    return any(
        all(abs(one[n] - other[n]) <= abs(one[n]) * 1e-40 for n in names)
        for k, one in enumerate(states)
        for other in states[:k]
    )


# --- methods ---


def methods(case: Case, plan: Plan, names: Sequence[str], tolerances: Sequence[float]) -> Iterator[Method]:
    """All of them, for one case. ``names`` are the inputs that the plan takes by position."""
    yield Method("backsolve", "backsolve", lambda: _solved(case, plan))
    yield Method("backsolve, prepared", "backsolve, prepared", lambda: _prepared(case, plan, names))
    if can_prove():
        yield Method("backsolve, proved", "backsolve, proved", lambda: _solved(case, plan, prove=True))
    rules = case.modes[0].rules
    kernel = BlockKernel(planner(case.model).graph, SolveBlock(rules.equations, rules.unknowns, ()))
    known = [v for name in kernel.known if isinstance(v := case.inputs[name], float)]
    residual, jacobian = kernel.residual(known), kernel.jacobian(known)
    start = [case.start[name] for name in rules.unknowns]

    def iterated(name: str, family: str, run: Callable[[], ScipyRoot], tolerance: float | None) -> Method:
        def end() -> End:
            root = run()
            answers = (dict(zip(rules.unknowns, root.x, strict=True)),) if root.success else ()
            return End(answers, root.evaluations, "no convergence")

        return Method(name, family, end, tolerance)

    for to in tolerances:
        yield iterated(
            f"Newton to {to:.0e}", "Newton", partial(plain_newton, residual, jacobian, start, to), to
        )
    for by in METHODS:
        name = f"scipy {by}"
        yield iterated(name, name, partial(scipy_root, residual, jacobian, start, by), None)


def plain_newton(
    residual: Residual, jacobian: Jacobian, start: Sequence[float], tolerance: float, most: int = 60
) -> ScipyRoot:
    """Full steps from ``start`` (n,), halved only to stay in the domain, until one is short."""
    system = System(residual, jacobian, [abs(v) or 1.0 for v in start])
    point, used = system.point(list(start)), 0
    while point is not None and used < most:
        expect_time()
        used += 1
        step = point.correction(point.residual)
        shares = (0.5**k for k in range(12))
        tried = (
            (share, system.point([v + share * d for v, d in zip(point.x, step, strict=True)]))
            for share in shares
        )
        share, following = next(((share, there) for share, there in tried if there), (0.0, None))
        if following is None or (share == 1.0 and scaled_norm(step, point.weight) <= tolerance):
            return ScipyRoot(tuple((following or point).x), following is not None, used)
        point = following
    return ScipyRoot(tuple(point.x if point else start), False, used)


def _given(case: Case) -> dict[str, Value | None]:
    return {name: case.inputs.get(name) for name in case.model.variables}


def _plan(case: Case, guesses: Mapping[str, float], names: Sequence[str]) -> Plan:
    return prepare(case.model, names, case.judged, _given(case), dict(guesses))


def _solved(case: Case, plan: Plan, prove: bool = False) -> End:
    """``solver.solve``, from the model on; with ``prove`` an answer is one that is proved."""
    result = solve(case.model, _given(case), want=plan.want, guesses=plan.guesses, prove=prove)
    if result.status is not Status.SOLVED:
        return End((), said=str(result.status))
    if not prove:
        return End(result.solutions)
    proved = [s for s in result.solutions if s.proof is not None and s.proof.proved]
    return End(tuple(proved), said="not proved", radii=tuple(solution.radius for solution in proved))


def _prepared(case: Case, plan: Plan, names: Sequence[str]) -> End:
    try:
        rows = plan.all(*(case.inputs[name] for name in names))
    except Unsolved as unsolved:
        return End((), said=str(unsolved.status))
    return End(tuple(dict(zip(plan.want, row, strict=True)) for row in rows))


# --- marks ---


def _mark(case: Case, method: Method, at: float | None) -> Mark:
    began = time.perf_counter()
    end = method.run()  # once without the clock: what is compiled at first use is compiled
    slow = time.perf_counter() - began > SLOW
    seconds = _seconds(method.run, time.process_time if slow else time.perf_counter)
    error = min((_error(case, answer) for answer in end.answers), default=math.nan)
    limit = max(FALSE, 1e3 * (method.tolerance or 0.0))
    status = end.said if not end.answers else "solved" if error <= limit else "false"
    radii = (
        radius[name] / (abs(float(answer[name])) or 1.0)
        for answer, radius in zip(end.answers, end.radii, strict=False)
        for name in case.judged
    )
    name, family, tolerance = method.name, method.family, method.tolerance
    return Mark(name, family, tolerance, status, error, end.iterations, seconds, at, max(radii, default=None))


def _seconds(run: Callable[[], End], clock: Callable[[], float]) -> float:
    """The least of several runs."""
    timer, taken = Timer(run, timer=clock), list[float]()
    while len(taken) < LEAST_RUNS or (len(taken) < MOST_RUNS and sum(taken) - max(taken) < LEAST_TIME):
        taken.append(timer.timeit(1))
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
