"""All values of an unknown, as nodes: from one rule solved for it, or a block with a closed
form."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TypeAlias

from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Name
from solver.accuracy.rule_sides import symbol_of
from solver.kernel.block import FormulaNumbers, candidates, kernel_of
from solver.kernel.step import is_affine, is_scaled, reach, window
from solver.numerics.tolerances import EPS, SAME_TURN
from solver.path import (
    TARGET,
    Circle,
    Coefficient,
    Isolation,
    Let,
    Parabola,
    Quadratic,
    Select,
    SolveBlock,
    Stage,
    activity,
)
from solver.trace.flow import LIBRARY, Flow
from solver.trace.graph import NotCompilable, vanishes
from solver.trace.guards import CLEAR, STRANGE, Guards, State
from solver.trace.number import Number

MAX_TURNS = 8
LEFT = 1e-4
"""Share of the terms of a discriminant that must be left of them: its root is right to 1e-12
then."""
Candidate: TypeAlias = tuple[State, Mapping[str, int | str]]
"""A state of its own, and the nodes of some unknowns, or a symbol."""
_LINEAR = frozenset({"negative", "sum", "product", "quotient"})


class Inverses(Guards):
    """Isolations evaluated backwards, and the two roots of a quadratic."""

    def _isolation(self, equation: int, unknown: str) -> Isolation:
        """Raises NotCompilable if no formula solves the rule for the unknown."""
        isolation = self.graph.isolation(equation, self.graph.number[unknown])
        if isolation is None:
            raise NotCompilable
        return isolation

    def _values(self, state: State, equation: int, unknown: str) -> list[int | str]:
        """The nodes of all values, the principal one first, or a symbol."""
        isolation = self._isolation(equation, unknown)
        said = symbol_of(isolation.start, state.symbols) if isolation.identity else None
        if said is not None:
            state.settled.add(equation)
            return [said]
        found = self._preimages(state, isolation)
        self._solved_for(state, equation, isolation)
        return [*found]

    def _selected(self, state: State, step: Select) -> int:
        """A selection between the values of rules that can be active; exactly one must be."""
        flow, groups = self.flow, dict[int, int]()
        for index in step.equations:
            equation = self.model.equations[index]
            if activity(equation, state.decided) is False:
                continue
            active = self._active(state, equation.guard)
            if active is None:
                raise NotCompilable
            if active == flow.false:
                continue
            isolation = self._isolation(index, step.unknown)
            if isolation.branches > 1 or (
                isolation.identity and symbol_of(isolation.start, state.symbols)
            ):
                raise NotCompilable
            with flow.only_if(active):
                (node,) = self._preimages(state, isolation)
                self._solved_for(state, index, isolation)
            groups[node] = flow.add("or", groups[node], active) if node in groups else active
        if not groups:
            raise NotCompilable
        *others, (found, some) = groups.items()
        for place, (node, active) in enumerate(reversed(others)):
            found = flow.add("where", active, node, found)
            if place == len(others) - 1:
                some = flow.add("xor", active, some)
            else:
                flow.require(flow.add("not", flow.add("and", active, some)))
                some = flow.add("or", active, some)
        flow.require(some)
        return found

    @staticmethod
    def _solved_for(state: State, equation: int, isolation: Isolation) -> None:
        """A rule that was solved by sums and products holds by construction: one rounding per
        operation.

        It must be linear in the unknown: a sum in a divisor may be far smaller than the unknown.
        """
        operations = [stage.operation for stage in isolation.stages]
        divides = [place for place, stage in enumerate(isolation.stages) if stage.divisor == TARGET]
        linear = _LINEAR.issuperset(operations) and not any(
            "sum" in operations[place:] for place in divides
        )
        if linear and isolation.quadratic is None and not isolation.verify:
            state.settled.add(equation)

    # --- stages ---

    def _preimages(self, state: State, isolation: Isolation) -> list[int]:
        if isolation.quadratic is not None:
            one, other = self._roots_of(state, isolation.quadratic)
            larger = self.flow.add("lt", other, one)
            pairs = (one, other), (other, one)
            return [self.flow.add("where", larger, *pair) for pair in pairs]
        targets = [self._expression(state, isolation.start)]
        for place, stage in enumerate(isolation.stages):
            targets = [node for target in targets for node in self._undone(state, stage, target)]
            if stage.period is not None:
                return self._turned_values(
                    state, isolation, stage, isolation.stages[place + 1 :], targets
                )
        return targets

    def _roots_of(self, state: State, form: Quadratic) -> list[int]:
        """The two roots of a quadratic equation, in no order."""
        parts = (self._expression(state, part) for part in (form.a, form.b, form.c))
        on = NodeNumbers(self.flow, state, set())
        return [root.node for root in on.roots(*(Number(self.flow, part) for part in parts))]

    def _undone(self, state: State, stage: Stage, target: int) -> list[int]:
        flow = self.flow
        several = len(stage.forms) > 1
        flow.require(self._inside(target, stage.low, stage.low_open or several))
        flow.require(self._inside(target, stage.high, stage.high_open or several, upper=True))
        here = {**state.values, TARGET.name: target}
        if stage.divisor is not None:
            divisor = flow.expression(stage.divisor, here)
            flow.bound(divisor)
            flow.apart_from_zero(divisor)
            if stage.operation == "power" and several:
                self._same_parity(divisor)
        found = [flow.expression(form, here) for form in stage.forms]
        if stage.divisor == TARGET:  # what is found is what the rule divides by
            for node in found:
                if not vanishes(flow, node):  # else the rule has no value in any row
                    flow.require(flow.add("not", flow.is_zero(node)))
        return found

    def _same_parity(self, exponent: int) -> None:
        """Require that an exponent stays even, or odd: bases ±b have equal even powers only."""
        half = self.flow.add("div", exponent, 2.0)
        even = self.flow.add("eq", self.flow.add("rint", half), half)
        self._require(even, bool(self._numbers(even)))

    def _turned_values(
        self,
        state: State,
        isolation: Isolation,
        stage: Stage,
        rest: Sequence[Stage],
        targets: list[int],
    ) -> list[int]:
        """The remaining stages of an angle, and its whole turns: within the range, else within one
        turn."""
        low, high = reach(self.graph, isolation.unknown)
        period, turn = stage.period or 0.0, self.graph.turn(isolation.unknown)
        bounded = low > -math.inf or high < math.inf
        if not bounded and turn is None and rest and all(map(is_affine, rest)):
            return self._usual_turns(state, isolation.unknown, period, rest, targets)
        if any(step.operation not in ("sum", "negative") for step in rest):
            raise NotCompilable
        for step in rest:
            targets = [node for target in targets for node in self._undone(state, step, target)]
        if bounded:
            ends = window(low, high, turn or period)
            return [node for form in targets for node in self._whole_turns(form, period, *ends)]
        if turn != period:
            raise NotCompilable
        return [self._wrapped(form, period) for form in targets]

    def _usual_turns(
        self, state: State, unknown: str, period: float, rest: Sequence[Stage], targets: list[int]
    ) -> list[int]:
        """A multiple of an angle in the period around its guess, else in the first one from 0; a
        sum with an angle in the principal turn."""
        flow = self.flow
        ends = [flow.constant(0.0), flow.constant(period), *targets]
        for step in rest:
            ends = [node for end in ends for node in self._undone(state, step, end)]
        foot, top, *found = ends
        if not is_scaled(rest):
            return found
        size, guess = flow.add("abs", flow.add("sub", top, foot)), self.pattern.guesses.get(unknown)
        low = flow.constant(0.5 - SAME_TURN)
        if guess is not None:
            low = flow.add("sub", flow.add("div", guess, size), SAME_TURN)
        counts = [
            flow.add("rint", flow.add("sub", flow.add("div", node, size), low)) for node in found
        ]
        moved = zip(found, counts, strict=True)
        return [flow.add("sub", node, flow.add("mul", size, count)) for node, count in moved]

    def _wrapped(self, node: int, turn: float) -> int:
        """The angle in the turn around 0, its upper end included, also if rounding moved it past
        that."""
        flow = self.flow
        half, edge = turn / 2, LIBRARY * EPS * turn - turn / 2
        count = flow.add("rint", flow.add("div", node, turn))
        moved = flow.add("sub", node, flow.add("mul", turn, count))
        wrapped = flow.add("where", flow.add("lt", half, flow.add("abs", node)), moved, node)
        found = flow.add("where", flow.add("le", wrapped, edge), half, wrapped)
        self.wrapped.add(found)
        return found

    def _whole_turns(self, node: int, period: float, low: float, high: float) -> list[int]:
        """The angle with every whole turn that brings it into a range at the sample, and one more
        on either side, which has to stay outside."""
        number = float(self._numbers(node))
        if not (math.isfinite(number) and high - low <= MAX_TURNS * period):
            raise NotCompilable
        first, last = math.ceil((low - number) / period) - 1, math.floor((high - number) / period)
        counts = sorted(range(first, last + 2), key=lambda k: (abs(k), k < 0))
        return [self.flow.add("add", node, k * period) for k in counts]

    # --- closed forms ---

    def _candidates(self, state: State, step: SolveBlock) -> list[Candidate]:
        """Raises NotCompilable for a block without a closed form."""
        form = kernel_of(self.graph, step).closed
        if form is None:
            raise NotCompilable
        start = NodeNumbers(self.flow, self._on(state.fork()), set())
        found = candidates(form, start, state.values)
        return [(branch.state, {n: nodes[n] for n in step.unknowns}) for branch, nodes in found]


class NodeNumbers(FormulaNumbers):
    """Closed forms as nodes; what they ask is required of a ``state``. Of the points on a
    ``circle`` around 0 of radius 1 the sine and the cosine are known."""

    def __init__(self, flow: Flow, state: State, circle: set[tuple[int, ...]]) -> None:
        self.flow, self.state, self.circle = flow, state, circle

    def fork(self) -> NodeNumbers:
        branch = NodeNumbers(self.flow, self.state.fork(), self.circle)
        self.flow.checks = branch.state.checks
        return branch

    def let(self, formula: Let, known: Mapping[str, int]) -> int:
        flow = self.flow
        match formula.expression:
            case nodes.Call("atan2d" | "atan2" as function, (Name(sine), Name(cosine))):
                point, unit = (known[sine], known[cosine]), function.removeprefix("atan2")
                # what else they are computed from may cancel
                return flow.direction(*point, unit, point in self.circle)
        node = flow.expression(formula.expression, known)
        if formula.size is not None:
            size = flow.expression(formula.size, known)
            if flow.value_of(node) is None:
                flow.require(flow.beyond(node, CLEAR if formula.divisor else STRANGE, size))
            if formula.divisor:
                flow.bound(node)
            else:
                flow.require(flow.add("le", 0.0, node))
        return node

    def coefficient(self, part: Coefficient, known: Mapping[str, int]) -> Number:
        return Number(self.flow, self.flow.expression(part.expression, known))

    def apart(self, divisor: Number) -> Number:
        self.flow.bound(divisor.node)
        self.flow.apart_from_zero(divisor.node)
        return divisor

    def square_roots(self, one: Number, other: Number) -> tuple[Number, Number]:
        """Those of a difference that is not lost in the rounding of its terms."""
        difference = one - other
        self.flow.require((LEFT * (abs(one) + abs(other)) < difference).node)
        root = Number(self.flow, self.flow.add("sqrt", difference.node))
        return root, -root

    def signed(self, root: Number, like: Number) -> Number:
        return Number(self.flow, self.flow.add("where", (like < 0.0).node, (-root).node, root.node))

    def kept(self, formula: Parabola | Circle, found: Mapping[str, Number]) -> dict[str, int]:
        kept = {name: number.node for name, number in found.items()}
        if isinstance(formula, Circle) and nodes.is_number(formula.square.expression, 1.0):
            self.circle.add((kept[formula.y], kept[formula.x]))
        return kept
