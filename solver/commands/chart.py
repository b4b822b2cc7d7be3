"""``backsolve chart``: methods measured on a sheet, how long each takes and how far its answers are off.

Exact are the states that satisfy the active rules to 50 digits.
"""

from __future__ import annotations

import csv
import math
from argparse import ArgumentParser, Namespace
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from io import StringIO
from time import perf_counter
from timeit import Timer
from typing import Any, NamedTuple, TypeAlias

from rulesheets.deadline import expect_time
from rulesheets.diagnosis import RuleSheetError
from rulesheets.evaluate.digits import context
from rulesheets.model import Model, Value
from rulesheets.syntax import escaped
from solver.accuracy.digits import ManyDigits, Work
from solver.commands.inputs import Option, Request, add_input_options, read_request
from solver.commands.over import read_approach, read_axes
from solver.commands.running import Command
from solver.derivatives.linearization import Linearization, linearize
from solver.facts import FALSE, Mark, Status, Unsolved
from solver.files import write_file
from solver.kernel.block import BlockKernel
from solver.numerics.newton import METHODS, Jacobian, Residual, ScipyRoot, System, scipy_root
from solver.numerics.tolerances import scaled_norm
from solver.path import SolveBlock
from solver.path.planner import planner
from solver.pictures.drawing import picture_kind
from solver.report import table
from solver.report.text import result_text
from solver.result import Result, Solution
from solver.solution.conclusion import can_prove
from solver.solving import solve
from solver.sweeps import Plan, prepare

OURS = "backsolve"
DIGITS = 60
OFF = 0.05
"""How far off the answer iterations begin, relative to each unknown."""
TOLERANCES, FEW = tuple(10.0**-k for k in range(2, 16)), (1e-6, 1e-12)
"""Of Newton's method at one set of inputs, and along an input."""
NONE = 1e-30
"""What a number of 50 digits may be instead of 0; errors beside it are absolute."""
LEAST_TIME, LEAST_RUNS, MOST_RUNS = 0.02, 3, 200
MOST = 2_000
"""Values of a chart over an input: each is solved by every method several times."""

State: TypeAlias = Mapping[str, Any]
"""Numbers by name, exact ones of many digits, and symbols."""
Run: TypeAlias = Callable[[], tuple[Sequence[State], str, "int | None"]]
"""A solve: its answers, what is said where there are none, and its iterations."""


class Mode(NamedTuple):
    """A regular square part of the rules, and the exact state that they have."""

    rules: Linearization
    state: State


class Case(NamedTuple):
    """An answered sheet: its exact states, that of the primary answer first; errors of ``judged`` count."""

    result: Result
    judged: tuple[str, ...]
    modes: tuple[Mode, ...]

    def error(self, answer: State) -> float:
        """The worst relative error over the judged variables, against the state to which it is least."""
        turn = planner(self.result.model).graph.turn
        return min(
            max((_relative(answer[n], mode.state[n], turn(n)) for n in self.judged), default=0.0)
            for mode in self.modes
        )


def measure(
    model: Model,
    inputs: Mapping[str, Value | None],
    want: Sequence[str] | None,
    guesses: Mapping[str, float],
    name: str | None = None,
    numbers: Sequence[float] = (),
) -> Iterator[Mark]:
    """Every method at one set of inputs, or at each of the ``numbers`` of the input ``name``.

    Iterations begin at the exact state of the number before, or 5 % off where other rules are active. Where
    the sheet has no regular answer nothing is measured, and along an input that is said of ``solve``.
    """
    plan: Plan | None = None
    before: Mode | None = None
    names = () if name is None else (name,)
    for number in numbers if names else (None,):
        given: dict[str, Any] = {**inputs, **dict.fromkeys(names, number)}
        began = perf_counter()
        result = solve(model, given, want=want, guesses=guesses)
        seconds = perf_counter() - began
        case = _case(result)
        if case is not None:
            plan = plan or prepare(model, names, case.judged, given, dict(guesses))
            for family, tolerance, run in _methods(case, plan, given, _start(case.modes[0], before)):
                yield _mark(case, family, tolerance, run, number)
            before = case.modes[0]
        elif names:
            yield Mark(OURS, OURS, None, str(result.status), math.nan, None, seconds, number)


def _case(result: Result) -> Case | None:
    """The primary answer, with every other one as another exact state; None where none is regular."""
    if result.status is not Status.SOLVED:
        return None
    found = (mode_at(result.model, solution, result.inputs) for solution in result.solutions)
    modes = tuple(mode for mode in found if mode is not None)
    judged = tuple(n for n in result.wanted if all(n in mode.rules.unknowns for mode in modes))
    return Case(result, judged, modes) if modes else None


def mode_at(model: Model, values: Mapping[str, Value], inputs: Mapping[str, Value]) -> Mode | None:
    """The rules that hold at an answer, and the exact state near it; None where an unknown is free."""
    rules, state = linearize(model, values, inputs), dict[str, Any](inputs)
    for block in rules.blocks:
        equations = [model.equations[e] for e in block.equations]
        system = ManyDigits(equations, block.unknowns, {**values, **state}, DIGITS, Work(10**12))
        root = system.newton([float(values[name]) for name in block.unknowns])
        if root is None:
            return None
        state.update(zip(block.unknowns, root, strict=True))
    return Mode(rules, state) if rules.blocks else None


def _start(mode: Mode, before: Mode | None) -> list[float]:
    """Where iterations begin: at the state before, if it has the same rules; else beside the answer."""
    unknowns = mode.rules.unknowns
    if before is not None and sorted(before.rules.equations) == sorted(mode.rules.equations):
        return [float(before.state[name]) for name in unknowns]
    numbers = [float(mode.state[name]) for name in unknowns]
    return [n * (1 + (OFF if k % 2 else -OFF)) if n else OFF for k, n in enumerate(numbers)]


def _methods(
    case: Case, plan: Plan, given: Mapping[str, Value | None], start: Sequence[float]
) -> Iterator[tuple[str, float | None, Run]]:
    """The family of each method, its own tolerance, and what runs it."""
    model, inputs, rules = plan.model, case.result.inputs, case.modes[0].rules
    asked = {"want": plan.want, "guesses": plan.guesses}
    yield OURS, None, lambda: _solved(model, given, asked)
    yield f"{OURS}, prepared", None, lambda: _prepared(plan, [inputs[name] for name in plan.inputs])
    if can_prove():
        yield f"{OURS}, proved", None, lambda: _solved(model, given, {**asked, "prove": True})
    kernel = BlockKernel(planner(model).graph, SolveBlock(rules.equations, rules.unknowns, ()))
    known = [v for name in kernel.known if isinstance(v := inputs[name], float)]
    system = kernel.residual(known), kernel.jacobian(known), start

    def ended(run: Callable[[], ScipyRoot]) -> tuple[Sequence[State], str, int | None]:
        x, success, used = run()
        return [dict(zip(rules.unknowns, x, strict=True))] if success else [], "no convergence", used

    for to in FEW if plan.inputs else TOLERANCES:
        yield "Newton", to, partial(ended, partial(plain_newton, *system, to))
    for by in METHODS:
        yield f"scipy {by}", None, partial(ended, partial(scipy_root, *system, by))


def plain_newton(
    residual: Residual, jacobian: Jacobian, start: Sequence[float], tolerance: float, most: int = 60
) -> ScipyRoot:
    """Full steps from ``start`` (n,) until one is short; no success where one leaves the domain."""
    system, x = System(residual, jacobian, [abs(v) or 1.0 for v in start]), list(start)
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


def _solved(model: Model, given: Mapping[str, Value | None], asked: dict[str, Any]) -> tuple[Any, str, None]:
    """``solver.solve``, from the model on; where proof is asked for an answer is one that is proved."""
    result = solve(model, given, **asked)
    if result.status is not Status.SOLVED:
        return (), str(result.status), None
    kept = [s for s in result.solutions if "prove" not in asked or (s.proof is not None and s.proof.proved)]
    return kept, "not proved", None


def _prepared(plan: Plan, numbers: Sequence[Value]) -> tuple[Sequence[State], str, None]:
    try:
        return [dict(zip(plan.want, row, strict=True)) for row in plan.all(*numbers)], "", None
    except Unsolved as unsolved:
        return (), str(unsolved.status), None


def _mark(case: Case, family: str, tolerance: float | None, run: Run, at: float | None) -> Mark:
    answers, said, iterations = run()  # once without the clock: what is compiled at first use is compiled
    error = min(map(case.error, answers), default=math.nan)
    limit = max(FALSE, 1e3 * (tolerance or 0.0))
    status = said if not answers else "solved" if error <= limit else "false"
    radii = (
        answer.radius[name] / (abs(float(answer[name])) or 1.0)
        for answer in answers
        if isinstance(answer, Solution) and answer.radius
        for name in case.judged
    )
    method = family if tolerance is None else f"{family} to {tolerance:.0e}"
    taken: list[float] = []
    while len(taken) < LEAST_RUNS or (len(taken) < MOST_RUNS and sum(taken) < LEAST_TIME):
        taken.append(Timer(run).timeit(1))
    return Mark(
        method, family, tolerance, status, error, iterations, min(taken), at, max(radii, default=None)
    )


def _relative(found: Any, exact: Any, turn: float | None) -> float:
    mp = context(DIGITS)
    miss = mp.mpf(found) - exact
    if turn:
        miss -= turn * mp.nint(miss / turn)
    return float(abs(miss / exact)) if abs(exact) > NONE else float(abs(miss))


# --- the command ---

COLUMNS = ("method", "tolerance", "at", "status", "error", "iterations", "seconds", "radius")
KINDS = (".png", ".svg", ".csv")
DPI = 130.0


def chart_table(marks: Sequence[Mark]) -> str:
    """One line a method, at one set of inputs."""
    rows = (
        (m.method, m.status, _short(m.error), _short(m.radius), str(m.iterations or ""), _micro(m.seconds))
        for m in marks
    )
    return table(("Method", "Status", "Error", "Radius", "Iterations", "µs"), rows)


def stability_table(marks: Sequence[Mark], name: str) -> str:
    """One line a method: values of the input that it solved, where it is worst, and the median time."""
    methods = dict.fromkeys(mark.method for mark in marks)
    heads = ("Method", "Solved", "False", "Nothing", "Worst error", f"at {name}", "µs")
    return table(heads, (_row(method, [m for m in marks if m.method == method]) for method in methods))


def _row(method: str, marks: Sequence[Mark]) -> tuple[str, ...]:
    said = Counter(mark.status for mark in marks)
    silent = len(marks) - said["solved"] - said["false"]
    worst = max(marks, key=lambda mark: -1.0 if math.isnan(mark.error) else mark.error)
    median = sorted(mark.seconds for mark in marks)[len(marks) // 2]
    at = "" if math.isnan(worst.error) else f"{worst.at:.10g}"
    counts = f"{said['solved']} of {len(marks)}", str(said["false"]), str(silent)
    return method, *counts, _short(worst.error), at, _micro(median)


def chart_csv(marks: Iterable[Mark]) -> str:
    """One line a measurement, all digits; empty where there is nothing."""
    text = StringIO()
    writer = csv.DictWriter(text, COLUMNS, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    for mark in marks:
        writer.writerow({**mark._asdict(), "error": "" if math.isnan(mark.error) else mark.error})
    return text.getvalue()


def _short(error: float | None) -> str:
    return "" if error is None or math.isnan(error) else f"{error:.0e}" if error else "0"


def _micro(seconds: float) -> str:
    return f"{1e6 * seconds:.1f}"


def _arguments(parser: ArgumentParser) -> None:
    add_input_options(parser)
    along = parser.add_mutually_exclusive_group()
    along.add_argument("--over", metavar="NAME=START:STOP:STEP", help="a chart over the values of an input")
    along.add_argument("--approach", metavar="NAME=LIMIT:1e-1..1e-15", help="a chart towards a limit of it")
    parser.add_argument("-o", "--output", metavar="FILE", help="write the chart: .png, .svg or .csv")


def _run(arguments: Namespace) -> int:
    """Measure, print, draw; 0 where there is something to measure, 1 where the sheet has no answer."""
    path = arguments.output
    kind = "" if path is None else picture_kind(path, KINDS, "chart")
    request = read_request(arguments)
    request.expect_output(path)
    name, places = _line(arguments, request)
    marks = tuple(measure(request.model, request.inputs, request.want, request.guesses, name, list(places)))
    if all(math.isnan(mark.error) for mark in marks):
        first = {**request.inputs, name: next(iter(places))} if name and places else request.inputs
        print(result_text(solve(request.model, first, want=request.want, guesses=request.guesses)))
        print("\nthere is no isolated answer to measure methods by")
        return 1
    print(chart_table(marks) if name is None else stability_table(marks, name))
    if path is not None:
        data = chart_csv(marks).encode() if kind == ".csv" else _drawn(request, marks, name, places, kind)
        write_file(path, data)
        print(f"\n{escaped(path)}")
    return 0


def _line(arguments: Namespace, request: Request) -> tuple[str | None, dict[float, float]]:
    """The varied input, and where each of its values is drawn: at itself, or at its distance from a limit."""
    if arguments.approach:
        name, places = read_approach(arguments.approach, request.model)
    elif arguments.over:
        ((name, axis),) = read_axes([arguments.over], request.model).items()
        values = axis[: MOST + 1].tolist()
        if len(values) > MOST or not all(isinstance(value, float) for value in values):
            said, note = f"a chart is over at most {MOST:,} numbers", "take a larger step"
            raise RuleSheetError(Option("over", arguments.over).wrong("E424", said, note))
        places = {value: value for value in values}
    else:
        return None, {}
    request.swept([name])
    return name, places


def _drawn(
    request: Request, marks: Sequence[Mark], name: str | None, places: dict[float, float], kind: str
) -> bytes:
    from solver.pictures.page import encode
    from solver.pictures.plot import speed_picture, stability_picture

    if name is None:
        return encode(speed_picture(marks, request.model.name), kind[1:], DPI)
    near = any(place != value for value, place in places.items())
    unit = request.model.variables[name].unit
    label = f"relative distance of {name} from its limit" if near else f"{name}, {unit}" if unit else name
    picture = stability_picture(marks, request.model.name, label, places if near else None)
    return encode(picture, kind[1:], DPI)


COMMANDS = {"chart": Command(_arguments, _run)}
