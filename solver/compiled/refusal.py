"""Rows that have no answer for the same reason, told at once.

Where a row was found infeasible at one step of one way, every row that comes to that step by the same
decisions and asks the same impossible thing of it, clearly, is infeasible as well: what the
step-by-step way does after it can't make an answer of it.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from solver.compiled.flow import NotCompilable
from solver.compiled.program import Ending, Program
from solver.compiled.translate import Translation
from solver.compiled.way import CLEAR
from solver.path.closed_form import Circle, Let, Parabola
from solver.path.steps import Decide, Evaluate, Select, SolveBlock

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rulesheets.model import Model, Value
    from solver.compiled.way import Pattern, Way
    from solver.path.planner import Planner
    from solver.path.steps import Step

BEYOND = 1e-6
"""How far outside of an image, relative to the numbers around, a target is refused without a second look."""


def refusals(
    model: Model, planner: Planner, pattern: Pattern, sample: Mapping[str, Value]
) -> Iterator[Program]:
    """Programs whose one ending holds where a row is refused as the sample was, if that is the reason.

    ``sample`` has what was computed of the refused row.
    """
    for kind in (_Refusal, _RefusalOfAll):
        try:
            yield kind(model, planner, pattern, sample).run()
        except NotCompilable:
            continue


class _Refusal(Translation):
    """Follows the way of the sample to the first step that it has no value for."""

    def _follow(self, way: Way, steps: Sequence[Step]) -> None:
        for step in steps:
            self.flow.checks, self.flow.finite = way.checks, way.finite
            match step:
                case Evaluate(unknown=unknown) if unknown not in self.sample:
                    self._refused(way, self._no_value(way, step))
                    return
                case Select(unknown=unknown) if unknown not in self.sample:
                    raise NotCompilable
                case SolveBlock(unknowns=unknowns) if not all(name in self.sample for name in unknowns):
                    self._refused(way, self._no_root(way, step))
                    return
                case Decide(conditions=conditions):
                    self._decide(way, conditions)
                    self._plan(way)
                    return
            found = self._taken(way, step)
            if len(found) != 1:
                raise NotCompilable
            way = found[0]
        raise NotCompilable

    def _refused(self, way: Way, condition: int) -> None:
        self.flow.checks = way.checks
        self.flow.require(condition)
        self.endings.append(Ending((), tuple(way.checks), tuple(way.finite), self.flow.false, ()))

    def _no_value(self, way: Way, step: Evaluate) -> int:
        """A target clearly outside of the image of the operation that is undone."""
        flow = self.flow
        isolation = self._isolation(step.equation, step.unknown)
        if isolation.quadratic is not None or not isolation.stages:
            raise NotCompilable
        target = self._expression(way, isolation.start)
        for stage in isolation.stages:
            if stage.low > -math.inf or stage.high < math.inf:
                margin = flow.add("mul", flow.constant(BEYOND), self._size(way, step.equation))
                low, high = flow.constant(max(stage.low, -1e300)), flow.constant(min(stage.high, 1e300))
                below = flow.add("lt", flow.add("add", target, margin), low)
                above = flow.add("lt", flow.add("add", high, margin), target)
                return flow.add("or", below, above)
            target, *others = self._undone(way, stage, target)
            if others:
                raise NotCompilable
        raise NotCompilable

    def _size(self, way: Way, equation: int) -> int:
        """The square of the largest number of a rule, or 1: what a target's rounding goes by."""
        flow = self.flow
        largest = flow.constant(1.0)
        for name in self.model.equations[equation].names:
            if name in way.values:
                size = flow.add("abs", way.values[name])
                largest = flow.add("where", flow.add("lt", largest, size), size, largest)
        return flow.add("mul", largest, largest)

    def _no_root(self, way: Way, step: SolveBlock) -> int:
        """A discriminant clearly negative."""
        letters = dict(way.values)
        for formula in self._closed(step).formulas:
            match formula:
                case Let(name):
                    letters[name] = self._let(way, letters, formula)
                case Parabola(_, a, b, c):
                    square, four_ac, size = self._discriminant(*self._coefficients(letters, a, b, c))
                    return self._clearly_less(square, four_ac, size)
                case Circle(_, _, a, b, k, radius):
                    reach, across, size = self._reach(*self._coefficients(letters, a, b, k, radius))
                    return self._clearly_less(reach, across, size)
        raise NotCompilable

    def _clearly_less(self, one: int, other: int, size: int) -> int:
        flow = self.flow
        margin = flow.add("mul", flow.constant(CLEAR), size)
        return flow.add("lt", flow.add("add", one, margin), other)


class _RefusalOfAll(_Refusal):
    """Every candidate that the formulas of a block give is none: a root of it would be negative."""

    def _no_root(self, way: Way, step: SolveBlock) -> int:
        flow, everything = self.flow, self.flow.true
        for one in self._block(way, step):
            everything = flow.add("and", everything, one.gone)
            way.checks += [check for check in one.checks if check not in way.checks]
            way.finite += [node for node in one.finite if node not in way.finite]
        return everything
