"""Guards: the state of a record at a step, and conditions of rules and their checks as nodes.

If one of them fails the results do not count, and another record or a full solve decides.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from rulesheets.evaluate import differentiate
from rulesheets.model import Equation, Model, Premise, Requirement, Values, Variable
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import ZERO, And, Comparison, Expression, Given, Not, Or, subtract
from solver.accuracy.rule_sides import heights, jumps, symbol_of
from solver.numerics.tolerances import BACKWARD
from solver.path import activity
from solver.path.isolate import without_logarithm
from solver.path.planner import planner
from solver.trace.compensated import noise, residual
from solver.trace.flow import LIBRARY, Flow, Numbers
from solver.trace.graph import ALGEBRAIC, LEAVES, NotCompilable, computed_from

CLEAR = 1e-6
"""Discriminants and divisors smaller than this, relative to their terms, are left to a full
solve."""
STRANGE = 1e-6
"""A rule with a larger residual, relative to its terms, is violated."""
RESERVE = 4.0
"""How many times the rounding of a rule may grow from the sample to another row."""
ENOUGH = 0.1
"""Share of the terms of a rule by which alone its check is tried first."""


class Pattern(NamedTuple):
    """The fixed part of a question: varying inputs, values of the others, wanted variables."""

    inputs: tuple[str, ...]
    given: Values
    want: tuple[str, ...]
    guesses: Mapping[str, float]


@dataclass
class State:
    """The nodes of the known variables, and the conditions under which they count.

    ``settled`` are the rules that hold because an unknown was computed from them, ``compensated``
    those for which its rounding was corrected, ``used`` the conditions that activated the rules
    that were solved.
    """

    values: dict[str, int]
    symbols: dict[str, str]
    decided: dict[int, bool]
    settled: set[int] = field(default_factory=set)
    compensated: set[int] = field(default_factory=set)
    used: set[int] = field(default_factory=set)
    checks: list[int] = field(default_factory=list)

    def fork(self) -> State:
        return State(*(part.copy() for part in vars(self).values()))


LARGEST = 1e300


class Guards:
    """A graph in progress, of one model for one pattern, with the decisions of ``sample``."""

    def __init__(self, model: Model, pattern: Pattern, sample: Values) -> None:
        self.model, self.pattern, self.sample = model, pattern, sample
        self.graph = planner(model).graph
        self.flow = Flow()
        self.given = frozenset((*pattern.given, *pattern.inputs))
        values = (sample[name] for name in pattern.inputs)
        self._numbers = Numbers(
            self.flow, {k: v for k, v in enumerate(values) if isinstance(v, float)}
        )
        self.flow.at = self._numbers
        self.wrapped = set[int]()
        """Angles within one turn by the way they are computed."""
        self._beyond = dict[int, int]()
        """For a condition that a number is within a bound: that it is beyond it."""

    def _on(self, state: State) -> State:
        """Let requirements from here on belong to this state."""
        self.flow.checks = state.checks
        return state

    def _expression(self, state: State, expression: Expression) -> int:
        try:
            return self.flow.expression(expression, state.values)
        except KeyError:
            raise NotCompilable from None

    # --- conditions ---

    def _require(self, condition: int, outcome: bool) -> None:
        self.flow.require(condition if outcome else self.flow.add("not", condition))

    def _condition(
        self, state: State, condition: nodes.Condition, missing: bool | None = None
    ) -> int | None:
        """The node of a condition; None if a variable is missing.

        With ``missing``, unknown terms are left out if the others decide that outcome.
        """
        match condition:
            case Comparison(operator, left, right):
                used = {*nodes.names(left, right)}
                if not all(name in state.values or name in state.symbols for name in used):
                    return None
                one, other = (symbol_of(side, state.symbols) for side in (left, right))
                if (one, other) != (None, None):
                    return self.flow.constant(
                        (one == other) is (operator == "=") and operator in ("=", "<>")
                    )
                sides = [self._expression(state, side) for side in (left, right)]
                # decimals may decide between numbers that are no values of transcendental functions
                made = {self.flow.nodes[node][0] for node in computed_from(self.flow, sides)}
                error = None
                if not LEAVES.issuperset(made) and ALGEBRAIC.issuperset(made):
                    error = 4.0 * max(map(self._numbers.error, sides))
                return self.flow.compare(operator, sides[0], sides[1], error)
            case And(terms) | Or(terms):
                join = "and" if isinstance(condition, And) else "or"
                found = [self._condition(state, term) for term in terms]
                known = [node for node in found if node is not None]
                if len(known) < len(found) and (
                    missing is None or missing is (join == "and") or not known
                ):
                    return None
                return self.flow.over(join, known)
            case Not(term):
                inside = self._condition(state, term)
                return None if inside is None else self.flow.add("not", inside)
            case Given(name):
                return self.flow.constant(name in self.given)
        raise NotCompilable

    def _active(self, state: State, guard: Sequence[Premise]) -> int | None:
        """The node of a guard; None if it is not known."""
        nodes = list[int]()
        for premise in guard:
            node = self._condition(state, self.model.conditions[premise.condition])
            if node is None:
                return None
            nodes.append(node if premise.holds else self.flow.add("not", node))
        return self.flow.over("and", nodes)

    # --- ranges ---

    def _in_range(self, variable: Variable, node: int) -> int:
        """Whether a number lies in a declared range, and not only by rounding."""
        return self.flow.over("and", self._ends(variable, node))

    def _ends(self, variable: Variable, node: int) -> list[int]:
        return [
            self._inside(node, variable.low, variable.low_open),
            self._inside(node, variable.high, variable.high_open, upper=True),
        ]

    def _inside(self, node: int, edge: float, strict: bool, upper: bool = False) -> int:
        """Whether a number lies above a lower bound, or below an ``upper`` one, by more than its
        rounding at the sample."""
        if math.isinf(edge):
            return self.flow.true
        add, error = self.flow.add, 4.0 * self._numbers.error(node)
        less, more = add("sub", node, error), add("add", node, error)
        within, beyond = ((more, edge), (edge, less)) if upper else ((edge, less), (more, edge))
        check = add("lt" if strict else "le", *within)
        self._beyond[check] = add("lt", *beyond)
        return check

    # --- rules ---

    def _check_rules(self, state: State) -> None:
        """Require every rule, except those that hold because an unknown was computed from them."""
        for equation in self.model.equations:
            known = all(name in state.values or name in state.symbols for name in equation.names)
            if not known or activity(equation, state.decided) is False:
                continue
            if self._is_lost_in_rounding(state, equation):
                if equation.index in state.settled:
                    raise NotCompilable
                state.compensated.add(equation.index)
            if equation.index in state.settled:
                for clear in self._clear_of_edges(state, equation):
                    self.flow.require(clear)
                continue
            active = self._active(state, equation.guard)
            if active is None or active == self.flow.false:
                continue
            check = self._check_rule(state, equation)
            with self.flow.only_if(active):
                self.flow.require(check)

    def _is_lost_in_rounding(self, state: State, equation: Equation) -> bool:
        """Whether floats cannot tell if a rule holds: a solve has more digits, a record has not."""
        if equation.index in state.compensated or not state.values.keys() >= set(equation.names):
            return False
        values = {name: float(self._numbers(state.values[name])) for name in equation.names}
        return RESERVE * noise(equation, [values]) > LIBRARY

    def _check_rule(self, state: State, equation: Equation) -> int:
        """Whether an equation holds: |F| ≤ 64 eps · Σ|∂F/∂v · v|, including hidden rounding.

        Next to the pole of a logarithm, where its argument is lost in rounding, both are compared
        without it.
        """
        flow = self.flow
        symbols = [symbol_of(side, state.symbols) for side in equation.sides]
        if symbols != [None, None]:
            return flow.constant(symbols[0] == symbols[1])
        checks = flow.checks.copy()
        met = self._balanced(state, equation, *equation.sides)
        if not all(map(self._numbers, (*flow.checks[len(checks) :], met))):
            form = equation.form
            if (other := without_logarithm(form)) is not form:
                flow.checks[:] = checks
                return self._balanced(state, equation, other, ZERO)
        return met

    def _balanced(
        self, state: State, equation: Equation, left: Expression, right: Expression
    ) -> int:
        """Whether the two sides of an equation are equal up to rounding."""
        flow = self.flow
        flow.reported = True
        try:
            miss = self._miss(state, equation, left, right)
            if flow.value_of(miss) == 0.0:
                return flow.true
            size, quick = self._sizes(state, equation, subtract(left, right))
            for clear in self._clear_of_edges(state, equation):
                flow.require(clear)
        finally:
            flow.reported = False
        met = flow.within(miss, BACKWARD, size)
        if quick in (size, flow.constant(0.0)):
            flow.bound(size)
            return met
        whole = flow.add("and", flow.add("lt", size, LARGEST), met)
        if not ENOUGH * self._numbers(size) <= self._numbers(quick):
            return whole
        flow.bound(quick)  # terms that are there already may be enough
        return flow.node("sooner", flow.within(miss, BACKWARD, quick), whole)

    def _miss(self, state: State, equation: Equation, left: Expression, right: Expression) -> int:
        """The difference of two sides of an equation, without its own rounding if that was
        corrected."""
        if equation.index in state.compensated:
            return residual(self.flow, subtract(left, right), state.values)
        return self.flow.add("sub", *(self._expression(state, side) for side in (left, right)))

    def _broken(self, state: State, equation: Equation) -> int:
        """Whether an equation is missed by far."""
        flow = self.flow
        sides = [self._expression(state, side) for side in equation.sides]
        miss, form = flow.add("sub", *sides), equation.form
        flow.bound(miss)
        return flow.beyond(miss, STRANGE, self._sizes(state, equation, form)[0])

    def _sizes(self, state: State, equation: Equation, form: Expression) -> tuple[int, int]:
        """Σ|∂F/∂v · v| over all variables, and over those whose slope is a number."""
        flow = self.flow
        terms, quick = list[int](), list[int]()
        for name in equation.names:
            slope, term = self._term(state, form, name)
            if math.isnan(self._numbers(slope)):  # by the whole exponent of a negative base
                continue
            terms.append(term)
            if flow.value_of(slope) is not None:
                quick.append(term)
        return flow.over("add", terms), flow.over("add", quick)

    def _term(self, state: State, form: Expression, name: str) -> tuple[int, int]:
        """∂F/∂v and |∂F/∂v · v|."""
        slope = self._slope(state, form, name)
        return slope, self.flow.add("abs", self.flow.add("mul", slope, state.values[name]))

    def _slope(self, state: State, form: Expression, name: str) -> int:
        return self._expression(state, differentiate(form, name))

    def _clear_of_edges(self, state: State, equation: Equation) -> Iterator[int]:
        """Whether no function jumps close to the computed values: slopes are useless there."""
        flow = self.flow
        for function, height in heights(equation) if jumps(equation) else ():
            if (
                isinstance(height, nodes.Name)
                and flow.nodes[state.values[height.name]][0] in LEAVES
            ):
                continue  # a given number is exact
            at = self._expression(state, height)
            apart = at if function in ("sgn", "step") else flow.add("sub", at, flow.add("rint", at))
            if function == "round":
                apart = flow.add("sub", flow.add("abs", apart), 0.5)
            terms = [
                self._term(state, height, name)[1] for name in dict.fromkeys(nodes.names(height))
            ]
            yield flow.beyond(apart, 2.0 * BACKWARD, flow.over("add", terms))

    # --- requirements ---

    def _requirement(self, state: State, requirement: Requirement) -> tuple[int, int]:
        """Whether a requirement applies, and whether it is met. One with unknown values is skipped;
        next to its boundary a full solve decides."""
        flow = self.flow
        if not all(name in state.values for name in requirement.names):
            if all(name in state.values or name in state.symbols for name in requirement.names):
                raise NotCompilable
            return flow.false, flow.true
        active = self._active(state, requirement.guard)
        if active is None or active == flow.false:
            return flow.false, flow.true
        comparison = requirement.comparison
        one, other = (self._expression(state, side) for side in (comparison.left, comparison.right))
        meets = flow.compare(comparison.operator, one, other)
        with flow.only_if(active):
            flow.require(flow.add("not", flow.compare("=", one, other)))
        return active, meets
