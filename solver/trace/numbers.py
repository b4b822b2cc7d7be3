"""The numbers that the nodes of a program have at a sample."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from rulesheets.functions import TABLE
from solver.trace.flow import FOLD, Flow, Operand
from solver.trace.schedule import LEAVES, operands


class Numbers:
    """Evaluates nodes at one set of inputs, each once. ``found`` takes nodes that are known otherwise."""

    def __init__(self, flow: Flow, inputs: Mapping[int, float]) -> None:
        self.flow, self.inputs = flow, inputs
        self.found: dict[int, float | bool] = {}

    def __call__(self, node: int) -> float | bool:
        """The number of a node; nan where an operation has none."""
        waiting = [node]
        while waiting:
            one = waiting[-1]
            missing = (
                [] if one in self.found else [o for o in operands(self.flow, one) if o not in self.found]
            )
            if not missing:
                waiting.pop()
                if one not in self.found:
                    self.found[one] = self._value(one)
            waiting += missing
        return self.found[node]

    def _value(self, node: int) -> float | bool:
        operation, *rest = self.flow.nodes[node]
        if operation in LEAVES:
            return self._leaf(node)
        try:
            return self._result(operation, rest, [self.found[one] for one in operands(self.flow, node)])
        except (ArithmeticError, ValueError):
            return math.nan

    def _result(
        self, operation: Operand, rest: Sequence[Operand], numbers: list[float | bool]
    ) -> float | bool:
        match operation:
            case "call":
                return TABLE[str(rest[0])].value(*numbers)
            case "sind" | "cosd" | "sin" | "cos":
                return TABLE[str(operation)].value(*numbers)
            case "direction" | "directiond":
                return TABLE["atan2" if operation == "direction" else "atan2d"].value(*numbers)
            case "finite":
                return math.isfinite(numbers[0])
            case "root" | "item":
                return math.nan
            case _:
                return FOLD[str(operation)](*numbers)

    def _leaf(self, node: int) -> float | bool:
        kind, value, *_ = self.flow.nodes[node]
        return self.inputs[int(value)] if kind == "input" else value  # type: ignore[return-value]
