"""The path followed once more in numbers of many digits, until two precisions agree."""

from __future__ import annotations

import math
from collections import ChainMap
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from rulesheets.construct import subtract
from rulesheets.evaluate import Undefined, derivatives, extended, holds, value
from rulesheets.evaluate.conditions import equal
from rulesheets.functions.extended import context
from rulesheets.model import Equation, Model, Value
from rulesheets.nodes import Comparison, Condition
from solver.accuracy.forward_error import input_errors, slopes
from solver.accuracy.last_places import blur, half_unit
from solver.accuracy.witness import gross, testify
from solver.facts import Conflict, DoubleRoot, RestsOnRounding
from solver.kernel.code.block import kernel_of
from solver.kernel.precise.extended_block import solve_block_extended
from solver.kernel.precise.extended_step import exact_turn, solve_step_extended
from solver.kernel.precise.extended_system import (
    SPARE,
    Exhausted,
    ExtendedSystem,
    TooFewDigits,
    Unresolved,
    Work,
)
from solver.kernel.question import Question
from solver.path.activity import activity
from solver.path.isolate import Isolation
from solver.path.steps import Evaluate, SolveBlock, Step, equations_of
from solver.solution.casework import Casework
from solver.solution.explore import Explorer
from solver.solution.leaves import Branch, Exploration, Leaf

if TYPE_CHECKING:
    from solver.kernel.outcome import BlockOutcome
    from solver.kernel.steps.step import StepOutcome

AGREEMENT = 1e-18
"""Relative difference of two precisions that no float can show."""
DIGITS = (50, 100, 200)
FAINT = (200, 400, 800)


def explore_precisely(
    model: Model,
    inputs: Mapping[str, Value],
    want: Sequence[str] | None,
    guesses: Mapping[str, float],
    judged: Sequence[str],
    floats: Exploration,
) -> Exploration | None:
    """The exploration on which two precisions agree; None where none do. ``floats`` is the one in floats."""

    lost = False  # the digits of a number, all of them or some

    def precisely(digits: int) -> Exploration | None:
        nonlocal lost
        try:
            return _PreciseExplorer(model, inputs, want, guesses, judged, floats, digits).run()
        except Unresolved as reason:
            lost = isinstance(reason, TooFewDigits)
            return None

    def agreed(digits: Sequence[int]) -> Exploration | None:
        nonlocal lost
        try:
            for rough, fine in pairwise(map(precisely, digits)):
                if rough is not None and fine is not None:
                    if _agree(rough, fine, judged):
                        return fine
                    lost = True
        except Exhausted:
            pass
        return None

    found = agreed(DIGITS)
    faint = lost if found is None else _faint(model, found)
    return (agreed(FAINT) or found) if faint else found


def _faint(model: Model, found: Exploration) -> bool:
    """Whether rules are contradicted that only more digits still could satisfy: a number next to zero,
    beside a larger one, may be lost to all of these precisions alike. Where it is, it contradicts the very
    rule that it was solved from."""
    contradicted = (
        (leaf, index, conflict.values)
        for leaf in found.dead
        for conflict in leaf.conflicts
        if isinstance(conflict, Conflict)
        for index in conflict.equations
    )
    return any(
        _solved_from(leaf, index) or testify(model.equations[index], values).delicate
        for leaf, index, values in contradicted
        if all(name in values for name in model.equations[index].names)
    )


def _solved_from(leaf: Leaf, equation: int) -> bool:
    return any(equation in equations_of(step) for step in leaf.branch.origins.values())


def _known(branch: Branch) -> Mapping[str, Any]:
    return ChainMap(branch.precise, branch.values)


class _PreciseCasework(Casework):
    """Conditions on numbers of many digits."""

    def __init__(self, model: Model, inputs: Mapping[str, Value], digits: int) -> None:
        super().__init__(model, inputs)
        self.digits = digits

    def holds(self, condition: Condition, branch: Branch) -> bool:
        """Numbers are equal that differ by no more than the given numbers' last places explain."""

        def same(comparison: Comparison, left: float, right: float) -> bool:
            return equal(left, right) and self._meet(comparison, branch)

        return holds(condition, branch.values, self.inputs, same)

    def _meet(self, comparison: Comparison, branch: Branch) -> bool:
        sides, known = (comparison.left, comparison.right), _known(branch)
        left, right = (extended(side, known, self.digits) for side in sides)
        moved = self.last_places(branch)
        reach = sum(
            abs(slope * moved[name])
            for side in sides
            for name, slope in derivatives(side, branch.values)[1].items()
            if moved.get(name)
        )
        return bool(abs(left - right) <= reach + 10.0 ** (SPARE - self.digits) * max(abs(left), abs(right)))

    def last_places(self, branch: Branch) -> Mapping[str, float]:
        """How far each number moves with the last places of the inputs, and of the numbers in the rules."""
        decided = branch.conditions
        given = {n: half_unit(v) for n, v in self.inputs.items() if isinstance(v, float)}
        steps, values = branch.steps, branch.values
        return input_errors(self.model, values, steps, lambda e: activity(e, decided), given)


class _PreciseExplorer(Explorer):
    """Follows every way with values to so many digits; the floats next to them go by their names."""

    def __init__(
        self,
        model: Model,
        inputs: Mapping[str, Value],
        want: Sequence[str] | None,
        guesses: Mapping[str, float],
        judged: Sequence[str],
        floats: Exploration,
        digits: int,
    ) -> None:
        super().__init__(model, inputs, want, guesses, judged)
        self.digits, self.mp = digits, context(digits)
        self.outcomes, self.work = floats.outcomes, Work()
        self.manifold: set[int] = set()
        self.casework: _PreciseCasework = _PreciseCasework(model, self.inputs, digits)

    def _stepped(self, branch: Branch, equation: int, isolation: Isolation) -> StepOutcome:
        off = partial(self._off, branch)
        found = solve_step_extended(self.graph, equation, isolation, _known(branch), self.digits, off)
        if len(found.values) > 2:
            self.manifold.add(equation)
        return found

    def _solved(self, step: SolveBlock, branch: Branch) -> BlockOutcome:
        floats = super()._solved(step, branch)
        kernel, known = kernel_of(self.graph, step), _known(branch)
        here = {name: known[name] for name in kernel.known}
        asked = Question(kernel, branch.values, self.guesses)
        system = ExtendedSystem(kernel, here, self.digits, self.work)
        return solve_block_extended(asked, system, floats, partial(self._off, branch))

    def _off(self, branch: Branch) -> Mapping[str, float]:
        """How far each number may be off, to first order. Of one that may pass through a pole (a slope near
        infinity) that says nothing: it is as large as it will, but never 0, and not off here."""
        moved = self.casework.last_places(branch)
        poles = {name for name, far in moved.items() if self._unbounded(branch, name, far, moved)}
        return {name: 0.0 if name in poles else far for name, far in moved.items()} if poles else moved

    def _finish(self, branch: Branch, loose: bool = False) -> None:
        branch.facts = (*branch.facts, *self._resting_on_rounding(branch))
        super()._finish(branch, loose)

    def _resting_on_rounding(self, branch: Branch) -> Iterator[RestsOnRounding]:
        """What passes through a pole within the last places of given numbers, and was asked for itself."""
        if any(isinstance(fact, DoubleRoot) for fact in branch.facts):
            return  # what moves far there has no slope, and no pole
        moved = self.casework.last_places(branch)
        for name, far in moved.items():
            if name not in self.findings.judged or far == math.inf:
                continue
            if self._unbounded(branch, name, far, moved) or self._inverts(branch, name, far, moved):
                origin = equations_of(branch.origins[name])[0]
                yield RestsOnRounding(origin, name, self._following(branch, name, moved))

    def _inverts(self, branch: Branch, name: str, far: float, moved: Mapping[str, float]) -> bool:
        """Whether a number that may be off by more than itself goes as the inverse of what moves it: through
        a pole, not through 0. Half as far along is far enough to tell."""
        number, step = branch.values.get(name), branch.origins.get(name)
        if not (isinstance(number, float) and isinstance(step, Evaluate)) or step.equation in self.manifold:
            return False  # each of many preimages would be held to all of them
        if not 0.0 < abs(number) <= far < math.inf:
            return False
        isolation = self.graph.isolation(step.equation, self.graph.number[name])
        slope = slopes(self.model.equations[step.equation], branch.values)
        assert isolation is not None
        there = []
        for share in (0.5 * abs(number) / far, -0.5 * abs(number) / far):
            at = dict(_known(branch))
            for n, s in slope.items():
                if n != name and s and moved.get(n):
                    at[n] = self.mp.mpf(at[n]) + math.copysign(share * moved[n], share * s)
            found = solve_step_extended(self.graph, step.equation, isolation, at, self.digits, dict)
            there += [float(v) / number for v in found.values if not isinstance(v, str)]
        if len(there) != 2 or min(there) <= 0.0:
            return False
        one, other = there
        return abs(1.0 / one + 1.0 / other - 2.0) < abs(one + other - 2.0)

    def _following(self, branch: Branch, pole: str, moved: Mapping[str, float]) -> tuple[str, ...]:
        """A number that may have any value, and those that it takes along."""
        lost = {pole: None}
        for name, step in branch.origins.items():
            number = branch.values.get(name)
            reads = {n for index in equations_of(step) for n in self.model.equations[index].names}
            if isinstance(number, float) and moved.get(name, 0.0) >= abs(number) and reads & lost.keys():
                lost[name] = None
        return tuple(lost)

    def _unbounded(self, branch: Branch, name: str, far: float, moved: Mapping[str, float]) -> bool:
        """Whether a number may be off by more than itself, though its equation does not admit 0 for it."""
        number, step = branch.values.get(name), branch.origins.get(name)
        if isinstance(number, str) or not number or step is None or far < abs(number):
            return False
        at = {**branch.values, name: 0.0}
        for equation in (self.model.equations[index] for index in equations_of(step)):
            if name not in equation.names or any(n not in at for n in equation.names):
                continue
            form = subtract(equation.left, equation.right)
            try:
                return abs(value(form, at)) > blur(form, at, {**moved, name: 0.0})
            except Undefined:
                return False
        return False

    def _learn(self, branch: Branch, step: Step, found: Mapping[str, Any]) -> None:
        numbers = {
            name: number if self._known_from_zero(branch, step, found, name) else 0 * number
            for name, number in found.items()
            if not isinstance(number, str)
        }
        super()._learn(branch, step, {**found, **{name: float(v) for name, v in numbers.items()}})
        branch.precise.update(numbers)

    def _known_from_zero(self, branch: Branch, step: Step, found: Mapping[str, Any], name: str) -> bool:
        """Whether a number is more than the rounding of the terms that it was solved from: in some equation,
        whose other terms tell it from 0, or in all."""
        if not found[name] or abs(found[name]) > 10.0 ** (-0.5 * self.digits):
            return True
        values = {**branch.values, **{n: v if isinstance(v, str) else float(v) for n, v in found.items()}}
        reach, lost = 10.0 ** (SPARE - self.digits), False
        for equation in (self.model.equations[index] for index in equations_of(step)):
            if name in equation.names and all(n in values for n in equation.names):
                moved = _slope(equation, values, name) * float(abs(found[name]))
                terms = gross(equation, values)  # 0 where they are smaller than floats hold
                if moved <= reach * terms != 0.0:
                    lost = True
                elif gross(equation, {**values, name: 0.0}):
                    return True
        return not lost

    def _settled(self, branch: Branch) -> dict[str, Value]:
        """Whole turns are taken off the digits that floats do not hold, too."""
        settled = super()._settled(branch)
        for name, number in settled.items():
            before = branch.values[name]
            if isinstance(number, str) or isinstance(before, str) or number == before:
                continue
            turn = self.graph.turn(name)
            if turn is None or name not in branch.precise:
                continue
            exact = self.mp.mpf(branch.precise[name])  # at a double root it is a float
            branch.precise[name] = exact + round((number - before) / turn) * exact_turn(turn, self.mp)
            settled[name] = float(branch.precise[name])
        return settled


def _slope(equation: Equation, values: Mapping[str, Value], name: str) -> float:
    try:
        return abs(slopes(equation, values).get(name, 0.0))
    except Undefined:
        return math.inf


def _agree(rough: Exploration, fine: Exploration, judged: Sequence[str]) -> bool:
    """Whether twice the digits lead the same ways to the same answers."""
    for some, others in ((rough.leaves, fine.leaves), (rough.dead, fine.dead), (rough.adrift, fine.adrift)):
        if len(some) != len(others):
            return False
        if not all(_same(a, b, judged) for a, b in zip(some, others, strict=True)):
            return False
    return True


def _same(one: Leaf, other: Leaf, judged: Sequence[str]) -> bool:
    a, b = one.branch, other.branch
    if a.values.keys() != b.values.keys() or a.void.keys() != b.void.keys():
        return False
    return all(
        abs(a.precise[name] - exact) <= AGREEMENT * abs(exact)
        for name, exact in b.precise.items()
        if name in judged and name in a.precise
    )
