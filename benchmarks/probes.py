"""Small questions that tell solvers apart: a hard start, a redundant pair, a contradiction, too few
inputs.

    python benchmarks/probes.py

prints what each solver makes of them: the answer with its residual (``!`` where it is no root, or
one of a continuum given as if it were the only one), or that it failed.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent.parent))

import rulesheets
import solver
from benchmarks.peers import Equations, absent, numbers, peers, run

Judge = Callable[[Sequence[float]], bool]


@dataclass(frozen=True)
class Probe:
    """``right`` tells whether a point given as the answer is one; ``truth`` says what is to be
    said."""

    title: str
    truth: str
    sheet: str
    names: tuple[str, ...]
    equations: Equations
    start: tuple[float, ...]
    right: Judge
    inputs: Mapping[str, float] = field(default_factory=dict)


PROBES = (
    Probe(
        "the cubic of EES's help page, from 1",
        "x = 66.6717",
        "3*x^3 - 200*x^2 - x - 1 = 0",
        ("x",),
        Equations(lambda x, m: [3 * x[0] ** 3 - 200 * x[0] ** 2 - x[0] - 1], 1),
        (1.0,),
        lambda x: abs(x[0] - 66.6717) < 1e-4,
    ),
    Probe(
        "x + y = 26 and 2 x + 2 y = 52",
        "a continuum: give x or y",
        "x + y = 26\n2*x + 2*y = 52",
        ("x", "y"),
        Equations(lambda x, m: [x[0] + x[1] - 26, 2 * x[0] + 2 * x[1] - 52], 2),
        (1.0, 1.0),
        lambda x: False,
    ),
    Probe(
        "x + y = 26 and x + y = 27",
        "a contradiction of these two",
        "x + y = 26\nx + y = 27",
        ("x", "y"),
        Equations(lambda x, m: [x[0] + x[1] - 26, x[0] + x[1] - 27], 2),
        (1.0, 1.0),
        lambda x: False,
    ),
    Probe(
        "V = 12, V = I R, P = V I",
        "one short: give I, R or P",
        "variables\nV = 12\nI\nR\nP\nrules\nV = I*R\nP = V*I",
        ("I", "R", "P"),
        Equations(lambda x, m: [x[0] * x[1] - 12, 12 * x[0] - x[2], 0 * x[0]], 3),
        (1.0, 1.0, 1.0),
        lambda x: False,
    ),
    Probe(
        "circles that touch, x² + y² = 1 and (x - 2)² + y² = 1",
        "the double root (1, 0)",
        "x^2 + y^2 = 1\n(x - 2)^2 + y^2 = 1",
        ("x", "y"),
        Equations(lambda x, m: [x[0] ** 2 + x[1] ** 2 - 1, (x[0] - 2) ** 2 + x[1] ** 2 - 1], 2),
        (0.5, 0.7),
        lambda x: abs(x[0] - 1) < 1e-6 and abs(x[1]) < 1e-6,
    ),
    Probe(
        "circles that miss, (x - 2.1)² + y² = 1",
        "no real point",
        "x^2 + y^2 = 1\n(x - 2.1)^2 + y^2 = 1",
        ("x", "y"),
        Equations(lambda x, m: [x[0] ** 2 + x[1] ** 2 - 1, (x[0] - 2.1) ** 2 + x[1] ** 2 - 1], 2),
        (0.5, 0.7),
        lambda x: False,
    ),
)


def ours(probe: Probe) -> list[str]:
    """The status, the values, and the first line of what is said about them."""
    guesses = dict(zip(probe.names, probe.start, strict=True))
    result = solver.solve(rulesheets.loads(probe.sheet), probe.inputs, guesses=guesses)
    lines = [f"{result.status}"]
    for solution in result.solutions:
        known = {name: solution[name] for name in probe.names if name in solution}
        lines[0] += "".join(f"  {name} = {value:.6g}" for name, value in known.items())
    for diagnosis in result.diagnoses[:1]:
        lines += [diagnosis.message, *(str(note) for note in diagnosis.notes[:1])]
    return lines


def theirs(probe: Probe, name: str, solve: Any) -> str:
    end = run(solve, probe.equations, probe.start)
    if not end.success or end.x is None:
        return "fails"
    try:
        residual = max(abs(r) for r in probe.equations.residuals(end.x, numbers()))
    except (ArithmeticError, ValueError):
        return "! undefined there"
    point = ", ".join(f"{v:.6g}" for v in end.x)
    return f"{'' if probe.right(end.x) else '! '}({point}), residual {residual:.0e}"


def main() -> None:
    others = peers()
    if missing := absent():
        print(f"not installed, left out: {', '.join(missing)}")
    for probe in PROBES:
        print(f"\n{probe.title}\n  {'truth':<22}{probe.truth}")
        first, *more = ours(probe)
        print(f"  {'backsolve':<22}{first}", *(f"{'':24}{line}" for line in more), sep="\n")
        for name, solve in others.items():
            print(f"  {name:<22}{theirs(probe, name, solve)}", flush=True)


if __name__ == "__main__":
    main()
