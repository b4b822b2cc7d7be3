"""One solve, prepared: microseconds for five outputs, checked and judged, beside peers that check
nothing."""

from __future__ import annotations

import tempfile
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from benchmarks.speed import closed_forms, solvers, symbols
from benchmarks.speed.by_c import CCrank
from benchmarks.speed.page import Claim, Section, figures
from benchmarks.speed.rules_as_equations import system_of
from benchmarks.speed.stopwatch import Contestant, Time, race
from benchmarks.speed.task import ANGLE, DIRECTIONS, GUESS, NEARBY, POSITION, model, plan


def measure(rounds: int) -> Section:
    with tempfile.TemporaryDirectory() as folder:
        found = {d: race(contestants(d, Path(folder)), rounds) for d in DIRECTIONS}
    kinds = {c: k for c, k in KINDS.items() if any(c in times for times in found.values())}
    rows = [(name, *_cells(found, name)) for name in kinds]
    return Section(
        "one",
        "One solve",
        (
            "µs a solve",
            "forward",
            "slider-driven, both answers",
            "forward, ratio",
            "slider-driven, ratio",
        ),
        rows,
        (
            "Ratios are to the closed form in Python. fsolve, casadi's Newton and nsolve start "
            "from the "
            "values at a crank angle 10 degrees off, and return one answer. Theirs are five "
            "equations by "
            "hand; *the rules of the sheet* are all that the path uses, exact Jacobian included.",
        ),
        claims(found),
        tuple(
            (
                title,
                "µs",
                [(n, found[d][n].cpu * 1e6, k) for n, k in kinds.items() if n in found[d]],
            )
            for d, title in (
                ("forward", "One solve, forward"),
                ("backward", "One solve, slider-driven"),
            )
        ),
    )


OURS, HAND = "backsolve, prepared", "closed form by hand, Python"
FIVE = "scipy fsolve with Jacobian"
RULES = "scipy fsolve with Jacobian, the rules of the sheet"
KINDS = {
    OURS: "ours",
    HAND: "hand",
    "closed form by hand, numba": "hand",
    "closed form by hand, C": "hand",
    "sympy.lambdify with cse": "peer",
    "casadi function": "peer",
    "casadi rootfinder (newton)": "peer",
    "jax": "peer",
    FIVE: "peer",
    "scipy fsolve": "peer",
    RULES: "peer",
    "scipy fsolve, the rules of the sheet": "peer",
    "sympy.nsolve": "peer",
}


def contestants(direction: str, folder: Path) -> list[Contestant]:
    ahead = direction == "forward"
    number = ANGLE if ahead else POSITION
    prepared = plan(direction)
    closed = closed_forms.forward if ahead else closed_forms.backward
    runs: dict[str, Any] = {
        OURS: prepared if ahead else prepared.all,
        HAND: closed,
        "sympy.lambdify with cse": symbols.function(direction, "math", every=True),
        FIVE: solvers.fsolve(direction, True),
        "scipy fsolve": solvers.fsolve(direction, False),
        RULES: _rules(direction, True),
        "scipy fsolve, the rules of the sheet": _rules(direction, False),
        "sympy.nsolve": solvers.nsolve(direction),
    }
    if find_spec("numba"):
        from benchmarks.speed import by_numba

        runs["closed form by hand, numba"] = by_numba.forward if ahead else by_numba.backward
    if find_spec("casadi"):
        runs["casadi function"] = solvers.casadi_function(direction)
        runs["casadi rootfinder (newton)"] = solvers.casadi_rootfinder(direction)
    if find_spec("jax"):
        runs["jax"] = solvers.jax_function(direction)
    with suppress(OSError):  # no compiler
        runs["closed form by hand, C"] = CCrank(folder).one()[0 if ahead else 1]
    return [Contestant(name, runs[name], number) for name in KINDS if name in runs]


def _rules(direction: str, with_jacobian: bool) -> Any:
    """fsolve on the rules that the path uses, from the answer of a row some degrees away."""
    prepared = plan(direction)
    here, nearby = (ANGLE, GUESS) if direction == "forward" else (POSITION, NEARBY["forward"][0])
    system = system_of(model(), prepared, prepared.judged((here,))[0])
    if system is None:
        raise ValueError("the rules of the path are no square system")
    solve = system.fsolve(with_jacobian)
    start = system.start(prepared.judged((nearby,))[0].leaves[0].branch.values)
    return lambda number: solve(number, start)


def _cells(found: dict[str, dict[str, Time]], name: str) -> list[str]:
    times = [found[d][name].cpu * 1e6 if name in found[d] else None for d in DIRECTIONS]
    bases = [found[d][HAND].cpu * 1e6 for d in DIRECTIONS]
    ratios = [None if t is None else t / base for t, base in zip(times, bases, strict=True)]
    return ["–" if t is None else figures(t) for t in (*times, *ratios)]


def claims(found: dict[str, dict[str, Time]]) -> list[Claim]:
    def ratio(direction: str, one: str, other: str) -> float:
        return found[direction][one].cpu / found[direction][other].cpu

    return [
        Claim("forward, of the closed form by hand in Python", 4, ratio("forward", OURS, HAND)),
        Claim(
            "forward, faster than fsolve with its Jacobian, the rules of the sheet",
            40,
            ratio("forward", RULES, OURS),
            more=True,
        ),
        Claim(
            "the same, five equations by hand",
            40,
            ratio("forward", FIVE, OURS),
            more=True,
        ),
        Claim(
            "slider-driven, both answers, of the closed form by hand",
            10,
            ratio("backward", OURS, HAND),
        ),
        Claim(
            "slider-driven, both answers, faster than fsolve for one, the rules of the sheet",
            30,
            ratio("backward", RULES, OURS),
            more=True,
        ),
        Claim("the same, five equations by hand", 30, ratio("backward", FIVE, OURS), more=True),
    ]
