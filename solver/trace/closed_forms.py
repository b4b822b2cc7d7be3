"""Blocks with a closed form, as nodes: every candidate that the formulas give."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Name
from solver.kernel.code.block import kernel_of
from solver.path.closed_form import Circle, Coefficient, Let, Parabola
from solver.path.steps import SolveBlock
from solver.trace.flow import NotCompilable
from solver.trace.inverses import Inverses
from solver.trace.state import CLEAR, STRANGE, State

Letters = dict[str, int]


class ClosedForms(Inverses):
    """Formulas in their order; one with two values makes two candidates of each."""

    def _candidates(self, state: State, step: SolveBlock) -> list[tuple[State, Letters]]:
        """For each candidate a state of its own, and the nodes of its letters.

        Raises NotCompilable for a block without a closed form.
        """
        form = kernel_of(self.graph, step).closed
        if form is None:
            raise NotCompilable
        found = [(state.fork(), dict(state.values))]
        for formula in form.formulas:
            found = [after for one, letters in found for after in self._formula(one, letters, formula)]
        return found

    def _formula(
        self, state: State, letters: Letters, formula: Let | Parabola | Circle
    ) -> Iterator[tuple[State, Letters]]:
        self._on(state)
        match formula:
            case Let(name):
                yield state, {**letters, name: self._let(letters, formula)}
            case Parabola(name, a, b, c):
                for node in self._roots(*self._coefficients(letters, a, b, c)):
                    yield state.fork(), {**letters, name: node}
            case Circle(x, y, a, b, k, square):
                for point in self._meets(*self._coefficients(letters, a, b, k, square)):
                    yield state.fork(), {**letters, x: point[0], y: point[1]}

    def _let(self, letters: Mapping[str, int], formula: Let) -> int:
        flow = self.flow
        match formula.expression:
            case nodes.Call("atan2d" | "atan2" as function, (Name(sine), Name(cosine))):
                return flow.direction(letters[sine], letters[cosine], function.removeprefix("atan2"))
        node = flow.expression(formula.expression, letters)
        if formula.size is not None:
            size = flow.expression(formula.size, letters)
            if formula.divisor:
                self._apart(node, size, CLEAR)
                flow.bound(node)
            else:
                self._apart(node, size, STRANGE)
                flow.require(flow.add("le", flow.constant(0.0), node))
        return node

    def _apart(self, node: int, size: int, share: float) -> None:
        """Require a number to be apart from zero."""
        flow = self.flow
        if flow.value_of(node) is None:
            limit = flow.add("mul", flow.constant(share), size)
            flow.require(flow.add("lt", limit, flow.add("abs", node)))

    def _coefficients(self, letters: Mapping[str, int], *coefficients: Coefficient) -> list[int]:
        return [self.flow.expression(coefficient.expression, letters) for coefficient in coefficients]

    def _meets(self, a: int, b: int, k: int, square: int) -> Iterator[tuple[int, int]]:
        flow = self.flow
        length = flow.add("add", flow.add("mul", a, a), flow.add("mul", b, b))
        root = self._root(*self._reach(a, b, k, square))
        flow.require(flow.add("not", flow.add("eq", length, flow.constant(0.0))))
        flow.bound(length)
        for sign in ("sub", "add"):
            opposite = "add" if sign == "sub" else "sub"
            x = flow.add(sign, flow.add("mul", a, k), flow.add("mul", b, root))
            y = flow.add(opposite, flow.add("mul", b, k), flow.add("mul", a, root))
            yield flow.add("div", x, length), flow.add("div", y, length)

    def _reach(self, a: int, b: int, k: int, square: int) -> tuple[int, int]:
        """``(a² + b²) square`` and ``k²``."""
        flow = self.flow
        length = flow.add("add", flow.add("mul", a, a), flow.add("mul", b, b))
        return flow.add("mul", length, square), flow.add("mul", k, k)
