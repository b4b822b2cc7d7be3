"""The record of a solve: for each answer the steps that led to it, as one straight-line program with guards.

A direct step is recorded by the inverse that was taken, a block by its closed form or else by Newton's
method from the answer. The conditions that were decided or assumed, the ends of domains and every rule
guard the results: where one of them fails, the record is left and the next one, or a full solve, has
the word. Where the condition of a block is bad, no record calls it solved.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

from rulesheets.model import Model, Value, Variable
from solver.compiled.flow import NotCompilable
from solver.compiled.program import Program
from solver.compiled.translate import Translation
from solver.compiled.way import Pattern, Way
from solver.kernel.code.block import kernel_of
from solver.path.activity import activity
from solver.path.cases import EQUAL, value_of_equality
from solver.path.planner import Planner
from solver.path.steps import Evaluate, Select, SolveBlock, Step
from solver.ranking.ranking import Ranking
from solver.solution.leaves import Leaf
from solver.trace.newton import BlockNewton
from solver.trace.numbers import Numbers
from solver.trace.order import order

MATCHES = 1e-6
"""How near a number of the record must come to the answer that it was made from, relative to it."""
CONDITION = 1e6
"""The largest error of an unknown of a block that a record answers for, in units of the last place."""
APART = 1e-6
"""The least relative distance of two answers of a block."""
REMOTE = 1e60
"""No record iterates on larger numbers, or on smaller ones than 1 over it: products of them overflow."""


def record(
    model: Model,
    planner: Planner,
    pattern: Pattern,
    leaves: Sequence[Leaf],
    plain: bool = False,
    ranking: Ranking | None = None,
) -> Program:
    """The program of the answers ``leaves``, in their order: where the ``ranking`` says the same.

    Raises NotCompilable where a step has no record.
    """
    if model.requirements:
        raise NotCompilable  # an answer that one of them excluded at the sample may be one elsewhere
    return Recording(model, planner, pattern, leaves, plain).run(ranking)


class Recording(Translation):
    """Follows the steps of each answer as they were taken."""

    def __init__(
        self, model: Model, planner: Planner, pattern: Pattern, leaves: Sequence[Leaf], plain: bool
    ) -> None:
        super().__init__(model, planner, pattern, leaves[0].branch.values, plain)
        self.leaves, self.branch = leaves, leaves[0].branch
        self._blocks: dict[tuple[object, ...], tuple[BlockNewton, list[int]]] = {}
        self._numbers = Numbers(self.flow, {})
        self._ways: list[Way] = []

    def run(self, ranking: Ranking | None = None) -> Program:
        start, symbols = self._start()
        for place, leaf in enumerate(self.leaves):
            way = start.fork()
            self.branch, self.sample = leaf.branch, leaf.branch.values
            if self.branch.void or self.branch.facts:
                raise NotCompilable
            self._numbers = Numbers(self.flow, self._inputs())
            if len(self.leaves) > 1:
                way.order.append(self.flow.constant(float(place)))
            self._record(way)
        if ranking is not None and len(self.leaves) > 1:
            self._rank(ranking)
        ordered = ranking is not None or len(self.leaves) == 1
        return Program(self.flow, len(self.pattern.inputs), tuple(self.endings), symbols, ordered)

    def _rank(self, ranking: Ranking) -> None:
        """Sort the answers by the rule."""
        answers = [[way.values.get(name) for name in ranking.read] for way in self._ways]
        given = [self._ways[0].values.get(name) for name in ranking.known]
        numbers = Numbers(self.flow, self._inputs())
        for newton, items in self._blocks.values():
            numbers.found.update(zip(items, newton.start, strict=True))
        keys, guards = order(self.flow, ranking, answers, given, lambda node: float(numbers(node)))
        first, *others = (replace(e, order=key) for e, key in zip(self.endings, keys, strict=True))
        holds = dict.fromkeys((*first.holds, *(node for node in guards if node != self.flow.true)))
        self.endings = [replace(first, holds=tuple(holds)), *others]

    def _record(self, way: Way) -> None:
        way.decided = dict(self.branch.conditions)
        for pair, sign in self.branch.signs.items():
            if sign == EQUAL and (said := value_of_equality(pair)) is not None:
                self._say(way, *said)
        for step in self.branch.steps:
            way = self._recorded(way, step)
        self.flow.checks, self.flow.finite = way.checks, way.finite
        for index, outcome in self.branch.conditions.items():
            node = self._condition(way, self.model.conditions[index], outcome)
            if node is not None:
                self.flow.require(node if outcome else self.flow.add("not", node))
        self._settle(way)
        self._ways.append(way)
        self.endings.append(self._finished(way))

    def _settle(self, way: Way) -> None:
        """Angles in the turn in which the answer has them."""
        for name, node in way.values.items():
            wanted, turn = self.sample[name], self.graph.turn(name)
            if turn is None or name in self.given or isinstance(wanted, str):
                continue
            if abs(float(self._numbers(node)) - wanted) > turn / 2:
                way.values[name] = self._wrapped(node, turn)

    def _turned(self, way: Way, name: str, variable: Variable) -> None:
        """A case may say that an angle lies outside of the turn around 0."""
        node = way.values.get(name)
        if node is not None and self.flow.value_of(node) is None:
            super()._turned(way, name, variable)

    def _say(self, way: Way, name: str, value: Value) -> None:
        if isinstance(value, str):
            way.symbols.setdefault(name, value)
        else:
            way.values.setdefault(name, self.flow.constant(value))

    def _recorded(self, way: Way, step: Step) -> Way:
        match step:
            case Evaluate(equation=equation, unknown=unknown):
                return self._direct(way, equation, unknown)
            case Select(equations=equations, unknown=unknown):
                active = (e for e in equations if activity(self.model.equations[e], self.branch.conditions))
                return self._direct(way, next(active), unknown)
            case SolveBlock():
                return self._solved(way, step)
            case _:
                return way

    def _direct(self, way: Way, equation: int, unknown: str) -> Way:
        """By the inverse that was taken; by Newton's method where it has no form of its own."""
        try:
            fork = self._on(way.fork())
            return self._taken_of(list(self._evaluated(fork, equation, unknown)), (unknown,))
        except NotCompilable:
            return self._iterated_from(way, SolveBlock((equation,), (unknown,), (unknown,)))

    def _solved(self, way: Way, step: SolveBlock) -> Way:
        try:
            fork = self._on(way.fork())
            return self._taken_of(list(self._block(fork, step)), step.unknowns)
        except NotCompilable:
            return self._iterated_from(way, step)

    def _on(self, way: Way) -> Way:
        self.flow.checks, self.flow.finite = way.checks, way.finite
        return way

    def _iterated(self, way: Way, step: SolveBlock) -> Iterator[Way]:
        """No search for all roots: the record holds those that were found."""
        raise NotCompilable

    def _prefer(self, way: Way, step: SolveBlock) -> None:
        """Answers stand in the order in which they were solved."""

    def _result(self, way: Way, name: str) -> int | str:
        """What only the order of answers reads may have no value in one of them. Answers that are told apart
        by that alone have the same wanted values, to the last bit."""
        flow, wanted = self.flow, self.pattern.pruned or self.pattern.want
        if not (name in way.symbols or name in way.values or name in wanted):
            return flow.constant(math.nan)
        found = super()._result(way, name)
        twin = self._twin(wanted) if name in wanted else None
        if twin is None or isinstance(found, str):
            return found
        other = self.endings[twin].results[self.pattern.want.index(name)]
        if isinstance(other, str):
            raise NotCompilable
        limit = flow.add("mul", flow.constant(MATCHES), flow.add("abs", other))
        flow.require(flow.add("le", flow.add("abs", flow.add("sub", found, other)), limit))
        return other

    def _twin(self, wanted: Sequence[str]) -> int | None:
        """The number of an answer before this one that has the same wanted values."""
        mine = [self.sample.get(name) for name in wanted]
        before = self.leaves[: len(self.endings)]
        same = (k for k, leaf in enumerate(before) if [leaf.branch.values.get(n) for n in wanted] == mine)
        return next(same, None)

    # --- which of several values ---

    def _taken_of(self, ways: Sequence[Way], unknowns: Sequence[str]) -> Way:
        """The way on which the unknowns have the values of the answer."""
        numbers = self._numbers
        for way in ways:
            if all(self._is_sampled(way, name, numbers) for name in unknowns):
                del way.order[1 if len(self.leaves) > 1 else 0 :]
                return way
        raise NotCompilable

    def _inputs(self) -> dict[int, float]:
        values = (self.sample[name] for name in self.pattern.inputs)
        return {place: value for place, value in enumerate(values) if isinstance(value, float)}

    def _is_sampled(self, way: Way, name: str, numbers: Numbers) -> bool:
        wanted = self.sample[name]
        if isinstance(wanted, str) or name in way.symbols:
            return way.symbols.get(name) == wanted
        apart = abs(float(numbers(way.values[name])) - wanted)
        turn = self.graph.turn(name)
        if turn is not None:
            apart = min(apart, abs(apart - turn))
        return apart <= MATCHES * max(abs(wanted), 1e-3 if turn is not None else 0.0)

    # --- blocks without a form ---

    def _iterated_from(self, way: Way, step: SolveBlock) -> Way:
        """Newton's method from the answer of the record."""
        self._on(way)
        kernel = kernel_of(self.graph, step)
        known = self._floats(kernel.known)
        start = self._floats(step.unknowns)
        places = [way.values.get(name, -1) for name in kernel.known]
        if -1 in places:
            raise NotCompilable
        key = (step.equations, step.unknowns, tuple(start), *places)
        if key not in self._blocks:
            self._blocks[key] = self._newton(BlockNewton(kernel, start, known), places)
        newton, items = self._blocks[key]
        self._numbers.found.update(zip(items, newton.start, strict=True))
        self._distinct(key, places)
        for name, node in zip(step.unknowns, items, strict=True):
            way.values[name] = self._in_turn(name, node)
            self._within(way, self.model.variables[name], way.values[name])
        self._well_conditioned(way, newton)
        return way

    def _newton(self, newton: BlockNewton, places: list[int]) -> tuple[BlockNewton, list[int]]:
        flow = self.flow
        flow.finders.append(newton)
        root = flow.node("root", len(flow.finders) - 1, *places)
        items = [flow.node("item", place, root) for place in range(len(newton.start))]
        return newton, items

    def _floats(self, names: Sequence[str]) -> list[float]:
        values = [self.sample[name] for name in names]
        numbers = [value for value in values if isinstance(value, float)]
        usual = all(value == 0.0 or 1.0 / REMOTE <= abs(value) <= REMOTE for value in numbers)
        if not usual or len(numbers) < len(values):
            raise NotCompilable
        return numbers

    def _in_turn(self, name: str, node: int) -> int:
        """An angle without a range in the turn around 0."""
        variable, turn = self.model.variables[name], self.graph.turn(name)
        if turn is None or variable.low > -math.inf or variable.high < math.inf:
            return node
        return self._wrapped(node, turn)

    def _distinct(self, key: tuple[object, ...], places: list[int]) -> None:
        """Roots of one block at the same numbers must stay apart: no two branches may come to one root."""
        flow, (_, items) = self.flow, self._blocks[key]
        for other, (_, others) in self._blocks.items():
            if other is key or other[0] != key[0] or other[1] != key[1] or list(other[3:]) != places:
                continue
            if items == others:
                continue
            apart = flow.false
            for one, two in zip(items, others, strict=True):
                limit = flow.add("mul", flow.constant(APART), flow.add("abs", one))
                differ = flow.add("abs", flow.add("sub", one, two))
                apart = flow.add("or", apart, flow.add("lt", limit, differ))
            flow.require(apart)

    def _well_conditioned(self, way: Way, newton: BlockNewton) -> None:
        """Require that the rounding of the block's rules moves no unknown far: what an inverse of the slopes
        makes of errors of these sizes, with signs drawn once (Higham, Accuracy and Stability, ch. 15)."""
        flow, kernel = self.flow, newton.kernel
        entries = newton.matrix(flow, way.values)
        errors = []
        for place, equation in enumerate(kernel.equations):
            size, _ = self._sizes(way, equation)
            errors.append(flow.add("neg", size) if place * place % 3 == 1 else size)
        moved = newton.elimination(flow, entries).solve(errors)
        for name, node, scale in zip(kernel.unknowns, moved, newton.scale, strict=True):
            size = flow.add("add", flow.add("abs", way.values[name]), flow.constant(scale))
            limit = flow.add("mul", flow.constant(CONDITION), size)
            flow.require(flow.add("le", flow.add("abs", node), limit))
