"""``backsolve chart``: measures the time and the error of methods on a sheet.

The reference states satisfy the active rules to 50 digits.
"""

from __future__ import annotations

import math
from argparse import Namespace
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from time import perf_counter
from timeit import Timer
from typing import Any, TypeAlias

import numpy as np

from rulesheets.deadline import expect_time
from rulesheets.diagnosis import RuleSheetError
from rulesheets.evaluate.digits import context, in_many_digits
from rulesheets.model import Model, Value, Values
from rulesheets.syntax import escaped
from solver.commands import GIVEN, WANTED, Command, Option, Request, read_request
from solver.commands.over import read_approach, read_axes
from solver.derivatives.linearization import DIGITS, linearize, sharpened
from solver.facts import Status, Unsolved
from solver.files import csv_text, write_file
from solver.kernel.block import BlockKernel
from solver.numerics.newton import METHODS, Jacobian, Residual, ScipyRoot, Search, scipy_root
from solver.path import SolveBlock
from solver.path.planner import planner
from solver.pictures import FALSE, Measurement, picture_kind
from solver.report import table
from solver.report.sheet import result_text
from solver.solution.solving import Solution, can_prove, solve
from solver.sweeps import Plan, prepare

OURS = "backsolve"
STEPS, OFF = 60, 0.05
"""The most steps of Newton's method; and the relative distance of its start from the answer."""
TOLERANCES, FEW = tuple(10.0**-k for k in range(2, 16)), (1e-6, 1e-12)
"""Of Newton's method at one set of inputs, and along an input."""
NONE = 1e-30
"""The size of a number of 50 digits that counts as 0; errors next to it are absolute."""
MOST = 2_000
"""Values of a chart over an input: each is solved by every method several times."""

State: TypeAlias = Mapping[str, Any]
"""Numbers by name, exact ones of many digits, and symbols."""
Ended: TypeAlias = tuple[Sequence[State], int | None]
"""The answers of a method, and the number of iterations."""
Exact: TypeAlias = tuple[SolveBlock, State]
"""A regular square part of the rules, and the state that satisfies them."""
Method: TypeAlias = tuple[str, float | None, Callable[[], Ended]]
"""A family, its own tolerance, and a run."""


def measure(
    asked: Request, name: str | None = None, numbers: Sequence[float] = ()
) -> Iterator[Measurement]:
    """Measure every method at one set of inputs, or at ``numbers`` of the input ``name``.

    Every answer is a reference state, the primary one first. If the sheet has no regular answer
    nothing is measured; along an input this is recorded for ``solve``.
    """
    plan: Plan | None = None
    before: Exact | None = None
    names = () if name is None else (name,)
    for number in numbers if names else (None,):
        given: dict[str, Any] = {**asked.inputs, **dict.fromkeys(names, number)}
        began = perf_counter()
        result = solve(asked.model, given, asked.want, asked.guesses)
        seconds = perf_counter() - began
        answers = result.solutions if result.status is Status.SOLVED else ()
        exact = [near for one in answers if (near := exact_state(asked.model, one, result.inputs))]
        if exact:
            want = [n for n in result.wanted if all(n in block.unknowns for block, _ in exact)]
            plan = plan or prepare(asked.model, names, want, given, asked.guesses)
            others = _others(plan, exact[0], before, result.inputs)
            for method in (*_ours(plan, given, result.inputs), *others):
                yield _measured(plan, exact, method, number)
            before = exact[0]
        elif names:
            yield Measurement(OURS, None, number, str(result.status), math.nan, None, seconds)


def exact_state(model: Model, values: Values, inputs: Values) -> Exact | None:
    """The reference state; None if an unknown is free, or a function is known in floats only."""
    rules = linearize(model, values, inputs)
    known = (model.equations[e] for e in rules.equations)
    sides = (side for equation in known for side in equation.sides)
    if not rules.blocks or not all(map(in_many_digits, sides)):
        return None
    sharp = sharpened(model, rules, values, inputs)
    block = SolveBlock(rules.equations, rules.unknowns, ())
    return (block, sharp.values) if sharp.blocks == rules.blocks else None


def _ours(plan: Plan, given: Mapping[str, Value | None], inputs: Values) -> Iterator[Method]:
    """``solver.solve`` from the model on, the prepared plan, and proved answers."""

    def solved(prove: bool = False) -> Ended:
        answers = solve(plan.model, given, plan.want, plan.guesses, prove=prove).solutions
        return [s for s in answers if not prove or (s.proof and s.proof.proved)], None

    def prepared() -> Ended:
        with suppress(Unsolved):
            rows = plan.all(*(inputs[name] for name in plan.inputs))
            return [dict(zip(plan.want, row, strict=True)) for row in rows], None
        return [], None

    yield OURS, None, solved
    yield f"{OURS}, prepared", None, prepared
    if can_prove():
        yield f"{OURS}, proved", None, partial(solved, prove=True)


def _others(plan: Plan, exact: Exact, before: Exact | None, inputs: Values) -> Iterator[Method]:
    """Iterations from the previous reference state if it has the same rules, else from nearby."""
    block, state = exact
    kernel = BlockKernel(planner(plan.model).graph, block)
    known = [v for name in kernel.known if isinstance(v := inputs[name], float)]
    if before is not None and sorted(before[0].equations) == sorted(block.equations):
        start = [float(before[1][name]) for name in block.unknowns]
    else:
        numbers = [float(state[name]) for name in block.unknowns]
        start = [n * (1 + (OFF if k % 2 else -OFF)) if n else OFF for k, n in enumerate(numbers)]
    system = kernel.residual(known), kernel.jacobian(known), start

    def ended(run: Callable[[], ScipyRoot]) -> Ended:
        x, success, used = run()
        return [dict(zip(block.unknowns, x, strict=True))] if success else [], used

    for to in FEW if plan.inputs else TOLERANCES:
        yield "Newton", to, partial(ended, partial(plain_newton, *system, to))
    for by in METHODS:
        yield f"scipy {by}", None, partial(ended, partial(scipy_root, *system, by))


def plain_newton(
    residual: Residual, jacobian: Jacobian, start: Sequence[float], tolerance: float
) -> ScipyRoot:
    """Full steps from ``start`` (n,) until one is short; no success if one leaves the domain."""
    search, x = Search(residual, jacobian, start), np.array(start)
    used, short = 0, False
    while used < STEPS and not short and (point := search.at(x)) is not None:
        expect_time()
        x, short = x + point.step, point.norm(point.step) <= tolerance
        used += 1
    return ScipyRoot(tuple(x.tolist()), short, used)


def _measured(plan: Plan, states: Sequence[Exact], method: Method, at: float | None) -> Measurement:
    """A method with its largest relative error over the wanted variables, to the nearest state."""
    mp, turn = context(DIGITS), planner(plan.model).graph.turn
    names = [name for name in plan.want if all(name in block.unknowns for block, _ in states)]

    def off(answer: State, exact: State, name: str) -> float:
        miss = mp.mpf(answer[name]) - exact[name]
        if whole := turn(name):
            miss -= whole * mp.nint(miss / whole)
        return float(abs(miss / exact[name]) if abs(exact[name]) > NONE else abs(miss))

    family, tolerance, run = method
    # once without the clock, for code that is compiled on first use
    answers, iterations = run()
    pairs = ((answer, state) for answer in answers for _, state in states)
    errors = (max((off(*pair, name) for name in names), default=0.0) for pair in pairs)
    error = min(errors, default=math.nan)
    said = "not proved" if iterations is None else "no convergence"
    if answers:
        said = "solved" if error <= max(FALSE, 1e3 * (tolerance or 0.0)) else "false"
    proved = (answer for answer in answers if isinstance(answer, Solution) and answer.radius)
    radii = (a.radius[n] / (abs(float(a[n])) or 1.0) for a in proved for n in names)
    told = family if tolerance is None else f"{family} to {tolerance:.0e}"
    runs = 1 + min(199, int(max(2.0, 0.02 / Timer(run).timeit(1))))
    seconds, radius = min(Timer(run).repeat(runs, 1)), max(radii, default=None)
    return Measurement(told, tolerance, at, said, error, iterations, seconds, radius, family)


# --- the command ---


def chart_table(marks: Sequence[Measurement], name: str | None = None) -> str:
    """A line for each method: at one set of inputs; or over an input, with the number of values
    solved, the largest error, and the median time."""
    rows = []
    for method in dict.fromkeys(mark.method for mark in marks):
        mine = [mark for mark in marks if mark.method == method]
        said = Counter(mark.status for mark in mine)
        worst = max(mine, key=lambda mark: -1.0 if math.isnan(mark.error) else mark.error)
        sizes = [_short(worst.error), _short(worst.radius)]
        cells = [worst.status, *sizes, str(worst.iterations or "")]
        if name is not None:
            silent = len(mine) - said["solved"] - said["false"]
            counts = f"{said['solved']} of {len(mine)}", str(said["false"]), str(silent)
            at = "" if math.isnan(worst.error) else f"{worst.at:.10g}"
            cells = [*counts, _short(worst.error), at]
        median = sorted(mark.seconds for mark in mine)[len(mine) // 2]
        rows.append((method, *cells, f"{1e6 * median:.1f}"))
    heads = ["Status", "Error", "Radius", "Iterations"]
    if name is not None:
        heads = ["Solved", "False", "Nothing", "Worst error", f"at {name}"]
    return table(("Method", *heads, "µs"), rows)


def _short(error: float | None) -> str:
    return "" if error is None or math.isnan(error) else f"{error:.0e}" if error else "0"


def chart_csv(marks: Iterable[Measurement]) -> str:
    """A line for each measurement, all digits; missing values are empty."""
    rows = ([None if v != v else v for v in mark[:-1]] for mark in marks)
    return csv_text([Measurement._fields[:-1], *rows])


def _picture(
    marks: Sequence[Measurement],
    model: Model,
    name: str | None,
    distances: Mapping[float, float],
    form: str,
) -> bytes:
    """The chart at one set of inputs, or over an input or its ``distances`` from a limit."""
    from solver.pictures.page import encode
    from solver.pictures.plot import chart_picture

    label = ", ".join(filter(None, (name, model.variables[name].unit))) if name else ""
    if distances:
        label = f"relative distance of {name} from its limit"
        marks = [mark._replace(at=distances[mark.at]) for mark in marks if mark.at is not None]
    return encode(chart_picture(marks, model.name, label, bool(distances)), form, 130.0)


CHART = f"""\
{GIVEN}{WANTED}
| --over NAME=START:STOP:STEP  measure over values of an input
| --approach NAME=X:A..B       measure towards a limit of an input, such as NAME=3:1e-1..1e-15
-o --output FILE               write the chart: .png, .svg or .csv
"""


def _run(arguments: Namespace) -> int:
    """Measure, print, draw; 0 if something was measured, 1 if the sheet has no answer."""
    path, name, distances = arguments.output, None, dict[float, float]()
    kind = path and picture_kind(path, (".png", ".svg", ".csv"), "chart")
    request = read_request(arguments)
    request.expect_output(path)
    numbers: list[float] = []
    if arguments.approach:
        name, distances = read_approach(arguments.approach, request.model)
        request.swept([name])
        numbers = list(distances)
    elif arguments.over:
        ((name, axis),) = read_axes([arguments.over], request).items()
        numbers = axis[: MOST + 1].tolist()
        if len(numbers) > MOST or not all(isinstance(number, float) for number in numbers):
            said, note = f"a chart is over at most {MOST:,} numbers", "take a larger step"
            raise RuleSheetError(Option("over", arguments.over).wrong("E424", said, note))
    marks = tuple(measure(request, name, numbers))
    if all(math.isnan(mark.error) for mark in marks):
        first = {**request.inputs, name: numbers[0]} if name and numbers else request.inputs
        print(result_text(solve(request.model, first, request.want, request.guesses)))
        print("\nthere is no isolated answer to measure methods by")
        return 1
    print(chart_table(marks, name))
    if kind == ".csv":
        write_file(path, chart_csv(marks).encode())
    elif kind:
        write_file(path, _picture(marks, request.model, name, distances, kind[1:]))
    if kind:
        print(f"\n{escaped(path)}")
    return 0


COMMANDS = {"chart": Command(CHART, _run)}
