"""Blocks with one iterated unknown beside casadi's Newton on the same block, both prepared.

    python -m benchmarks.one_tear [--model NAME]… [--each] [--write]

The blocks are those that single swaps of the shipped models lead to (``benchmarks.swaps``), each by
itself: its rules as a sheet, one known number given anew, the others fixed. Ours is a prepared
call, which returns the first answer checked against every rule. casadi's ``rootfinder`` gets the
same rules and starts from the answer at the sheet's own numbers; it checks nothing. The ratio is
that of processor times at numbers within 1% of the sheet's, where casadi comes to the same answer.
"""

from __future__ import annotations

import argparse
import functools
import math
import re
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

import rulesheets
import solver
from benchmarks.networks import _value
from benchmarks.pages import ROOT, place
from benchmarks.speed.page import Claim, Section, figures
from benchmarks.swaps import MODELS, NAMES, PATIENCE, clocked
from rulesheets.deadline import TimeIsUp, time_limit
from rulesheets.format import format_expression
from rulesheets.inputs import override
from rulesheets.syntax.nodes import names
from solver.leaves import Asked
from solver.path import SolveBlock
from solver.solution.explore import explore

SHARES = (1e-2, 4e-3, -3e-3, -7e-3)
"""How far from the state of the sheet the given number is asked, relative to itself."""
SAME = 1e-6
"""Relative difference of two answers that are the same."""


@dataclass
class Block:
    """The rules of a block over ``state``: the numbers of its ``unknowns`` and of its ``known``
    names."""

    model: str
    rules: list[tuple[Any, Any]]
    unknowns: list[str]
    known: list[str]
    state: dict[str, float]
    ours: float = math.nan
    other: float = math.nan

    @property
    def ratio(self) -> float:
        return self.ours / self.other

    def sheet(self) -> str:
        sides = ((_flat(format_expression(a)), _flat(format_expression(b))) for a, b in self.rules)
        rows = (f"{_flat(name)} = {self.state[name]!r}" for name in self.known)
        return "\n".join(["variables", *rows, "rules", *(f"{a} = {b}" for a, b in sides), ""])


def _flat(text: str) -> str:
    """Full names without the dots of calls, and without their numbers' signs."""
    return re.sub(r"(?<=\w)\.(?=[A-Za-z_])", "__", re.sub(r"#(?=\d)", "_n", text))


def blocks(name: str) -> Iterator[Block]:
    """The blocks with one tear on the ways of the single swaps of a model, each once."""
    model = rulesheets.load(MODELS / name / "model.tk")
    state: Any = solver.solve(model).solutions[0]
    posted = [n for n, v in model.variables.items() if v.posted and isinstance(state.get(n), float)]
    inputs = [n for n in posted if model.variables[n].value is not None]
    seen = set[tuple[Any, ...]]()
    for given in (n for n in posted if n not in inputs):
        for wanted in inputs:
            values = override(model, {given: state[given], wanted: None}, {}).values
            try:
                with time_limit(PATIENCE):
                    found = explore(Asked(model, values, [wanted], {}, [wanted]))
            except TimeIsUp:
                continue
            leaf = next((leaf for leaf in found.leaves if leaf.solved), None)
            for step in leaf.branch.steps if leaf else ():
                if not isinstance(step, SolveBlock) or len(step.tears) != 1:
                    continue
                rules = [
                    (e.left, e.right) for e in map(model.equations.__getitem__, step.equations)
                ]
                every = dict.fromkeys(n for rule in rules for side in rule for n in names(side))
                known = [n for n in every if n not in step.unknowns]
                key = (step.equations, step.unknowns)
                there = {n: leaf.branch.values.get(n) for n in every}
                if key not in seen and known and all(isinstance(v, float) for v in there.values()):
                    seen.add(key)
                    yield Block(name, rules, list(step.unknowns), known, there)


class Degrees:
    """The functions of the language by those of casadi."""

    def __init__(self, casadi: Any) -> None:
        turn = math.pi / 180.0
        alike = "sin cos tan asin acos atan sinh cosh tanh exp sqrt fabs"
        self.__dict__.update({name: getattr(casadi, name) for name in alike.split()})
        self.ln, self.log, self.atan2, self.pi = (
            casadi.log,
            casadi.log10,
            casadi.atan2,
            lambda: math.pi,
        )
        self.sind, self.cosd, self.tand = (
            functools.partial(lambda f, x: f(x * turn), f)
            for f in (casadi.sin, casadi.cos, casadi.tan)
        )
        self.asind, self.acosd, self.atand = (
            functools.partial(lambda f, x: f(x) / turn, f)
            for f in (casadi.asin, casadi.acos, casadi.atan)
        )
        self.atan2d = lambda y, x: casadi.atan2(y, x) / turn


def measure(block: Block) -> bool:
    """Time both; False where a prepared call or casadi has no answer, or another one."""
    import casadi

    given = next((n for n in block.known if block.state[n]), block.known[0])
    flat = [_flat(n) for n in block.unknowns]
    plan: Any = solver.prepare(
        rulesheets.loads(block.sheet()), [_flat(given)], flat, timeout=PATIENCE
    )
    x, p = casadi.SX.sym("x", len(block.unknowns)), casadi.SX.sym("p")
    values: dict[str, Any] = {**block.state, given: p}
    values |= dict(zip(block.unknowns, casadi.vertsplit(x), strict=True))
    module = Degrees(casadi)
    try:
        residuals = [_value(a, values, module) - _value(b, values, module) for a, b in block.rules]
    except (NotImplementedError, AttributeError):
        return False
    system = {"x": x, "p": p, "g": casadi.vertcat(*residuals)}
    finder = casadi.rootfinder("finder", "newton", system, {"error_on_fail": True})
    start = casadi.DM([block.state[n] for n in block.unknowns])
    ours, other = [], []
    for share in SHARES:
        number = block.state[given] * (1.0 + share)
        try:
            rows, found = plan.all(number), finder(start, number).full().ravel()
        except (solver.Unsolved, RuntimeError):
            continue
        scale = np.maximum(np.abs(found), 1e-9 * np.abs(found).max())
        if any((np.abs(np.array(row, dtype=float) - found) <= SAME * scale).all() for row in rows):
            ends = time.process_time() + 1.0
            plan(number)
            ours.append(clocked(functools.partial(plan, number), ends) * 1e6)
            other.append(clocked(functools.partial(finder, start, number), ends) * 1e6)
    if not ours:
        return False
    block.ours, block.other = float(np.median(ours)), float(np.median(other))
    return True


def section(found: list[Block], left: int) -> Section:
    shares = (0.5, 0.9, 0.97, 1.0)
    table = [
        (name, *(figures(float(np.quantile(times, share))) for share in shares))
        for name, times in (
            ("a prepared call, µs", [b.ours for b in found]),
            ("casadi's rootfinder, µs", [b.other for b in found]),
            ("ratio", [b.ratio for b in found]),
        )
    ]
    ratios = np.array([b.ratio for b in found])
    remark = (
        f"{left} more blocks, where casadi's Newton ends elsewhere or nowhere, or a rule has no "
        "formula in "
        "casadi, are left out."
    )
    claims = [
        Claim("blocks within 1 × casadi", 100, 100 * float((ratios <= 1.0).mean()), "%", more=True)
    ]
    head = (f"{len(found)} blocks of one tear", "median", "90 %", "97 %", "worst")
    return Section("one tear", "Blocks of one tear", head, table, [remark], claims)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--model", choices=NAMES, action="append", help="several can be named")
    parser.add_argument("--each", action="store_true")
    parser.add_argument("--write", action="store_true", help="put the table into docs/speed.md")
    options = parser.parse_args()
    found: list[Block] = []
    left = 0
    for name in options.model or NAMES:
        for block in blocks(name):
            if not measure(block):
                left += 1
                continue
            found.append(block)
            if options.each or block.ratio > 1.0:
                said = f"{block.ours:9.2f} {block.other:9.2f} {block.ratio:8.2f}"
                print(f"{name:<28}{said}  {', '.join(block.unknowns)}", flush=True)
    table = section(found, left)
    print(f"\n## {table.title}\n\n{table.markdown()}")
    if options.write and not place(ROOT / "docs" / "speed.md", "speed: one tear", table.markdown()):
        sys.exit("docs/speed.md has no place for this table")


if __name__ == "__main__":
    main()
