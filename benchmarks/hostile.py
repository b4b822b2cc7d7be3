"""Random, ill-scaled, degenerate and hostile sheets: no crash, no hang, no false claim.

python benchmarks/hostile.py [--count 1000] [--seed 0] [--limit 60] [--jobs 1] [-o FILE] [--show
    SEED]

solves the sheets of ``hostile_kinds.py`` from a seed on, in so many processes, and prints how they
ended, by kind and status, and every one that is

- a *crash*: any exception but the refusal of a broken sheet, and any warning of Python;
- a *hang*: longer than the limit, in seconds of the processor;
- a *false success*: an answer with a rule that no change of 1e-9 of its values would satisfy,
  judged with 50 digits by a witness that shares no code with the solver;
- a *false refusal*: called infeasible, contradictory, or completely solved without the planted
  state, although that state is there, and determined well.

With ``--small`` the sheets are those of ``hostile_small.py``. With ``--plans`` they go through
compiled plans instead (``hostile_plans.py``); with both these are small ones of two inputs
(``hostile_inputs.py``). A long run writes every outcome to a file, goes on where the file ends, and
prints the table of all in it.
"""

from __future__ import annotations

import argparse
import csv
import os
import re
import signal
import sys
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

os.environ.setdefault(
    "OPENBLAS_NUM_THREADS", "1"
)  # the matrices are small, and the processes several

import mpmath

sys.path.insert(0, str(Path(__file__).parent.parent))

import rulesheets
import solver
from benchmarks.expressions import DIGITS, Undefined, evaluated
from benchmarks.hostile_kinds import sheet
from benchmarks.hostile_sheets import Sheet, active, uncertainty
from solver import Result, Status

CHANGE = 1e-9
"""The relative change of the values that may be needed to satisfy a rule exactly."""
SHARES = (
    0.0,
    *(sign * 10.0**-k for sign in (1, -1) for k in range(7)),
    *(k / 10 for k in range(-9, 10)),
)
"""Of the change, where a rule is tried."""
CERTAIN = 1e-9
"""Planted states are looked for if rounding explains no larger change of them."""
NEAR = 1e-6
HALVINGS = 100
"""Of what lies beside the end of a domain: enough for a root of it to vanish."""
MANY = 27_720
"""Whole turns that are whole ones of an angle's halves, thirds, … and twelfths."""
LONGEST = 350
"""Digits in which a difference of floats leaves some beyond the point: each is below 1e309."""
JUMPS = re.compile(r"\b(int|frac|round|mod|sgn|atan2d?)\(")
"""Beside a jump a rule may be satisfied in a stretch far shorter than the changes that are
tried."""
SMALLEST = 2.0**-1022
"""The floats next to 0 are as far apart as those next to this number."""


@dataclass(frozen=True)
class Finding:
    """What is wrong with how a sheet was answered."""

    seed: int
    what: str
    detail: str


@dataclass(frozen=True)
class Outcome:
    """``seconds`` of the processor."""

    seed: int
    kind: str
    status: str
    seconds: float
    finding: Finding | None = None


class TooLong(Exception):
    pass


def examine(
    seed: int,
    limit: float,
    most: int = 5,
    make: Callable[[int, int], Sheet] = sheet,
    claims: Callable[[Sheet, Result], Iterator[tuple[str, str]]] | None = None,
) -> Outcome:
    """Solve the sheet of a seed (``most`` unknowns) within so many seconds of the processor, and
    judge it."""
    made = make(seed, most)
    began = time.process_time()
    warnings.simplefilter("error")
    signal.signal(signal.SIGPROF, alarm)
    signal.setitimer(signal.ITIMER_PROF, limit)
    try:
        result = solver.solve(rulesheets.loads(made.text))
        _ = result.diagnoses  # the messages must come to an end, too
    except rulesheets.RuleSheetError as error:
        return _refused(seed, made, error, time.process_time() - began)
    except TooLong:
        return Outcome(seed, made.kind, "hang", limit, Finding(seed, "hang", f"over {limit:g} s"))
    except Exception:  # warnings among them
        said = traceback.format_exc().strip().splitlines()
        return Outcome(seed, made.kind, "crash", 0.0, Finding(seed, "crash", " | ".join(said[-3:])))
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
    seconds = time.process_time() - began
    detail = next((claims or false_claims)(made, result), None)
    finding = Finding(seed, *detail) if detail else None
    return Outcome(seed, made.kind, str(result.status), seconds, finding)


def alarm(*_: Any) -> None:
    raise TooLong


def _refused(seed: int, made: Sheet, error: Exception, seconds: float) -> Outcome:
    """Only broken text, and numbers that no float holds, may be refused."""
    if made.raw is not None or made.kind == "nasty numbers":
        return Outcome(seed, made.kind, "refused", seconds)
    return Outcome(
        seed, made.kind, "refused", seconds, Finding(seed, "refused", str(error).splitlines()[0])
    )


def false_claims(made: Sheet, result: Result) -> Iterator[tuple[str, str]]:
    if made.raw is not None:
        return
    for solution in result.solutions:
        for rule in made.rules:
            known = {name: v for name, v in solution.items() if isinstance(v, float)}
            if not satisfied(*_with_result(made, rule, known)):
                yield "false success", f"{result.status}: {rule} at {known}"
    spread = uncertainty(made)
    if spread > CERTAIN:
        return
    if result.status in (Status.INFEASIBLE, Status.INCONSISTENT) and _square(made):
        yield "false refusal", f"{result.status}, but there is {made.planted}"
    elif (
        result.complete
        and (result.solutions or _square(made))
        and not any(_is_plant(made, solution, spread) for solution in result.solutions)
        and not any(_in_parts(made, name) for name in made.planted or ())
    ):
        yield "false refusal", f"complete without {made.planted}"


def _with_result(
    made: Sheet, rule: tuple[str, str, str], known: Mapping[str, float]
) -> tuple[tuple[str, str, str], Mapping[str, float]]:
    """The rule and what is known: what a call gives back is a value of its own, not a number of the
    rule."""
    condition, left, right = rule
    return ((condition, left, "k"), {**known, "k": float(right)}) if made.head else (rule, known)


def satisfied(rule: tuple[str, str, str], values: Mapping[str, float]) -> bool:
    """Whether changes of 1e-9 of the values satisfy the rule; rules that do not apply, or that read
    what has no value, ask nothing."""
    names = set(re.findall(r"\b[a-z]\b", " ".join(rule)))
    if not names <= set(values):
        return True
    values = {name: values[name] for name in names}
    more = (
        (16 * DIGITS,) if JUMPS.search(" ".join(rule[1:])) else ()
    )  # as the parts of exp(600) take
    return any(_holds(rule, values, digits) for digits in (DIGITS, 4 * DIGITS, *more))


def _holds(rule: tuple[str, str, str], values: Mapping[str, float], digits: int) -> bool:
    condition, left, right = rule
    text = f"{left} - ({right})"
    try:
        if condition and not evaluated(condition, values, digits):
            return True
        miss = evaluated(text, values, digits)
    except Undefined:
        return any(_reaches(rule, values, name, digits) for name in values)
    if miss == 0 or abs(evaluated(text, values, 2 * digits)) <= abs(miss) * mpmath.mpf(10) ** (
        10 - digits
    ):
        return True  # as sin(pi), which is 0 but for the digits of pi
    with mpmath.workdps(digits):
        total = mpmath.mpf(0)
        share = mpmath.mpf(10) ** (-digits // 2)
        for name, value in values.items():
            step = mpmath.mpf(max(abs(value), SMALLEST)) * share
            try:
                moved = [
                    evaluated(text, {**values, name: value + sign * step}, digits)
                    for sign in (1, -1)
                ]
            except Undefined:
                continue
            total += abs(moved[0] - moved[1]) / 2 / share
            if abs(miss) <= CHANGE * total:
                return True
    return any(_reaches(rule, values, name, digits) for name in values)


def _reaches(
    rule: tuple[str, str, str], values: Mapping[str, float], name: str, digits: int
) -> bool:
    """Whether the miss changes its sign, or vanishes, as one value changes by up to 1e-9 of itself;
    beside a jump, whether it comes next to 0; beside the end of a domain, whether it vanishes
    towards that."""
    _, left, right = rule

    def miss(number: Any) -> Any:
        at = {**values, name: number}
        try:
            one, other = (evaluated(side, at, digits) for side in (left, right))
        except Undefined:
            return None
        nothing = JUMPS.search(f"{left} {right}") and abs(one - other) <= CHANGE * abs(other)
        return mpmath.mpf(0) if nothing else one - other

    with mpmath.workdps(digits):
        size = mpmath.mpf(max(abs(values[name]), SMALLEST))
        change = (
            CHANGE * mpmath.pi / 3
        )  # no float: a float times an angle of whole turns may be one again
        tried = [values[name] + size * change * share for share in SHARES]
        short = {round(values[name], places) for places in range(12)}  # where a jump has its edge
        tried += [near for near in short if abs(near - values[name]) <= CHANGE * size]
        found = [(number, miss(number)) for number in sorted(set(tried))]
        signs = {int(mpmath.sign(there)) for _, there in found if there is not None}
        return (
            0 in signs or len(signs) > 1 or any(_vanishes(miss, *pair) for pair in pairwise(found))
        )


def _vanishes(miss: Callable[[Any], Any], one: tuple[Any, Any], other: tuple[Any, Any]) -> bool:
    """Whether a miss that has a value at one of two numbers alone goes to 0 towards the end of
    where it has, as that of ``(3/y - x)^1.5 = 0`` does: the end may lie between two floats."""
    if (one[1] is None) == (other[1] is None):
        return False
    (inside, first), (outside, _) = (one, other) if other[1] is None else (other, one)
    last = first
    for _ in range(HALVINGS):
        middle = (inside + outside) / 2
        there = miss(middle)
        if there is None:
            outside = middle
        else:
            inside, last = middle, there
    return bool(abs(last) <= CHANGE * abs(first))


def _square(made: Sheet) -> bool:
    """More rules than unknowns contradict each other by the rounding of their constants."""
    assert made.planted is not None
    return len(active(made)) == len(made.planted) - len(made.inputs)


def _is_plant(made: Sheet, solution: Mapping[str, Any], spread: float) -> bool:
    """Whether an answer is the planted state, which rounding leaves unsure by a relative
    ``spread``."""
    assert made.planted is not None
    used = {name for rule in made.rules for name in solution if name in "".join(rule)}
    return all(
        abs(solution[name] - value) <= NEAR * abs(value)
        or _turns(value, solution[name], 10 * spread * abs(value))
        for name, value in made.planted.items()
        if name in used
    )


def _in_parts(made: Sheet, name: str) -> bool:
    """Whether an unknown lies beyond one turn of an angle that the rules read in parts, as
    ``sin(y/3)``: no more of its turns than one are listed. Some turns leave the rules as they are,
    one does not."""
    assert made.planted is not None
    value = made.planted[name]
    return name not in made.inputs and any(
        abs(value) > turn / 2
        and _indifferent(made, name, MANY * turn)
        and not _indifferent(made, name, turn)
        for turn in (mpmath.mpf(360), 2 * mpmath.pi)
    )


def _indifferent(made: Sheet, name: str, change: Any) -> bool:
    """Whether the rules come out the same where a planted value is so much larger."""
    assert made.planted is not None
    with mpmath.workdps(LONGEST):
        changed = {**made.planted, name: mpmath.mpf(made.planted[name]) + change}
        try:
            moves = [
                evaluated(left, changed) - evaluated(left, made.planted)
                for _, left, _ in active(made)
            ]
        except Undefined:
            return False
        return all(abs(move) < CERTAIN for move in moves)


def _turns(planted: float, found: float, unsure: float) -> bool:
    """Angles are reported within one turn: whole ones apart (degrees or radians), but for what is
    unsure."""
    with mpmath.workdps(LONGEST):
        apart = mpmath.mpf(planted) - mpmath.mpf(found)
        return any(
            abs(apart) > turn / 2
            and abs(apart - turn * mpmath.nint(apart / turn)) < max(NEAR * turn, unsure)
            for turn in (mpmath.mpf(360), 2 * mpmath.pi)
        )


def main() -> None:
    parser = argparse.ArgumentParser(
        description="Hostile sheets: no crash, no hang, no false claim."
    )
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0, help="the first of as many seeds")
    parser.add_argument("--most", type=int, default=5, help="unknowns of a sheet, at most")
    parser.add_argument(
        "--limit", type=float, default=60.0, help="seconds of the processor for each"
    )
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="CSV of the outcomes, to go on with"
    )
    parser.add_argument("--show", type=int, metavar="SEED", help="print one sheet and solve it")
    parser.add_argument(
        "--small",
        action="store_true",
        help="sheets of one to three rules at special points (hostile_small.py)",
    )
    parser.add_argument(
        "--plans",
        action="store_true",
        help="hold compiled plans to what a solve says (hostile_plans.py)",
    )
    parser.add_argument(
        "--patience",
        type=float,
        metavar="S",
        help="seconds of a solve: numbers that take more are left out of --plans",
    )
    arguments = parser.parse_args()
    if arguments.show is not None:
        print(_trial(arguments).keywords.get("make", sheet)(arguments.show, arguments.most).text)
        print(_trial(arguments)(arguments.show))
        return
    before = [] if arguments.output is None else recorded(arguments.output)
    done = {outcome.seed for outcome in before}
    seeds = [
        seed for seed in range(arguments.seed, arguments.seed + arguments.count) if seed not in done
    ]
    outcomes = before + list(_examined(seeds, arguments))
    report(outcomes)
    sys.exit(any(outcome.finding for outcome in outcomes))


def _trial(arguments: argparse.Namespace) -> partial[Outcome]:
    """What is done with a seed."""
    if arguments.plans:
        from benchmarks import hostile_plans

        patience = hostile_plans.PATIENCE if arguments.patience is None else arguments.patience
        asked = partial(
            hostile_plans.examine, limit=arguments.limit, most=arguments.most, patience=patience
        )
        if arguments.small:
            from benchmarks import hostile_inputs

            return partial(asked, make=hostile_inputs.sheet, asked=hostile_inputs.points)
        return asked
    if arguments.small:
        from benchmarks import hostile_small

        small, claims = hostile_small.sheet, hostile_small.false_claims
        return partial(
            examine, limit=arguments.limit, most=arguments.most, make=small, claims=claims
        )
    return partial(examine, limit=arguments.limit, most=arguments.most)


def _examined(seeds: list[int], arguments: argparse.Namespace) -> Iterator[Outcome]:
    """The outcomes, written to the file as they come."""
    trial = _trial(arguments)
    with ProcessPoolExecutor(arguments.jobs) as pool:
        found = pool.map(trial, seeds, chunksize=20) if arguments.jobs > 1 else map(trial, seeds)
        for outcome in found:
            if outcome.finding:
                print(outcome.finding, flush=True)
            if arguments.output is not None:
                _record(arguments.output, outcome)
            yield outcome


def _record(file: Path, outcome: Outcome) -> None:
    found = (outcome.finding.what, outcome.finding.detail) if outcome.finding else ("", "")
    with file.open("a", newline="", encoding="utf-8") as stream:
        row = (outcome.seed, outcome.kind, outcome.status, f"{outcome.seconds:.4f}", *found)
        csv.writer(stream).writerow(row)


def recorded(file: Path) -> list[Outcome]:
    """The outcomes that a run has written; none where there is no file yet."""
    if not file.exists():
        return []
    with file.open(newline="", encoding="utf-8") as stream:
        return [
            Outcome(
                int(seed),
                kind,
                status,
                float(seconds),
                Finding(int(seed), what, said) if what else None,
            )
            for seed, kind, status, seconds, what, said in csv.reader(stream)
        ]


def report(outcomes: list[Outcome]) -> None:
    """A table of kinds by statuses, the times, and what was found."""
    statuses = list(dict.fromkeys([*map(str, Status), *(outcome.status for outcome in outcomes)]))
    print(f"{'':<16}" + "".join(f"{status:>13}" for status in statuses))
    for kind in dict.fromkeys(outcome.kind for outcome in outcomes):
        counts = Counter(outcome.status for outcome in outcomes if outcome.kind == kind)
        print(f"{kind:<16}" + "".join(f"{counts[status]:>13}" for status in statuses))
    seconds = sorted(outcome.seconds for outcome in outcomes)
    middle, most = seconds[len(seconds) // 2], seconds[-1]
    print(
        f"{len(outcomes)} sheets; median {1e3 * middle:.1f} ms, longest {most:.1f} s, "
        f"all {sum(seconds):.0f} s"
    )
    found = Counter(outcome.finding.what for outcome in outcomes if outcome.finding)
    print("found: " + (", ".join(f"{n} × {what}" for what, n in found.items()) or "nothing wrong"))


if __name__ == "__main__":
    main()
