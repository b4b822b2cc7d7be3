"""Conditions as nodes, and the outcomes that the sample of a way had."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rulesheets import nodes
from rulesheets.evaluate import Undefined, holds, value
from rulesheets.nodes import And, Comparison, Expression, Given, Not, Or
from solver.compiled.flow import Flow, NotCompilable
from solver.compiled.way import symbol_of
from solver.path.cases import comparisons

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rulesheets.model import Model, Premise, Value
    from solver.compiled.way import Pattern, Way
    from solver.path.planner import Planner

_TURNED = ("<=", ">=")


class Conditions:
    """A graph in the making, of one model for one pattern, that decides as ``sample`` does."""

    def __init__(
        self, model: Model, planner: Planner, pattern: Pattern, sample: Mapping[str, Value], plain: bool
    ) -> None:
        self.model, self.planner, self.pattern = model, planner, pattern
        self.graph = planner.graph
        self.sample = sample
        self.flow = Flow(plain)
        self.given = frozenset((*pattern.given, *pattern.inputs))
        self._mirrored: frozenset[frozenset[Expression]] = frozenset()

    def _decide(self, way: Way, conditions: Sequence[int]) -> None:
        """Take the outcome that the sample had, and require it."""
        self.flow.checks = way.checks
        known = {n: v for n, v in self.sample.items() if n in way.values or n in way.symbols}
        for index in conditions:
            if index in way.decided:
                continue
            try:
                outcome = holds(self.model.conditions[index], known, self.given)
            except KeyError:
                continue
            except Undefined:
                raise NotCompilable from None
            way.decided[index] = outcome
            self._pin(way, index, outcome)

    def _pin(self, way: Way, index: int, outcome: bool | None = None) -> None:
        self.flow.checks = way.checks
        if outcome is None:
            known = {n: v for n, v in self.sample.items() if n in way.values or n in way.symbols}
            outcome = holds(self.model.conditions[index], known, self.given)
            way.decided[index] = outcome
        node = self._condition(way, self.model.conditions[index], outcome)
        if node is None:
            raise NotCompilable
        self.flow.require(node if outcome else self.flow.add("not", node))

    def _condition(self, way: Way, condition: nodes.Condition, missing: bool | None = None) -> int | None:
        """The node of a condition; None where a variable is missing.

        With ``missing``, terms that are not known are left out where the others settle that outcome.
        """
        flow = self.flow
        match condition:
            case Comparison(operator, left, right):
                return self._comparison(way, operator, left, right)
            case And(terms) | Or(terms):
                join = "and" if isinstance(condition, And) else "or"
                found = [self._condition(way, term) for term in terms]
                known = [node for node in found if node is not None]
                if len(known) < len(found) and (missing is None or missing is (join == "and") or not known):
                    return None
                total = known[0]
                for node in known[1:]:
                    total = flow.add(join, total, node)
                return total
            case Not(term):
                inside = self._condition(way, term)
                return None if inside is None else flow.add("not", inside)
            case Given(name):
                return flow.constant(name in self.given)
        raise NotCompilable

    def _comparison(self, way: Way, operator: str, left: Expression, right: Expression) -> int | None:
        used = {*nodes.names(left), *nodes.names(right)}
        if not all(name in way.values or name in way.symbols for name in used):
            return None
        symbols = [symbol_of(side, way.symbols) for side in (left, right)]
        if symbols != [None, None]:
            same = symbols[0] == symbols[1]
            return self.flow.constant(same is (operator == "=") and operator in ("=", "<>"))
        one, other = (self._expression(way, side) for side in (left, right))
        if operator not in _TURNED:
            return self.flow.compare(operator, one, other)
        if frozenset((left, right)) in self._mirrored and self._apart_in_sample(left, right):
            self._part(way, one, other)
        return self._at_most(way, *((one, other) if operator == "<=" else (other, one)))

    def _part(self, way: Way, one: int, other: int) -> None:
        """Leave rows with two numbers alike to the step-by-step way."""
        if frozenset((one, other)) not in way.apart:
            way.apart.add(frozenset((one, other)))
            self.flow.require(self.flow.add("not", self.flow.add("eq", one, other)))
            self.flow.bound(one)
            self.flow.bound(other)

    def _at_most(self, way: Way, one: int, other: int) -> int:
        """Whether ``one <= other``; of numbers that are apart, that or the opposite of ``other <= one``."""
        if frozenset((one, other)) in way.apart:
            opposite = self.flow.add("le", other, one)
            if self.flow.value_of(opposite) is not None or other < one:
                return self.flow.add("not", opposite)
        return self.flow.add("le", one, other)

    def _apart_in_sample(self, left: Expression, right: Expression) -> bool:
        try:
            return value(left, self.sample) != value(right, self.sample)
        except (Undefined, KeyError):
            return False

    def _mirrored_in(self, equations: Sequence[int]) -> frozenset[frozenset[Expression]]:
        """Pairs of numbers that the guards of some equations compare both ways, ``<=`` and ``>=``."""
        seen: set[tuple[Expression, Expression]] = set()
        for index in equations:
            for premise in self.model.equations[index].guard:
                for comparison in comparisons(self.model.conditions[premise.condition]):
                    if comparison.operator in _TURNED:
                        pair = comparison.left, comparison.right
                        seen.add(pair if comparison.operator == "<=" else pair[::-1])
        return frozenset(frozenset(pair) for pair in seen if pair[::-1] in seen)

    def _active(self, way: Way, guard: Sequence[Premise]) -> int | None:
        """The node of a guard; None where it is not known."""
        total = self.flow.true
        for premise in guard:
            node = self._condition(way, self.model.conditions[premise.condition])
            if node is None:
                return None
            total = self.flow.add("and", total, node if premise.holds else self.flow.add("not", node))
        return total

    def _expression(self, way: Way, expression: Expression) -> int:
        try:
            return self.flow.expression(expression, way.values)
        except KeyError:
            raise NotCompilable from None
