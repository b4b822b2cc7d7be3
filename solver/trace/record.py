"""The record of a solve: for each answer its steps, as one straight-line program with guards.

The conditions that were decided or assumed, the ends of domains and every rule guard the results:
if one of them fails, the next record, or a full solve, decides. The same holds if a branch without
an answer may come to one, and if a block is ill-conditioned.

A refusal is a record of a row without an answer: every row that comes to the same step by the same
decisions and asks for the same impossible value, clearly, is infeasible as well.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import Any

from rulesheets.evaluate import Undefined, holds
from rulesheets.functions import TABLE, named
from rulesheets.model import Equation, Row, Value, Variable
from rulesheets.syntax.nodes import Comparison, Or, Quotient, names, walk
from solver.accuracy.rule_check import check_rule
from solver.facts import (
    Conflict,
    DoubleRoot,
    Fact,
    Indeterminacy,
    NoRoot,
    NoValue,
    OutOfRange,
    Unmet,
)
from solver.kernel.block import kernel_of
from solver.leaves import Leaf, different
from solver.path import Isolation, SolveBlock, activity, known_rules
from solver.path.cases import MEANING
from solver.ranking.ranking import Ranking
from solver.trace.flow import Numbers
from solver.trace.folds import NO_CASE
from solver.trace.graph import NotCompilable, computed_from, copied, vanishes
from solver.trace.guards import State
from solver.trace.newton import BlockNewton
from solver.trace.order import Order, Ranked
from solver.trace.order import order as order_of
from solver.trace.program import Ending, Program, simplified
from solver.trace.python import compile_scalar
from solver.trace.steps import BEYOND, MATCHES, REMOTE, ROUNDINGS, StepRecording

BESIDE = 1e-3, -7e-4
"""How far from the sample answers must be the same that are so at it, relative to its numbers."""
LEAP = 1e12
"""How many times the result of its sample the result of another row may be."""
MAX_DEAD = 8
"""The most branches without an answer that a record watches."""
_DIRECTIONS = named(lambda row: row.angle) | {"direction", "directiond"}
_BOUNDED = frozenset({"sind", "cosd", "sin", "cos", "lt", "le", "finite"})


class Recording(StepRecording):
    """The program of answers, or of a refusal, from a step recording of their leaves."""

    def __init__(self, *asked: Any) -> None:
        super().__init__(*asked)
        self.endings: list[Ending] = []
        self._watches = set[int]()
        """Those guards that only show that a branch outside its case still is."""

    def run(self, refused: Sequence[Leaf], ranking: Ranking) -> Program:
        """The program of the answers, put in their order by the ``ranking``; ``refused`` are
        branches that contradict a rule at the sample, or come to a step without a value."""
        start, symbols = self._start()
        states = [self._followed(start, leaf) for leaf in self.leaves]
        places = self._different()
        self.endings = [self.endings[place] for place in places]
        states = [states[place] for place in places]
        facts = [self.leaves[place].branch.facts for place in places]
        double = [any(isinstance(fact, DoubleRoot) for fact in some) for some in facts]
        cases = [{}, *(leaf.branch.signs for leaf in self.leaves)]
        for leaf in refused[:MAX_DEAD]:
            if _begins(leaf):
                raise NotCompilable
            try:
                self._watch(start, leaf)
            except (NotCompilable, KeyError):
                # at other rows it may have an answer, but hardly one of an equality
                other = leaf.branch.signs not in cases or any(map(_is_sided, leaf.branch.reasons))
                if other and not leaf.branch.on_boundary:
                    raise NotCompilable from None
        self._keep_usual()
        ranked = None
        if len(states) > 1 or self._watches:
            answers = tuple(tuple(map(state.values.get, ranking.read)) for state in states)
            ranked = Ranked(ranking, answers, tuple(map(states[0].values.get, ranking.known)))
        endings = tuple(Ending(results, (*holds, *self._guards)) for results, holds in self.endings)
        watches = frozenset(self._watches)
        alone = endings[0].without(watches)
        iterated = len(self._iterates((alone,))) < len(self._iterates(endings))
        order = Order()
        if ranked and len(states) > 1:
            order = order_of(self.flow, ranked, self._numbers, not iterated, double)
        program = Program(
            self.flow, len(self.pattern.inputs), endings, symbols, order, watches=watches
        )
        if any(double):  # the ranking alone does not tell which is the first
            return simplified(program)
        brief = None
        if order.first:
            brief = simplified(
                program._replace(endings=endings[:1], order=Order(usual=order.first))
            )
        return simplified(program)._replace(brief=brief, ranked=ranked if iterated else None)

    def _different(self) -> list[int]:
        """The places of the answers whose wanted values differ, also near the sample."""
        rows = [
            [n if isinstance(n, str) else self._numbers(n) for n in e.results] for e in self.endings
        ]
        several, places = list(range(len(rows))), different(rows)
        if len(places) == len(rows):
            return several
        tagged = tuple(
            Ending((*ending.results, self.flow.constant(float(place))), ())
            for place, ending in enumerate(self.endings)
        )
        every = compile_scalar(
            Program(self.flow, len(self.pattern.inputs), tagged), all_answers=True
        )
        for share in BESIDE:
            sample = (self.sample[name] for name in self.pattern.inputs)
            numbers = (v if isinstance(v, str) else v + share * (abs(v) or 1.0) for v in sample)
            found: list[Row] | None = every(*numbers)
            if found is None or different([row[:-1] for row in found]) != places:
                return several
        return places

    def _iterates(self, endings: Sequence[Ending]) -> set[int]:
        """The blocks that are iterated in answers."""
        read = computed_from(self.flow, Program(self.flow, 0, tuple(endings)).wanted)
        return {node for node in read if self.flow.nodes[node][0] == "root"}

    def _start(self) -> tuple[State, tuple[tuple[int, str], ...]]:
        """The given values, and the symbols among them, by their places."""
        flow, values, symbols = self.flow, dict[str, int](), dict[str, str]()
        for name, known in self.pattern.given.items():
            if isinstance(known, str):
                symbols[name] = known
            else:
                values[name] = flow.constant(known)
        told: list[tuple[int, str]] = []
        for place, name in enumerate(self.pattern.inputs):
            if isinstance(said := self.sample[name], str):
                symbols[name] = said
                told.append((place, said))
            else:
                values[name] = flow.input(place)
        state = self._on(State(values, symbols, {}))
        for name in self.pattern.inputs:
            if name in values:
                flow.bound(values[name])  # a missing one comes out on some side of every comparison
                flow.require(self._in_range(self.model.variables[name], values[name]))
        return state, tuple(told)

    def _followed(self, start: State, leaf: Leaf) -> State:
        state = self._steps(start.fork(), leaf)
        for requirement in self.model.requirements:
            active, meets = self._requirement(state, requirement)
            with self.flow.only_if(active):
                self.flow.require(meets)
        for name, variable in self.model.variables.items():
            self._turned(state, name, variable)
        self._check_rules(state)
        self._expect_rules(state)
        results = tuple(self._result(state, name) for name in self.pattern.want)
        for node in results:
            if isinstance(node, int):
                self._keep_size(node)
        self.endings.append(Ending(results, tuple(state.checks)))
        return state

    def _keep_size(self, node: int) -> None:
        """Require a result not to be far larger than at the sample if it may be so by rounding
        alone: a tangent beside its pole, as ``tan(acos(x))`` at 0."""
        self.flow.bound(node)
        size = LEAP * abs(self._numbers(node))
        if size and any("tan" in self.flow.nodes[one] for one in computed_from(self.flow, [node])):
            self.flow.require(self.flow.add("lt", -size, node))
            self.flow.require(self.flow.add("lt", node, size))

    def _expect_rules(self, state: State) -> None:
        """Raises NotCompilable if the numbers of the record break a rule at the sample or slightly
        beside it, to any digits: the floats that they are computed in may be too few."""
        for share in (0.0, *BESIDE):
            moved = {k: (1.0 + share) * v for k, v in self._numbers.inputs.items()}
            numbers = Numbers(self.flow, moved) if share else self._numbers
            if share and not all(map(numbers, state.checks)):
                continue
            found = {name: numbers(node) for name, node in state.values.items()}
            values: dict[str, Value] = {**found, **state.symbols}
            for rule in known_rules(self.model, self.branch.conditions, values):
                if not check_rule(rule, values).holds:
                    raise NotCompilable

    def _turned(self, state: State, name: str, variable: Variable) -> None:
        """Require an angle to stay within the turn of the answer. A case may override this."""
        flow, turn, node = self.flow, self.graph.single_turn(name), state.values.get(name)
        bounded = variable.low > -math.inf or variable.high < math.inf
        if node is None or turn is None or bounded or not variable.posted or name in self.given:
            return
        kind = flow.nodes[node]
        told = node in self.wrapped or flow.value_of(node) is not None
        if told or str(kind[kind[0] == "call"]) in _DIRECTIONS:
            return
        middle = turn * math.ceil(self._numbers(node) / turn - 0.5)
        flow.require(flow.add("lt", middle - turn / 2, node))
        flow.require(flow.add("le", node, middle + turn / 2))

    def _result(self, state: State, name: str) -> int | str:
        """Answers that differ only in other names have the same wanted values, to the last bit."""
        if name in state.symbols:
            return state.symbols[name]
        if name not in state.values and name in self.poles:
            return self.flow.constant(math.nan)
        if name not in state.values:
            raise NotCompilable
        flow, found, want = self.flow, state.values[name], self.pattern.want
        mine = [self.sample.get(one) for one in want]
        before = zip(self.leaves, self.endings, strict=False)
        same = (e for leaf, e in before if [leaf.branch.values.get(one) for one in want] == mine)
        if (twin := next(same, None)) is None:
            return found
        other = twin.results[want.index(name)]
        if isinstance(other, str):
            raise NotCompilable
        flow.require(flow.within(flow.add("sub", found, other), MATCHES, flow.add("abs", other)))
        return other

    # --- branches without an answer ---

    def refused(self) -> Program:
        """The program whose one ending holds if a row is refused as this one was.

        Raises NotCompilable if more than one step without a value was the reason for a leaf, or if
        known numbers may decide which cases are possible.
        """
        start, symbols = self._start()
        for leaf in self.leaves:
            branch = leaf.branch
            known = [e for e in self.model.equations if branch.values.keys() >= set(e.names)]
            active = [e.index for e in known if activity(e, branch.conditions)]
            if branch.inactive and not branch.checked.issuperset(active):
                raise NotCompilable
            if len(branch.signs) > 1 and any(
                all(any(names(side)) for side in pair) for pair in branch.signs
            ):
                raise NotCompilable
            self._watch(start, leaf, len(branch.reasons))
        if any(isinstance(finder, BlockNewton) for finder in self.flow.finders):
            raise NotCompilable  # of the roots of a block it follows those that the sample has
        self._keep_usual(zeros=False)  # at 0 rules may be read again, without a factor
        return Program(
            self.flow, len(self.pattern.inputs), (Ending((), tuple(self._guards)),), symbols
        )

    def _watch(self, start: State, leaf: Leaf, stops: int = 1) -> None:
        """Require that a branch without an answer still has none, for the first reason that is
        known to hold; or, where it came to ``stops`` steps without a value, for all of these.

        Raises NotCompilable if there is none.
        """
        for reason in (self._rootless, self._contradicted, partial(self._stopped, stops=stops)):
            with suppress(NotCompilable, KeyError, Undefined):
                reason(start, leaf)
                return
        raise NotCompilable

    def _rootless(self, start: State, leaf: Leaf) -> None:
        """A block of the branch has roots outside the case alone."""
        for place, step in enumerate(leaf.branch.steps if leaf.branch.signs else ()):
            if (
                not isinstance(step, SolveBlock)
                or (kernel := kernel_of(self.graph, step)).closed is not None
            ):
                continue
            branch = leaf.branch.fork()
            branch.steps, branch.inactive = branch.steps[:place], {}
            state = self._steps(start.fork(), replace(leaf, branch=branch), within=False)
            if (case := self._case(state, kernel)).excludes(branch.values):
                self._use(state, step.equations)
                self._hold(state, sorted(state.used - state.decided.keys()))
                if not all(map(self._numbers, state.checks)):
                    break
                self._keep_roots(state, kernel, (case,), proved=True)
                self._guard(*state.checks)
                return
        raise NotCompilable

    def _contradicted(self, start: State, leaf: Leaf) -> None:
        """The values of a branch contradict its case, or a rule."""
        state, flow = self._steps(start.fork(), leaf, within=bool(leaf.conflicts)), self.flow
        broken = flow.false
        for pair, sign in leaf.branch.signs.items():
            comparisons = (Comparison(operator, *pair) for operator in (MEANING[sign], "="))
            inside = self._condition(state, Or(tuple(comparisons)))
            if inside is not None:
                broken = flow.add("or", broken, flow.add("not", inside))
        for fact in leaf.conflicts:
            if isinstance(fact, Unmet):
                active, meets = self._requirement(state, self.model.requirements[fact.requirement])
                broken = flow.add("or", broken, flow.add("and", active, flow.add("not", meets)))
            elif isinstance(fact, Conflict):  # of several rules each excludes a case
                rules = (self.model.equations[index] for index in fact.equations)
                every = flow.over("and", (self._broken(state, rule) for rule in rules))
                broken = flow.add("or", broken, every)
            elif isinstance(fact, Indeterminacy):  # its rule divides by 0, whatever the inputs are
                parts = walk(*self.model.equations[fact.equation].sides)
                divisors = (part.right for part in parts if isinstance(part, Quotient))
                if any(vanishes(flow, self._expression(state, part)) for part in divisors):
                    broken = flow.true
        if not all(map(self._numbers, (*state.checks, broken))):
            raise NotCompilable
        known = {*self._guards, *(check for _, holds in self.endings for check in holds)}
        self._guard(*state.checks, broken)
        self._watches |= set() if leaf.conflicts else self._guards.keys() - known

    def _stopped(self, start: State, leaf: Leaf, stops: int) -> None:
        """The branch came to a step without a value, or to several."""
        branch = leaf.branch.fork()
        if not branch.inactive:
            raise NotCompilable
        branch.inactive = {}
        state = self._on(self._steps(start.fork(), replace(leaf, branch=branch), within=False))
        impossible = [self._impossible(state, why, leaf) for why in leaf.branch.reasons[:stops]]
        self._hold(state, sorted(state.used - state.decided.keys()))
        if not all(map(self._numbers, (*state.checks, *impossible))):
            raise NotCompilable
        self._guard(*state.checks, *impossible)

    def _keep_usual(self, zeros: bool = True) -> None:
        """Require inputs of ordinary size, whose products do not over- or underflow, or 0."""
        flow = self.flow
        wanted = *Program(flow, 0, tuple(self.endings)).wanted, *self._guards
        odd = {
            operand
            for node in computed_from(flow, wanted)
            if flow.nodes[node][0] not in _BOUNDED
            for operand in flow.operands[node]
        }
        checks = []
        for place in self._numbers.inputs:
            node = flow.input(place)
            if node in odd:
                size = flow.add("abs", node)
                ends = flow.add("le", 1.0 / REMOTE, size), flow.add("le", size, REMOTE)
                usual = flow.add("and", *ends)
                zero = flow.is_zero(node)
                checks.append(
                    flow.add("or", usual, zero) if zeros or self._numbers(zero) else usual
                )
        if not all(self._numbers(check) for check in checks):
            raise NotCompilable
        self._guard(*checks)

    # --- steps without a value ---

    def _impossible(self, state: State, fact: Fact, leaf: Leaf) -> int:
        match fact:
            case NoValue(equation, unknown, _, False):
                self._use(state, (equation,))
                if self._is_fixed(state, fact):
                    return self.flow.true
                return self._no_value(state, equation, unknown)
            case NoRoot(equations, unknowns, True):
                self._use(state, equations)
                steps = (step for step in leaf.branch.attempts if step.equations == equations)
                step = next(steps, None) or SolveBlock(equations, unknowns, ())
                before = state.checks.copy()
                try:
                    return self.flow.over("and", self._every_out(state, step))
                except NotCompilable:
                    state.checks[:] = before
                    kernel = kernel_of(self.graph, step)
                    self._keep_roots(
                        self._on(state), kernel, (self._case(state, kernel), NO_CASE), proved=True
                    )
                    return self.flow.true
            case OutOfRange(equation, unknown):
                for step in leaf.branch.attempts:
                    if equation in step.equations:
                        return self._block_stays_out(state, step)
                self._use(state, (equation,))
                return self._out_of_range(state, equation, unknown)
        raise NotCompilable

    def _no_value(self, state: State, equation: int, unknown: str) -> int:
        """A target clearly outside of the image of the operation that is undone; or what this leads
        to clearly breaks the rule."""
        isolation = self._isolation(equation, unknown)
        self._expect_known(state, equation, unknown)
        before = state.checks.copy()
        with suppress(NotCompilable):
            return self._outside_image(state, equation, isolation)
        state.checks[:] = before
        rule = self.model.equations[equation]
        return self.flow.over(
            "and",
            [
                self._refuted(replace(state, values={**state.values, unknown: node}), rule)
                for node in self._preimages(state, isolation)
            ],
        )

    def _refuted(self, state: State, rule: Equation) -> int:
        """The condition that a rule has no value, or is clearly broken."""
        before = state.checks.copy()
        broken = self._broken(state, rule)
        if all(map(self._numbers, (broken, *state.checks[len(before) :]))):
            return broken
        state.checks[:] = before
        return self._undefined(self._miss(state, rule, *rule.sides))

    def _outside_image(self, state: State, equation: int, isolation: Isolation) -> int:
        if isolation.quadratic is not None:
            before = state.checks.copy()
            root = self._preimages(state, isolation)[0]
            state.checks[:] = before
            return self._undefined(root)
        target = self._expression(state, isolation.start)
        for stage in isolation.stages:
            if stage.low > -math.inf or stage.high < math.inf:
                margin = self._margin(state, equation, target)
                outside = self._outside(
                    target, max(stage.low, -1e300), min(stage.high, 1e300), margin
                )
                if self._numbers(outside) is True:
                    return outside
            target, *others = self._undone(state, stage, target)
            if others:  # a root has two signs, if any
                break
        negative = self._undefined(target)
        state.checks[:] = [  # nothing is asked of what has no value
            check
            for check in state.checks
            if not any(map(math.isnan, map(self._numbers, computed_from(self.flow, [check]))))
        ]
        return negative

    def _outside(self, node: int, low: float, high: float, margin: int) -> int:
        """The condition that a number lies outside a range by more than the margin."""
        flow = self.flow
        below = flow.add("lt", flow.add("add", node, margin), float(low))
        return flow.add("or", below, flow.add("lt", flow.add("add", float(high), margin), node))

    def _undefined(self, target: int) -> int:
        """The condition that an operation has no value: its argument is outside its domain."""
        flow = self.flow
        for node in computed_from(flow, [target]):
            match flow.nodes[node]:
                case ("pow" | "sqrt", argument, *_):
                    low, high = 0.0, math.inf
                case ("call", function, argument):
                    low, high = TABLE[str(function)].domain
                case _:
                    continue
            margin = flow.constant(ROUNDINGS * self._numbers.error(int(argument)))
            ends = max(low, -1e300), min(high, 1e300)
            outside = self._outside(int(argument), *ends, margin)
            if math.isnan(self._numbers(node)) and self._numbers(outside) is True:
                return outside
        raise NotCompilable

    def _expect_known(self, state: State, equation: int, unknown: str) -> None:
        """Raises NotCompilable for a rule of a block, which has unknowns that are not known yet."""
        known = state.values.keys() | state.symbols.keys() | {unknown}
        if not known >= set(self.model.equations[equation].names):
            raise NotCompilable

    def _margin(self, state: State, equation: int, node: int) -> int:
        """The distance by which a number must lie outside: its change, to first order, if every
        input changes by ``BEYOND`` of itself. After an iterated block it is relative to the squares
        of the rule's numbers, or 1."""
        flow, read = self.flow, computed_from(self.flow, [node])
        if any(flow.nodes[one][0] == "root" for one in read):
            numbers = map(state.values.get, self.model.equations[equation].names)
            squares = (flow.add("mul", node, node) for node in numbers if node is not None)
            return flow.add("mul", BEYOND, flow.add("add", 1.0, flow.over("add", squares)))
        total = flow.constant(ROUNDINGS * self._numbers.error(node))
        inputs = list(map(flow.input, range(len(self.pattern.inputs))))
        for place, number in enumerate(inputs):
            if number in read:
                moved = flow.add("mul", 1.0 + BEYOND, number)
                (there,) = copied(
                    flow, flow, [node], [*inputs[:place], moved, *inputs[place + 1 :]]
                )
                total = flow.add("add", total, flow.add("abs", flow.add("sub", there, node)))
        return total

    def _out_of_range(self, state: State, equation: int, unknown: str) -> int:
        """Every value is clearly beyond an end of the range."""
        variable = self.model.variables[unknown]
        isolation = self._isolation(equation, unknown)
        self._expect_known(state, equation, unknown)
        form = isolation.quadratic
        found = self._roots_of(state, form) if form else self._preimages(state, isolation)
        return self.flow.over(
            "and", [self._is_outside(state, equation, variable, node) for node in found]
        )

    def _is_outside(self, state: State, equation: int, variable: Variable, node: int) -> int:
        """Whether a number is beyond an end of a range, by a margin unless it is the same in every
        row."""
        number = 0.0 if vanishes(self.flow, node) else self.flow.value_of(node)
        if number is not None:
            return self.flow.constant(not variable.admits(float(number)))
        margin = self._margin(state, equation, node)
        return self._outside(node, variable.low, variable.high, margin)

    def _block_stays_out(self, state: State, step: SolveBlock) -> int:
        """Every candidate of a block stays refused, by its checks or its ranges."""
        self._use(state, step.equations)
        asked = len(state.checks)
        for one, found in self._candidates(state, step):
            self._on(state)
            conditions = [*one.checks[asked:], *self._in_ranges(found)]
            if all(map(self._numbers, conditions)):
                raise NotCompilable
            self._stays_out(conditions)
        return self.flow.true

    def _every_out(self, state: State, step: SolveBlock) -> Iterator[int]:
        """For each candidate the first check that failed at the sample and clearly fails."""
        asked = len(state.checks)
        for one, _ in self._candidates(state, step):
            self._on(state)
            checks = one.checks[asked:]
            place = next(
                (k for k, c in enumerate(checks) if self._numbers(c) is False), len(checks)
            )
            for check in checks[:place]:
                self.flow.require(check)
            yield self._failing(*checks[place : place + 1])

    def _failing(self, *checks: int) -> int:
        """The condition that a number is negative by more than rounding."""
        flow = self.flow
        for kind, *parts in (flow.nodes[check] for check in checks):
            if kind == "le" and flow.value_of(int(parts[0])) == 0.0:
                return flow.add("not", checks[0])
            if kind == "lt":
                less = flow.add("lt", int(parts[1]), flow.add("neg", int(parts[0])))
                if self._numbers(less) is True:
                    return less
        raise NotCompilable


def _is_sided(fact: Fact) -> bool:
    """Whether a step has a value on the other side of some end."""
    return isinstance(fact, OutOfRange) or (isinstance(fact, NoValue) and not fact.pole)


def _begins(leaf: Leaf) -> bool:
    """Whether a branch without an answer lies on the boundary of its case, beside which it may have
    one: nothing else refuses it."""
    if leaf.conflicts or leaf.missing or leaf.branch.inactive or leaf.branch.on_boundary:
        return False
    with suppress(KeyError, Undefined):
        pairs = (Comparison("=", *pair) for pair in leaf.branch.signs)
        return any(holds(pair, leaf.branch.values) for pair in pairs)
    return False
