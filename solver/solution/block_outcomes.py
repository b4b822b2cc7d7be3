"""What the blocks of one exploration come to: cases that meet a block again at the same values share it."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING

from rulesheets.model import Value
from rulesheets.syntax.nodes import Number
from solver.facts import NoRoot
from solver.kernel.budget import Budget
from solver.kernel.code.block import kernel_of
from solver.kernel.elimination.near_rank import Blur
from solver.kernel.outcome import BlockOutcome
from solver.kernel.solve_block import solve_block
from solver.path.graph import ModelGraph
from solver.path.steps import Evaluate, SolveBlock
from solver.solution.leaves import Branch, Outcomes

if TYPE_CHECKING:
    from solver.solution.twins import Twins

MAX_SEARCHES = 150
"""Searches of nonlinear blocks at other values, after the first search of each block."""


class BlockOutcomes:
    """Searches each block at most once for the same known numbers, under whatever rules they meet it."""

    def __init__(
        self, graph: ModelGraph, guesses: Mapping[str, float], budget: Budget, outcomes: Outcomes
    ) -> None:
        self.graph, self.guesses, self.budget, self.outcomes = graph, guesses, budget, outcomes
        self._senses: dict[Hashable, tuple[SolveBlock, tuple[Value, ...]]] = {}
        self._searched: set[SolveBlock] = set()

    def outcome(self, step: SolveBlock, branch: Branch, proving: bool, off: Blur) -> BlockOutcome:
        """The outcome of a block at the values of a branch.

        ``proving``: a proof that it has no other answers would still serve; ``off`` tells how far the known
        numbers may be from what they stand for.
        """
        kernel, values, assumed = kernel_of(self.graph, step), branch.values, bool(branch.signs)
        numbers = tuple(values[name] for name in kernel.known)
        key = step, numbers
        if key not in self.outcomes and (told := self._told(step, kernel.known, numbers)) is not None:
            self.outcomes[key] = told
        if key not in self.outcomes:
            again = len(self.outcomes) - len(self._searched)
            if step in self._searched and again >= MAX_SEARCHES and not kernel.linear:
                return BlockOutcome(facts=(NoRoot(step.equations, step.unknowns, proven=False),))
            shared = assumed or step in self._searched
            self._searched.add(step)
            self.budget.begin_block(proving, shared)
            given = [name for name in kernel.known if self._is_given(branch, name)]
            self.outcomes[key] = solve_block(kernel, values, self.guesses, self.budget, assumed, off, given)
            if assumed:
                self._senses.setdefault(self._sense(step, kernel.known, numbers), key)
        return self.outcomes[key]

    def _is_given(self, branch: Branch, name: str) -> bool:
        """Whether a value is exact: an input, or a number that a rule says."""
        step = branch.origins.get(name)
        if not isinstance(step, Evaluate):
            return step is None
        isolation = self.graph.isolation(step.equation, self.graph.number[name])
        return isolation is not None and isolation.identity and isinstance(isolation.start, Number)

    def _told(
        self, step: SolveBlock, known: tuple[str, ...], numbers: tuple[Value, ...]
    ) -> BlockOutcome | None:
        """What a block came to that says the same by other rules, in another case."""
        met = self._senses.get(self._sense(step, known, numbers)) if self._senses else None
        return None if met is None else self._twins.told(self.outcomes[met], met[0], step)

    def _sense(self, step: SolveBlock, known: tuple[str, ...], numbers: tuple[Value, ...]) -> Hashable:
        return self._twins.sense(step), frozenset(zip(known, numbers, strict=True))

    @cached_property
    def _twins(self) -> Twins:
        from solver.solution.twins import Twins

        return Twins(self.graph.model)
