"""One equation for one unknown: evaluated, or selected among those that can be active."""

from __future__ import annotations

from typing import TYPE_CHECKING

from solver.accuracy.witness import BACKWARD
from solver.compiled.coverage import HARMLESS, covered, inverted
from solver.compiled.flow import NotCompilable
from solver.compiled.preimages import Preimages
from solver.compiled.rounding import quiet
from solver.compiled.way import symbol_of
from solver.path.activity import activity
from solver.path.isolate import TARGET

if TYPE_CHECKING:
    from collections.abc import Iterator

    from solver.compiled.way import Way
    from solver.path.isolate import Isolation
    from solver.path.steps import Select

_LINEAR = frozenset({"negative", "sum", "product", "quotient"})


class Single(Preimages):
    """Steps that compute one unknown from one equation."""

    def _evaluated(self, way: Way, equation: int, unknown: str) -> Iterator[Way]:
        isolation = self._isolation(equation, unknown)
        said = symbol_of(isolation.start, way.symbols) if isolation.identity else None
        if said is not None:
            way.settled.add(equation)
            way.symbols[unknown] = said
            yield way
            return
        found = self._preimages(way, isolation)
        self._drown(way, equation)
        if _linear(isolation):
            self._certify(way, equation, isolation, found[0])
        variable = self.model.variables[unknown]
        if len(found) == 1:
            self._within(way, variable, found[0])
            way.values[unknown] = found[0]
            yield way
            return
        for place, node in enumerate(found):
            fork = way.fork()
            fork.values[unknown] = node
            fork.order.append(self.flow.constant(float(place)))
            self._leave(fork, variable, node)
            if fork.gone != self.flow.true:
                yield fork

    def _selected(self, way: Way, step: Select) -> Way:
        """A selection between the values of those that can be active; exactly one value may come out."""
        flow, unknown = self.flow, step.unknown
        groups: dict[int, int] = {}
        self._mirrored = self._mirrored_in(step.equations)
        for index in step.equations:
            equation = self.model.equations[index]
            if activity(equation, way.decided) is False:
                continue
            active = self._active(way, equation.guard)
            if active is None:
                raise NotCompilable
            if active == flow.false:
                continue
            isolation = self._isolation(index, unknown)
            if isolation.branches > 1 or (isolation.identity and symbol_of(isolation.start, way.symbols)):
                raise NotCompilable
            self._drown(way, index)
            with flow.only_if(active):
                (node,) = self._preimages(way, isolation)
                if _linear(isolation):
                    self._certify(way, index, isolation, node)
            groups[node] = flow.add("or", groups[node], active) if node in groups else active
            way.chosen += [p.condition for p in equation.guard if p.condition not in way.decided]
        self._mirrored = frozenset()
        if not groups:
            raise NotCompilable
        *others, (value, some) = groups.items()
        for place, (node, active) in enumerate(reversed(others)):
            value = flow.add("where", active, node, value)
            if place == len(others) - 1:
                some = flow.add("xor", active, some)
            else:
                flow.require(flow.add("not", flow.add("and", active, some)))
                some = flow.add("or", active, some)
        flow.require(some)
        self._within(way, self.model.variables[unknown], value)
        way.values[unknown] = value
        return way

    def _certify(self, way: Way, equation: int, isolation: Isolation, node: int) -> None:
        """A rule that was solved for an unknown holds by construction: one rounding an operation, no more.

        Where the form of the rule does not tell that its variables explain these, it is required that
        the unknown does. What is multiplied or divided must not be lost below what floats hold.
        """
        way.settled.add(equation)
        target = self._expression(way, isolation.start)
        for stage in isolation.stages:
            (target,) = self._undone(way, stage, target)
            if stage.operation in ("product", "quotient"):
                way.undone.append(target)
        if inverted(isolation, not self.flow.plain) > HARMLESS:
            self.flow.require(quiet(self.flow, node, way.values.values(), BACKWARD / 2.0))

    def _drown(self, way: Way, equation: int) -> None:
        turns = not self.flow.plain
        way.drowned = way.drowned or covered(self.model.equations[equation], turns) > HARMLESS


def _linear(isolation: Isolation) -> bool:
    """Whether an unknown comes of sums, products and quotients, undone one after the other, and its rule is
    linear in it: what is a sum in a divisor may be far smaller than the unknown."""
    operations = [stage.operation for stage in isolation.stages]
    divides = [place for place, stage in enumerate(isolation.stages) if stage.divisor == TARGET]
    linear = _LINEAR.issuperset(operations) and not any("sum" in operations[place:] for place in divides)
    return linear and isolation.quadratic is None and not isolation.verify
