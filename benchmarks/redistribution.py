"""How many random choices of the slider crank's inputs lead back to the state that they were taken from.

    python benchmarks/redistribution.py [--sheet NAME] [--pool posted|all] [--seeds FIRST:LAST] [--each]

For each sheet and each pool of numbers it draws well-posed choices of six (and the branch) at random values,
solves, and prints how many returned the state, how many called their list of answers complete, how many said
something false, and the seconds they took. ``--each`` prints every choice on a line of its own.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))

import solver
from tests.oracles.redistribution import SHEETS, Choice, Sheet, sheet, well_posed_choice

WIDTHS = {"choices": 8, "back": 6, "all": 5, "false": 6, "median": 8, "p95": 7, "worst": 7}
HEAD = f"{'sheet':<32}{'pool':<8}" + "".join(f"{name:>{width}}" for name, width in WIDTHS.items())
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
        found = trial(of, well_posed_choice(of, of.posted if pool == "posted" else of.numbers, seed))
        if each:
            mark = "singular" if found.choice.singular else "back" if found.back else "LOST"
            print(
                f"{seed:>5} {mark:<9}{found.status:<13}{found.answers:>3}{'' if found.complete else '+':<2}"
                f"{found.seconds:7.2f} {'FALSE ' if found.false else ''}{','.join(found.choice.inputs)}"
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


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--sheet", choices=SHEETS)
    parser.add_argument("--pool", choices=("posted", "all"))
    parser.add_argument("--seeds", default="0:40")
    parser.add_argument("--each", action="store_true")
    options = parser.parse_args()
    seeds = range(*map(int, options.seeds.split(":")))
    lines = []
    for name in [options.sheet] if options.sheet else SHEETS:
        for pool in [options.pool] if options.pool else ("posted", "all"):
            lines.append(summary(name, pool, list(trials(sheet(name), pool, seeds, options.each))))
    print(HEAD, *lines, sep="\n")


if __name__ == "__main__":
    main()
