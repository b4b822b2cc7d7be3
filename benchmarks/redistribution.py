"""How many random choices of the slider crank's inputs lead back to the state that they were taken
from.

    python benchmarks/redistribution.py [--sheet NAME] [--pool posted|all] [--seeds FIRST:LAST]
        [--each] [--prepared]

For each sheet and each pool of numbers it draws well-posed choices of six (and the branch) at
random values, solves, and prints how many returned the state, how many called their list of answers
complete, how many said something X
"""

from __future__ import annotations

import argparse
import math
import random
import sys
import time
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent))

import rulesheets
import solver
from rulesheets.evaluate import differentiate, value
from rulesheets.syntax.nodes import subtract
from tests.oracles.redistribution import MODELS, SHEETS, Choice, Sheet, sheet, well_posed_choice

WIDTHS = {"choices": 8, "back": 6, "all": 5, "false": 6, "median": 8, "p95": 7, "worst": 7}
HEAD = f"{'sheet':<32}{'pool':<8}" + "".join(f"{name:>{width}}" for name, width in WIDTHS.items())
PATIENCE, NEARBY, SPREAD, QUICK = 20.0, 4, 1e-3, 200.0
"""Of prepared calls: seconds for a full solve, calls next to the state, how near, microseconds held
to."""
NEAR, SINGULAR = 0.1, 1e-7
"""Of states of linkages: how far inputs are moved, and the share of slopes that determines
nothing."""
LINKAGES = ("four_link_chain",)
REFUSALS = ("infeasible", "inconsistent")


@dataclass(frozen=True)
class Trial:
    """``back``: the state is among the answers. ``false``: what the solve claims is not true."""

    choice: Choice
    status: str
    answers: int
    complete: bool
    back: bool
    seconds: float

    @property
    def false(self) -> bool:
        if self.choice.singular:
            return False
        return self.status in REFUSALS or (self.complete and not self.back)


def trial(of: Sheet, choice: Choice) -> Trial:
    started = time.process_time()
    result = solver.solve(of.model, of.inputs_of(choice))
    seconds = time.process_time() - started
    back = any(of.is_state(solution, choice) for solution in result.solutions)
    return Trial(choice, str(result.status), len(result.solutions), result.complete, back, seconds)


def trials(of: Sheet, pool: str, seeds: range, each: bool) -> Iterator[Trial]:
    for seed in seeds:
        found = trial(
            of, well_posed_choice(of, of.posted if pool == "posted" else of.numbers, seed)
        )
        if each:
            mark = "singular" if found.choice.singular else "back" if found.back else "LOST"
            print(
                f"{seed:>5} "
                f"{mark:<9}{found.status:<13}{found.answers:>3}{'' if found.complete else '+':<2}"
                f"{found.seconds:7.2f} "
                f"{'FALSE ' if found.false else ''}{','.join(found.choice.inputs)}"
                f"  {found.choice.condition:.0e}",
                flush=True,
            )
        yield found


def summary(name: str, pool: str, found: list[Trial]) -> str:
    regular = [t for t in found if not t.choice.singular]
    times = sorted(t.seconds for t in found)
    return (
        f"{name:<32}{pool:<8}{len(regular):>8}{sum(t.back for t in regular):>6}"
        f"{sum(t.complete for t in regular):>5}{sum(t.false for t in found):>6}"
        f"{times[len(times) // 2]:8.2f}{times[int(len(times) * 0.95)]:7.2f}{times[-1]:7.2f}"
        f"  {dict(Counter(t.status for t in found))}"
    )


class Drawn(NamedTuple):
    """A question next to a state of a sheet: the numbers given anew, what is fixed, what is
    wanted."""

    model: Any
    given: dict[str, float]
    fixed: dict[str, Any]
    want: list[str]


def crank_question(name: str, pool: str, seed: int) -> Drawn | None:
    """A random state of a slider crank and a well-posed choice of its numbers; None where it is
    singular."""
    of = sheet(name)
    choice = well_posed_choice(of, of.posted if pool == "posted" else of.numbers, seed)
    if choice.singular:
        return None
    given = {of.full[name]: choice.state[name] for name in choice.inputs}
    fixed = {name: value for name, value in of.inputs_of(choice).items() if name not in given}
    want = [of.full[name] for name in of.posted if name not in choice.inputs]
    return Drawn(of.model, given, fixed, want)


def linkage_question(name: str, pool: str, seed: int) -> Drawn | None:
    """The same of a sheet whose rules all hold at once: its own state with every input moved a
    little."""
    model, draw = rulesheets.load(MODELS / name / "model.tk"), random.Random(seed)
    stated = [n for n, v in model.variables.items() if isinstance(v.value, float)]
    moved = {
        n: (model.variables[n].value or 1.0) * (1 + NEAR * draw.uniform(-1, 1)) for n in stated
    }
    found: Any = solver.solve(model, moved).solutions
    if not found:
        return None
    state = {n: v for n, v in found[0].items() if isinstance(v, float)}
    numbers = [n for n in state if pool != "posted" or model.variables[n].posted]
    while True:
        names = draw.sample(numbers, len(stated))
        if _is_well_posed(model, state, names):
            given = {n: state[n] for n in names}
            want = [n for n, v in model.variables.items() if v.posted and n not in given]
            return Drawn(model, given, {n: None for n in stated if n not in given}, want)


def _is_well_posed(model: Any, state: Mapping[str, float], given: Collection[str]) -> bool:
    """Whether the rules determine all other numbers next to a state: the rank of their scaled
    slopes."""
    unknowns = [name for name in state if name not in given]
    matrix = np.zeros((len(model.equations), len(unknowns)))
    for row, rule in enumerate(model.equations):
        for name in set(rule.names).difference(given):
            slope = value(differentiate(subtract(rule.left, rule.right), name), state)
            matrix[row, unknowns.index(name)] = slope * (abs(state[name]) or 1.0)
    matrix /= np.abs(matrix).max(axis=1, initial=1e-300)[:, None]
    singular = np.linalg.svd(matrix, compute_uv=False)
    return len(matrix) >= len(unknowns) and bool(
        singular[len(unknowns) - 1] > SINGULAR * singular[0]
    )


def prepared_call(asked: Drawn) -> float:
    """Processor time (s) of a prepared call next to the numbers of a question; nan without an
    answer."""
    numbers = [*asked.given.values()]
    plan: Any = solver.prepare(
        asked.model, [*asked.given], asked.want, asked.fixed, timeout=PATIENCE
    )
    draw, times = random.Random(str((*asked.given,))), []
    try:
        plan(*numbers)
        for _ in range(NEARBY):
            near = [number * (1 + SPREAD * draw.uniform(-1, 1)) for number in numbers]
            plan(*near)
            times.append(min(clocked(plan, near) for _ in range(5)))
    except solver.Unsolved:
        pass
    return sorted(times)[len(times) // 2] if times else math.nan


def clocked(plan: Any, numbers: list[float]) -> float:
    started = time.process_time()
    plan(*numbers)
    return time.process_time() - started


def prepared(name: str, pool: str, seeds: range, each: bool) -> str:
    """The distribution of prepared calls over the choices, in microseconds."""
    times = []
    for seed in seeds:
        asked = (crank_question if name in SHEETS else linkage_question)(name, pool, seed)
        seconds = prepared_call(asked) if asked is not None else math.nan
        if asked is not None and seconds == seconds:
            times.append(1e6 * seconds)
            if each:
                print(f"{seed:>5} {times[-1]:12.1f} µs  {','.join(asked.given)}", flush=True)
    times.sort()
    within = sum(t <= QUICK for t in times) / len(times)
    middle, most = times[len(times) // 2], times[int(0.9 * (len(times) - 1))]
    return (
        f"{name:<32}{pool:<8}{len(times):>4} answered of {len(seeds)}; within {QUICK:g} µs "
        f"{within:.0%}, "
        f"median {middle:,.1f} µs, 90 % {most:,.1f} µs, worst {times[-1]:,.0f} µs"
    )


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--sheet", choices=(*SHEETS, *LINKAGES))
    parser.add_argument("--pool", choices=("posted", "all"))
    parser.add_argument("--seeds", default="0:40")
    parser.add_argument("--each", action="store_true")
    parser.add_argument("--prepared", action="store_true")
    options = parser.parse_args()
    seeds = range(*map(int, options.seeds.split(":")))
    lines = []
    for name in (
        [options.sheet] if options.sheet else (*SHEETS, *LINKAGES) if options.prepared else SHEETS
    ):
        for pool in [options.pool] if options.pool else ("posted", "all"):
            if options.prepared:
                print(prepared(name, pool, seeds, options.each), flush=True)
            else:
                lines.append(
                    summary(name, pool, list(trials(sheet(name), pool, seeds, options.each)))
                )
    if lines:
        print(HEAD, *lines, sep="\n")


if __name__ == "__main__":
    main()
