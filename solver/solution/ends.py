"""The ends of the branches of a search: each checked by the independent rule check, and what is
known about whether they are all."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial

from rulesheets.evaluate import Undefined, derivatives, holds
from rulesheets.evaluate.number import equal
from rulesheets.model import Equation, Value, Values
from rulesheets.syntax.nodes import Comparison, Condition, subtract
from solver.accuracy.rule_check import check_rule
from solver.accuracy.rule_sides import MANY, explained
from solver.facts import Conflict, Fact, Gap, Truncated
from solver.kernel.problem import Budget
from solver.kernel.step import StepSolver
from solver.leaves import (
    Asked,
    Branch,
    CaseAnalysis,
    Exploration,
    Leaf,
    Outcomes,
    blocked,
    branch_errors,
    hides_no_answer,
    indeterminacy,
    infinite,
    moved_into_one_turn,
    turns_matter,
    unmet,
)
from solver.numerics.tolerances import ROUGHLY, SAFETY
from solver.path import activity, equations_of, known_rules
from solver.path.cases import EQUAL, Pair
from solver.path.graph import ModelGraph
from solver.path.planner import planner

MAX_LEAVES, FEW_LEAVES, MAX_VALUES = 1_000, 20, 20_000
"""Answers that are listed; the least and the values in all where the model is large."""


class Ends:
    """The answers of a question so far, and the other ends of its branches.

    ``complete``: no step so far can have more answers than were followed, but for whole turns of
    angles (``turned``). ``delicate``: somewhere rounding decides how many there are, or whether a
    rule holds.
    """

    def __init__(self, asked: Asked, enough: Callable[[Leaf], bool] | None) -> None:
        self.model, self.inputs, self.judged = asked.model, dict(asked.inputs), asked.judged
        self.enough = enough
        listable = MAX_VALUES // max(len(asked.model.variables), 1)
        self.most_leaves = min(MAX_LEAVES, max(FEW_LEAVES, listable))
        self.planner = planner(asked.model)
        self.graph = self.planner.graph
        self.analysis = CaseAnalysis(asked.model, self.inputs, self._holds)
        self.budget = Budget()
        self.outcomes: Outcomes = {}
        self._begin()

    def _begin(self) -> None:
        """Reset the results."""
        self.leaves: list[Leaf] = []
        self.contradicted: list[Leaf] = []
        self.open_cases: list[Leaf] = []
        self.outside_case: list[Leaf] = []
        self.complete, self.delicate = True, False
        self.turned, self.cases = False, 0
        self.gaps: dict[tuple[int, ...], Gap] = {}

    def _found(self) -> Exploration:
        """The results, and whether they are known to be all."""
        complete = self.complete and all(
            hides_no_answer(self.model, leaf, self.inputs) for leaf in self.open_cases
        )
        if complete and self.turned:
            ended = not (self.leaves or self.open_cases)
            complete = ended and not turns_matter(self.model, self.contradicted)
        ends = tuple(self.leaves), complete, tuple(self.contradicted), tuple(self.open_cases)
        gaps, outside = tuple(self.gaps.values()), tuple(self.outside_case)
        return Exploration(*ends, self.delicate, self.outcomes, self.budget.used, gaps, outside)

    def _is_full(self, branch: Branch) -> bool:
        """Whether the search of a branch is to end."""
        ends = len(self.leaves) + len(self.contradicted) + len(self.open_cases)
        enough = self.enough is not None and any(map(self.enough, self.leaves))
        if full := enough or ends >= self.most_leaves:
            self._truncate(branch, "answers")
        return full

    def _truncate(self, branch: Branch, what: str) -> None:
        """Record that a branch was abandoned: there are too many ``what``."""
        self.complete = False
        self.gaps.setdefault((), Gap(count=len(self.leaves), cut=what == "answers"))
        branch.facts = (*branch.facts, Truncated(what))

    def note(
        self,
        complete: bool,
        equations: tuple[int, ...],
        unknowns: tuple[str, ...],
        listed: Sequence[Values],
        cut: bool,
        turns: bool = True,
    ) -> None:
        """Record where a step may have more answers than are listed, the first of each step;
        ``turns``: it may be that they differ by whole turns."""
        self.complete = self.complete and complete
        if turns and not self.graph.weighed.isdisjoint(unknowns):
            self.turned, complete = True, False
        if complete or equations in self.gaps:
            return
        first = (values.get(unknowns[0]) for values in listed)
        numbers = [float(v) for v in first if v is not None and not isinstance(v, str)]
        ends = min(numbers, default=0.0), max(numbers, default=0.0)
        listed_cut = cut and len(listed) > 1
        self.gaps[equations] = Gap(
            equations, unknowns, len(listed), *ends, listed_cut, uncounted=cut
        )

    def _underdetermined_since(self, count: int) -> Leaf | None:
        """The first case after so many open ones that leaves an uncontradicted continuum: answers
        of other cases do not make this solved, and equality is only its boundary."""
        for leaf in self.open_cases[count:]:
            if not (blocked(self.model, leaf) or leaf.branch.on_boundary or leaf.branch.cut):
                return leaf
        return None

    @property
    def _known(self) -> Leaf | None:
        """The first answer, or the first case that leaves something undetermined."""
        return self.leaves[0] if self.leaves else self._underdetermined_since(0)

    def _holds(self, condition: Condition, branch: Branch) -> bool:
        return holds(condition, branch.values, self.inputs, partial(self._same, branch))

    def _same(self, branch: Branch, comparison: Comparison, one: float, other: float) -> bool:
        """Whether numbers are equal: ``=`` and ``<>`` within the tolerance of comparisons, others
        if they are with the decimals as written."""
        if not equal(one, other) or comparison.operator in ("=", "<>"):
            return equal(one, other)
        from rulesheets.evaluate.exact import value_as_written  # where numbers nearly meet
        from solver.kernel.written import WrittenNumbers

        read = WrittenNumbers(self.graph, branch.values, branch.origins).number
        return value_as_written(subtract(comparison.left, comparison.right), read) == 0

    # --- the end of a branch ---

    def _off(self, branch: Branch) -> Mapping[str, float]:
        """The error of each number of a branch."""
        return branch_errors(self.model, branch)

    def _moved_into_one_turn(self, branch: Branch) -> dict[str, Value]:
        return moved_into_one_turn(self.graph, branch.values, self.inputs)

    def _finish(self, branch: Branch, underdetermined: bool = False) -> None:
        """Check every rule that is active at the end of a branch with the independent rule
        check."""
        branch = branch.fork()
        if not self._stays_in_case(branch):
            return
        values = branch.values = self._moved_into_one_turn(branch)
        decided = self._decided(branch)
        rules = list(known_rules(self.model, decided, values))
        worst, left = 0.0, tuple(rules)
        if len(rules) > MANY:
            from solver.accuracy.alike import accepted

            worst, left = accepted(self.model, rules, values)
        conflicts: list[Fact] = []
        for equation in left:
            check = check_rule(equation, values)
            if check.holds:
                worst = max(worst, check.scaled)
            # no step has asked it
            elif equation.index in branch.checked or not self._agreed(
                branch, equation, check.miss, decided
            ):
                self.delicate = self.delicate or check.delicate
                undefined = indeterminacy(equation, values) if check.miss is None else None
                conflicts.append(undefined or Conflict((equation.index,), check.miss, values))
        conflicts += unmet(self.model, values, decided)
        lacking = (name for name in self._due(branch) if name not in values)
        missing = tuple(
            dict.fromkeys(name for name in lacking if not infinite(self.model, branch, name))
        )
        leaf = Leaf(branch, missing, tuple(conflicts), worst, len(rules), underdetermined)
        if conflicts:
            self.contradicted.append(leaf)
        elif missing and (excluded := self.analysis.excluded(branch)) is not None:
            self.outside_case.append(replace(leaf, conflicts=excluded))
        elif missing and branch.signs and self._is_open(leaf):
            self.open_cases.append(leaf)
        else:
            self.leaves.append(leaf)

    def _stays_in_case(self, branch: Branch) -> bool:
        """Whether the values of a branch are those of its case; what misses its boundary by
        rounding is moved onto it."""
        if not (branch.signs and self.analysis.contradicted(branch)):
            return True
        for pair in (pair for pair, sign in branch.signs.items() if sign > EQUAL):
            moved = onto_boundary(self.graph, branch, pair, self.inputs, self._off, self.analysis)
            if moved:
                return True
            self.complete = self.complete and moved is not None
        self.outside_case.append(Leaf(branch, (), (), 0.0, 0))
        return False

    def _decided(self, branch: Branch) -> dict[int, bool]:
        """The outcome of each condition at the values of a branch; as assumed if these leave it
        open."""
        every = range(len(self.model.conditions))
        return {**branch.assumed, **self.analysis.outcomes(every, branch)}

    def _agreed(
        self, branch: Branch, rule: Equation, miss: float | None, decided: dict[int, bool]
    ) -> bool:
        """As ``agreed``, if errors of the values may explain the ``miss`` of the rule, and every
        condition is ``decided`` as before at the other value."""
        if miss is not None and not explained(rule, branch.values, miss, self._off(branch)):
            return False
        trial = branch.fork()
        trial.decided = decided
        if not agreed(self.graph, trial, rule.index, self.inputs):
            return False
        if same := self._decided(trial) == decided:
            branch.values.update(trial.values)
            branch.precise = trial.precise
        return same

    def _due(self, branch: Branch) -> Sequence[str]:
        """The names that must have values at the end of a branch: if it assumes an equality, all
        posted ones that the inputs determine with it."""
        if not branch.on_boundary:
            return self.judged
        path = self.planner.path(branch.given(self.inputs), branch.conditions)
        free, variables = frozenset(path.undetermined), self.model.variables.items()
        return (*self.judged, *(n for n, v in variables if v.posted and n not in free))

    def _is_open(self, leaf: Leaf) -> bool:
        """Whether an assumption of a leaf is not known even at its end, or led to a refusal."""
        return self.analysis.unverified(leaf.branch) or hides_no_answer(
            self.model, leaf, self.inputs
        )


# --- numbers that miss a rule, or the boundary of their case, by rounding: moved onto it ---


def agreed(graph: ModelGraph, branch: Branch, equation: int, inputs: Collection[str]) -> bool:
    """Whether another value, equally good for all its rules, satisfies a rule that fails: it is
    taken.

    It is the nearest one: a farther one may be another answer, which has a branch of its own.
    """
    for name in graph.model.equations[equation].names:
        isolation, _ = graph.isolated(equation, graph.number[name])
        number = branch.values[name]
        if name in inputs or isolation is None or isinstance(number, str):
            continue
        others = {other: value for other, value in branch.values.items() if other != name}
        found = StepSolver(graph, equation, name, others).outcome().values
        nearest = sorted((v for v in found if isinstance(v, float)), key=lambda v: abs(v - number))
        if any(_moved(graph, branch, name, value) for value in nearest):
            return True
    return False


def _moved(graph: ModelGraph, branch: Branch, name: str, value: float) -> bool:
    """Whether the rules that read a computed number also hold at another value of it, which is
    taken.

    None of the block that it came from may be left open by an unknown: no value of that need save
    it. They hold between the two as well; another root of them is an answer of its own.
    """
    trial, decided = {**branch.values, name: value}, branch.conditions
    between = {**trial, name: (value + float(branch.values[name])) / 2.0}
    active = [e for i in graph.users[name] if activity(e := graph.model.equations[i], decided)]
    known = [e for e in active if all(other in trial for other in e.names)]
    told_by = () if name not in branch.origins else equations_of(branch.origins[name])
    if any(e.index in told_by and e not in known for e in active):
        return False
    told = [e for e in known if e.index in told_by]
    asked = (*((rule, trial) for rule in known), *((rule, between) for rule in told))
    if not all(check_rule(rule, values).holds for rule, values in asked):
        return False
    branch.values[name] = value
    branch.precise.pop(name, None)
    return True


def onto_boundary(
    graph: ModelGraph,
    branch: Branch,
    pair: Pair,
    inputs: Collection[str],
    errors: Callable[[Branch], Mapping[str, float]],
    analysis: CaseAnalysis,
) -> bool | None:
    """Whether a branch misses the equality of a pair by no more than its rounding: a number is
    moved onto it. None if no number can be moved alone, so that the case stays open.

    The Reynolds number that a friction factor gives as 2299.9999999999995 belongs to ``Re >=
    2300``.
    """
    with suppress(Undefined, KeyError, TypeError):
        miss, slopes = derivatives(subtract(*pair), branch.values)
        numbers = {name: v for name in slopes if isinstance(v := branch.values[name], float)}
        if not abs(miss) <= ROUGHLY * sum(abs(slopes[n] * v) for n, v in numbers.items()):
            return False
        off = errors(branch)
        if abs(miss) > SAFETY * sum(abs(slope) * off[name] for name, slope in slopes.items()):
            return False
        ends = [
            (n, v - miss / slopes[n]) for n, v in numbers.items() if n not in inputs and slopes[n]
        ]
        beside = (
            (name, math.nextafter(at, to)) for name, at in ends for to in (at, math.inf, -math.inf)
        )
        open_: bool | None = None
        for name, number in beside:
            if _moved(graph, trial := branch.without(()), name, number):
                if not analysis.contradicted(trial):
                    branch.values, branch.precise = trial.values, trial.precise
                    return True
                open_ = False
        return open_
    return False
