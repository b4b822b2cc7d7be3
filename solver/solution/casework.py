"""Conditions along a branch: what the values say of them, what is assumed, and what contradicts that."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping

from rulesheets.evaluate import Undefined, holds, value
from rulesheets.evaluate.conditions import meets
from rulesheets.model import Equation, Model, Requirement, Value
from rulesheets.syntax import nodes
from solver.facts import Indeterminacy, Unmet
from solver.path.cases import (
    MEANING,
    Pair,
    activity,
    assumed_outcome,
    cases_of,
    comparisons,
    outcome,
    possible,
)
from solver.solution.leaves import Branch


class Casework:
    """The conditions of a model at given inputs."""

    def __init__(self, model: Model, inputs: Mapping[str, Value]) -> None:
        self.model, self.inputs = model, inputs
        self._cases: dict[Pair, tuple[int, ...]] = {}

    def cases(self, pair: Pair) -> tuple[int, ...]:
        """What is assumed of a comparison, one after another."""
        if pair not in self._cases:
            conditions = self.model.conditions
            guards = {(conditions[p.condition], p.holds) for e in self.model.equations for p in e.guard}
            self._cases[pair] = cases_of(pair, conditions, guards)
        return self._cases[pair]

    def outcomes(self, conditions: Collection[int], branch: Branch) -> dict[int, bool]:
        """The conditions that the values settle; an ``and`` or ``or`` may be, before all of it is known."""
        found = {}
        for index in conditions:
            known = self._settle(self.model.conditions[index], branch)
            if known is not None:
                found[index] = known
        return found

    def open_pair(self, branch: Branch, condition: int) -> Pair | None:
        """The first comparison of a condition that is neither known nor assumed."""
        for atom in comparisons(self.model.conditions[condition]):
            if self._settle(atom, branch) is None and assumed_outcome(atom, branch.signs) is None:
                return atom.left, atom.right
        return None

    def infer(self, branch: Branch) -> None:
        """What the values and the assumed signs tell about every condition."""

        def settle(atom: nodes.Condition) -> bool | None:
            known = self._settle(atom, branch)
            if known is None and isinstance(atom, nodes.Comparison):
                return assumed_outcome(atom, branch.signs)
            return known

        for index, condition in enumerate(self.model.conditions):
            if index not in branch.decided:
                found = outcome(condition, settle)
                if found is not None:
                    branch.assumed[index] = found

    def _settle(self, condition: nodes.Condition, branch: Branch) -> bool | None:
        """How a condition comes out at known values; None where they do not tell."""
        try:
            return self.holds(condition, branch)
        except KeyError:
            return None
        except Undefined:
            return False

    def holds(self, condition: nodes.Condition, branch: Branch) -> bool:
        """As ``evaluate.holds`` at the values of a branch."""
        return holds(condition, branch.values, self.inputs)

    def contradicted(self, branch: Branch) -> bool:
        """Whether a comparison came out otherwise than assumed, or all of them cannot come out so."""
        return any(
            self._settle(nodes.Comparison(MEANING[sign], *pair), branch) is False
            for pair, sign in branch.signs.items()
        ) or not possible(branch.signs.items(), branch.values)

    def unverified(self, branch: Branch) -> bool:
        return any(self._settle(nodes.Comparison("=", *pair), branch) is None for pair in branch.signs)


def indeterminacy(equation: Equation, values: Mapping[str, Value]) -> Indeterminacy | None:
    """The fact that an equation is 0/0 at the values, if it is."""
    from rulesheets.evaluate.limit import indeterminate

    for side in (equation.left, equation.right):
        found = indeterminate(side, values)
        if found is not None:
            read = {name: values[name] for name in equation.names if name in values}
            return Indeterminacy(equation.index, found.form, found.limit, found.is_open, read)
    return None


def unmet(model: Model, values: Mapping[str, Value], decided: Mapping[int, bool]) -> Iterator[Unmet]:
    """The requirements that these values break; those that read what has no value are not asked."""
    for index, requirement in enumerate(model.requirements):
        asked = activity(requirement, decided) and all(name in values for name in requirement.names)
        if asked and not _met(requirement, values):
            yield Unmet(index, shortfall(requirement, values), values)


def shortfall(requirement: Requirement, values: Mapping[str, Value]) -> float | None:
    """How far the smaller side is from where it has to be; None where a side is no number."""
    sides = requirement.comparison.left, requirement.comparison.right
    try:
        left, right = (value(side, values) for side in sides)
    except (Undefined, TypeError):
        return None
    apart = abs(left - right)
    return apart if math.isfinite(apart) else None


def _met(requirement: Requirement, values: Mapping[str, Value]) -> bool:
    try:
        return meets(requirement.comparison, values)
    except Undefined:
        return False
