"""Random small everyday questions with planted answers, by form: is any answer false, or the true
one missed?

    python -m benchmarks.planted [--count 1000] [--seed 0] [--form NAME] [--plans 8] [--show SEED]

A form is a few rules of one to six, with kinds of numbers to draw: engineers' numbers of two to
four digits. What the rules define is computed in fifty digits and written with 15 to 17. Then as
many names as there are rules become unknowns, some of the others literals in the rules, and some
questions move into a function. The judges are those of ``hostile.py``, ``brute_force.py`` and
``check_fuzz.py``, in mpmath alone:

- *false*: an answer that is no root; infeasible, inconsistent or complete without the planted
  answer or another root; a plan or sweep that differs from a solve (``hostile_plans.py``, one
  question in ``--plans``);
- *missed*: the planted answer is not listed, and nothing false is said; *slow*: beyond five
  seconds.
"""

from __future__ import annotations

import argparse
import re
import signal
import sys
import time
import traceback
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from random import Random

import rulesheets
import solver
from benchmarks import hostile_plans
from benchmarks.brute_force import missing
from benchmarks.check_fuzz import is_root
from benchmarks.check_sheets import EverydaySheet
from benchmarks.digits import condition
from benchmarks.hostile import (
    CERTAIN,
    TooLong,
    _in_parts,
    _is_plant,
    alarm,
    false_claims,
    satisfied,
)
from benchmarks.hostile_sheets import Sheet, active, names_of, uncertainty
from benchmarks.hostile_small import value
from solver import Status

SLOW, LIMIT = 5.0, 60.0
"""Seconds of the processor: a question that takes more is slow; one that takes yet more is
stopped."""
CLEAR = 1e6
"""Condition of an answer up to which Newton's method is asked about it."""
LARGE = 1e15
"""Whole turns of angles from here on are beyond Newton's method in fifty digits."""
MANY = 20
"""Answers, of which there may be infinitely many: plans may list others of them."""
SHARES = (1.0, 1.01, 0.97, 1.2, 0.8)
"""Of the planted inputs, where plans and sweeps are asked."""
UNITS = (("mm", "m", 1000.0), ("g", "kg", 1000.0), ("kPa", "Pa", 0.001))
COLUMNS = ("questions", "false", "missed", "crash", "slow")

NUMBERS: Mapping[str, Callable[[Random], float]] = {
    "size": lambda random: 10.0 ** random.uniform(-6, 6),
    "mid": lambda random: 10.0 ** random.uniform(-1, 2),
    "near": lambda random: 10.0 ** random.uniform(-0.5, 0.6),
    "part": lambda random: random.uniform(0.05, 0.95),
    "signed": lambda random: random.choice((-1, 1)) * 10.0 ** random.uniform(-1, 2),
    "base": lambda random: -(10.0 ** random.uniform(-0.7, 0.7)),
    "whole": lambda random: random.choice((-3, -2, -1, 2, 3, 4, 5)),
    "broken": lambda random: random.choice(
        (0.5, 1.5, 2.5, -0.5, -1.5, 0.4, 1.4, -0.286, 1.852, 0.1)
    ),
    "angle": lambda random: random.choice(
        (random.uniform(-179, 179), 15.0 * random.randint(-11, 12))
    ),
    "acute": lambda random: random.choice((random.uniform(5, 85), 15.0 * random.randint(1, 5))),
    "turn": lambda random: random.uniform(-3.1, 3.1),
    "kelvin": lambda random: random.uniform(260, 900),
    "count": lambda random: random.choice((2, 3, 5, 10, 12, 24, 60)),
    "volt": lambda random: random.uniform(0.3, 0.8),
    "tiny": lambda random: 10.0 ** random.uniform(-14, -9),
    "viscosity": lambda random: 10.0 ** random.uniform(-6, -4),
    "reynolds": lambda random: 10.0 ** random.uniform(3.7, 7),
    "friction": lambda random: random.uniform(0.012, 0.06),
}


@dataclass(frozen=True)
class Form:
    """Rules, and what is drawn for their names; without ``unknown`` these are drawn, too."""

    rules: tuple[str, ...]
    draws: tuple[str, ...]
    unknown: tuple[str, ...]


def _forms() -> dict[str, list[Form]]:
    forms: dict[str, list[Form]] = {}
    _, *sections = Path(__file__).with_name("planted_forms.txt").read_text().split("\n[")
    for section in sections:
        head, *lines = section.strip().splitlines()
        forms[head.replace("]", "")] = made = []
        for rules, draws, *unknown in (line.split(" | ") for line in lines):
            made.append(
                Form(
                    tuple(rules.split("; ")),
                    tuple(draws.split("; ")),
                    tuple(*map(str.split, unknown)),
                )
            )
    return forms


FORMS = _forms()
SPECIAL = tuple(name for name in FORMS if name.endswith("*"))
"""Forms whose planted state holds in decimals, though the rules do not determine it well."""


@dataclass(frozen=True)
class Question(Sheet):
    """``units``: of some inputs, as their rows give them; ``body``: the rules as the sheet has
    them."""

    units: Mapping[str, tuple[str, str, float]] = field(default_factory=dict)
    body: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        rows = [self._row(name, number) for name, number in self.inputs.items()]
        return "\n".join(
            ["variables", *rows, "rules", *self.body, ""] if rows else [*self.body, ""]
        )

    def _row(self, name: str, number: float) -> str:
        if name not in self.units:
            return f"{name} = {number!r}"
        given, used, factor = self.units[name]
        return f"{name} = {number * factor!r}[{given}] [{used}]"


def question(seed: int, most: int = 0, form: str = "") -> Question:
    """The question of a seed, of a form that is drawn from it or named."""
    random = Random(seed)
    form = form or random.choice(sorted(FORMS))
    while True:
        made = _drawn(random, form, random.choice(FORMS[form]))
        if made is not None and _sound(made):
            return made


def _sound(made: Question) -> bool:
    """Whether the planted state holds, and the rules determine it well, if they are meant to."""
    assert made.planted is not None
    holds = all(satisfied(rule, made.planted) for rule in active(made))
    return holds and (made.kind in SPECIAL or uncertainty(made) <= CERTAIN)


def _drawn(random: Random, name: str, form: Form) -> Question | None:
    digits = 15 if name in SPECIAL else random.choice((15, 16, 17))
    state = _state(random, form, digits)
    if state is None:
        return None
    count = len(form.rules)
    unknown = form.unknown or tuple(random.sample(sorted(state), min(count, len(state))))
    given = [n for n in state if n not in unknown]
    written = set(given) if random.random() < 0.3 else {n for n in given if random.random() < 0.4}
    if len(unknown) != count or set(unknown) - names_of(" ".join(form.rules)):
        return None
    lines = tuple(_written(rule, {n: state[n] for n in written}) for rule in form.rules)
    if any(not names_of(line) for line in lines):
        return None
    planted = {
        n: x for n, x in state.items() if n not in written and n in names_of(" ".join(lines))
    }
    inputs = {n: planted[n] for n in given if n in planted}
    units = {n: random.choice(UNITS) for n in inputs if random.random() < 0.1}
    units = {n: unit for n, unit in units.items() if inputs[n] * unit[2] / unit[2] == inputs[n]}
    rules = tuple(parts for line in lines for parts in _parts(line))
    body = _called(lines, list(inputs), list(unknown)) if random.random() < 0.15 else lines
    return Question(name, rules, inputs, planted=planted, lines=lines, units=units, body=body)


def _state(random: Random, form: Form, digits: int) -> dict[str, float] | None:
    """Numbers drawn, and computed from them; None where they have no value or an odd size."""
    state: dict[str, float] = {}
    kinds = {**NUMBERS, "mid": NUMBERS["size"]} if random.random() < 0.2 else NUMBERS
    for item in (*form.draws, *form.rules):
        variable, _, rest = item.partition(" ")
        if rest in NUMBERS:
            state[variable] = float(f"{kinds[rest](random):.{random.choice((2, 3, 4))}g}")
        elif re.match(r"[a-z] = ", item) and variable not in state:
            number = value(item[4:], state)
            if number is None or not 1e-9 < abs(number) < 1e9:
                return None
            state[variable] = float(f"{number:.{digits}g}")
    return state


def _written(rule: str, numbers: Mapping[str, float]) -> str:
    """The rule with literals for some names."""

    def literal(found: re.Match[str]) -> str:
        if found[0] not in numbers:
            return found[0]
        number = numbers[found[0]]
        text = f"{number:.0f}" if number.is_integer() and abs(number) < 1e6 else repr(number)
        return f"({text})" if number < 0 else text

    return re.sub(r"\b[a-z]\b", literal, rule)


def _parts(line: str) -> Iterator[tuple[str, str, str]]:
    """Condition, left and right of every equation in a line."""
    found = re.fullmatch(r"if (.*) then (.*) else (.*)", line)
    arms = [(found[1], found[2]), (f"not ({found[1]})", found[3])] if found else [("", line)]
    for test, rule in arms:
        left, right = rule.split(" = ")
        yield test, left, right if names_of(right) else repr(value(right, {}))


def _called(lines: tuple[str, ...], inputs: list[str], unknown: list[str]) -> tuple[str, ...]:
    """The rules in a function, called with the same names."""
    if not inputs:
        return lines
    head = f"({', '.join(inputs)}; {', '.join(unknown)})"
    return (f"call part{head}", f"function part{head}", "rules", *lines)


def findings(made: Question, result: solver.Result) -> Iterator[tuple[str, str]]:
    """What is false, or else that the planted answer is missed."""
    false = list(_false(made, result))
    yield from (("false", detail) for detail in false)
    if not false and not _listed(made, result):
        yield (
            "missed",
            f"{result.status}, {len(result.solutions)} answers, {dict(made.planted or {})}",
        )


def _listed(made: Question, result: solver.Result) -> bool:
    spread = min(uncertainty(made), 1e-7)
    return any(_is_plant(made, solution, spread) for solution in result.solutions)


def _false(made: Question, result: solver.Result) -> Iterator[str]:
    assert made.planted is not None
    yield from (": ".join(claim) for claim in false_claims(made, result))
    denied = result.status in (Status.INFEASIBLE, Status.INCONSISTENT)
    if made.kind in SPECIAL and (
        denied or (result.status is Status.SOLVED and result.complete and not _listed(made, result))
    ):
        yield f"{result.status} without {dict(made.planted)}, which holds in decimals"
    for solution in (
        result.solutions if result.status is Status.SOLVED and made.kind not in SPECIAL else ()
    ):
        at = {n: x for n, x in solution.items() if isinstance(x, float) and abs(x) < LARGE}
        if not set(made.planted) <= set(at):
            continue
        rules = tuple(f"{left} = {right}" for _, left, right in active(replace(made, planted=at)))
        unknowns = tuple(n for n in made.planted if n not in made.inputs)
        square = len(rules) == len(unknowns)
        if square and condition(rules, at, unknowns) < CLEAR:
            asked = EverydaySheet(made.kind, rules, made.inputs, made.planted, unknowns)
            if not is_root(asked, at):
                yield f"no root: {at}"
    if not made.inputs and not any(_in_parts(made, n) for n in made.planted):
        yield from (f"{result.status} without {root!r}" for root in missing(made, result))


def examine(
    seed: int, form: str = "", plans: bool = False
) -> tuple[str, float, list[tuple[str, str]]]:
    """The form of the question of a seed, seconds of a solve, and what was found."""
    made = question(seed, form=form)
    signal.signal(signal.SIGPROF, alarm)
    signal.setitimer(signal.ITIMER_PROF, LIMIT)
    began = time.process_time()
    try:
        result = solver.solve(rulesheets.loads(made.text))
        _ = result.diagnoses  # the messages must come to an end, too
    except TooLong:
        return made.kind, LIMIT, [("slow", f"over {LIMIT:g} s")]
    except Exception:
        return made.kind, 0.0, [("crash", traceback.format_exc().strip().splitlines()[-1])]
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
    seconds = time.process_time() - began
    found = list(findings(made, result))
    found += [("slow", f"{seconds:.1f} s")] if seconds > SLOW else []
    if plans and made.inputs and len(result.solutions) <= MANY:
        found += _of_plans(seed, form)
    return made.kind, seconds, found


def _of_plans(seed: int, form: str) -> list[tuple[str, str]]:
    finding = hostile_plans.examine(
        seed,
        LIMIT,
        patience=1.0,
        make=lambda seed, most: question(seed, most, form),
        asked=_asked,
        strict=True,
    ).finding
    if finding is None:
        return []
    return [
        ("crash" if finding.what == "crash" else "false", f"plan, {finding.what}: {finding.detail}")
    ]


def _asked(made: Sheet, seed: int) -> list[tuple[float, ...]]:
    return [tuple(x if x.is_integer() else x * k for x in made.inputs.values()) for k in SHARES]


def main() -> None:
    parser = argparse.ArgumentParser(
        description="Small everyday questions with planted answers, by form."
    )
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0, help="the first of as many seeds")
    parser.add_argument(
        "--form", choices=sorted(FORMS), default="", help="questions of this form alone"
    )
    parser.add_argument(
        "--plans", type=int, default=8, help="one question in so many goes through plans"
    )
    parser.add_argument(
        "--show", type=int, metavar="SEED", help="print one question and its answers"
    )
    options = parser.parse_args()
    if options.show is not None:
        made = question(options.show, form=options.form)
        result = solver.solve(rulesheets.loads(made.text))
        print(
            made.text,
            f"planted {made.planted}",
            result.status,
            f"complete {result.complete}",
            sep="\n",
        )
        print(*map(dict, result.solutions), *examine(options.show, options.form, True)[2], sep="\n")
        return
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    worst: dict[str, float] = defaultdict(float)
    for seed in range(options.seed, options.seed + options.count):
        form, seconds, found = examine(
            seed, options.form, options.plans > 0 and seed % options.plans == 0
        )
        worst[form] = max(worst[form], seconds)
        counts[form] += Counter({"questions": 1, **dict.fromkeys({what for what, _ in found}, 1)})
        for what, detail in found:
            print(f"{what} {seed} {form}: {detail}")
            print(question(seed, form=options.form).text if what != "missed" else "", flush=True)
    print(f"{'':<18}" + "".join(f"{name:>10}" for name in COLUMNS) + "  worst s")
    counts["all"], worst["all"] = sum(counts.values(), Counter()), max(worst.values())
    for form, of in sorted(counts.items(), key=lambda item: (item[0] == "all", item[0])):
        print(
            f"{form:<18}" + "".join(f"{of[name]:>10}" for name in COLUMNS) + f"{worst[form]:>9.2f}"
        )
    sys.exit(bool(counts["all"]["false"] or counts["all"]["crash"]))


if __name__ == "__main__":
    main()
