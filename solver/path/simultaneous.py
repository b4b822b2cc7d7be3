"""What no direct step reaches: Dulmage–Mendelsohn parts, block triangular form and tearing, as steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from solver.path.graph import ModelGraph
from solver.path.steps import Evaluate, SolveBlock
from solver.structure.dulmage_mendelsohn import dulmage_mendelsohn
from solver.structure.frontier import Frontier
from solver.structure.incidence import Block, Incidence
from solver.structure.matching import maximum_matching
from solver.structure.tearing import tearings
from solver.structure.triangular import block_triangular

TEARINGS = 2
MAX_TORN = 100
"""Unknowns of a block up to which it is torn; all of a larger one are iterated on at once."""


def simultaneous_steps(
    graph: ModelGraph, frontier: Frontier, remaining: Sequence[int]
) -> tuple[Evaluate | SolveBlock, ...]:
    """The blocks of the ``remaining`` equations that determine their unknowns, in the order of solution.

    Of over-determined equations it is the first block of a square part alone; the others will check it.
    """
    part = _Remaining(graph, frontier, remaining)
    return tuple(map(part.step, part.blocks()))


class _Remaining:
    """Equations that have no direct step, with the unknowns that are left in them."""

    def __init__(self, graph: ModelGraph, frontier: Frontier, remaining: Sequence[int]) -> None:
        self.graph, self.equations = graph, remaining
        numbers: dict[int, int] = {}
        occurs: list[tuple[int, ...]] = []
        for equation in remaining:
            row = [numbers.setdefault(variable, len(numbers)) for variable in frontier.unknowns(equation)]
            occurs.append(tuple(sorted(row)))
        self.incidence = Incidence(tuple(occurs), ({},) * len(occurs), len(numbers))
        self.unknowns = list(numbers)

    def blocks(self) -> tuple[Block, ...]:
        matching = maximum_matching(self.incidence)
        parts = dulmage_mendelsohn(self.incidence, matching)
        if parts.over.unknowns:
            return self._first_of(parts.over)
        return block_triangular(self.incidence, parts.square, matching)

    def _first_of(self, over: Block) -> tuple[Block, ...]:
        """The first block of a matched square part of the over-determined equations."""
        matching = maximum_matching(self.incidence.restrict(over))
        matched = Block(tuple(e for e in over.equations if matching.unknown_of[e] is not None), over.unknowns)
        return block_triangular(self.incidence, matched)[:1]

    def step(self, block: Block) -> Evaluate | SolveBlock:
        """The step that solves a block; of those with one tear, with another way to tear it."""
        equations, unknowns = (
            tuple(self.equations[e] for e in block.equations),
            tuple(map(self._name, block.unknowns)),
        )
        if len(unknowns) > MAX_TORN:
            return SolveBlock(equations, unknowns, ())
        incidence = self._resolvable(block)
        if len(unknowns) == 1 and incidence.resolvable[block.equations[0]]:
            return self._evaluate(block.equations[0], block.unknowns[0])
        weights = {unknown: self._weight(unknown) for unknown in block.unknowns}
        first, *others = (
            SolveBlock(
                equations,
                unknowns,
                tuple(map(self._name, tearing.tears)),
                tuple(self._evaluate(e, u) for e, u in tearing.order),
                tuple(self.equations[e] for e in tearing.residuals),
            )
            for tearing in tearings(incidence, weights, limit=TEARINGS)
        )
        return replace(first, others=tuple(others)) if len(first.tears) == 1 else first

    def _resolvable(self, block: Block) -> Incidence:
        """The part that is a block, with what each of its equations can be solved for."""
        part, resolvable = self.incidence.restrict(block), {}
        for equation in block.equations:
            costs = (
                (unknown, self.graph.cost(self.equations[equation], self.unknowns[unknown]))
                for unknown in part.occurs[equation]
            )
            resolvable[equation] = {unknown: cost for unknown, cost in costs if cost is not None}
        return replace(part, resolvable=resolvable)

    def _evaluate(self, equation: int, unknown: int) -> Evaluate:
        isolation = self.graph.isolation(self.equations[equation], self.unknowns[unknown])
        assert isolation is not None
        return Evaluate(self.equations[equation], self._name(unknown), isolation.branches)

    def _name(self, unknown: int) -> str:
        return self.graph.names[self.unknowns[unknown]]

    def _weight(self, unknown: int) -> int:
        """Angles and variables with a finite range are the better ones to search over."""
        name = self._name(unknown)
        variable = self.graph.model.variables[name]
        finite = variable.low > float("-inf") and variable.high < float("inf")
        return 0 if finite or self.graph.turn(name) else 1
