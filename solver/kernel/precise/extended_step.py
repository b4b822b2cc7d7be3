"""One equation solved for one unknown to many digits: the preimages of ``step``, in mpmath numbers.

The known values may be mpmath numbers or floats (taken exactly); nothing is clamped that floats would
clamp for their rounding, so a target just inside an image keeps both its preimages, and one just outside has
none.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from rulesheets.construct import subtract
from rulesheets.deadline import expect_time
from rulesheets.evaluate import Undefined, derivatives, extended
from rulesheets.functions.extended import context
from rulesheets.model import Value
from rulesheets.nodes import Expression
from solver.accuracy.last_places import half_unit, with_named_numbers
from solver.accuracy.witness import gross, testify
from solver.facts import AsksNothing, DoubleRoot
from solver.kernel.elimination.near_rank import Blur
from solver.kernel.precise.extended_system import SPARE, TooFewDigits
from solver.kernel.steps.preimages import SAMPLES
from solver.kernel.steps.step import StepOutcome, StepSolver
from solver.path.graph import ModelGraph
from solver.path.isolate import Isolation, Stage

MAX_POLISH = 4
WIDE_SAMPLES = (*SAMPLES, *(1e3 * number for number in SAMPLES))
"""Where an equation is tried that may not depend on its unknown, whatever size that has."""


def solve_step_extended(
    graph: ModelGraph, equation: int, isolation: Isolation, values: Mapping[str, Any], digits: int, off: Blur
) -> StepOutcome:
    """As ``solve_step``, computed with ``digits`` decimal digits.

    ``off`` tells how far the known values may be from what they stand for: an unknown that drops out of the
    equation within that is not determined. Raises TooFewDigits where whole turns are lost beside a number.
    """
    step = _ExtendedStep(graph, equation, isolation, values, digits)
    if step.divides and step.drops_out(off()):
        return StepOutcome(fact=AsksNothing(equation, isolation.unknown))
    return step.outcome()


def exact_turn(turn: float, mp: Any) -> Any:
    """A period to all digits: 360 is itself, the float next to 2π stands for 2π."""
    halves = round(turn / math.pi)
    return halves * mp.pi if math.isclose(turn, halves * math.pi, rel_tol=1e-15) else mp.mpf(turn)


class _ExtendedStep(StepSolver):
    def __init__(
        self,
        graph: ModelGraph,
        equation: int,
        isolation: Isolation,
        values: Mapping[str, Any],
        digits: int,
    ) -> None:
        super().__init__(graph, equation, isolation, values)
        self.digits, self.mp = digits, context(digits)

    def evaluate(self, expression: Expression, values: Mapping[str, Value]) -> Any:
        return extended(expression, values, self.digits)

    def _root(self, number: Any) -> Any:
        return self.mp.sqrt(number)

    def _parts(self, number: Any) -> tuple[Any, int]:
        return number, 0

    def _near(self, share: float) -> float:
        return float(10.0 ** (SPARE - self.digits))

    def _cancels(self, expression: Expression, at: Mapping[str, Value]) -> bool:
        return False

    def _on_the_edge(self, undefined: Undefined) -> bool:
        return False

    def _in_image(self, stage: Stage, target: Any) -> Any:
        """Ends that no float holds (π/2) are left to the operation itself."""
        ends = [end for end in (stage.low, stage.high) if math.isfinite(end)]
        if all(float(end).is_integer() for end in ends):
            return super()._in_image(stage, target)
        return target

    def _turns(self, principal: Any, period: float, rest: tuple[Stage, ...]) -> list[Any]:
        return super()._turns(principal, exact_turn(period, self.mp), rest)

    def uncounted(self) -> None:
        raise TooFewDigits

    def _wrapped(self, number: Any) -> Any:
        turn = self.graph.turn(self.isolation.unknown)
        bounded = self.variable.low > -math.inf or self.variable.high < math.inf
        if turn is None or bounded or not self.isolation.stages or self.isolation.period is None:
            return number
        whole = exact_turn(turn, self.mp)
        wrapped = number - whole * self.mp.ceil(number / whole - 0.5)
        return wrapped + whole if float(wrapped) == -turn / 2 else wrapped

    def _polished(self, number: Any) -> Any:
        """Newton corrections with slopes in floats: each gains as many digits as floats have."""
        if not self.isolation.stages:
            return number
        miss = self._miss(number)
        for _ in range(MAX_POLISH):
            expect_time()
            slope = self._float_slope(number)
            if not miss or not slope or not math.isfinite(slope) or abs(miss) > 1e-9 * abs(slope * number):
                return number
            corrected = number - miss / slope
            better = self._miss(corrected)
            if better is None or abs(better) >= abs(miss):
                return number
            number, miss = corrected, better
        return number

    def _miss(self, number: Any) -> Any:
        at = {**self.values, self.isolation.unknown: number}
        try:
            return self.evaluate(self.equation.left, at) - self.evaluate(self.equation.right, at)
        except Undefined:
            return None

    def _floats(self, number: Any) -> dict[str, Value]:
        known: dict[str, Value] = {n: v if isinstance(v, str) else float(v) for n, v in self.values.items()}
        return {**known, self.isolation.unknown: float(number)}

    def _float_slope(self, number: Any) -> float:
        miss, slope = self._slope_at(self._floats(number))
        return math.nan if miss is None else slope

    @property
    def divides(self) -> bool:
        """Whether what the unknown is multiplied by, or raised to, is made of numbers that may cancel."""
        stages = self.isolation.stages
        return self.isolation.quadratic is not None or any(stage.divides for stage in stages)

    def drops_out(self, off: Mapping[str, float]) -> bool:
        """Whether the equation holds wherever it is tried, and its terms with the unknown change by no more
        from one trial to another than its numbers and the known ones leave open. Raises TooFewDigits where it
        has a slope, but the trials are lost beside larger numbers.
        """
        trials = list(self._trials(off))
        if len(trials) < 2:
            return False
        first, moved, rounding = trials[0]
        if all(miss == first for miss, _, _ in trials) and self._float_slope(SAMPLES[0]):
            raise TooFewDigits
        if not abs(first) <= sum(map(abs, moved.values())) + rounding < math.inf:
            return False
        return all(
            abs(miss - first) <= sum(abs(move - moved[name]) for name, move in moves.items()) + noise
            for miss, moves, noise in trials[1:]
        )

    def _trials(self, off: Mapping[str, float]) -> Iterator[tuple[Any, dict[str, float], float]]:
        """Samples of the unknown: what the equation misses by there, how far each number moves that (signed),
        and how far rounding does."""
        numbers: dict[str, float] = {}
        form = with_named_numbers(subtract(self.equation.left, self.equation.right), numbers)
        errors = {**off, **{name: half_unit(number) for name, number in numbers.items()}}
        for number in WIDE_SAMPLES:
            at = self._floats(number)
            miss = self._miss(number)
            try:
                slopes = derivatives(form, {**at, **numbers})[1]
            except Undefined:
                continue
            moves = {name: slope * error for name, slope in slopes.items() if (error := errors.get(name))}
            if miss is not None:
                yield miss, moves, self._near(0.0) * gross(self.equation, at)

    def _holds(self, number: Any) -> bool:
        if not (self.isolation.verify or self.clamped):
            return True
        return testify(self.equation, self._floats(number)).holds

    def _indifferent(self) -> bool:
        known = {n: v if isinstance(v, str) else float(v) for n, v in self.values.items()}
        return StepSolver(self.graph, self.index, self.isolation, known)._indifferent()

    def _double(self, number: Any) -> DoubleRoot | None:
        return super()._double(float(number))

    def _slope(self, number: float) -> tuple[float | None, float]:
        return None, self._float_slope(number)
