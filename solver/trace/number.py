"""Nodes of a program with the operators of numbers, for formulas that are written once over numbers
of any kind."""

from __future__ import annotations

from typing import Any

from solver.trace.flow import Flow

NOISE = 1e-13
"""Powers and factors below this are rounding errors of 0."""


def _operator(operation: str, swapped: bool = False) -> Any:
    if swapped:
        return lambda self, other: self.applied(operation, other, self)
    return lambda self, other: self.applied(operation, self, other)


class Number:
    """A node of a program, with the operators of numbers; a condition counts as 0 or 1."""

    __add__, __radd__ = _operator("add"), _operator("add")
    __sub__, __rsub__ = _operator("sub"), _operator("sub", swapped=True)
    __mul__, __rmul__ = _operator("mul"), _operator("mul")
    __truediv__, __rtruediv__ = _operator("div"), _operator("div", swapped=True)
    __lt__, __gt__ = _operator("lt"), _operator("lt", swapped=True)
    __le__, __ge__ = _operator("le"), _operator("le", swapped=True)
    __ne__, __and__ = _operator("ne"), _operator("and")
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, flow: Flow, node: int) -> None:
        self.flow, self.node, self.logical = flow, node, flow.logical(node)

    @property
    def number(self) -> int:
        return self.flow.add("where", self.node, 1.0, 0.0) if self.logical else self.node

    def applied(self, operation: str, one: Any, other: Any) -> Any:
        flow = self.flow
        if operation == "mul":
            return self._times(other)
        if operation == "and":
            return Number(flow, flow.add("and", one.node, other.node))
        if operation == "sub" and one is not self and self.logical and one == 1.0:
            return Number(flow, flow.add("not", self.node))
        nodes = node_of(flow, one), node_of(flow, other)
        if operation == "ne":
            return Number(flow, flow.add("not", flow.add("eq", *nodes)))
        return Number(flow, flow.add(operation, *nodes))

    def _times(self, other: Any) -> Any:
        flow = self.flow
        if not isinstance(other, Number):
            if abs(other) < NOISE or other == 1.0:
                return self if other == 1.0 else 0.0
            return Number(flow, flow.add("mul", self.number, float(other)))
        if self.logical and other.logical:
            return self & other
        if self.logical or other.logical:
            chosen, number = (self, other) if self.logical else (other, self)
            return Number(flow, flow.add("where", chosen.node, number.node, 0.0))
        return Number(flow, flow.add("mul", self.node, other.node))

    def __abs__(self) -> Number:
        return Number(self.flow, self.flow.add("abs", self.number))

    def __neg__(self) -> Number:
        return Number(self.flow, self.flow.add("neg", self.number))


def node_of(flow: Flow, value: Any) -> int:
    return value.number if isinstance(value, Number) else flow.constant(float(value))
