"""Twenty-three standard nonlinear systems against other solvers, from near starts and far ones.

    python benchmarks/nonlinear.py [-o PICTURE.png] [--only NUMBER,…] [--factors 1,10,100] [--write]

solves every system of ``standard.py`` from its standard start and from ten and a hundred times
that, and prints how many each solver solved. An end counts by its *scaled residual*, computed with
50 digits: the largest |F_i| / max(1, Σ_j |∂F_i/∂x_j · x_j|). *Solved* is a root reported with 1e-10
or less, *rough* one up to 1e-6, a *false success* one with more. (Backsolve may call an answer
singular: it is a multiple root, or one of a continuum. It counts as solved if it is one.)
``--write`` puts the counts into ``docs/accuracy.md``.
"""

from __future__ import annotations

import argparse
import math
import statistics
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import mpmath

sys.path.insert(0, str(Path(__file__).parent.parent))

import rulesheets
import solver
from benchmarks.pages import ROOT, markdown_table, place
from benchmarks.peers import (
    NOT_TRIED,
    End,
    Equations,
    Solve,
    absent,
    compiled,
    digits,
    peers,
    run,
    symbolic,
)
from benchmarks.standard import PROBLEMS, Problem
from rulesheets.model import Model

OURS = "backsolve"
ENDS = ("solved", "rough", NOT_TRIED, "failed", "false success")
SOLVED, ROUGH = 1e-10, 1e-6


@dataclass(frozen=True)
class Mark:
    """How one search ended: one of ``ENDS``, with the scaled residual of what was reported."""

    end: str
    residual: float
    seconds: float
    said: str = ""


@cache
def model(number: int) -> Model:
    return rulesheets.loads(PROBLEMS[number - 1].sheet)


def equations(problem: Problem) -> Equations:
    return Equations(problem.residuals, len(problem.start))


def ours(problem: Problem, factor: float) -> Solve:
    """``solver.solve`` on the sheet, the start as guesses."""

    def solve(_: Equations, start: Sequence[float]) -> tuple[bool, Sequence[float] | None]:
        result = solver.solve(model(problem.number), guesses=problem.guesses(factor))
        if not result.solutions:
            return False, None
        return True, [float(str(result.solutions[0][name])) for name in problem.names]

    return solve


def scaled_residual(problem: Problem, x: Sequence[float]) -> float:
    """The largest |F_i| / max(1, Σ_j |∂F_i/∂x_j · x_j|), with 50 digits and differences of 25."""
    with mpmath.workdps(50):
        functions, step = digits(), mpmath.mpf(10) ** -25
        point = [mpmath.mpf(v) for v in x]
        try:
            here = problem.residuals(point, functions)
            sizes = [mpmath.mpf(0)] * len(here)
            for j, v in enumerate(point):
                ahead = [*point[:j], v + step, *point[j + 1 :]]
                moved = problem.residuals(ahead, functions)
                sizes = [
                    s + abs((b - a) / step * v) for s, a, b in zip(sizes, here, moved, strict=True)
                ]
            return float(max(abs(r) / max(1, s) for r, s in zip(here, sizes, strict=True)))
        except (ArithmeticError, ValueError):
            return math.inf


def mark(problem: Problem, end: End) -> Mark:
    if not end.success or end.x is None:
        return Mark(
            NOT_TRIED if end.said.startswith(NOT_TRIED) else "failed",
            math.nan,
            end.seconds,
            end.said,
        )
    residual = scaled_residual(problem, end.x)
    name = "solved" if residual <= SOLVED else "rough" if residual <= ROUGH else "false success"
    return Mark(name, residual, end.seconds)


def measure(problems: Sequence[Problem], factor: float) -> dict[str, list[Mark]]:
    """Marks by solver, in the order of the problems."""
    others = peers()
    found: dict[str, list[Mark]] = {name: [] for name in (OURS, *others)}
    for problem in problems:
        model(problem.number), compiled(equations(problem)), symbolic(equations(problem))
        start = [factor * v for v in problem.start]
        for name in found:
            solve = ours(problem, factor) if name == OURS else others[name]
            found[name].append(mark(problem, run(solve, equations(problem), start)))
    return found


def table(problems: Sequence[Problem], found: Mapping[str, Sequence[Mark]]) -> str:
    """One row a solver: how many ended how, median time, and what was not solved."""
    reference = statistics.median(m.seconds for m in found[OURS])
    lines = [
        f"{'':<22}{'solved':>8}{'rough':>7}{'untried':>9}{'failed':>8}{'false':>7}"
        f"{'median ms':>11}{'ratio':>8}  not solved (! falsely reported)"
    ]
    for name, marks in found.items():
        counts = [sum(m.end == end for m in marks) for end in ENDS]
        seconds = statistics.median(m.seconds for m in marks if m.end != NOT_TRIED)
        missed = " ".join(
            f"{p.number}{'!' if m.end == 'false success' else ''}"
            for p, m in zip(problems, marks, strict=True)
            if m.end in ("failed", "false success")
        )
        lines.append(
            f"{name:<22}{counts[0]:>8}{counts[1]:>7}{counts[2]:>9}{counts[3]:>8}{counts[4]:>7}"
            f"{1e3 * seconds:>11.2f}{seconds / reference:>8.2f}  {missed}".rstrip()
        )
    return "\n".join(lines)


def summary(measured: Mapping[float, Mapping[str, Sequence[Mark]]]) -> str:
    """Counts by solver and distance of the start: solved, rough, falsely reported; the first median
    time."""
    first, *_ = measured
    rows = []
    for name in measured[first]:
        tried = [m.seconds for m in measured[first][name] if m.end != NOT_TRIED]
        counts = (_counted(found[name]) for found in measured.values())
        rows.append((name, *counts, f"{1e3 * statistics.median(tried):.3g}"))
    head = ("", *(f"start × {factor:g}" for factor in measured), f"median ms, start × {first:g}")
    return markdown_table(head, rows)


def _counted(marks: Sequence[Mark]) -> str:
    count = {end: sum(m.end == end for m in marks) for end in ENDS}
    told = [f"{count[end]} {end}" for end in ("rough", "false success", NOT_TRIED) if count[end]]
    return f"{count['solved']} ({', '.join(told)})" if told else str(count["solved"])


def picture(path: str, measured: Mapping[float, Mapping[str, Sequence[Mark]]]) -> None:
    """Stacked bars of ends by solver, one group a factor."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    colours = dict(zip(ENDS, ("#2a7f62", "#b9d8a8", "#ffffff", "#d4d4d4", "#c0392b"), strict=True))
    figure, axes = pyplot.subplots(
        1, len(measured), sharey=True, figsize=(4.2 * len(measured), 3.6), squeeze=False
    )
    for axis, (factor, found) in zip(axes[0], measured.items(), strict=True):
        names = list(found)
        left = [0] * len(names)
        for end in ENDS:
            counts = [sum(m.end == end for m in found[name]) for name in names]
            axis.barh(
                names,
                counts,
                left=left,
                color=colours[end],
                edgecolor="#b0b0b0",
                linewidth=0.5,
                label=end,
            )
            left = [a + b for a, b in zip(left, counts, strict=True)]
        axis.set_title(f"standard start × {factor:g}")
        axis.set_xlabel("problems")
        axis.set_xlim(0, max(left))
        axis.spines[["top", "right"]].set_visible(False)
    axes[0][0].invert_yaxis()
    handles, labels = axes[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncols=len(ENDS), frameon=False)
    figure.tight_layout(rect=(0, 0.09, 1, 1))
    figure.savefig(path, dpi=130)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("-o", "--output", metavar="PICTURE.png", help="also draw the table")
    parser.add_argument("--only", default="", help="numbers of problems, by commas")
    parser.add_argument(
        "--factors", default="1,10,100", help="multiples of the standard start, by commas"
    )
    parser.add_argument("--write", action="store_true", help="put the counts into docs/accuracy.md")
    arguments = parser.parse_args()
    chosen = [
        p for p in PROBLEMS if not arguments.only or str(p.number) in arguments.only.split(",")
    ]
    if missing := absent():
        print(f"not installed, left out: {', '.join(missing)}")
    measured = {}
    for factor in map(float, arguments.factors.split(",")):
        measured[factor] = measure(chosen, factor)
        print(
            f"\n{len(chosen)} systems, standard start × "
            f"{factor:g}\n{table(chosen, measured[factor])}",
            flush=True,
        )
    if arguments.output:
        picture(arguments.output, measured)
    if arguments.write and not place(
        ROOT / "docs" / "accuracy.md", "standard systems", summary(measured)
    ):
        sys.exit("docs/accuracy.md has no place for the counts")


if __name__ == "__main__":
    main()
