"""Given numbers that the rules fix otherwise, whatever the unknowns are.

A ratio of speeds does not depend on the speed that is free. A search for the speed at which it comes out as
given finds nothing, or creeps towards 0; but the rules give the ratio one value at any speed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from rulesheets.functions import named
from rulesheets.model import Equation, Model, Value
from rulesheets.syntax.nodes import Call, Name
from rulesheets.syntax.program import walk
from solver.facts import Fact, Fixed, NoRoot, NoValue
from solver.result import Status
from solver.solution.explore import explore
from solver.verdicts.remedy import Patience
from solver.verdicts.verdict import Verdict

TRIALS = (1.3247180, 7.3890561, 0.0207880, 1.1e-4)
"""Shares of its size at which an unknown is tried."""
MOST = 4
"""Unknowns, and given numbers, that are looked at."""
_FLAT = named(lambda row: not row.smooth)
"""Functions that are constant, or without a part of their arguments, over a range of them."""
SAME = 1e-9
"""Relative difference of values that do not depend on the trial; a given one must agree with them."""


def fixed_otherwise(model: Model, verdict: Verdict, inputs: Mapping[str, Value]) -> Verdict | None:
    """The verdict that a given number contradicts the rules at any value of an unknown; None if none does."""
    patience = Patience()
    for equations, unknowns in filter(None, map(_refused, verdict.facts)):
        if any(_has_pieces(model.equations[e]) for e in equations):
            continue
        for found in _fixed(model, equations, unknowns, inputs, patience):
            return replace(verdict, status=Status.INCONSISTENT, facts=(found,))
    return None


def _refused(fact: Fact) -> tuple[tuple[int, ...], tuple[str, ...]] | None:
    """The rules of which it is said that nothing satisfies them, with their unknowns."""
    match fact:
        case NoRoot(equations=equations, unknowns=unknowns):
            return equations, unknowns
        case NoValue(equation=equation, unknown=unknown, reading=reading, pole=pole):
            return ((equation,), (unknown,)) if pole or reading.startswith("product") else None
        case _:
            return None


def _has_pieces(equation: Equation) -> bool:
    """Whether what an equation says may differ from one range of its variables to the next."""
    parts = (part for side in (equation.left, equation.right) for part in walk(side))
    return bool(equation.guard) or any(isinstance(p, Call) and p.function in _FLAT for p in parts)


def _fixed(
    model: Model,
    equations: Sequence[int],
    unknowns: Sequence[str],
    inputs: Mapping[str, Value],
    patience: Patience,
) -> Iterator[Fixed]:
    rules = [model.equations[e] for e in equations]
    read = [name for rule in rules for name in rule.names]
    alone = {side.name for rule in rules for side in (rule.left, rule.right) if isinstance(side, Name)}
    own = {name: variable.value for name, variable in model.variables.items()}
    given = [name for name in inputs if name in read and isinstance(inputs[name], float)]
    given.sort(key=lambda name: (own[name] == inputs[name], name not in alone, read.count(name)))
    free = sorted((n for n in unknowns if n in read), key=lambda name: (own[name] is None, name in alone))
    for unknown in free[:MOST]:
        for name in given[:MOST]:
            value, number = _whatever(model, name, unknown, inputs, patience), inputs[name]
            if value is None or not isinstance(number, float):
                continue
            if abs(value - number) > SAME * max(abs(value), abs(number)):
                yield Fixed(name, value, number, unknown, tuple(equations))


def _whatever(
    model: Model,
    name: str,
    unknown: str,
    inputs: Mapping[str, Value],
    patience: Patience,
) -> float | None:
    """The one value that the rules give to a variable at any trial of an unknown; None if there is none."""
    rest = {n: v for n, v in inputs.items() if n != name}
    sizes = [abs(v) for v in rest.values() if isinstance(v, float) and v]
    size = math.exp(sum(map(math.log, sizes)) / len(sizes)) if sizes else 1.0
    found: set[float] = set()
    for share in TRIALS:
        trial = {**rest, unknown: share * size}
        if patience.lost or not model.variables[unknown].admits(share * size):
            return None
        tried = patience.shown(explore(model, trial, None, {}, (name,), brief=True))
        leaves = [leaf for leaf in tried.leaves if leaf.solved]
        if len(leaves) != 1 or not tried.complete:
            return None
        value = leaves[0].branch.values[name]
        if not isinstance(value, float):
            return None
        found.add(value)
    low, high = min(found), max(found)
    return low if high - low <= SAME * max(abs(low), abs(high)) else None
