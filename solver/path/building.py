"""Building a path: the order of the steps, and no more steps than are needed."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from heapq import heappop, heappush
from itertools import combinations_with_replacement
from random import Random

import numpy as np

from rulesheets.deadline import expect_time
from rulesheets.evaluate import Undefined, derivatives, value
from rulesheets.model import Equation
from rulesheets.syntax.nodes import Call, Number, degree, walk
from solver.numerics.elimination import independent_rows
from solver.numerics.linear_algebra import Array
from solver.numerics.tolerances import ON_RULES, REPEATED
from solver.path import (
    Assume,
    Check,
    Decide,
    Evaluate,
    Isolation,
    Path,
    Select,
    SolveBlock,
    Step,
    activity,
    equations_of,
    given_by,
)
from solver.path.cases import value_said
from solver.path.graph import ModelGraph
from solver.structure.decomposition import (
    Block,
    Frontier,
    Incidence,
    block_triangular,
    dulmage_mendelsohn,
    maximum_matching,
)
from solver.structure.tearing import EFFORT, Tearing, tearings

TEARINGS, LINEAR_EFFORT = 2, 200
"""How many are kept of one block; and the effort that one is worth which is linear, and hardly ever
torn."""
MAX_TORN = 100
"""Unknowns of a block up to which it is torn; in a larger one all are iterated on at once."""


def _evaluate(graph: ModelGraph, equation: int, unknown: int) -> Evaluate:
    effort = graph.effort(equation, unknown)
    assert effort is not None
    return Evaluate(equation, graph.names[unknown], effort.branches)


def _blocks(
    part: Incidence,
    bends: Callable[[int], bool],
    independent: Callable[[Block], Sequence[int] | None],
) -> tuple[Block, ...]:
    """The blocks that determine their unknowns, in the order of solution.

    For over-determined equations it is only the first block of a square part: of the linear ones,
    of which none ``bends``, if these determine some unknowns, else of as few ``independent`` ones
    as may be, if the first are not independent. The other equations will check it.
    """
    matching = maximum_matching(part)
    parts = dulmage_mendelsohn(part, matching)
    over = parts.over
    if not over.unknowns:
        return block_triangular(part, parts.square, matching)
    linear = Block(tuple(e for e in over.equations if not bends(e)), over.unknowns)
    if linear != over and (blocks := _blocks(part.restrict(linear), bends, independent)):
        return blocks[:1]
    matching = maximum_matching(part.restrict(over))
    first = Block.of(
        (e for e in over.equations if matching.unknown_of[e] is not None), over.unknowns
    )
    if independent(first) or not independent(over):
        return block_triangular(part, first)[:1]
    # the smallest of the parts that two rules span
    pairs = combinations_with_replacement(over.equations, 2)
    spans = {tuple(sorted({*part.occurs[a], *part.occurs[b]})) for a, b in pairs}
    for span in sorted(spans, key=lambda span: (len(span), span)):
        inside = Block(tuple(e for e in over.equations if set(part.occurs[e]) <= set(span)), span)
        if chosen := independent(inside):
            return block_triangular(part, Block.of(chosen, span))[:1]
    return block_triangular(part, Block.of(independent(over) or (), over.unknowns))[:1]


def _block_step(
    graph: ModelGraph, part: Incidence, rules: Mapping[int, int], variables: Mapping[int, int]
) -> Evaluate | SolveBlock:
    """The step that solves a block; with one tear also another tearing.

    ``rules`` and ``variables`` map the equations and the variables of the ``part`` to those of the
    model.
    """
    names = {unknown: graph.names[variable] for unknown, variable in variables.items()}
    equations, unknowns = tuple(rules.values()), tuple(names.values())
    if len(unknowns) > MAX_TORN:
        return SolveBlock(equations, unknowns, ())
    resolvable = {}  # what an equation can be solved for, and at which cost
    for place, equation in rules.items():
        efforts = ((u, graph.effort(equation, variables[u])) for u in part.occurs[place])
        resolvable[place] = {u: effort.cost for u, effort in efforts if effort is not None}
    if len(unknowns) == 1 and all(resolvable.values()):
        return _evaluate(graph, equations[0], *variables.values())
    weights = {}  # angles and variables with a finite range are the better ones to search over
    for unknown, name in names.items():
        variable = graph.model.variables[name]
        finite = variable.low > float("-inf") and variable.high < float("inf")
        weights[unknown] = 0 if finite or graph.turn(name) else 1
    asked, every = frozenset(unknowns), (graph.model.equations[e] for e in equations)
    linear = all(degree(rule.form, asked) <= 1.0 for rule in every)
    first, *others = (
        SolveBlock(
            equations,
            unknowns,
            tuple(names[u] for u in tearing.tears),
            tuple(_evaluate(graph, rules[e], variables[u]) for e, u in tearing.order),
            tuple(rules[e] for e in tearing.residuals),
        )
        for tearing in _tearings(graph, replace(part, resolvable=resolvable), weights, linear)
    )
    return first._replace(others=tuple(others)) if len(first.tears) == 1 else first


def _tearings(
    graph: ModelGraph, part: Incidence, weights: Mapping[int, int], linear: bool
) -> Iterator[Tearing]:
    """The tearings of a block, computed once for blocks that differ only in numbering."""
    equations, unknowns = part.block
    place = {unknown: k for k, unknown in enumerate(unknowns)}
    rows = tuple([tuple([place[u] for u in part.occurs[e]]) for e in equations])
    costs = tuple(
        [tuple([(place[u], c) for u, c in part.resolvable[e].items()]) for e in equations]
    )
    key = rows, costs, tuple([weights[u] for u in unknowns]), linear
    if key not in graph.torn:
        effort = LINEAR_EFFORT if linear else EFFORT
        alone = Incidence(rows, tuple(map(dict, costs)), len(unknowns))
        graph.torn[key] = tearings(alone, dict(enumerate(key[2])), TEARINGS, effort)
    for tears, order, residuals in graph.torn[key]:
        yield Tearing(
            tuple([unknowns[u] for u in tears]),
            tuple([(equations[e], unknowns[u]) for e, u in order]),
            tuple([equations[e] for e in residuals]),
        )


def needed_steps(
    graph: ModelGraph, steps: Sequence[Step], want: Iterable[str], undetermined: Collection[str]
) -> list[Step]:
    """The steps that the wanted variables need; no decision, if these are all reached."""
    needed = set(want)
    reached = needed.isdisjoint(undetermined)
    kept: list[Step] = []
    for step in reversed(steps):
        wanted = (
            not reached
            if isinstance(step, Decide | Assume)
            else needed.intersection(given_by(step))
        )
        if wanted:
            needed.update(read_by(graph, step))
            kept.append(step)
    return kept[::-1]


def read_by(graph: ModelGraph, step: Step) -> Iterator[str]:
    """The variables of a step's equations and of the conditions that it evaluates or depends on."""
    conditions = step.conditions if isinstance(step, Decide | Assume) else ()
    for equation in (graph.model.equations[index] for index in equations_of(step)):
        yield from equation.names
        conditions = (*conditions, *(premise.condition for premise in equation.guard))
    for condition in conditions:
        yield from (graph.names[v] for v in graph.condition_occurs[condition])


ANY_COST = 1 << 30


class Building:
    """One run of the planner."""

    def __init__(
        self,
        graph: ModelGraph,
        known: Collection[str],
        decided: Mapping[int, bool],
        inactive: frozenset[int],
        want: frozenset[str] | None,
        required: bool,
    ) -> None:
        self.graph = graph
        self.want, self.required = want, required
        self.steps: list[Step] = []
        equations = graph.model.equations
        verdicts = [False if e.index in inactive else activity(e, decided) for e in equations]
        self.active = [verdict is True for verdict in verdicts]
        self.pending = [
            e.index for e, verdict in zip(equations, verdicts, strict=True) if verdict is None
        ]
        self.guards = {
            i: tuple(p.condition for p in equations[i].guard if p.condition not in decided)
            for i in self.pending
        }
        self.parked: list[tuple[int, int, Isolation]] = []
        self.forking: list[tuple[int, int, int]] = []
        self.frontier = Frontier((*graph.occurs, *graph.condition_occurs), len(graph.names))
        for name in known:
            self.frontier.set_known(graph.number[name])
        self.frontier.activate(i for i, active in enumerate(self.active) if active)
        self.frontier.activate(self.pending)
        waiting = dict.fromkeys(c for guard in self.guards.values() for c in guard)
        self.frontier.activate(len(graph.occurs) + condition for condition in waiting)

    def run(self) -> Path:
        while (  # the cheapest way forward first
            self._direct()
            or self._select(cost=1)
            or self._fork()
            or self._select(cost=ANY_COST)
            or (not self._decide() and self._solve_blocks())
        ):
            expect_time()
        if not (self.steps and isinstance(self.steps[-1], Decide)):
            self._assume()
        graph, steps, want = self.graph, self.steps, self.want
        free = tuple(
            n for n, known in zip(graph.names, self.frontier.known, strict=True) if not known
        )
        if want is None:
            return Path(tuple(steps), free)
        for requirement in graph.model.requirements if self.required else ():
            new = frozenset(requirement.names) - want
            if new and new.isdisjoint(free):  # if direct steps of one value lead to what it reads
                plain = needed_steps(graph, steps, want, free)
                more = [
                    step
                    for step in needed_steps(graph, steps, want | new, free)
                    if step not in plain
                ]
                if all(isinstance(step, Evaluate) and step.branches == 1 for step in more):
                    want |= new
        return Path(tuple(needed_steps(graph, steps, want, free)), free)

    def _take(self, *steps: Step) -> None:
        """Add steps: their unknowns are known; spent equations become checks unless they use
        them."""
        used: set[int] = set()
        for step in steps:
            used.update(equations_of(step))
            for name in given_by(step):
                self.frontier.set_known(self.graph.number[name])
        spent = (
            e
            for e in self.frontier.spent
            if e < len(self.active) and self.active[e] and e not in used
        )
        self.steps += (*steps, *map(Check, spent))
        self.frontier.spent = []

    # --- direct steps ---

    def _direct(self) -> bool:
        """A round of ripe equations; those that fork, or wait for a condition, are postponed."""
        ripe, self.frontier.ripe = self.frontier.ripe, []
        best: dict[int, tuple[int, int]] = {}
        for equation in ripe:
            unknown = self.frontier.unknown_of(equation)
            if unknown is None or equation >= len(self.active):
                continue
            effort = self.graph.effort(equation, unknown)
            if effort is None:
                continue
            if not self.active[equation]:
                self.parked.append((equation, unknown, effort))
            elif effort.cost > 1:
                heappush(self.forking, (effort.cost, equation, unknown))
            else:
                best[unknown] = min(best.get(unknown, (ANY_COST, 0)), (effort.cost, equation))
        self._take(
            *(_evaluate(self.graph, equation, unknown) for unknown, (_, equation) in best.items())
        )
        return bool(best) or bool(self.frontier.ripe)

    def _fork(self) -> bool:
        """The ripe equation with the fewest preimages, once no cheaper step is left."""
        while self.forking:
            _, equation, unknown = heappop(self.forking)
            if self.frontier.missing[equation]:
                self._take(_evaluate(self.graph, equation, unknown))
                return True
        return False

    # --- guards ---

    def _select(self, cost: int) -> bool:
        groups: dict[int, list[tuple[int, Isolation]]] = {}
        self.parked = [one for one in self.parked if self.frontier.missing[one[0]]]
        for equation, unknown, effort in self.parked:
            if effort.cost <= cost and not self._awaited(equation):
                groups.setdefault(unknown, []).append((equation, effort))
        for unknown, members in groups.items():
            equations = tuple(sorted(equation for equation, _ in members))
            branches = max(effort.branches for _, effort in members)
            self._take(Select(equations, self.graph.names[unknown], branches))
        return bool(groups)

    def _awaited(self, equation: int) -> list[int]:
        """The conditions of a pending equation that cannot be evaluated yet."""
        first = len(self.graph.occurs)
        return [c for c in self.guards[equation] if self.frontier.missing[first + c]]

    def _decide(self) -> bool:
        """Evaluate conditions that can be evaluated and guard open equations."""
        waiting = [
            condition
            for equation in self.pending
            if self.frontier.missing[equation] and not self._awaited(equation)
            for condition in self.guards[equation]
        ]
        if waiting:
            self.steps.append(Decide(tuple(dict.fromkeys(waiting))))
        return bool(waiting)

    def _assume(self) -> None:
        """Case by case, if a guarded rule could still determine an unknown."""
        for equation in self.pending:
            useful = self._awaited(equation)
            if not self.frontier.missing[equation]:  # a condition may say what its unknown is
                useful = [c for c in useful if value_said(self.graph.model.conditions[c])]
            if useful:
                self.steps.append(Assume(useful[0]))
                return

    # --- simultaneous blocks ---

    def _solve_blocks(self) -> bool:
        remaining = [
            e for e in range(len(self.active)) if self.active[e] and self.frontier.missing[e]
        ]
        number: dict[int, int] = {}
        occurs = []
        for equation in remaining:
            left = (v for v in self.graph.occurs[equation] if not self.frontier.known[v])
            occurs.append(tuple(sorted(number.setdefault(v, len(number)) for v in left)))
        part, variables = Incidence(tuple(occurs), ({},) * len(occurs), len(number)), list(number)
        unknown = {self.graph.names[v] for v in variables}

        def bends(place: int) -> bool:
            rule = self.graph.model.equations[remaining[place]]
            return degree(rule.form, unknown) > 1.0

        def independent(block: Block) -> Sequence[int] | None:
            if len(block.equations) < len(block.unknowns):
                return None
            rules = [self.graph.model.equations[remaining[place]] for place in block.equations]
            rows = self._slopes(rules, [self.graph.names[variables[u]] for u in block.unknowns])
            ones = [1.0] * len(block.unknowns)  # slopes are by relative changes
            chosen = () if rows is None else independent_rows(rows, ones, REPEATED).rows
            if len(chosen) < len(block.unknowns):
                return None
            return [block.equations[place] for place in chosen]

        blocks = _blocks(part, bends, independent) if remaining else ()
        for block in blocks:
            rules = {place: remaining[place] for place in block.equations}
            mine = {unknown: variables[unknown] for unknown in block.unknowns}
            self._take(_block_step(self.graph, part.restrict(block), rules, mine))
        return bool(blocks)

    def _slopes(self, rules: Sequence[Equation], names: Sequence[str]) -> Array | None:
        """How rules depend on unknowns where all active rules hold, if such a point is found."""
        equations = self.graph.model.equations
        active = tuple(e for e, active in zip(equations, self.active, strict=True) if active)
        if len(active) > MAX_GENERIC:
            return None
        key = tuple(rule.index for rule in active)
        if key not in self.graph.generic:
            self.graph.generic[key] = _generic_point(self.graph, active)
        if (point := self.graph.generic[key]) is None:
            return None
        return _linearized(rules, names, point)[1]


# --- rules that repeat one another ---
#
# The sines and the cosines of a triangle are different functions of its sides and angles, and yet
# dependent where they hold. Which rules are independent is decided at a point on which all hold,
# whatever the inputs are.

MAX_GENERIC = 60
"""Rules of which a point is sought on which they hold."""
TRIES, ITERATIONS = 16, 60
LARGEST_STEP = 0.5
"""Relative change of a number in a step towards such a point."""
CLEAR = 1e-4
"""The least slope of a rule, in units of its largest, that leaves no doubt about its rank."""


def _generic_point(graph: ModelGraph, rules: Sequence[Equation]) -> dict[str, float] | None:
    """Numbers at which rules hold, by least-norm Gauss-Newton steps, mostly with the values that
    explicit rules give: the first at which every rule depends clearly on each of its names, else
    the one at which all do most."""
    names = list(dict.fromkeys(name for rule in rules for name in rule.names))
    constants = [rule for rule in rules if len(rule.names) == 1]
    found = dict[float, dict[str, float]]()
    for number, point in enumerate(_starts(graph, rules, names)):
        for _ in range(ITERATIONS):
            point = _told(rules if number % 2 else constants, point)
            try:
                misses, slopes = _linearized(rules, names, point)
            except (Undefined, OverflowError):
                break
            if not (np.isfinite(misses).all() and np.isfinite(slopes).all()):
                break
            if np.abs(misses).max() <= ON_RULES:
                found.setdefault(float(abs(slopes[slopes != 0.0]).min(initial=1.0)), point)
                break
            step = np.linalg.lstsq(slopes, -misses, rcond=ON_RULES)[0]
            step = step / max(1.0, np.abs(step).max() / LARGEST_STEP)
            shares = zip(point.items(), step.tolist(), strict=True)
            point = {name: number * (1.0 + share) for (name, number), share in shares}
        if max(found, default=0.0) > CLEAR:
            break
    return found[max(found)] if found else None


def _starts(
    graph: ModelGraph, rules: Sequence[Equation], names: Sequence[str]
) -> Iterator[dict[str, float]]:
    """Numbers near those of the sheet; the others ordinary, or as small or large as numbers in the
    rules."""
    turns = {name: graph.single_turn(name) or 10.0 for name in names}
    given = {name: graph.model.variables[name].value for name in names}
    parts = (part for rule in rules for part in walk(rule.form) if isinstance(part, Number))
    written = [math.log(abs(part.value)) for part in parts if part.value] or [0.0]
    for seed in range(TRIES):
        draw = Random(seed)
        start = {name: draw.uniform(0.6, 1.8) * turn / 10.0 for name, turn in turns.items()}
        if seed % 4 == 3:
            start = {n: math.exp(draw.uniform(min(written), max(written))) for n in names}
        own = ((n, v) for n, v in given.items() if isinstance(v, float) and v)
        yield start | {name: draw.uniform(0.9, 1.1) * v for name, v in own}


def _told(rules: Sequence[Equation], point: Mapping[str, float]) -> dict[str, float]:
    """The point with the values of names that rules give explicitly, whatever their size or sign;
    a function that is 0 here need not be so elsewhere."""
    found, told = dict(point), set[str]()
    for name, side in (pair for rule in rules for pair in rule.definitions):
        if name not in told:
            with suppress(Undefined, OverflowError):
                number = value(side, found)
                if number or not any(isinstance(part, Call) for part in walk(side)):
                    found[name] = number
                told.add(name)
    return found


def _linearized(
    rules: Sequence[Equation], names: Sequence[str], point: Mapping[str, float]
) -> tuple[Array, Array]:
    """The misses (m,) of rules and their slopes (m, n) by relative changes, in units of the largest
    slope of each."""
    misses, rows = [], []
    for rule in rules:
        miss, slopes = derivatives(rule.form, point)
        row = [slopes.get(name, 0.0) * point[name] for name in names]
        size = max(map(abs, (slopes[name] * point[name] for name in slopes)), default=0.0) or 1.0
        misses.append(miss / size)
        rows.append([entry / size for entry in row])
    return np.array(misses), np.array(rows)
