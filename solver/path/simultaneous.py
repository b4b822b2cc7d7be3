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
        resolvable: list[dict[int, int]] = []
        for equation in remaining:
            variables = tuple(frontier.unknowns(equation))
            row = [numbers.setdefault(variable, len(numbers)) for variable in variables]
            costs = (graph.cost(equation, variable) for variable in variables)
            occurs.append(tuple(sorted(row)))
            resolvable.append({n: cost for n, cost in zip(row, costs, strict=True) if cost is not None})
        self.incidence = Incidence(tuple(occurs), tuple(resolvable), len(numbers))
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
        if len(block.equations) == 1 and block.unknowns[0] in self.incidence.resolvable[block.equations[0]]:
            return self._evaluate(block.equations[0], block.unknowns[0])
        weights = {unknown: self._weight(unknown) for unknown in block.unknowns}
        first, *others = (
            SolveBlock(
                tuple(self.equations[e] for e in block.equations),
                tuple(map(self._name, block.unknowns)),
                tuple(map(self._name, tearing.tears)),
                tuple(self._evaluate(e, u) for e, u in tearing.order),
                tuple(self.equations[e] for e in tearing.residuals),
            )
            for tearing in tearings(self.incidence.restrict(block), weights, limit=TEARINGS)
        )
        return replace(first, others=tuple(others)) if len(first.tears) == 1 else first

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
