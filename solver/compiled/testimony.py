"""The witness of one equation, as a node."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rulesheets.construct import subtract
from rulesheets.evaluate import NotDifferentiable, differentiate
from rulesheets.nodes import names
from solver.accuracy.attained import heights
from solver.accuracy.witness import BACKWARD, STEEP, jumps
from solver.compiled.conditions import Conditions
from solver.compiled.coverage import HARMLESS, covered, steep
from solver.compiled.flow import NotCompilable
from solver.compiled.rounding import UNIT, Analysis
from solver.compiled.schedule import LEAVES
from solver.compiled.way import STRANGE, symbol_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rulesheets.model import Equation
    from solver.compiled.way import Way

LARGEST = 1e300


class Testimony(Conditions):
    """Equations evaluated at what a way has computed."""

    def _witness(self, way: Way, equation: Equation, active: int) -> int:
        """Whether an equation holds: |F| ≤ 64 eps · Σ|∂F/∂v · v|, with what rounding may have hidden. One of
        several values that is far from that is no answer."""
        flow = self.flow
        symbols = [symbol_of(side, way.symbols) for side in (equation.left, equation.right)]
        if symbols != [None, None]:
            return flow.constant(symbols[0] == symbols[1])
        with flow.as_reported():
            sides = [self._expression(way, side) for side in (equation.left, equation.right)]
            miss = flow.add("sub", *sides)
            if flow.value_of(miss) == 0.0 and not flow.off(miss):
                return flow.true
            size, quick = self._sizes(way, equation)
            for clear in self._clear_of_edges(way, equation):
                flow.require(clear)
        apart = flow.add("abs", miss)
        rounded = covered(equation, not flow.plain)
        if rounded > HARMLESS:
            flow.require(self._gentle(sides, size))
            return self._noisy(way, active, miss, size)
        if steep(equation):
            exact = flow.add("eq", miss, flow.constant(0.0))
            flow.require(flow.add("or", exact, self._gentle(sides, size)))
        share = flow.constant(BACKWARD - rounded * UNIT)
        limit = flow.add("mul", share, size)
        far = flow.add("lt", flow.add("mul", flow.constant(STRANGE), size), apart)
        holds = flow.add("le", apart, limit)
        if quick in (size, flow.constant(0.0)):
            flow.bound(size)
        else:
            # Terms that are there already may be enough.
            flow.bound(quick)
            sooner = flow.add("le", apart, flow.add("mul", share, quick))
            finite = flow.add("lt", size, flow.constant(LARGEST))
            holds = flow.node("sooner", sooner, flow.add("and", finite, holds))
            far = flow.node("unless", sooner, far)
        self._lose(way, active, far)
        return holds

    def _sizes(self, way: Way, equation: Equation) -> tuple[int, int]:
        """Σ|∂F/∂v · v| over all variables, and over those whose slope is a number."""
        flow = self.flow
        form = subtract(equation.left, equation.right)
        size = quick = flow.constant(0.0)
        for name in equation.names:
            try:
                slope = self._expression(way, differentiate(form, name))
            except NotDifferentiable:
                raise NotCompilable from None
            term = flow.add("abs", flow.add("mul", slope, way.values[name]))
            size = flow.add("add", size, term)
            if flow.value_of(slope) is not None:
                quick = flow.add("add", quick, term)
        return size, quick

    def _clear_of_edges(self, way: Way, equation: Equation) -> Iterator[int]:
        """Whether no function jumps next to what was computed: there slopes do not tell."""
        flow = self.flow
        for function, height in heights(equation) if jumps(equation) else ():
            if all(flow.nodes[way.values[name]][0] in LEAVES for name in names(height)):
                continue
            at = self._expression(way, height)
            apart = at if function in ("sgn", "step") else flow.add("sub", at, flow.add("rint", at))
            if function == "round":
                apart = flow.add("sub", flow.add("abs", apart), flow.constant(0.5))
            reach = flow.constant(0.0)
            for name in dict.fromkeys(names(height)):
                try:
                    slope = self._expression(way, differentiate(height, name))
                except NotDifferentiable:
                    raise NotCompilable from None
                reach = flow.add("add", reach, flow.add("abs", flow.add("mul", slope, way.values[name])))
            reach = flow.add("mul", flow.constant(2.0 * BACKWARD), reach)
            yield flow.add("lt", reach, flow.add("abs", apart))

    def _gentle(self, sides: Sequence[int], size: int) -> int:
        """Whether a rule does not go far within so small a change: slopes do not tell of it where it does."""
        flow = self.flow
        both = flow.add("add", *(flow.add("abs", side) for side in sides))
        limit = flow.add("mul", flow.constant(STEEP / BACKWARD), both)
        return flow.add("le", size, limit)

    def _noisy(self, way: Way, active: int, miss: int, size: int) -> int:
        """Whether an equation holds whose variables do not explain what rounding makes of it."""
        flow = self.flow
        flow.bound(size)
        apart = flow.add("abs", miss)
        noise = Analysis(flow, way.values.values()).error(miss)
        far = flow.add("lt", flow.add("add", flow.add("mul", flow.constant(STRANGE), size), noise), apart)
        self._lose(way, active, far)
        limit = flow.add("mul", flow.constant(BACKWARD), size)
        return flow.add("le", flow.add("add", apart, noise), limit)

    def _lose(self, way: Way, active: int, far: int) -> None:
        """One of several values that is far from satisfying a rule is no answer."""
        if way.order:
            way.gone = self.flow.add("or", way.gone, self.flow.add("and", active, far))
