"""Prepared calls over every single swap of the shipped models: one output given, one input wanted.

    python -m benchmarks.swaps [--model NAME]… [--everyday] [--rows N] [--budget SECONDS]
        [--kept FILE] [--each] [--agree] [--wide] [--write]

Each swap that leads back to the state of its sheet is prepared once; then it is called at numbers
next to that state, and swept over rows of them. The figures are distributions over the swaps, in
processor time. A swap gets ``--budget`` seconds: what it has not been asked by then is left out.
``--kept`` appends what was measured to a file and leaves out the swaps that stand there, so that a
run can be stopped and taken up again. ``--agree`` compares calls with full solves: statuses, number
of answers, and values beside their error bars. ``--everyday`` asks the backward questions of
tests/everyday instead, prepared for the first number that each gives. ``--wide`` sweeps a sample of the swaps over a wide
range instead, with plans that know nothing before. ``--write`` puts the tables into docs/speed.md.
"""

from __future__ import annotations

import argparse
import functools
import json
import math
import random
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

import rulesheets
import solver
from benchmarks.pages import ROOT, place
from benchmarks.speed.page import Claim, Section, figures
from tests.everyday.corpus import sheets

MODELS = ROOT / "models"
NAMES = sorted(path.parent.name for path in MODELS.glob("*/model.tk"))
SPREAD = 1e-2
"""How far from the state, relative to its number, a swap is asked."""
POINTS = 12
REPEATS, LEAST = 5, 3
"""Readings of the clock, and how many there are when the time is over: the first one may say
anything."""
ENOUGH = 2e-4
"""Seconds over which a quick call is repeated for one reading of the clock."""
RETURNED = 1e-6
PATIENCE = 5.0
"""Seconds after which a choice that nothing is known of counts as no swap."""
SAMPLE, WIDE, WIDE_ROWS = 0.05, (0.7, 1.4), 300
"""Share of the swaps that are swept widely, the ends relative to the state, and in how many
rows."""
WORST = 25
"""Swaps of which the page shows that they are too slow, one by one."""

QUANTILES = "median", "90 %", "97 %", "worst"
CALL, MEDIAN_CALL, WORST_CALL, ROW, WORST_ROW = 100.0, 5.0, 5000.0, 2.0, 100.0
"""Microseconds that calls and rows are held to."""


@dataclass
class Swap:
    """One output given instead of one input. Times in microseconds; of the points only those with
    an answer.

    ``call`` is the median over the points, ``worst`` the largest; ``first`` is the slowest call at
    a point that no record settled yet (0: none), of which there were ``left`` among ``points``.
    ``without`` is the median time at points without an answer, ``unanswered`` their number.
    ``learn`` is the time of a first wide sweep, ``again`` that of a row of the next one.
    """

    model: str
    given: str
    wanted: str
    call: float = math.nan
    worst: float = math.nan
    first: float = 0.0
    left: int = 0
    points: int = 0
    unanswered: int = 0
    without: float = 0.0
    row: float = math.nan
    learn: float = math.nan
    again: float = math.nan
    differs: list[str] = field(default_factory=list)

    @property
    def name(self) -> str:
        return f"{self.given} → {self.wanted}"

    def __str__(self) -> str:
        if self.learn == self.learn:
            return f"{self.model:<32}{self.name:<28}{self.learn * 1e-6:10.3f} s{self.again:12.3f}"
        times = f"{self.call:12.2f}{self.worst:14.2f}{self.row:12.3f}{self.first:14.0f}"
        counts = (
            f"  left {self.left}/{self.points}, unanswered {self.unanswered} ({self.without:.0f})"
        )
        return f"{self.model:<32}{self.name:<28}{times}{counts}"


def swaps(
    name: str, known: set[tuple[str, str, str]], share: float = 1.0
) -> Iterator[tuple[Swap, Any, float]]:
    """The swaps of a model that lead back to its state, or a share of them, with their plans and
    the number given."""
    model = rulesheets.load(MODELS / name / "model.tk")
    state: Any = solver.solve(model).solutions[0]
    posted = [n for n, v in model.variables.items() if v.posted and isinstance(state.get(n), float)]
    inputs = [n for n in posted if model.variables[n].value is not None]
    for given in (n for n in posted if n not in inputs):
        for wanted in inputs:
            draw = random.Random(f"wide {name} {given} {wanted}").random()
            if (name, given, wanted) in known or draw >= share:
                continue
            plan: Any = solver.prepare(model, [given], [wanted], {wanted: None}, timeout=PATIENCE)
            rows = asked(plan, state[given])
            if any(abs(row[0] - state[wanted]) <= RETURNED * abs(state[wanted]) for row in rows):
                yield Swap(name, given, wanted), plan, state[given]


def everyday(known: set[tuple[str, str, str]], share: float) -> Iterator[tuple[Swap, Any, float]]:
    """The backward questions of the everyday sheets, or a share of them, likewise."""
    for question in (question for sheet in sheets() for question in sheet.questions()):
        numbers = {name: v for name, v in question.changes.items() if isinstance(v, float)}
        asked = tuple(name for name, v in question.changes.items() if v is None)
        name, label = f"{question.sheet.area}/{question.sheet.name}", " ".join(asked)
        given = next(iter(numbers), "")
        draw = random.Random(f"wide {question.id}").random()
        if given and (name, given, label) not in known and draw < share:
            plan: Any = solver.prepare(
                question.sheet.model, [given], asked, question.changes, timeout=PATIENCE
            )
            yield Swap(name, given, label), plan, numbers[given]


def asked(plan: Any, point: float) -> list[Any]:
    """All answers; none where it is unsolved."""
    try:
        found: list[Any] = plan.all(point)
    except solver.Unsolved:
        return []
    return found


def measure(swap: Swap, plan: Any, number: float, rows: int, budget: float) -> Swap:
    """Time the calls of a swap, and its rows."""
    draw = random.Random(f"{swap.model} {swap.given} {swap.wanted}")
    ends = time.process_time() + budget
    times, without = dict[float, float](), dict[float, float]()
    for point in (number, *(number * (1 + SPREAD * draw.uniform(-1, 1)) for _ in range(POINTS))):
        if time.process_time() > ends or (len(without) > 2 and between(point, number, without)):
            continue
        records = len(plan.records.programs)
        started = time.process_time()
        there = bool(asked(plan, point))
        first = (time.process_time() - started) * 1e6
        if not there:
            without[point] = first
            continue
        told = (
            point,
        ) in plan.records.rows  # no record serves it: the same number again says nothing
        seconds = first * 1e-6 if told else clocked(functools.partial(plan, point), ends)
        times[point] = min(seconds * 1e6, first)
        if len(plan.records.programs) > records or seconds > 1e-3:
            swap.left, swap.first = swap.left + 1, max(swap.first, first)
    swap.points, swap.unanswered = len(times) + len(without), len(without)
    swap.call, swap.worst = float(np.median([*times.values()])), max(times.values())
    swap.without = float(np.median([*without.values()])) if without else 0.0
    if rows:
        low = max((p for p in without if p < number), default=-math.inf)
        high = min((p for p in without if p > number), default=math.inf)
        swap.row = timed_rows(plan, [p for p in times if low < p < high], rows, swap)
    return swap


def widely(swap: Swap, plan: Any, number: float) -> Swap:
    """Time a sweep by a plan that knows nothing, and the same rows after."""
    low, high = WIDE
    column = np.linspace(low * number, high * number, WIDE_ROWS)
    cleared = {name: plan.given.get(name) for name in plan.model.variables}
    fresh: Any = solver.prepare(plan.model, plan.inputs, plan.want, cleared, timeout=PATIENCE)
    started = time.process_time()
    fresh.sweep(column)
    swap.learn = (time.process_time() - started) * 1e6
    swap.again = clocked(functools.partial(fresh.sweep, column), 0.0) * 1e6 / WIDE_ROWS
    return swap


def between(point: float, number: float, without: Iterable[float]) -> bool:
    """Whether a point without an answer lies between a point and the state: that says enough."""
    return any(min(point, number) < p < max(point, number) for p in without)


def clocked(call: Callable[[], Any], ends: float) -> float:
    """Seconds of processor time that a call takes, at best."""
    count, best = 1, math.inf
    for reading in range(REPEATS):
        started = time.process_time()
        for _ in range(count):
            call()
        taken = time.process_time() - started
        best = min(best, taken / count)
        if time.process_time() > ends and reading + 1 >= LEAST:
            break
        count = max(1, min(1000, int(ENOUGH / max(best, 1e-9))))
    return best


def timed_rows(plan: Any, points: Sequence[float], rows: int, swap: Swap) -> float:
    """Microseconds a row, between points with answers; of fewer rows where calls take long."""
    count = rows if swap.call < 1e3 else max(int(3e5 / swap.call), 20)
    column = np.linspace(min(points), max(points), count)
    plan.sweep(column[:: max(count // 2000, 1)])
    best = math.inf
    for _ in range(2):
        started = time.process_time()
        plan.sweep(column)
        best = min(best, (time.process_time() - started) / count * 1e6)
        if best * count > 2e5:
            break
    return best


def difference(plan: Any, point: float) -> str:
    """What a prepared call says otherwise than a full solve; empty where they agree."""
    given = {plan.inputs[0]: point}
    stated = (n for n, v in plan.model.variables.items() if v.value is not None)
    cleared = {name: None for name in stated if name not in plan.given}
    result: Any = solver.solve(plan.model, {**cleared, **plan.given, **given}, want=plan.want)
    try:
        rows = plan.all(point)
    except solver.Unsolved as error:
        return (
            ""
            if error.status == result.status
            else f"{point!r}: {error.status}, not {result.status}"
        )
    if str(result.status) != "solved":
        return f"{point!r}: solved, not {result.status}"
    name = plan.want[0]
    wanted = list(dict.fromkeys(s[name] for s in result.solutions))
    bar = max((s.error[name] for s in result.solutions), default=0.0)
    found = [row[0] for row in rows]
    if len(found) != len(wanted):
        return f"{point!r}: {len(found)} answers, not {len(wanted)}"
    for one, other in zip(found, wanted, strict=True):
        if abs(one - other) > 4 * bar + 8 * math.ulp(other):
            return f"{point!r}: {one!r}, not {other!r} (± {bar:.1e})"
    return ""


def sections(found: list[Swap]) -> tuple[Section, Section]:
    """The distributions of the times over the swaps, and the swaps that are too slow."""
    calls, rows = np.array([s.call for s in found]), np.array([s.row for s in found])
    worst, count = max(s.worst for s in found), f"{len(found)} single swaps, µs"
    timed = rows[np.isfinite(rows)]
    table = [
        (name, *_quantiles(times))
        for name, times in (("a prepared call", calls), ("a row of a sweep", timed))
        if len(times)
    ]
    left, points = sum(s.left for s in found), sum(s.points for s in found)
    open_points = sum(s.unanswered for s in found)
    remark = (
        f"Processor time at up to {POINTS + 1} numbers within {SPREAD:.0%} of the state of each "
        "sheet, "
        f"{points:,} in all. {left / points:.1%} of them were solved step by step, and recorded, "
        "before they "
        f"were timed; {open_points / points:.1%} have no answer, or none that was found, and are "
        "not timed."
    )
    claims = [
        Claim("calls within 100 µs", 97, 100 * float((calls <= CALL).mean()), "%", more=True),
        Claim("median of the calls", MEDIAN_CALL, float(np.median(calls)), "µs"),
        Claim("worst call", WORST_CALL, worst, "µs"),
    ]
    if len(timed):
        claims += [
            Claim("rows within 2 µs", 97, 100 * float((timed <= ROW).mean()), "%", more=True),
            Claim("worst row", WORST_ROW, float(timed.max()), "µs"),
        ]
    slow = sorted((s for s in found if _is_slow(s)), key=lambda s: -max(s.call, 50 * _row(s)))
    lines = [
        (f"{s.model}: {s.name}", *map(figures, (s.call, s.worst, s.row)), f"{s.left}/{s.points}")
        for s in slow[:WORST]
    ]
    more = [f"And {len(slow) - WORST} more."] if len(slow) > WORST else []
    head = ("µs", "call", "worst call", "a row", "numbers first solved step by step")
    return (
        Section("swaps", "Every swap", (count, *QUANTILES), table, [remark], claims),
        Section("slow swaps", "Swaps that are too slow", head, lines, more),
    )


def _quantiles(times: Any) -> Iterator[str]:
    return (figures(float(np.quantile(times, share))) for share in (0.5, 0.9, 0.97, 1.0))


def wide_section(found: list[Swap]) -> Section:
    """How long wide sweeps take to learn, and their rows after that."""
    kinds = (
        ("to learn, s", [s.learn * 1e-6 for s in found]),
        ("a row after that, µs", [s.again for s in found]),
    )
    table = [
        (kind, *(figures(float(np.quantile(times, share))) for share in (0.5, 0.9, 0.97, 1.0)))
        for kind, times in kinds
    ]
    low, high = WIDE
    remark = (
        f"Processor time of {WIDE_ROWS} rows over {low} to {high} times the state, for randomly "
        "drawn swaps. "
        "The first sweep solves the rows that no record covers yet. Many of them cross a fold, "
        "beyond which "
        "the number of answers differs or is 0."
    )
    return Section(
        "wide sweeps", "Wide sweeps", (f"{len(found)} swaps", *QUANTILES), table, [remark]
    )


def _is_slow(swap: Swap) -> bool:
    return swap.call > CALL or swap.worst > WORST_CALL or _row(swap) > ROW


def _row(swap: Swap) -> float:
    return swap.row if swap.row == swap.row else 0.0


def kept_in(path: Path | None) -> list[Swap]:
    """The swaps that a file has."""
    if path is None or not path.exists():
        return []
    return [Swap(**json.loads(line)) for line in path.read_text(encoding="utf-8").splitlines()]


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--model", choices=NAMES, action="append", help="several can be named")
    parser.add_argument("--everyday", action="store_true")
    parser.add_argument("--rows", type=int, default=100_000)
    parser.add_argument("--budget", type=float, default=3.0)
    parser.add_argument("--kept", type=Path)
    parser.add_argument("--each", action="store_true")
    parser.add_argument("--agree", action="store_true")
    parser.add_argument("--wide", action="store_true")
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    found = kept_in(options.kept)
    known = {(s.model, s.given, s.wanted) for s in found}
    share = SAMPLE if options.wide else 1.0
    models = chain.from_iterable(swaps(name, known, share) for name in options.model or NAMES)
    for swap, plan, number in everyday(known, share) if options.everyday else models:
        if options.wide:
            widely(swap, plan, number)
        else:
            measure(swap, plan, number, options.rows, options.budget)
        if options.agree:
            points = (number, number * (1 + 0.3 * SPREAD), number * (1 - 0.7 * SPREAD))
            swap.differs = [text for point in points if (text := difference(plan, point))]
        found.append(swap)
        if options.kept:
            with options.kept.open("a", encoding="utf-8") as file:
                file.write(json.dumps(asdict(swap)) + "\n")
        if options.each or swap.differs or _is_slow(swap):
            print(swap, *swap.differs, flush=True)
    prefix = "everyday " if options.everyday else ""
    for section in [wide_section(found)] if options.wide else sections(found):
        print(f"\n## {section.title}\n\n{section.markdown()}")
        if options.write and not place(
            ROOT / "docs" / "speed.md", f"speed: {prefix}{section.name}", section.markdown()
        ):
            sys.exit(f"docs/speed.md has no place for {prefix}{section.name}")


if __name__ == "__main__":
    main()
