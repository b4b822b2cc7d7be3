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
        size = flow.constant(0.0)
        for name in equation.names:
            try:
                slope = self._expression(way, differentiate(form, name))
            except NotDifferentiable:
                raise NotCompilable from None
            size = flow.add("add", size, flow.add("abs", flow.add("mul", slope, way.values[name])))
        flow.bound(size)
        limit = flow.add("mul", flow.constant(BACKWARD), size)
        if way.order:
            far = flow.add("lt", flow.add("mul", flow.constant(STRANGE), size), flow.add("abs", miss))
            way.gone = flow.add("or", way.gone, flow.add("and", active, far))
        return flow.add("le", flow.add("abs", miss), limit)
