"""Simultaneous blocks: by the formulas of their closed form, or by roots that are proven."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rulesheets import nodes
from rulesheets.nodes import Name
from solver.compiled.flow import NotCompilable
from solver.compiled.preimages import Preimages
from solver.compiled.roots import Roots, root_values
from solver.compiled.testimony import Testimony
from solver.compiled.twofold import Twofold
from solver.compiled.way import STRANGE
from solver.kernel.code.block import BlockKernel
from solver.kernel.code.reduction import reduced
from solver.kernel.question import Question
from solver.path.closed_form import Circle, ClosedForm, Let, Parabola

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from solver.compiled.way import Way
    from solver.path.closed_form import Coefficient
    from solver.path.steps import SolveBlock


class Simultaneous(Preimages, Testimony):
    """Steps that compute the unknowns of a block together."""

    def _block(self, way: Way, step: SolveBlock) -> Iterator[Way]:
        if self._kernel(step).closed is None:
            yield from self._iterated(way, step)
            return
        ways = [(way, dict(way.values))]
        for formula in self._closed(step).formulas:
            ways = [found for one, letters in ways for found in self._formula(one, letters, formula)]
        for one, letters in ways:
            self.flow.checks, self.flow.finite = one.checks, one.finite
            for name in step.unknowns:
                one.values[name] = letters[name]
                self._leave(one, self.model.variables[name], letters[name])
            if len(ways) > 1:
                self._prefer(one, step)
            if one.gone != self.flow.true:
                yield one

    def _closed(self, step: SolveBlock) -> ClosedForm:
        form = self._kernel(step).closed
        if form is None:
            raise NotCompilable
        return form

    def _kernel(self, step: SolveBlock) -> BlockKernel:
        kernels: dict[SolveBlock, BlockKernel] = self.graph.kernels
        if step not in kernels:
            kernels[step] = BlockKernel(self.graph, step)
        return kernels[step]

    def _iterated(self, way: Way, step: SolveBlock) -> Iterator[Way]:
        """A block without a formula: its roots, where they are known to be all there are."""
        roots = self._proven_roots(way, step)
        several = roots.count > 1
        for place in range(roots.count):
            one = way.fork() if several else way
            self.flow.checks, self.flow.finite = one.checks, one.finite
            found = root_values(self.flow, roots, place, way.values)
            for name in step.unknowns:
                one.values[name] = found[name]
                if several:
                    self._leave(one, self.model.variables[name], found[name])
                else:
                    self._within(one, self.model.variables[name], found[name])
            if several:
                # A root that is proven to be there and does not satisfy a rule in floats is not gone.
                for equation in (self.model.equations[number] for number in step.equations):
                    self.flow.require(self._witness(one, equation, self.flow.true))
                    one.settled.add(equation.index)
                self._prefer(one, step)
            if one.gone != self.flow.true:
                yield one

    def _proven_roots(self, way: Way, step: SolveBlock) -> Roots:
        kernel = self._kernel(step)
        torn = kernel if len(step.tears) == 1 else reduced(kernel)
        if torn is None or any(name in way.symbols for name in kernel.known):
            raise NotCompilable
        question = Question(kernel, self.sample, self.pattern.guesses)
        varying = [self.flow.value_of(way.values[name]) is None for name in kernel.known]
        return Roots(torn, question.domain(torn.block.tears[0]), question.known, varying)

    def _formula(
        self, way: Way, letters: dict[str, int], formula: Let | Parabola | Circle
    ) -> Iterator[tuple[Way, dict[str, int]]]:
        flow = self.flow
        flow.checks, flow.finite = way.checks, way.finite
        match formula:
            case Let(name):
                yield way, {**letters, name: self._let(way, letters, formula)}
            case Parabola(name, a, b, c):
                fine = self._fine(a.expression, b.expression, c.expression, letters)
                one, other, rest = self._coefficients(letters, a, b, c)
                first, second = self._roots(one, other, rest, fine)
                for node in (first, second):
                    yield way.fork(), {**letters, name: node}
            case Circle(x, y, a, b, k, square):
                fine = self._fine_reach(letters, formula)
                one, other, shift, radius = self._coefficients(letters, a, b, k, square)
                points = self._meets(one, other, shift, radius, fine)
                for point in points:
                    yield way.fork(), {**letters, x: point[0], y: point[1]}

    def _let(self, way: Way, letters: Mapping[str, int], formula: Let) -> int:
        flow = self.flow
        match formula.expression:
            case nodes.Call("atan2d" | "atan2" as function, (Name(sine), Name(cosine))):
                return flow.direction(letters[sine], letters[cosine], function.removeprefix("atan2"))
        node = flow.expression(formula.expression, letters)
        if formula.size is not None:
            size = flow.expression(formula.size, letters)
            if formula.divisor:
                self._apart(node, size, self.pattern.clear)
                flow.bound(node)
            else:
                self._apart(node, size, STRANGE)
                way.gone = flow.add("or", way.gone, flow.add("lt", node, flow.constant(0.0)))
        return node

    def _apart(self, node: int, size: int, share: float) -> None:
        """Require a number to be apart from zero."""
        flow = self.flow
        if flow.value_of(node) is None:
            limit = flow.add("mul", flow.constant(share), size)
            flow.require(flow.add("lt", limit, flow.add("abs", node)))

    def _coefficients(self, letters: Mapping[str, int], *coefficients: Coefficient) -> list[int]:
        return [self.flow.expression(coefficient.expression, letters) for coefficient in coefficients]

    def _fine_reach(self, letters: Mapping[str, int], circle: Circle) -> int | None:
        """``(a² + b²) square - k²`` from twice the digits of a float; None where it is no polynomial."""
        exact = Twofold(self.flow)
        coefficients = (circle.a, circle.b, circle.k, circle.square)
        try:
            a, b, k, square = (exact.pair(one.expression, letters) for one in coefficients)
        except NotCompilable:
            return None
        length = exact.add(exact.multiply(a, a), exact.multiply(b, b))
        return exact.add(exact.multiply(length, square), exact.negative(exact.multiply(k, k)))[0]

    def _meets(self, a: int, b: int, k: int, square: int, fine: int | None) -> Iterator[tuple[int, int]]:
        flow = self.flow
        length = flow.add("add", flow.add("mul", a, a), flow.add("mul", b, b))
        reach, across, size = self._reach(a, b, k, square)
        discriminant = self._resolved(flow.add("sub", reach, across), fine, size)
        flow.require(self._clear(discriminant, size))
        root = flow.add("sqrt", discriminant)
        flow.require(flow.add("not", flow.add("eq", length, flow.constant(0.0))))
        flow.bound(length)
        for sign in ("sub", "add"):
            opposite = "add" if sign == "sub" else "sub"
            x = flow.add(sign, flow.add("mul", a, k), flow.add("mul", b, root))
            y = flow.add(opposite, flow.add("mul", b, k), flow.add("mul", a, root))
            yield flow.add("div", x, length), flow.add("div", y, length)

    def _reach(self, a: int, b: int, k: int, square: int) -> tuple[int, int, int]:
        """``(a² + b²) square``, ``k²``, and the sum of their sizes."""
        flow = self.flow
        length = flow.add("add", flow.add("mul", a, a), flow.add("mul", b, b))
        reach, across = flow.add("mul", length, square), flow.add("mul", k, k)
        return reach, across, flow.add("add", flow.add("abs", reach), across)

    def _prefer(self, way: Way, step: SolveBlock) -> None:
        """The order of a block's answers: nearest to the guesses; angles by size; positive first."""
        flow = self.flow
        guessed = [name for name in step.unknowns if name in self.pattern.guesses]
        if guessed:
            total = flow.constant(0.0)
            for name in guessed:
                apart = flow.add("sub", way.values[name], flow.constant(self.pattern.guesses[name]))
                total = flow.add("add", total, flow.add("mul", apart, apart))
            way.order.append(total)
        first = step.tears[0] if step.tears else step.unknowns[0]
        node = way.values[first]
        zero, one = flow.constant(0.0), flow.constant(1.0)
        behind = flow.add("where", flow.add("lt", node, zero), one, zero)
        size = flow.add("abs", node)
        way.order += [size, behind] if self.graph.turn(first) else [behind, size]
