"""Cases and measurements: one set of inputs, or many along a line of one of them."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from rulesheets.evaluate.digits import context
from rulesheets.model import Model, Value
from solver.chart.methods import TOLERANCES, Case, End, Method, methods
from solver.chart.reference import ActiveRules, State, active_rules, applies, exact_state
from solver.path.planner import planner
from solver.plan import Plan, prepare
from solver.result import Status
from solver.solving import solve

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
