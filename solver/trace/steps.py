"""The steps of a branch as operations, with the requirements under which they count.

A direct step is recorded as the inverse that was taken, rules that exclude each other as a
selection, a block as its closed form or else as Newton's method from the answer.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from functools import cached_property
from itertools import compress
from typing import TypeAlias

from rulesheets.model import Equation, Model
from solver.facts import Beside, DoubleRoot, NoValue
from solver.kernel.block import BlockKernel, kernel_of
from solver.leaves import Leaf
from solver.path import Decide, Evaluate, Select, SolveBlock, Step, activity
from solver.path.cases import EQUAL, value_of_equality
from solver.trace.compensated import NOISY, noise, residual
from solver.trace.flow import Numbers
from solver.trace.folds import NO_CASE, Case, ConstantRootCount, case_of
from solver.trace.graph import NotCompilable, vanishes
from solver.trace.guards import Pattern, State
from solver.trace.inverses import Candidate, Inverses
from solver.trace.newton import BlockNewton, eliminate

MATCHES = 1e-6
"""The relative distance of a number of the record from the answer it was made from."""
APART = 1e-6
"""The least relative distance of two answers of a block."""
REMOTE = 1e60
"""Records are not valid for larger numbers, or for smaller ones than 1 over it: products
overflow."""
BEYOND = 1e-6
"""How far outside of an image, relative to the numbers around, a target is refused without a second
look."""
VARIED, FAR = 6, 1e3
"""How many inputs of a record are varied to see where its rules may be noisy, and how far."""
ROUNDINGS = 2.0**10
"""The least distance outside a range, in multiples of the rounding at the sample."""


Proof: TypeAlias = tuple[tuple[object, ...], ConstantRootCount]
"""Of a block, and the known numbers that do not vary, where its roots neither appear nor vanish."""


class StepRecording(Inverses):
    """Follows the steps of branches as they were taken, those of ``leaves`` first.

    ``corrects``: unknowns are corrected by rules whose residual is too large. ``proofs``: those of
    other records, to which new ones are added. Raises NotCompilable if a step has no record.
    """

    def __init__(
        self,
        model: Model,
        pattern: Pattern,
        leaves: Sequence[Leaf],
        corrects: bool,
        proofs: list[Proof],
    ) -> None:
        super().__init__(model, pattern, leaves[0].branch.values)
        self.leaves, self.branch, self.corrects = leaves, leaves[0].branch, corrects
        self._guards = dict[int, None]()
        """Requirements common to all answers."""
        self._blocks: dict[tuple[object, ...], tuple[BlockNewton, list[int]]] = {}
        self._proofs = proofs

    def _guard(self, *checks: int) -> None:
        """Require more of the record."""
        self._guards.update(dict.fromkeys(node for node in checks if node != self.flow.true))

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
            if not (isinstance(fact, NoValue) and fact.pole and self._is_fixed(state, fact)):
                raise NotCompilable
            self.poles.add(fact.unknown)
        self._settle(state)
        return state

    def _is_fixed(self, state: State, fact: NoValue) -> bool:
        """Whether a step without a value reads only numbers that are the same in every row."""
        others = (n for n in self.model.equations[fact.equation].names if n != fact.unknown)
        nodes = [state.values.get(name) for name in others]
        return all(node is not None and self.flow.value_of(node) is not None for node in nodes)

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
                    found = self._values(fork, equation, unknown)
                    fork = self._taken(fork, unknown, self._compensated(fork, step, found))
                case Select(unknown=unknown):
                    fork = self._taken(fork, unknown, [self._selected(fork, step)])
                case SolveBlock():
                    self._use(fork, step.equations)
                    fork = self._take(fork, self._candidates(fork, step))
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
                or rule.index in state.settled | state.compensated
                or not activity(rule, self.branch.conditions)
            ):
                continue
            holds = self._numbers(self._check_rule(self._on(state.fork()), rule))
            self._on(state)
            if holds is not False:
                continue
            form = rule.form
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

    def _compensated(
        self, state: State, step: Evaluate, found: Sequence[int | str]
    ) -> Sequence[int | str]:
        """The values of a direct step, each corrected by its rule if that admits less than its own
        rounding: ``R/(R + h)`` is near 1, where the arc cosine is steep."""
        return [
            node
            if isinstance(node, str)
            else self._corrected(state, (step.equation,), {step.unknown: node}, everywhere=True)[0]
            for node in found
        ]

    def _corrected(
        self, state: State, equations: Sequence[int], found: Mapping[str, int], everywhere: bool
    ) -> list[int]:
        """Unknowns after a step of Newton's method with compensated residuals, if one of the rules
        that they were solved from admits less than its own rounding: ``(1 + i)^360`` has lost some
        digits of i."""
        there = State({**state.values, **found}, state.symbols, {})
        rules = [self.model.equations[index] for index in equations]
        if all(self._noise(there, rule, everywhere) <= NOISY for rule in rules):
            return [*found.values()]
        flow, misses, slopes = self.flow, list[int](), dict[tuple[int, int], int]()
        for row, rule in enumerate(rules):
            form = rule.form
            misses.append(residual(flow, form, there.values))
            for column, name in enumerate(found):
                if name in rule.names:
                    slopes[row, column] = self._slope(there, form, name)
        numbers = {place: float(self._numbers(node)) for place, node in slopes.items()}
        sizes = [abs(float(self._numbers(node))) or 1.0 for node in found.values()]
        moves = eliminate(flow, slopes, numbers, sizes).solve(misses)
        state.compensated.update(equations)
        return [flow.raw("sub", node, d) for node, d in zip(found.values(), moves, strict=True)]

    def _noise(self, state: State, rule: Equation, everywhere: bool) -> float:
        """The rounding of a rule as a share of what its check admits: at the sample, or the largest
        also ``everywhere`` one input is much smaller or larger."""
        if not state.values.keys() >= set(rule.names):
            return 0.0
        values = {name: state.values[name] for name in rule.names}
        numbers = (self._numbers, *(self._elsewhere if everywhere else ()))
        return noise(rule, [{n: float(at(node)) for n, node in values.items()} for at in numbers])

    @cached_property
    def _elsewhere(self) -> list[Numbers]:
        """The numbers of the record where one of its first inputs is much smaller or larger."""
        inputs = self._numbers.inputs
        return [
            Numbers(self.flow, {**inputs, place: factor * inputs[place]})
            for place in list(inputs)[:VARIED]
            for factor in (1.0 / FAR, FAR)
        ]

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
        before = state.fork()
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
                    miss = self._expression(state, rule.form)
                    if not vanishes(self.flow, miss):
                        raise NotCompilable
                case [name]:
                    state = self._taken(state, name, self._values(state, index, name))
                case _:
                    raise NotCompilable
        self._keep_others(before, step, state)
        if any(self._numbers(check) is False for check in state.checks[len(before.checks) :]):
            raise NotCompilable
        return state

    def _keep_others(self, state: State, step: SolveBlock, taken: State) -> None:
        """Require of a block from ``state`` that it keeps the ``taken`` root, and that no other one
        appears: the checks of its closed form, or that its roots keep their number."""
        kernel = kernel_of(self.graph, step)
        if kernel.closed is None:
            self._keep_roots(state, kernel, (self._case(state, kernel), NO_CASE))
            return
        candidates = self._candidates(state, step)
        self._on(taken)
        for one, found in candidates:
            own = one.checks[len(state.checks) :]
            if self._are_sampled(found):
                for check in own:
                    self.flow.require(check)
            else:
                self._stays_out([*own, *self._in_ranges(found)])

    def _use(self, state: State, equations: Iterable[int]) -> None:
        """Require that these rules, active at the sample, are active."""
        for equation in equations:
            state.used.update(premise.condition for premise in self.model.equations[equation].guard)

    # --- selection of a value ---

    def _taken(self, state: State, unknown: str, found: Iterable[int | str]) -> State:
        return self._take(state, [(state, {unknown: node}) for node in found])

    def _take(self, state: State, candidates: Sequence[Candidate]) -> State:
        """The candidate that is the answer, with its state; require that the others stay refused,
        by what theirs ask beyond ``state`` or by the ranges of their values."""
        answers = (candidate for candidate in candidates if self._are_sampled(candidate[1]))
        if (answer := next(answers, None)) is None:
            raise NotCompilable
        asked, (taken, found) = len(state.checks), answer
        self._on(taken)
        for name, node in found.items():
            if isinstance(node, str):
                taken.symbols[name] = node
            else:
                taken.values[name] = node
        for condition in self._in_ranges(found):
            self.flow.require(condition)
        for one, others in candidates:
            if others != found:
                self._stays_out([*one.checks[asked:], *self._in_ranges(others)])
        return taken

    def _in_ranges(self, found: Mapping[str, int | str]) -> list[int]:
        """Whether numbers lie in the ranges of their variables."""
        numbers = [(name, node) for name, node in found.items() if isinstance(node, int)]
        return [end for n, node in numbers for end in self._ends(self.model.variables[n], node)]

    def _stays_out(self, conditions: Sequence[int]) -> None:
        """Require that conditions of which one fails at the sample continue to fail, and by more
        than rounding."""
        failing = (node for node in conditions if self._numbers(node) is False)
        node = next(failing, None)
        if node is not None:
            beyond = self._beyond.get(node)
            self.flow.require(self.flow.add("not", node) if beyond is None else beyond)

    def _are_sampled(self, found: Mapping[str, int | str]) -> bool:
        return all(self._is_sampled(node, name) for name, node in found.items())

    def _is_sampled(self, node: int | str, name: str) -> bool:
        if (wanted := self.sample.get(name)) is None:
            return False
        if isinstance(wanted, str) or isinstance(node, str):
            return node == wanted
        apart = abs(float(self._numbers(node)) - wanted)
        turn = self.graph.turn(name)
        if turn is not None:
            apart = min(apart, abs(apart - turn))
        if apart <= MATCHES * max(abs(wanted), 1e-3 if turn is not None else 0.0):
            return True
        return name not in self.pattern.want and apart <= self._numbers.error(node)

    def _settle(self, state: State) -> None:
        """Angles in the turn of the answer."""
        for name, node in state.values.items():
            wanted, turn = self.sample[name], self.graph.turn(name)
            if turn is None or name in self.given or isinstance(wanted, str):
                continue
            if abs(float(self._numbers(node)) - wanted) > turn / 2:
                state.values[name] = self._wrapped(node, turn)

    # --- blocks without a form ---

    def _case(self, state: State, kernel: BlockKernel) -> Case:
        """The case that is assumed in a block."""
        return case_of(kernel, self.branch.signs, state.values.keys())

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
        found = dict(zip(step.unknowns, items, strict=True))
        roots = self._corrected(state, step.equations, found, everywhere=False)
        for name, node in zip(step.unknowns, roots, strict=True):
            variable, turn = self.model.variables[name], self.graph.turn(name)
            free = variable.low == -math.inf and variable.high == math.inf
            # an angle in the turn around 0, unless the answer has it elsewhere
            if turn is not None and free and abs(float(self._numbers(node))) <= 0.5 * turn:
                node = self._wrapped(node, turn)
            state.values[name] = node
            flow.require(self._in_range(variable, node))
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
                # the changes of numbers that make no difference to a solve
                errors = map(self._numbers.error, places if proved else ())
                pairs = zip(sample, errors, strict=False)
                margins = [BEYOND * abs(v) + ROUNDINGS * off for v, off in pairs]
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

    def _floats(self, names: Sequence[str], usual: bool = True) -> list[float]:
        """Numbers of the sample. Raises NotCompilable if one is missing, or not of ``usual``
        size."""
        values = [self.sample.get(name) for name in names]
        numbers = [value for value in values if isinstance(value, float)]
        odd = usual and not all(v == 0.0 or 1.0 / REMOTE <= abs(v) <= REMOTE for v in numbers)
        if odd or len(numbers) < len(values):
            raise NotCompilable
        return numbers

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
