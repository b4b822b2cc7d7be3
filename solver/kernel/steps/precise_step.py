"""One equation solved for one unknown in many decimal digits.

Nothing is clamped that floats would clamp for their rounding: a target just inside an image keeps both of its
preimages, and one just outside has none.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from rulesheets.evaluate import Undefined, extended
from rulesheets.evaluate.digits import context
from rulesheets.model import Value
from rulesheets.syntax.nodes import Expression
from solver.accuracy.digits import SPARE, Unresolved
from solver.accuracy.rule_check import check_rule
from solver.facts import DoubleRoot
from solver.kernel.steps.step import StepSolver
from solver.path.graph import ModelGraph
from solver.path.isolate import Isolation, Stage


def exact_turn(turn: float, mp: Any) -> Any:
    """A period in all digits: 360 is itself, the float next to 2π stands for 2π."""
    halves = round(turn / math.pi)
    return halves * mp.pi if math.isclose(turn, halves * math.pi, rel_tol=1e-15) else mp.mpf(turn)


class PreciseStep(StepSolver):
    """The known ``values`` may be mpmath numbers, or floats, which are taken as exact."""

    def __init__(
        self, graph: ModelGraph, equation: int, isolation: Isolation, values: Mapping[str, Any], digits: int
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
        return super()._in_image(stage, target) if all(float(end).is_integer() for end in ends) else target

    def _turns(self, principal: Any, period: float, rest: tuple[Stage, ...]) -> list[Any]:
        return super()._turns(principal, exact_turn(period, self.mp), rest)

    def uncounted(self) -> None:
        raise Unresolved

    def _wrapped(self, number: Any) -> Any:
        turn = self.graph.turn(self.isolation.unknown)
        bounded = self.variable.low > -math.inf or self.variable.high < math.inf
        if turn is None or bounded or not self.isolation.stages or self.isolation.period is None:
            return number
        whole = exact_turn(turn, self.mp)
        wrapped = number - whole * self.mp.ceil(number / whole - 0.5)
        return wrapped + whole if float(wrapped) == -turn / 2 else wrapped

    def _polished(self, number: Any) -> Any:
        return number

    def _floats(self, number: Any) -> dict[str, Value]:
        known: dict[str, Value] = {n: v if isinstance(v, str) else float(v) for n, v in self.values.items()}
        return {**known, self.isolation.unknown: float(number)}

    def _holds(self, number: Any) -> bool:
        if not (self.isolation.verify or self.clamped):
            return True
        return check_rule(self.equation, self._floats(number)).holds

    def _indifferent(self) -> bool:
        known = {n: v if isinstance(v, str) else float(v) for n, v in self.values.items()}
        return StepSolver(self.graph, self.index, self.isolation, known)._indifferent()

    def _double(self, number: Any) -> DoubleRoot | None:
        return super()._double(float(number))

    def _slope(self, number: float) -> tuple[float | None, float]:
        return self._slope_at(self._floats(number))
