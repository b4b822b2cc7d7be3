"""What an exploration has found so far, and where it may have left something out."""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Mapping, Sequence
from functools import cached_property, partial
from typing import TYPE_CHECKING

from rulesheets.model import Model, Value
from rulesheets.syntax.nodes import Number
from solver.accuracy.rule_check import check_rule
from solver.facts import Conflict, Fact, Gap, NoRoot, Truncated
from solver.kernel.budget import Budget
from solver.kernel.code.block import kernel_of
from solver.kernel.elimination.near_rank import Blur
from solver.kernel.outcome import BlockOutcome
from solver.kernel.solve_block import solve_block
from solver.kernel.steps.step import solve_step
from solver.path.cases import activity
from solver.path.graph import ModelGraph
from solver.path.steps import Evaluate, SolveBlock
from solver.solution.casework import indeterminacy, unmet
from solver.solution.leaves import Branch, Exploration, Leaf, Outcomes, blocked, excluded, infinite

if TYPE_CHECKING:
    from solver.solution.leaves import Twins


MAX_LEAVES = 1_000


class Findings:
    """The leaves of one exploration, and its gaps.

    ``judged`` are the names that a leaf must have; ``enough`` ends the search at the first such leaf.
    ``complete``: no step so far can have more answers than were followed. ``delicate``: somewhere rounding
    decides how many there are, or whether a rule holds.
    """

    def __init__(
        self, model: Model, judged: Sequence[str], enough: Callable[[Leaf], bool] | None = None
    ) -> None:
        self.model, self.judged = model, judged
        self.leaves: list[Leaf] = []
        self.dead: list[Leaf] = []
        self.adrift: list[Leaf] = []
        self.complete = True
        self.delicate = False
        self._gaps: dict[tuple[int, ...], Gap] = {}
        self._enough = enough

    @property
    def full(self) -> bool:
        """Whether nothing more is looked for."""
        if self._enough is not None and any(map(self._enough, self.leaves)):
            return True
        return len(self.leaves) + len(self.dead) + len(self.adrift) >= MAX_LEAVES

    def note(
        self,
        complete: bool,
        equations: tuple[int, ...],
        unknowns: tuple[str, ...],
        listed: Sequence[Mapping[str, Value]],
        cut: bool,
    ) -> None:
        """Remember where a step may have more answers than are listed, the first of each step."""
        self.complete = self.complete and complete
        if complete or equations in self._gaps:
            return
        first = [values[unknowns[0]] for values in listed if unknowns[0] in values]
        numbers = [number for number in first if not isinstance(number, str)]  # in floats, or of many digits
        low, high = (min(numbers), max(numbers)) if numbers else (0.0, 0.0)
        ends, listed_cut = (float(low), float(high)), cut and len(listed) > 1
        self._gaps[equations] = Gap(equations, unknowns, len(listed), *ends, listed_cut, uncounted=cut)

    def truncate(self, branch: Branch, what: str) -> None:
        """Remember that a branch was given up: there are too many ``what``."""
        self.complete = False
        self._gaps.setdefault((), Gap(count=len(self.leaves), cut=what == "answers"))
        branch.facts = (*branch.facts, Truncated(what))

    def loose_since(self, adrift: int) -> bool:
        """Whether the cases since so many were ``adrift`` leave a continuum that nothing contradicts.

        Answers of other cases do not make it a solved one; a case of equality is but its edge.
        """
        return any(not blocked(leaf) and not leaf.on_edge for leaf in self.adrift[adrift:])

    def add(self, branch: Branch, decided: Mapping[int, bool], loose: bool, unverified: bool) -> None:
        """The end of a branch: every rule that is active there is asked of the independent rule check.

        ``unverified``: an assumption was made on what is not known even now.
        """
        values = branch.values
        conflicts: list[Fact] = []
        worst, checked = 0.0, 0
        for equation in self.model.equations:
            if not activity(equation, decided) or not all(name in values for name in equation.names):
                continue
            check = check_rule(equation, values)
            checked += 1
            if check.holds:
                worst = max(worst, check.scaled)
            else:
                self.delicate = self.delicate or check.delicate
                undefined = indeterminacy(equation, values) if check.miss is None else None
                conflicts.append(undefined or Conflict((equation.index,), check.miss, values))
        conflicts += unmet(self.model, values, decided)
        lacking = (name for name in self.judged if name not in values)
        missing = tuple(name for name in lacking if not infinite(self.model, branch, name))
        leaf = Leaf(branch, missing, tuple(conflicts), worst, checked, loose)
        if conflicts:
            self.dead.append(leaf)
        else:
            (self.adrift if missing and unverified else self.leaves).append(leaf)

    def exploration(self, outcomes: Outcomes, work: int, refused: Callable[[Leaf], bool]) -> Exploration:
        """All of it, once every branch has ended. ``refused`` tells of a case that is adrift whether what it
        lacks is refused, so that no answer is hidden there."""
        return Exploration(
            tuple(self.leaves),
            self.complete and all(excluded(leaf) or refused(leaf) for leaf in self.adrift),
            tuple(self.dead),
            tuple(self.adrift),
            self.delicate,
            outcomes,
            work,
            tuple(self._gaps.values()),
        )


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
        from solver.solution.leaves import Twins

        return Twins(self.graph.model)


def agreed(
    graph: ModelGraph,
    equation: int,
    values: Mapping[str, Value],
    inputs: Collection[str],
    decided: Mapping[int, bool],
) -> tuple[str, float] | None:
    """A computed variable of an equation that does not hold, and a value with which it does, and so do all
    other rules that read it as far as their values are known. None where there is none.

    The nearest is taken: another may be another answer, and that is on a branch of its own.
    """
    for name in graph.model.equations[equation].names:
        isolation = graph.isolation(equation, graph.number[name])
        if name in inputs or isolation is None:
            continue
        others = {other: value for other, value in values.items() if other != name}
        numbers = [v for v in solve_step(graph, equation, isolation, others).values if isinstance(v, float)]
        for value in sorted(numbers, key=partial(_distance, values[name])):
            if _hold(graph, name, {**others, name: value}, decided):
                return name, value
    return None


def _distance(value: Value, other: float) -> float:
    return abs(other - value) if isinstance(value, float) else 0.0


def _hold(graph: ModelGraph, name: str, values: Mapping[str, Value], decided: Mapping[int, bool]) -> bool:
    readers = (graph.model.equations[index] for index in graph.users(name))
    return all(
        check_rule(equation, values).holds
        for equation in readers
        if activity(equation, decided) and all(other in values for other in equation.names)
    )
