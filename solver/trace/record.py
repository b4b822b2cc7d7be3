"""The record of a solve: for each answer its steps, as one straight-line program with guards.

A direct step is recorded as the inverse that was taken, rules that exclude each other as a
selection, a block as its closed form or else as Newton's method from the answer. The conditions
that were decided or assumed, the ends of domains and every rule guard the results: if one of them
fails, the next record, or a full solve, decides. The same holds if a branch without an answer may
come to one, and if a block is ill-conditioned.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import compress
from typing import TypeAlias

from rulesheets.evaluate import Undefined
from rulesheets.functions import named
from rulesheets.model import Model, Value, Variable
from rulesheets.syntax.nodes import Comparison, Or, subtract
from solver.facts import Beside, Conflict, DoubleRoot, NoValue, Unmet
from solver.kernel.block import BlockKernel, kernel_of
from solver.leaves import Leaf, different
from solver.path import Decide, Evaluate, Select, SolveBlock, Step, activity
from solver.path.cases import EQUAL, MEANING, value_of_equality
from solver.path.planner import Planner
from solver.ranking.ranking import Ranking
from solver.trace.folds import NO_CASE, Case, ConstantRootCount, case_of
from solver.trace.graph import Graph, NotCompilable, computed_from, operands
from solver.trace.guards import Pattern, State
from solver.trace.inverses import Inverses
from solver.trace.newton import BlockNewton
from solver.trace.order import Order, Ranked
from solver.trace.order import order as order_of
from solver.trace.program import Ending, Program, simplified
from solver.trace.python import compile_scalar

MATCHES = 1e-6
"""The relative distance of a number of the record from the answer it was made from."""
APART = 1e-6
"""The least relative distance of two answers of a block."""
BESIDE = 1e-3, -7e-4
"""How far from the sample answers must be the same that are so at it, relative to its numbers."""
REMOTE = 1e60
"""Records are not valid for larger numbers, or for smaller ones than 1 over it: products
overflow."""
MAX_DEAD = 8
"""The most branches without an answer that a record watches."""
BEYOND = 1e-6
"""How far outside of an image, relative to the numbers around, a target is refused without a second
look."""
ROUNDINGS = 2.0**10
"""The least distance outside a range, in multiples of the rounding at the sample."""
_DIRECTIONS = named(lambda row: row.angle) | {"direction", "directiond"}
_BOUNDED = frozenset({"sind", "cosd", "sin", "cos", "lt", "le", "finite"})


Proof: TypeAlias = tuple[tuple[object, ...], ConstantRootCount]
"""Of a block, and the known numbers that do not vary, where its roots neither appear nor vanish."""


class Recording(Inverses):
    """Follows the steps of each of the answers ``leaves`` as they were taken.

    ``corrects``: unknowns are corrected by rules whose residual is too large. ``proofs``: those of
    other records, to which new ones are added. Raises NotCompilable if a step has no record.
    """

    def __init__(
        self,
        model: Model,
        planner: Planner,
        pattern: Pattern,
        leaves: Sequence[Leaf],
        corrects: bool = False,
        proofs: list[Proof] | None = None,
    ) -> None:
        super().__init__(model, planner, pattern, leaves[0].branch.values)
        self.leaves, self.branch, self.corrects = leaves, leaves[0].branch, corrects
        self.endings: list[Ending] = []
        self._guards = dict[int, None]()
        """Requirements common to all answers."""
        self._watches = set[int]()
        """Those that only show that a branch outside its case still is."""
        self._blocks: dict[tuple[object, ...], tuple[BlockNewton, list[int]]] = {}
        self._proofs: list[Proof] = [] if proofs is None else proofs

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
        for leaf in refused[:MAX_DEAD]:
            with suppress(NotCompilable, KeyError):
                self._watch(start, leaf)
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
            found: list[tuple[Value, ...]] | None = every(*numbers)
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
        results = tuple(self._result(state, name) for name in self.pattern.want)
        for node in results:
            if isinstance(node, int):
                self.flow.bound(node)
        self.endings.append(Ending(results, tuple(state.checks)))
        return state

    def _steps(self, state: State, leaf: Leaf, within: bool = True) -> State:
        """The values that the steps of a leaf have computed, and their conditions: those that it
        assumed if it is ``within`` its case."""
        self.branch, self.sample, self.poles = leaf.branch, leaf.branch.values, set[str]()
        if not all(isinstance(fact, Beside | DoubleRoot) for fact in self.branch.facts):
            raise NotCompilable
        state.decided = dict(self.branch.assumed)
        for pair, sign in self.branch.signs.items():
            if sign == EQUAL and (said := value_of_equality(pair)) is not None:
                name, value = said
                if isinstance(value, str):
                    state.symbols.setdefault(name, value)
                else:
                    state.values.setdefault(name, self.flow.constant(value))
        self._on(state)
        self._hold(state, self.branch.conditions.keys() - state.decided.keys())
        for step in self.branch.steps:
            before = frozenset(state.values)
            state = self._step(state, step)
            if self._is_delicate:
                self._correct(state, frozenset(state.values) - before)
        self._on(state)
        doubles = (fact.unknowns for fact in self.branch.facts if isinstance(fact, DoubleRoot))
        moving = (state.values.get(name, self.flow.true) for names in doubles for name in names)
        if any(self.flow.value_of(node) != 0.0 for node in moving):
            raise NotCompilable  # two answers separate in nearby rows, or end
        assumed = self.branch.assumed if within else ()
        self._hold(state, (*assumed, *sorted(state.used - state.decided.keys())))
        for fact in self.branch.inactive.values():
            # A case of fixed numbers alone has no value: those are the same in every row.
            if not isinstance(fact, NoValue) or not fact.pole:
                raise NotCompilable
            others = (n for n in self.model.equations[fact.equation].names if n != fact.unknown)
            nodes = [state.values.get(name) for name in others]
            if any(node is None or self.flow.value_of(node) is None for node in nodes):
                raise NotCompilable
            self.poles.add(fact.unknown)
        self._settle(state)
        return state

    def _hold(self, state: State, conditions: Iterable[int]) -> None:
        """Require the outcomes of the sample, for conditions that are known, or decided by known
        ones."""
        for index in conditions:
            outcome, condition = self.branch.conditions.get(index), self.model.conditions[index]
            node = None if outcome is None else self._condition(state, condition, outcome)
            if node is not None and self._numbers(node) is not outcome:
                node = self._condition(state, condition)
            if node is not None and outcome is not None:
                state.decided[index] = outcome
                self._require(node, outcome)

    def _step(self, state: State, step: Step) -> State:
        if isinstance(step, SolveBlock) and any(
            self.sample.get(name) == 0.0 for name in step.unknowns
        ):
            with suppress(NotCompilable):
                return self._vanishing(state.fork(), step)
        if isinstance(step, SolveBlock) and self._is_delicate:
            with suppress(NotCompilable):
                return self._iterated(state.fork(), step)  # formulas lose digits that the solve has
        try:
            fork = self._on(state.fork())
            match step:
                case Evaluate(equation=equation, unknown=unknown):
                    self._use(fork, (equation,))
                    fork = self._taken(fork, unknown, self._values(fork, equation, unknown))
                case Select(unknown=unknown):
                    fork = self._taken(fork, unknown, [self._selected(fork, step)])
                case SolveBlock():
                    fork = self._solved(fork, step)
                case Decide(conditions=conditions):
                    self._hold(self._on(state), set(conditions) - state.decided.keys())
                    return state
            if any(self._numbers(check) is False for check in fork.checks[len(state.checks) :]):
                raise NotCompilable  # so near to a fold the formula would lose too many digits
        except NotCompilable:
            return self._otherwise(state, step)
        return fork

    @property
    def _is_delicate(self) -> bool:
        """Whether the solve took more digits than floats have, or a record by formulas did not
        hold."""
        return self.corrects or bool(self.branch.precise)

    def _correct(self, state: State, new: frozenset[str]) -> None:
        """A rule other than the one that a new unknown was solved from may determine its last
        places better: as the remainder of terms that cancel."""
        flow, values = self.flow, state.values
        for rule in self.model.equations:
            known = not new.isdisjoint(rule.names) and values.keys() >= set(rule.names)
            if (
                not known
                or rule.index in state.settled
                or not activity(rule, self.branch.conditions)
            ):
                continue
            holds = self._numbers(self._check_rule(self._on(state.fork()), rule))
            self._on(state)
            if holds is not False:
                continue
            form = subtract(rule.left, rule.right)
            slopes = {n: self._slope(state, form, n) for n in rule.names if n in new}
            name = max(
                slopes, key=lambda n: abs(self._numbers(flow.add("mul", slopes[n], values[n])))
            )
            step = flow.add("div", self._expression(state, form), slopes[name])
            limit = flow.add("mul", MATCHES, flow.add("abs", values[name]))
            limit = flow.add("add", limit, 10.0 * self._numbers.error(values[name]))
            flow.require(flow.add("le", flow.add("abs", step), limit))
            values[name] = flow.add("sub", values[name], step)
            state.settled -= {e.index for e in self.model.equations if name in e.names}

    def _otherwise(self, state: State, step: Step) -> State:
        """A selection by the rule that was active, and Newton's method for a step without a
        form."""
        match step:
            case Select(equations=equations, unknown=unknown):
                active = (
                    e
                    for e in equations
                    if activity(self.model.equations[e], self.branch.conditions)
                )
                return self._step(state, Evaluate(next(active), unknown))
            case Evaluate(equation=equation, unknown=unknown):
                step = SolveBlock((equation,), (unknown,), (unknown,), residuals=(equation,))
                return self._iterated(state, step)
            case SolveBlock():
                return self._iterated(state, step)
            case _:
                raise NotCompilable

    def _vanishing(self, state: State, step: SolveBlock) -> State:
        """Unknowns of a block that are 0 for any known numbers, and the others from them."""
        self._use(self._on(state), step.equations)
        zeros = [name for name in step.unknowns if self.sample.get(name) == 0.0]
        state.values |= dict.fromkeys(zeros, self.flow.constant(0.0))
        left = list(step.equations)
        while left:
            unknown = {
                index: set(self.model.equations[index].names) - state.values.keys()
                for index in left
            }
            index = min(left, key=lambda one: len(unknown[one]))
            left.remove(index)
            match [*unknown[index]]:
                case []:
                    rule = self.model.equations[index]
                    miss = self._expression(state, subtract(rule.left, rule.right))
                    if not _is_zero(self.flow, miss):
                        raise NotCompilable
                case [name]:
                    state = self._taken(state, name, self._values(state, index, name))
                case _:
                    raise NotCompilable
        return state

    def _use(self, state: State, equations: Iterable[int]) -> None:
        """Require that these rules, active at the sample, are active."""
        for equation in equations:
            state.used.update(premise.condition for premise in self.model.equations[equation].guard)

    # --- selection of a value ---

    def _taken(self, state: State, unknown: str, found: Sequence[int | str]) -> State:
        """The value of the answer; require that values out of range stay there."""
        taken = next((node for node in found if self._is_sampled(node, unknown)), None)
        if taken is None:
            raise NotCompilable
        if isinstance(taken, str):
            state.symbols[unknown] = taken
            return state
        variable = self.model.variables[unknown]
        state.values[unknown] = taken
        self.flow.require(self._in_range(variable, taken))
        for node in found:
            if node != taken and isinstance(node, int):
                self._stays_out([self._in_range(variable, node)])
        return state

    def _solved(self, state: State, step: SolveBlock) -> State:
        """The candidate that is the answer; require that refused ones stay refused."""
        self._use(state, step.equations)
        candidates = self._candidates(state, step)
        taken, generators = next(
            (one, generators)
            for one, generators in (*candidates, (None, None))
            if generators is None
            or all(self._is_sampled(generators[name], name) for name in step.unknowns)
        )
        if taken is None or generators is None:
            raise NotCompilable
        self._on(taken)
        for name in step.unknowns:
            taken.values[name] = generators[name]
            self.flow.require(self._in_range(self.model.variables[name], generators[name]))
        for one, others in candidates:
            if one is not taken:
                ranges = [
                    self._in_range(self.model.variables[name], others[name])
                    for name in step.unknowns
                ]
                self._stays_out([*one.checks[len(state.checks) :], *ranges])
        return taken

    def _stays_out(self, conditions: Sequence[int]) -> None:
        """Require that conditions of which one fails at the sample continue to fail."""
        failing = (node for node in conditions if self._numbers(node) is False)
        node = next(failing, None)
        if node is not None:
            self.flow.require(self.flow.add("not", node))

    def _is_sampled(self, node: int | str, name: str) -> bool:
        wanted = self.sample[name]
        if isinstance(wanted, str) or isinstance(node, str):
            return node == wanted
        apart = abs(float(self._numbers(node)) - wanted)
        turn = self.graph.turn(name)
        if turn is not None:
            apart = min(apart, abs(apart - turn))
        if apart <= MATCHES * max(abs(wanted), 1e-3 if turn is not None else 0.0):
            return True
        return name not in self.pattern.want and apart <= self._numbers.error(node)

    # --- the end ---

    def _settle(self, state: State) -> None:
        """Angles in the turn of the answer."""
        for name, node in state.values.items():
            wanted, turn = self.sample[name], self.graph.turn(name)
            if turn is None or name in self.given or isinstance(wanted, str):
                continue
            if abs(float(self._numbers(node)) - wanted) > turn / 2:
                state.values[name] = self._wrapped(node, turn)

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

    def _guard(self, *checks: int) -> None:
        """Require more of the record."""
        self._guards.update(dict.fromkeys(node for node in checks if node != self.flow.true))

    def _watch(self, start: State, leaf: Leaf) -> None:
        """Require that a branch without an answer still has none, for the first reason that is
        known to hold.

        Raises NotCompilable if there is none.
        """
        for reason in self._reasons:
            with suppress(NotCompilable, KeyError, Undefined):
                reason(start, leaf)
                return
        raise NotCompilable

    @property
    def _reasons(self) -> tuple[Callable[[State, Leaf], None], ...]:
        return self._rootless, self._contradicted

    def _case(self, state: State, kernel: BlockKernel) -> Case:
        """The case that is assumed in a block."""
        return case_of(kernel, self.branch.signs, state.values.keys())

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
            elif isinstance(fact, Conflict) and len(fact.equations) == 1:
                broken = flow.add(
                    "or", broken, self._broken(state, self.model.equations[fact.equations[0]])
                )
        if not all(map(self._numbers, (*state.checks, broken))):
            raise NotCompilable
        known = {*self._guards, *(check for _, holds in self.endings for check in holds)}
        self._guard(*state.checks, broken)
        self._watches |= set() if leaf.conflicts else self._guards.keys() - known

    def _keep_usual(self) -> None:
        """Require inputs of ordinary size, whose products do not over- or underflow."""
        flow = self.flow
        wanted = *Program(flow, 0, tuple(self.endings)).wanted, *self._guards
        odd = {
            operand
            for node in computed_from(flow, wanted)
            if flow.nodes[node][0] not in _BOUNDED
            for operand in operands(flow, node)
        }
        checks = []
        for place in self._numbers.inputs:
            node = flow.input(place)
            if node in odd:
                size = flow.add("abs", node)
                ends = flow.add("le", 1.0 / REMOTE, size), flow.add("le", size, REMOTE)
                checks.append(flow.add("or", flow.add("and", *ends), flow.is_zero(node)))
        if not all(self._numbers(check) for check in checks):
            raise NotCompilable
        self._guard(*checks)

    # --- blocks without a form ---

    def _iterated(self, state: State, step: SolveBlock) -> State:
        """Newton's method from the recorded answer."""
        self._on(state)
        self._use(state, step.equations)
        flow, kernel = self.flow, kernel_of(self.graph, step)
        known = self._floats(kernel.known)
        start = self._floats(step.unknowns, usual=False)
        places = [state.values.get(name, -1) for name in kernel.known]
        if -1 in places:
            raise NotCompilable
        key = (step.equations, step.unknowns, tuple(start), *places)
        if key not in self._blocks:
            varying = [self.flow.value_of(place) is None for place in places]
            newton = BlockNewton(kernel, start, known, varying)
            flow.finders.append(newton)
            root = flow.node("root", len(flow.finders) - 1, *compress(places, varying))
            self._blocks[key] = (
                newton,
                [flow.node("item", k, root) for k in range(len(newton.start))],
            )
            self._keep_roots(state, kernel, (self._case(state, kernel), NO_CASE))
        newton, items = self._blocks[key]
        self._numbers.found.update(zip(items, newton.start, strict=True))
        self._distinct(key, places)
        for name, node in zip(step.unknowns, items, strict=True):
            state.values[name] = self._in_turn(name, node)
            flow.require(self._in_range(self.model.variables[name], state.values[name]))
        return state

    def _keep_roots(
        self, state: State, kernel: BlockKernel, cases: Iterable[Case], proved: bool = False
    ) -> None:
        """Require that a block has as many roots as at the sample, in the first of the cases for
        which that is proved for ranges of the known numbers. Raises NotCompilable for none; unless
        it has to be ``proved``, it is required without a case anyway."""
        for case in dict.fromkeys(cases):
            names = *kernel.known, *case.known
            if not state.values.keys() >= set(names):
                raise NotCompilable
            places = [state.values[name] for name in names]
            varying = [self.flow.value_of(place) is None for place in places]
            if not any(varying):
                return
            sample = [float(self._numbers(place)) for place in places]
            fixed = (None if varies else v for v, varies in zip(sample, varying, strict=True))
            about = (kernel.block.equations, kernel.unknowns, case, proved, *fixed)
            numbers = list(compress(sample, varying))
            found = next(
                (one for asked, one in self._proofs if asked == about and one(*numbers)), None
            )
            if found is None:
                margins = list(map(self._rounded, places)) if proved else ()
                found = ConstantRootCount(kernel, sample, varying, margins, case)
                self._proofs.append((about, found))
            if found.proved or not (case.limits or proved):
                finders = self.flow.finders
                if found not in finders:
                    finders.append(found)
                self._guard(
                    self.flow.node("unfolded", finders.index(found), *compress(places, varying))
                )
                return
        raise NotCompilable

    def _rounded(self, node: int) -> float:
        """The change of a number that makes no difference to a solve."""
        return BEYOND * abs(self._numbers(node)) + ROUNDINGS * self._numbers.error(node)

    def _floats(self, names: Sequence[str], usual: bool = True) -> list[float]:
        """Numbers of the sample. Raises NotCompilable if one is missing, or not of ``usual``
        size."""
        values = [self.sample.get(name) for name in names]
        numbers = [value for value in values if isinstance(value, float)]
        odd = usual and not all(v == 0.0 or 1.0 / REMOTE <= abs(v) <= REMOTE for v in numbers)
        if odd or len(numbers) < len(values):
            raise NotCompilable
        return numbers

    def _in_turn(self, name: str, node: int) -> int:
        """An angle without a range in the turn around 0, unless the answer has it elsewhere."""
        variable, turn = self.model.variables[name], self.graph.turn(name)
        if turn is None or variable.low > -math.inf or variable.high < math.inf:
            return node
        if abs(float(self._numbers(node))) > 0.5 * turn:
            return node
        return self._wrapped(node, turn)

    def _distinct(self, key: tuple[object, ...], places: list[int]) -> None:
        """Roots of one block at the same numbers must stay apart: no two branches may come to one
        root.

        This is required of the two unknowns that differ most at the sample.
        """
        flow, (newton, items) = self.flow, self._blocks[key]
        for other, (second, others) in self._blocks.items():
            if (
                other is key
                or other[0] != key[0]
                or other[1] != key[1]
                or list(other[3:]) != places
            ):
                continue
            if items == others:
                continue
            shares = [
                abs(a - b) / s
                for a, b, s in zip(newton.start, second.start, newton.scale, strict=True)
            ]
            most = sorted(range(len(items)), key=shares.__getitem__)[-2:]
            pairs = [(items[k], others[k]) for k in most]
            apart = (
                flow.beyond(flow.add("sub", a, b), APART, flow.add("abs", a)) for a, b in pairs
            )
            flow.require(flow.over("or", apart))


def _is_zero(flow: Graph, node: int) -> bool:
    """Whether a number is 0 for any inputs."""
    kind, *parts = flow.nodes[node]
    return flow.value_of(node) == 0.0 or (kind in ("neg", "div") and _is_zero(flow, int(parts[0])))
