"""Conditions as nodes, and the outcomes that the sample of a way had."""

from __future__ import annotations

from rulesheets import nodes
from rulesheets.evaluate import Undefined, holds
from rulesheets.nodes import And, Comparison, Expression, Given, Not, Or
from solver.compiled.flow import Flow, NotCompilable
from solver.compiled.way import symbol_of

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rulesheets.model import Equation, Model, Value
    from solver.compiled.way import Pattern, Way
    from solver.path.planner import Planner


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
        return self.flow.compare(operator, *(self._expression(way, side) for side in (left, right)))

    def _active(self, way: Way, equation: Equation) -> int | None:
        """The node of an equation's guard; None where it is not known."""
        total = self.flow.true
        for premise in equation.guard:
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
