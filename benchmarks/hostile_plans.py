"""Hostile sheets through compiled plans: what ``plan``, ``plan.all`` and sweeps say is what
``solve`` says.

The inputs of a sheet are the inputs of its plan; of a sheet without inputs it is one number of its
rules. The plan is taught by the numbers of the sheet, then asked at those, beside them, and at
rough values (of the small sheets of ``hostile_inputs.py``: at plain numbers, then at special ones):
by calls, by sweeps, and for one sheet in eight, where the extra ``jit`` is installed, in machine
code. At each of these a fresh ``solve`` has the word:

- a *crash*: any exception but ``Unsolved``;
- another *status*: ``Unsolved`` or solved where ``solve`` says something else;
- other *answers*: more or fewer of them, or in another order;
- a *false success*: values that the witness of ``hostile.py`` refutes, or (``strict``) at which the
  rule check of a solve finds a rule that does not hold;
- other *values*: farther from those of ``solve`` than 4 ulp × conditioning (its error bars are
  those of one rounding an operation) or than 1e-9 of them, though no rule refutes them.
"""

from __future__ import annotations

import math
import random
import re
import signal
import time
import traceback
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import rulesheets
import solver
from benchmarks.hostile import SMALLEST, Finding, Outcome, TooLong, alarm, satisfied
from benchmarks.hostile_kinds import sheet
from benchmarks.hostile_sheets import NAMES, Sheet, names_of
from rulesheets.evaluate import Undefined, holds
from rulesheets.model import Model, Value
from solver import Result, Status
from solver.accuracy.forward_error import forward_errors
from solver.accuracy.rule_check import check_rule
from solver.files.tables import CODES, column_of
from solver.path import known_rules
from solver.solution.solving import Solution
from solver.sweeps import Plan, sweep_answers
from solver.trace.llvm import available

ROUGH = (0.0, 1.0, -1.0, 1e300, -1e300, 1e-300, math.nan)
NUMBER = re.compile(r"(?<![\w.^(-])(\d+\.?\d*(?:e[+-]?\d+)?)(?![\w.])")
BARS = 8.0
"""Error bars of ``solve`` that two ways to the same number may be apart."""
CLOSE = 1e-13
ROUNDS = 2
"""How often every point is asked: the second time all ways are learned."""
MACHINE_CODE = 8
"""Sheets of which one is compiled to machine code too, which takes longer than all else."""
PATIENCE = 0.1
"""Seconds of the processor for one solve of what is asked twenty times; what takes longer is not
asked."""

Answers = list[tuple[Any, ...]]


@dataclass(frozen=True)
class Said:
    """What one way says at a point: the answers, the primary first; ``bars`` are their error
    bars."""

    status: Status
    answers: Answers
    bars: Answers


def parametrised(made: Sheet, seed: int) -> Sheet | None:
    """The sheet with inputs: its own, or one number of its rules under a name; None where it has
    neither."""
    if made.raw is not None:
        return None
    if made.inputs:
        return made
    dice = random.Random(seed)
    if made.lines is not None:
        return None
    places = [
        (place, side, found)
        for place, rule in enumerate(made.rules)
        for side in (1, 2)
        for found in NUMBER.finditer(rule[side])
    ]
    free = [name for name in NAMES if name not in names_of(" ".join(map(" ".join, made.rules)))]
    if not places or not free:
        return None
    place, side, found = dice.choice(places)
    rules = [list(rule) for rule in made.rules]
    text = rules[place][side]
    rules[place][side] = text[: found.start()] + free[0] + text[found.end() :]
    inputs = {free[0]: float(found.group())}
    planted = None if made.planted is None else {**made.planted, **inputs}
    return replace(made, rules=tuple(tuple(rule) for rule in rules), inputs=inputs, planted=planted)  # type: ignore[misc]


def points(made: Sheet, seed: int) -> list[tuple[float, ...]]:
    """The numbers of the inputs that a plan is asked for, those of the sheet first."""
    dice = random.Random(seed)
    base = tuple(made.inputs.values())
    found = [base]
    for _ in range(3):
        place = dice.randrange(len(base))
        value = base[place]
        near = dice.choice(
            (
                math.nextafter(value, math.inf),
                math.nextafter(value, -math.inf),
                value * 1.001,
                value * 0.7,
            )
        )
        found.append((*base[:place], near, *base[place + 1 :]))
    for value in dice.sample(ROUGH, 3):
        place = dice.randrange(len(base))
        found.append((*base[:place], value, *base[place + 1 :]))
    # Numbers below the smallest normal one have fewer digits than others.
    return [p for p in found if not any(math.isinf(v) or 0.0 < abs(v) < SMALLEST for v in p)]


def examine(
    seed: int,
    limit: float,
    most: int = 5,
    patience: float = PATIENCE,
    make: Callable[[int, int], Sheet] = sheet,
    asked: Callable[[Sheet, int], list[tuple[float, ...]]] = points,
    strict: bool = False,
) -> Outcome:
    """Prepare the sheet of a seed, ask the plan at points, and judge it by ``solve``.

    ``strict``: by the rule check of a solve, too, which may have taken more digits than a plan has.
    """
    made = parametrised(make(seed, most), seed)
    if made is None:
        return Outcome(seed, "no input", "refused", 0.0)
    began = time.process_time()
    signal.signal(signal.SIGPROF, alarm)
    signal.setitimer(signal.ITIMER_PROF, limit)
    status, finding = "solved", None
    try:
        status, detail = _compared(made, seed, asked(made, seed), patience, strict)
        finding = Finding(seed, *detail) if detail else None
    except rulesheets.RuleSheetError:
        status = "refused"
    except TooLong:
        status = "hang"
    except Exception:
        said = traceback.format_exc().strip().splitlines()
        status, finding = "crash", Finding(seed, "crash", " | ".join(said[-3:]))
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
    return Outcome(seed, made.kind, status, time.process_time() - began, finding)


def _compared(
    made: Sheet, seed: int, at: list[tuple[float, ...]], patience: float, strict: bool
) -> tuple[str, tuple[str, str] | None]:
    """The status at the numbers of the sheet, and the first difference."""
    model = rulesheets.loads(made.text)
    names = tuple(made.inputs)
    want = tuple(name for name in model.variables if name not in names and name not in made.symbols)
    asked, said = [], []
    for point in at:
        began = time.process_time()
        told = _solved(made.text, names, point, want)
        if time.process_time() - began <= patience:
            asked.append(point)
            said.append(told)
    if not asked:
        return "slow", None
    sweeps = ["sweep", "sweep_all"]
    if seed % MACHINE_CODE == 0 and available():
        sweeps += ["sweep jit", "sweep_all jit"]
    return str(said[0].status), next(
        _differences(made, model, names, want, asked, said, sweeps, strict), None
    )


def _solved(text: str, names: Sequence[str], point: Sequence[float], want: Sequence[str]) -> Said:
    """What ``solve`` says of a model that was never solved before."""
    model = rulesheets.loads(text)
    given = {n: None if math.isnan(v) else v for n, v in zip(names, point, strict=True)}
    try:
        result: Result = solver.solve(model, given, want)
        _ = result.diagnoses  # the messages must come to an end, too
    except rulesheets.RuleSheetError:  # outside the range that the sheet declares
        return Said(Status.INFEASIBLE, [], [])
    return _told(result, want)


def _told(result: Result, want: Sequence[str]) -> Said:
    if result.status is not Status.SOLVED:
        return Said(result.status, [], [])
    answers = {tuple(s[n] for n in want): s for s in result.solutions}
    bars = [tuple(_bars(result, s).get(n, 0.0) for n in want) for s in answers.values()]
    return Said(result.status, list(answers), bars)


def _bars(result: Result, solution: Solution) -> Mapping[str, float]:
    """Conditioning × rounding of floats, also where more digits were taken."""
    decided = _decided(result.model, solution, result.inputs)
    steps = list(result.path.steps)
    return forward_errors(result.model, solution, steps, decided).error


def _decided(model: Model, values: Mapping[str, Value], inputs: Collection[str]) -> dict[int, bool]:
    """The outcomes of the conditions that have one at these values."""
    decided = {}
    for index, condition in enumerate(model.conditions):
        with suppress(KeyError, Undefined):
            decided[index] = holds(condition, values, inputs)
    return decided


def broken(model: Model, values: Mapping[str, Value], inputs: Collection[str]) -> Iterator[str]:
    """The active rules that do not hold at an answer, by the rule check of a solve."""
    for rule in known_rules(model, _decided(model, values, inputs), values):
        check = check_rule(rule, values)
        if not check.holds:
            yield f"rule {rule.index + 1} misses by {check.scaled:.1e} of its terms"


def _differences(
    made: Sheet,
    model: Model,
    names: tuple[str, ...],
    want: tuple[str, ...],
    asked: list[tuple[float, ...]],
    said: list[Said],
    sweeps: Sequence[str],
    strict: bool,
) -> Iterator[tuple[str, str]]:
    judged = partial(_judged, made, names, want, model if strict else None)
    plan = solver.prepare(model, names, want)
    for turn in range(ROUNDS):
        for point, right in zip(asked, said, strict=True):
            for kind in ("plan", "all"):
                told = _called(plan, point, kind)
                yield from judged(point, f"{kind} {turn + 1}", told, right)
    for kind in sweeps:
        fresh = solver.prepare(model, names, want)
        for turn in range(ROUNDS):
            # So many rows that ways on arrays are worth their while.
            for place, found in enumerate(_swept(fresh, asked, kind)):
                where = f"{kind} {turn + 1}"
                at = place % len(asked)
                yield from judged(asked[at], where, found, said[at])
    for turn in range(ROUNDS + 1):
        for point, right in zip(asked, said, strict=True):
            if not any(map(math.isnan, point)) and not _outside(model, names, point):
                again = _told(solver.solve(model, dict(zip(names, point, strict=True)), want), want)
                told = again.status, again.answers
                yield from judged(point, f"solve {turn + 1}", told, right)


def _outside(model: Model, names: Sequence[str], point: Sequence[float]) -> bool:
    return any(not model.variables[name].admits(v) for name, v in zip(names, point, strict=True))


def _called(plan: Plan, point: tuple[float, ...], kind: str) -> tuple[Status, Answers]:
    try:
        return Status.SOLVED, [plan(*point)] if kind == "plan" else plan.all(*point)
    except solver.Unsolved as refused:
        return refused.status, []


def _swept(
    plan: Plan, asked: list[tuple[float, ...]], kind: str
) -> Iterator[tuple[Status, Answers]]:
    rows = asked * 3
    columns = [list(column) for column in zip(*rows, strict=True)]
    by_code = {CODES[status]: status for status in Status}
    jit = kind.endswith(" jit")
    if not kind.startswith("sweep_all"):
        table = plan.sweep(*columns, jit=jit)
        for place, code in enumerate(table.status):
            status = by_code[int(code)]
            row = tuple(table[name][place] for name in plan.want)
            yield status, [row] if status is Status.SOLVED else []
        return
    codes, answers = sweep_answers(plan, list(map(column_of, columns)), jit)
    for row, (code, count) in enumerate(zip(codes, answers.counts, strict=True)):
        every = [tuple(column[row] for column in plane) for plane in answers.planes[: int(count)]]
        yield by_code[int(code)], every


def _judged(
    made: Sheet,
    names: tuple[str, ...],
    want: tuple[str, ...],
    model: Model | None,
    point: tuple[float, ...],
    where: str,
    found: tuple[Status, Answers],
    right: Said,
) -> Iterator[tuple[str, str]]:
    status, answers = found
    at = f"{where} at {dict(zip(names, point, strict=True))}"
    for row in answers:
        known = dict(zip((*names, *want), (*point, *row), strict=True))
        numbers = {
            n: float(v) for n, v in known.items() if not isinstance(v, str) and not math.isnan(v)
        }
        for rule in made.rules:
            if not satisfied(rule, numbers):
                yield "false success", f"{at}: {rule} at {numbers}"
        told = {n: v for n, v in known.items() if v == v}
        for what in broken(model, told, names) if model is not None else ():
            yield "false success", f"{at}: {what} at {told}"
    if status is not right.status:
        yield "status", f"{at}: {status} {answers}, but {right.status} {right.answers}"
        return
    expected = right.answers[:1] if where.startswith(("plan ", "sweep ")) else right.answers
    if len(expected) != len(answers):
        yield "answers", f"{at}: {answers}, but {expected}"
        return
    for row, other, bars in zip(answers, expected, right.bars, strict=False):
        if not all(_close(*pair) for pair in zip(row, other, bars, strict=True)):
            yield "values", f"{at}: {answers}, but {expected}"
            return


def _close(value: Any, expected: Any, bar: float) -> bool:
    if isinstance(expected, str) or isinstance(value, str):
        return bool(value == expected)
    apart = abs(float(value) - expected)
    return apart <= CLOSE * abs(expected) + BARS * bar or not apart < math.inf
