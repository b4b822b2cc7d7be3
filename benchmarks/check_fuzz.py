"""False answers, and true ones refused: everyday sheets with planted roots, singularities and
poles.

    python -m benchmarks.check_fuzz [--count 2000] [--seed 0] [--plans] [--show SEED]

solves the sheets of ``check_sheets.py`` from a seed on and judges every answer by Newton's method
in fifty digits on the rules as they are written: an answer from which that does not lead to a root
next to it is *false*. A planted state that is not listed is *missed*; it is *refused* if it is
listed where the second half of the check of an answer is left out, and *denied* if the list is
called complete without it. ``--plans``: a prepared plan that has learned from inputs nearby is
asked, too, for every answer.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

import rulesheets
import solver
from benchmarks.check_sheets import EverydaySheet, everyday
from benchmarks.digits import newton
from solver.kernel.candidates import Candidates

NEAR = 1e-6
"""Relative distance of an answer from the root that it stands for."""
TURN = 360.0
SHARES = (1e-2, -3e-3, 1e-3)
"""How far beside its inputs a plan learns."""


def examine(seed: int, plans: bool = False) -> tuple[Counter[str], list[str]]:
    """What is to count of the sheet of a seed, and what is to be told of it."""
    made = everyday(seed)
    if made is None:
        return Counter(), []
    result = solver.solve(rulesheets.loads(made.text), made.inputs)
    found, told = (
        Counter({"sheets": 1, str(result.status): 1, "answers": len(result.solutions)}),
        [],
    )
    for what, detail in (*_findings(made, result), *(_planned(made) if plans else ())):
        found[what] += 1
        told.append(f"{seed} {made.family}: {what} {detail}")
    return found, told


def _findings(made: EverydaySheet, result: solver.Result) -> Iterator[tuple[str, str]]:
    if str(result.status) == "solved":
        for place, solution in enumerate(result.solutions):
            if not is_root(made, solution):
                yield "false", f"answer {place}: {dict(solution)}"
    if not any(is_near(made, solution, made.planted) for solution in result.solutions):
        yield "missed", f"{result.status}, {_text(made)}"
        if result.complete or str(result.status) in ("infeasible", "inconsistent"):
            yield "denied", f"{result.status}, complete without {_text(made)}"
        if any(
            is_near(made, solution, made.planted) for solution in _without_check(made).solutions
        ):
            yield "refused", _text(made)


def _planned(made: EverydaySheet) -> Iterator[tuple[str, str]]:
    """False answers of a prepared plan."""
    numbers = list(made.inputs.values())
    plan = solver.prepare(rulesheets.loads(made.text), list(made.inputs), made.unknowns)
    for share in (*SHARES, 0.0):
        there = [
            x if x.is_integer() else x * (1.0 + (k + 1) * share) for k, x in enumerate(numbers)
        ]
        try:
            answers = plan.all(*there)
        except solver.Unsolved:
            continue
        at = dict(zip(made.inputs, there, strict=True))
        for answer in answers:
            if not is_root(made, {**at, **dict(zip(made.unknowns, answer, strict=True))}):
                yield "false in a plan", f"{at}: {answer}"


def is_root(made: EverydaySheet, solution: Mapping[str, Any]) -> bool:
    """Whether Newton's method leads from an answer to a root next to it."""
    if any(name not in solution for name in made.planted):
        return True
    root = newton(made.rules, solution, made.unknowns)
    return root is not None and is_near(made, solution, root, turns=False)


def is_near(
    made: EverydaySheet, solution: Mapping[str, Any], root: Mapping[str, Any], turns: bool = True
) -> bool:
    """Whether an answer stands for a root, angles but for whole ``turns``."""
    apart = (
        (name, float(abs(solution[name] - root[name])))
        for name in made.unknowns
        if name in solution
    )
    return all(
        far <= NEAR * abs(root[name]) or (turns and min(far % TURN, -far % TURN) <= NEAR * TURN)
        for name, far in apart
    )


def _without_check(made: EverydaySheet) -> solver.Result:
    """The result where an answer stands if its rules hold."""
    check, Candidates.stands = Candidates.stands, lambda *_: True  # type: ignore[method-assign]
    try:
        return solver.solve(rulesheets.loads(made.text), made.inputs)
    finally:
        Candidates.stands = check  # type: ignore[method-assign]


def _text(made: EverydaySheet) -> str:
    return str({name: float(value) for name, value in made.planted.items()})


def main() -> None:
    parser = argparse.ArgumentParser(description="False answers, and true ones refused.")
    parser.add_argument("--count", type=int, default=2000, help="seeds; some draw no sheet")
    parser.add_argument("--seed", type=int, default=0, help="the first")
    parser.add_argument("--plans", action="store_true", help="ask prepared plans, too")
    parser.add_argument(
        "--show", type=int, metavar="SEED", help="print one sheet, and what is found there"
    )
    arguments = parser.parse_args()
    if arguments.show is not None:
        made = everyday(arguments.show)
        assert made is not None
        print(made.text, made.inputs, sep="\n")
        for solution in solver.solve(rulesheets.loads(made.text), made.inputs).solutions:
            print(dict(solution))
        print(*examine(arguments.show, arguments.plans), sep="\n")
        return
    total: Counter[str] = Counter()
    for seed in range(arguments.seed, arguments.seed + arguments.count):
        found, told = examine(seed, arguments.plans)
        total += found
        print(*told, sep="\n", end="\n" if told else "", flush=True)
    print(
        ", ".join(
            f"{total[what]} {what}"
            for what in ("sheets", "answers", "false", "refused", "missed", "denied")
        )
    )
    print(dict(total))


if __name__ == "__main__":
    main()
