"""The witness of one equation, as a node."""

from __future__ import annotations

from rulesheets.construct import subtract
from rulesheets.evaluate import NotDifferentiable, differentiate
from solver.compiled.conditions import Conditions
from solver.compiled.flow import NotCompilable
from solver.compiled.way import STRANGE, symbol_of
from solver.witness import BACKWARD

TYPE_CHECKING = False
if TYPE_CHECKING:
    from rulesheets.model import Equation
    from solver.compiled.way import Way

LARGEST = 1e300


class Testimony(Conditions):
    """Equations evaluated at what a way has computed."""

    def _witness(self, way: Way, equation: Equation, active: int) -> int:
        """Whether an equation holds: |F| ≤ 64 eps · Σ|∂F/∂v · v|. One of several values that is far
        from that is no answer."""
        flow = self.flow
        symbols = [symbol_of(side, way.symbols) for side in (equation.left, equation.right)]
        if symbols != [None, None]:
            return flow.constant(symbols[0] == symbols[1])
        form = subtract(equation.left, equation.right)
        miss = flow.add("sub", *(self._expression(way, side) for side in (equation.left, equation.right)))
        if flow.value_of(miss) == 0.0:
            return flow.true
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
        apart = flow.add("abs", miss)
        limit = flow.add("mul", flow.constant(BACKWARD), size)
        far = flow.add("lt", flow.add("mul", flow.constant(STRANGE), size), apart)
        holds = flow.add("le", apart, limit)
        if quick in (size, flow.constant(0.0)):
            flow.bound(size)
        else:
            # Terms that are there already may be enough.
            flow.bound(quick)
            sooner = flow.add("le", apart, flow.add("mul", flow.constant(BACKWARD), quick))
            finite = flow.add("lt", size, flow.constant(LARGEST))
            holds = flow.node("sooner", sooner, flow.add("and", finite, holds))
            far = flow.node("unless", sooner, far)
        if way.order:
            way.gone = flow.add("or", way.gone, flow.add("and", active, far))
        return holds
