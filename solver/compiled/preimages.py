"""What an operation is undone to: the nodes of every preimage, within the range of the variable."""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING

from rulesheets.evaluate import Undefined, value
from rulesheets.nodes import Number
from solver.compiled.conditions import Conditions
from solver.compiled.flow import NotCompilable
from solver.compiled.magnitude import stands_out
from solver.compiled.rounding import Analysis, known_angles
from solver.compiled.twofold import Twofold
from solver.path.isolate import TARGET

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rulesheets.model import Variable
    from rulesheets.nodes import Expression
    from solver.compiled.way import Way
    from solver.path.isolate import Isolation, Quadratic, Stage

MAX_TURNS = 8
TINY = 1e-280
"""Squares smaller than this may have lost digits to underflow."""
FINE = 1e-2
"""Discriminants smaller than this, relative to their terms, are computed to twice the digits of a float."""


class Preimages(Conditions):
    """Isolations followed backwards, and the two roots of a quadratic."""

    @cached_property
    def rounding(self) -> Analysis:
        return Analysis(self.flow)

    def _isolation(self, equation: int, unknown: str) -> Isolation:
        isolation = self.graph.isolation(equation, self.graph.number[unknown])
        assert isolation is not None
        return isolation

    def _within(self, way: Way, variable: Variable, node: int) -> None:
        """Values outside the declared range do not count; how they fail is for the step-by-step way."""
        self.flow.require(self._in_range(variable, node))

    def _leave(self, way: Way, variable: Variable, node: int) -> None:
        """One of several values is no answer outside the declared range."""
        outside = self.flow.add("not", self._in_range(variable, node))
        way.gone = self.flow.add("or", way.gone, outside)

    def _in_range(self, variable: Variable, node: int) -> int:
        flow, inside = self.flow, self.flow.true
        if variable.low > -math.inf:
            inside = flow.add("and", inside, self._above(node, variable.low, variable.low_open))
        if variable.high < math.inf:
            inside = flow.add("and", inside, self._below(node, variable.high, variable.high_open))
        return inside

    def _above(self, node: int, edge: float, strict: bool) -> int:
        """Whether a number is at least (more than) an edge, and rounding does not make it so."""
        flow = self.flow
        return flow.add("lt" if strict else "le", flow.constant(edge), self._shifted("sub", node, edge))

    def _below(self, node: int, edge: float, strict: bool) -> int:
        flow = self.flow
        return flow.add("lt" if strict else "le", self._shifted("add", node, edge), flow.constant(edge))

    def _shifted(self, operation: str, node: int, edge: float) -> int:
        """A number moved towards an edge by what it may be off by; the sign of a product is right."""
        flow = self.flow
        try:
            bound = self.rounding.bound(node)
            if bound.exact or (edge == 0.0 and bound.rest is None):
                return node
            return flow.add(operation, node, self.rounding.error(node))
        except NotCompilable:
            return node

    def _preimages(self, way: Way, isolation: Isolation) -> list[int]:
        """The nodes of all preimages, the principal one first."""
        if isolation.quadratic is not None:
            return self._quadratic(way, isolation.quadratic)
        targets = [self._expression(way, isolation.start)]
        for place, stage in enumerate(isolation.stages):
            rest = isolation.stages[place + 1 :]
            targets = [node for target in targets for node in self._undone(way, stage, target)]
            if stage.period is not None:
                return self._turned_values(way, isolation, stage, rest, targets)
        return targets

    def _undone(self, way: Way, stage: Stage, target: int) -> list[int]:
        flow = self.flow
        several = len(stage.forms) > 1
        if stage.low > -math.inf:
            flow.require(self._above(target, stage.low, stage.low_open or several))
        if stage.high < math.inf:
            flow.require(self._below(target, stage.high, stage.high_open or several))
        here = {**way.values, TARGET.name: target}
        before = len(flow.taken_away)
        if stage.divisor is not None:
            divisor = flow.expression(stage.divisor, here)
            flow.bound(divisor)
            flow.require(flow.add("not", flow.add("eq", divisor, flow.constant(0.0))))
            for told in known_angles(flow, divisor):
                flow.require(told)
        found = [flow.expression(form, here) for form in stage.forms]
        if stage.divisor == TARGET:  # what is found is what the rule divides by
            for node in found:
                flow.require(flow.add("not", flow.add("eq", node, flow.constant(0.0))))
        if stage.divides:
            self._hold_what_is_left(before)
        return found

    def _hold_what_is_left(self, before: int) -> None:
        """Numbers that another was taken away from must be more than what floats hold of them beside it: an
        unknown that is multiplied by less is not determined."""
        flow = self.flow
        for left, taken in flow.taken_away[before:]:
            flow.require(stands_out(flow, left, taken))

    def _turned_values(
        self, way: Way, isolation: Isolation, stage: Stage, rest: Sequence[Stage], targets: list[int]
    ) -> list[int]:
        """What is left to undo of an angle, and its whole turns: within the range, else within one turn."""
        variable = self.model.variables[isolation.unknown]
        period, turn = stage.period or 0.0, self.graph.turn(isolation.unknown)
        if any(step.operation not in ("sum", "negative") for step in rest):
            raise NotCompilable
        for step in rest:
            targets = [node for target in targets for node in self._undone(way, step, target)]
        if variable.low > -math.inf or variable.high < math.inf:
            images = [_image(form, stage) if not rest else None for form in stage.forms]
            images *= len(targets) // len(images)
            return [
                node
                for form, image in zip(targets, images, strict=True)
                for node in self._whole_turns(variable, form, image, period, turn)
            ]
        if turn != period:
            raise NotCompilable
        return [self._wrapped(form, period) for form in targets]

    def _wrapped(self, node: int, turn: float) -> int:
        """The angle in the turn around 0, its upper end included."""
        flow = self.flow
        half, whole = flow.constant(turn / 2), flow.constant(turn)
        count = flow.add("rint", flow.add("div", node, whole))
        moved = flow.add("sub", node, flow.add("mul", whole, count))
        outside = flow.add("lt", half, flow.add("abs", node))
        wrapped = flow.add("where", outside, moved, node)
        return flow.add("where", flow.add("eq", wrapped, flow.constant(-turn / 2)), half, wrapped)

    def _whole_turns(
        self,
        variable: Variable,
        node: int,
        image: tuple[float, float] | None,
        period: float,
        turn: float | None,
    ) -> list[int]:
        """The angle with every whole turn that can bring it into a range; those outside drop out later."""
        low, high = variable.low, variable.high
        span = turn or period
        if high == math.inf:
            high = low + span
        if low == -math.inf:
            low = high - span
        least, most = image or (-1.5 * period, 1.5 * period)
        first, last = math.ceil((low - most) / period), math.floor((high - least) / period)
        if last - first > MAX_TURNS:
            raise NotCompilable
        counts = sorted(range(first, last + 1), key=lambda k: (abs(k), k < 0))
        return [self.flow.add("add", node, self.flow.constant(k * period)) for k in counts]

    def _quadratic(self, way: Way, quadratic: Quadratic) -> list[int]:
        before = len(self.flow.taken_away)
        a, b, c = (self._expression(way, part) for part in (quadratic.a, quadratic.b, quadratic.c))
        self._hold_what_is_left(before)
        one, other = self._roots(a, b, c, self._fine(quadratic.a, quadratic.b, quadratic.c, way.values))
        larger = self.flow.add("lt", other, one)
        return [self.flow.add("where", larger, one, other), self.flow.add("where", larger, other, one)]

    def _fine(self, a: Expression, b: Expression, c: Expression, values: Mapping[str, int]) -> int | None:
        """``b² - 4 a c`` from twice the digits of a float; None where it is no polynomial of inputs."""
        exact = Twofold(self.flow)
        try:
            pairs = [exact.pair(part, values) for part in (a, b, c)]
            four = exact.pair(Number(4.0), values)
        except NotCompilable:
            return None
        product = exact.multiply(four, exact.multiply(pairs[0], pairs[2]))
        return exact.add(exact.multiply(pairs[1], pairs[1]), exact.negative(product))[0]

    def _clear(self, difference: int, size: int) -> int:
        """Whether something is left of the terms of a difference, and these did not underflow."""
        flow = self.flow
        limit = flow.add("mul", flow.constant(self.pattern.clear), size)
        return flow.add("lt", flow.add("add", limit, flow.constant(TINY)), difference)

    def _resolved(self, difference: int, fine: int | None, size: int) -> int:
        """A difference; where little is left of its terms, by the digits that these are rounded by."""
        flow = self.flow
        if fine is None or flow.value_of(difference) is not None:
            return difference
        near = flow.add("lt", difference, flow.add("mul", flow.constant(FINE), size))
        return flow.add("seldom", near, fine, difference)

    def _roots(self, a: int, b: int, c: int, fine: int | None = None) -> tuple[int, int]:
        """Both roots of ``a x² + b x + c`` without cancellation, required to be apart."""
        flow = self.flow
        square, four_ac, size = self._discriminant(a, b, c)
        discriminant = self._resolved(flow.add("sub", square, four_ac), fine, size)
        flow.require(self._clear(discriminant, size))
        root = flow.add("sqrt", discriminant)
        signed = flow.add("where", flow.add("lt", b, flow.constant(0.0)), flow.add("neg", root), root)
        q = flow.add("mul", flow.constant(-0.5), flow.add("add", b, signed))
        for divisor in (a, q):
            flow.require(flow.add("not", flow.add("eq", divisor, flow.constant(0.0))))
            flow.bound(divisor)
        return flow.add("div", q, a), flow.add("div", c, q)

    def _discriminant(self, a: int, b: int, c: int) -> tuple[int, int, int]:
        """``b²``, ``4 a c``, and the sum of their sizes."""
        flow = self.flow
        four_ac = flow.add("mul", flow.constant(4.0), flow.add("mul", a, c))
        square = flow.add("mul", b, b)
        return square, four_ac, flow.add("add", square, flow.add("abs", four_ac))


def _image(form: Expression, stage: Stage) -> tuple[float, float] | None:
    """Where the values of a form lie, from those at the ends of the stage's image."""
    ends = [max(-1e300, stage.low), min(1e300, stage.high)]
    try:
        found = sorted(value(form, {TARGET.name: end}) for end in ends)
    except (Undefined, KeyError):
        return None
    return found[0], found[1]
