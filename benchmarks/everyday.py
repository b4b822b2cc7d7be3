"""How often the first answer to an ordinary question is the one that an engineer expects.

    python -m benchmarks.everyday [--corpus] [--random N] [--seed S] [--each] [--limit SECONDS]

``--corpus`` asks the questions of tests/everyday, by area; ``--random`` so many random sheets, by
the number of inputs and outputs exchanged. The columns: the expected answer comes first; another
answer without more negative values does (``rival``); it is listed behind a worse one; it is missed;
the result claims what is false, judged in fifty digits; the limit was reached; seconds of the
processor. ``--each`` prints what is not right.
"""

from __future__ import annotations

import argparse
import signal
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import rulesheets
import solver
from benchmarks.everyday_sheets import RandomSheet, random_sheet
from tests.everyday.corpus import Verdict, is_state, sheets, verdict

COLUMNS = ("first", "rival", "listed", "missed", "false", "late")


class Late(Exception):
    """A question took longer than its limit."""


@dataclass(frozen=True)
class Trial:
    group: str
    label: str
    mark: str
    false: tuple[str, ...]
    seconds: float
    text: str


def trial(
    group: str, label: str, limit: int, ask: Callable[[], Verdict], planted: Mapping[str, Any]
) -> Trial:
    started = time.process_time()
    signal.setitimer(signal.ITIMER_PROF, limit)
    try:
        found = ask()
    except Late:
        return Trial(group, label, "late", (), time.process_time() - started, f"over {limit} s")
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
    text = f"{found}, first: {dict(found.result.solutions[0]) if found.result.solutions else None}"
    return Trial(
        group, label, mark(found, planted), found.false, time.process_time() - started, text
    )


def mark(found: Verdict, planted: Mapping[str, Any]) -> str:
    if found.first:
        return "first"
    first = found.result.solutions[0] if found.result.solutions else {}
    if found.listed and negative(first) <= negative(planted):
        return "rival"
    return "listed" if found.listed else "missed"


def negative(values: Mapping[str, Any]) -> int:
    return sum(not isinstance(value, str) and value < 0 for value in values.values())


def of_corpus(limit: int) -> Iterator[Trial]:
    for sheet in sheets():
        for question in sheet.questions():
            yield trial(sheet.area, question.id, limit, question.judged, sheet.state)


def of_random(count: int, seed: int, limit: int) -> Iterator[Trial]:
    for number in range(seed, seed + count):
        made = random_sheet(number)
        group = f"exchanged {made.exchanged}" if made.exchanged < 4 else "exchanged more"
        yield trial(group, f"seed {number}", limit, lambda made=made: judged(made), made.state)


def judged(made: RandomSheet) -> Verdict:
    result = solver.solve(rulesheets.loads(made.text))
    return verdict(made.text, result, lambda answer: is_state(answer, made.state, 1e-7), made.state)


def table(trials: list[Trial]) -> Iterator[str]:
    yield f"{'':<16}{'asked':>7}" + "".join(f"{name:>8}" for name in COLUMNS) + f"{'seconds':>9}"
    for group in [*sorted({t.group for t in trials}), "all"]:
        of = [t for t in trials if group in (t.group, "all")]
        counts = Counter(t.mark for t in of) + Counter(false=sum(bool(t.false) for t in of))
        cells = "".join(f"{counts[name]:>8}" for name in COLUMNS)
        yield f"{group:<16}{len(of):>7}{cells}{sum(t.seconds for t in of):>9.1f}"


def _late(*_: Any) -> None:
    raise Late


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--corpus", action="store_true")
    parser.add_argument("--random", type=int, default=0, metavar="N")
    parser.add_argument("--seed", type=int, default=0, metavar="S")
    parser.add_argument("--each", action="store_true")
    parser.add_argument("--limit", type=int, default=30, metavar="SECONDS")
    options = parser.parse_args()
    signal.signal(signal.SIGPROF, _late)
    parts = [of_random(options.random, options.seed, options.limit)] if options.random else []
    if options.corpus or not parts:
        parts.insert(0, of_corpus(options.limit))
    for part in parts:
        trials = []
        for one in part:
            trials.append(one)
            if options.each and (one.mark != "first" or one.false):
                print(f"{one.mark:<7}{one.label}: {'; '.join(one.false) or one.text}", flush=True)
        print(*table(trials), sep="\n")


if __name__ == "__main__":
    main()
