"""Follow a path: from inputs to every answer, each one checked by the independent rule check."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from copy import copy
from dataclasses import replace
from functools import cached_property, partial
from itertools import chain, islice
from typing import TypeAlias

from rulesheets.deadline import TimeIsUp, expect_time, grace, in_one_chunk
from rulesheets.evaluate.number import rounded
from rulesheets.model import Row, Value, Values
from rulesheets.syntax.nodes import names
from solver.accuracy.rule_check import check_rule
from solver.accuracy.rule_sides import may_hold
from solver.facts import AsksNothing, Beside, Fact, NoRoot, NoValue, OutOfRange, RankLoss, about
from solver.kernel.block import DENSE, FEW, kernel_of
from solver.kernel.candidates import BlockOutcome
from solver.kernel.problem import PLAN, STEP, BlockProblem, uncertainty
from solver.kernel.solve_block import MAX_SEARCHED, SEARCHES, solve_block, solve_sparsely
from solver.kernel.step import StepOutcome, StepSolver
from solver.leaves import Asked, Branch, CutOff, Exploration, Leaf, indeterminacy, infinite, unmet
from solver.numerics.tolerances import CANCELLED, EPS, ROUNDED, SAFETY
from solver.path import (
    Assume,
    Check,
    Decide,
    Evaluate,
    Path,
    Select,
    SolveBlock,
    Step,
    activity,
    equations_of,
    given_by,
)
from solver.path.cases import EQUAL, Pair, Sign, comparisons
from solver.path.graph import Kind, continued, is_angle_sum, is_balance, kind_of, unknowns_by_kind
from solver.solution.ends import Ends, agreed

MANY_BLOCKS = 8
"""Blocks of a path from which on it is solved as one block where there are too many answers to
list."""
MAX_SEARCHES = 150
"""Searches of nonlinear blocks at other values, after the first search of each block."""
MAX_ASSUMPTIONS = 16
MAX_CASES, FEW_CASES, MAX_SETTLING = 100, 8, 30
"""Cases that are searched; up to which it does not matter which comes first; and the most that are
tried to find the first."""
GRACE = 1.0
"""Seconds to gather what was found when the time is up."""

Facts: TypeAlias = tuple[Fact, ...]
Forks: TypeAlias = Iterator[Branch]
Pending: TypeAlias = tuple[Branch, Sequence[Step] | None, int]
"""A branch, its remaining steps, and the first of them; without steps it is planned first."""


@in_one_chunk
def explore(
    asked: Asked,
    thorough: bool = False,
    brief: bool = False,
    enough: Callable[[Leaf], bool] | None = None,
    nearby: bool = False,
) -> Exploration:
    """Every answer for these inputs.

    ``thorough``: the work of proving that there are no others is not limited. ``brief``: the last
    resorts of a block are left out, and so are curves of answers if it has none. ``nearby``: in
    blocks, only what Newton's method leads to. ``enough``: the search ends at the first such
    answer. Raises CutOff at the time limit.
    """
    search = PathSearch(asked, enough)
    search.budget.thorough, search.budget.brief, search.budget.nearby = thorough, brief, nearby
    return search.run()


class PathSearch(Ends):
    """Follows every branch in floats; a subclass may solve the steps in another arithmetic."""

    def __init__(self, asked: Asked, enough: Callable[[Leaf], bool] | None = None) -> None:
        super().__init__(asked, enough)
        self.want = None if asked.want is None else frozenset(asked.want)
        self.guesses, self.careful = asked.guesses, False
        self._searched: set[SolveBlock] = set()
        self._sought = Counter[Kind]()  # blocks that were searched, by their kinds
        self.expected: Mapping[Pair, Sign] | None = None
        self._settling = False  # whether only the expected case of each comparison is followed
        self.first_path: Sequence[Step] | None = None
        self.forked, self.rounded = 1, False

    def run(self) -> Exploration:
        """All answers; if the preferred answers of blocks lead to none, those from the others.

        After a contradiction that rounding may explain, or where numbers on the way have lost too
        many digits, formulas are evaluated with care.
        """
        start = self._start()
        try:
            self._explore(start)
        except TimeIsUp:
            with grace(GRACE):
                raise CutOff(self._found(), start.values) from None
        # perhaps by cancelled digits alone
        doubtful = self.rounded or (self.delicate and self.contradicted)
        if doubtful and not self.careful:
            self.careful = True
            self._begin()
            return self.run()
        found = self._found()
        if (
            not self.budget.cut
            or self.budget.every
            or not all(leaf.missing for leaf in found.leaves)
        ):
            return found
        self.budget.every, self.outcomes = True, {}
        self._begin()
        return self.run()

    def _start(self) -> Branch:
        """The branch on which only the inputs are known."""
        start = Branch(dict(self.inputs), {})
        start.decided.update(self.analysis.outcomes(range(len(self.model.conditions)), start))
        return start

    # --- following a path ---

    def _explore(self, branch: Branch) -> None:
        """Follow a branch and its forks to their ends, depth first; a branch whose outcomes require
        it is planned again."""
        stack: list[tuple[Iterator[Pending], int]] = [(iter([(branch, None, 0)]), 1)]
        while stack:
            forks, answers = stack[-1]
            pending = next(forks, None)
            if pending is None:
                stack.pop()
                continue
            self.forked, (branch, steps, begin) = 1, pending
            found = True if steps is None else self._follow(branch, steps, begin)
            while found is True and not self._is_full(branch):
                self.budget.used += PLAN
                known, inactive = frozenset(branch.values), frozenset(branch.inactive)
                asked = known, branch.conditions, inactive, self._wanted(branch)
                path = self.planner.path(*asked, required=True)
                if self._leaves_free(branch, path):  # do other rules refute its case?
                    path = self.planner.path(*asked[:3], None, required=True)
                self.first_path = path.steps if self.first_path is None else self.first_path
                found = self._follow(branch, path.steps)
            forks = iter(()) if isinstance(found, bool) else found
            stack.append((forks, answers * self.forked))
            if answers * self.forked > self.most_leaves or self._too_many_searches:
                forked = answers * self.forked > 1 or not self.complete
                first = list(islice(forks, 1))
                one = self._as_one_block((*first, pending)[0][0].values, forked)
                stack[-1] = chain(first, forks), stack[-1][1]
                stack = stack if one is None else [(iter([(one, None, 0)]), 1)]

    def _wanted(self, branch: Branch) -> frozenset[str] | None:
        """What a branch has to reach: what is compared by the cases that it assumes, too, and all
        if it assumes an equality, which is one equation more than the question has."""
        if self.want is None or branch.on_boundary:
            return None
        return self.want.union(n for pair in branch.signs for n in names(*pair))

    def _leaves_free(self, branch: Branch, path: Path) -> bool:
        """Whether no rule determines a wanted name in the case that a branch assumes."""
        if self.want is None or not branch.signs or self.want.isdisjoint(path.undetermined):
            return False
        return not any(isinstance(step, Decide | Assume) for step in path.steps)

    @property
    def _too_many_searches(self) -> bool:
        """Whether the blocks of the first path of the kinds that were searched, one of them twice,
        have as many unknowns together as a large block; or as one too large for a search, if a
        first search proved nothing."""
        if not self.first_path or max(self._sought.values(), default=0) < 1 + self.complete:
            return False
        return sum(self._rows[kind] for kind in self._sought) > (DENSE if self.complete else FEW)

    @cached_property
    def _rows(self) -> Counter[Kind]:
        """The unknowns of the blocks of the first path, by their kinds."""
        return unknowns_by_kind(self.model, self.first_path or ())

    def _as_one_block(self, begun: Values, forked: bool) -> Branch | None:
        """The preferred answer of all steps of the first path, solved as one large block from the
        values at which its first steps have ``begun``.

        None for a model whose answers can be listed, for steps that are not those of a network of
        blocks, and if an unknown is negative though the path has ``forked``, so that others may be
        positive. A few of 2^100 answers are useless, and each block of such a path costs a search.
        If all of them are to be proven, each is searched.
        """
        steps, self.first_path = self.first_path or (), ()
        blocks = [place for place, step in enumerate(steps) if isinstance(step, SolveBlock)]
        cases = any(isinstance(step, Select | Assume) for step in steps)
        if len(blocks) < MANY_BLOCKS or cases or self.budget.thorough:
            return None
        branch, solved = self._start(), [one for one in steps[blocks[0] :] if given_by(one)]
        if self._follow(branch, steps[: blocks[0]], ends=False) is not True:
            return None
        equations = tuple(number for step in solved for number in equations_of(step))
        unknowns = tuple(name for step in solved for name in given_by(step))
        whole = SolveBlock(equations, unknowns, ())
        begun = continued(self.model, solved, begun)
        for guesses in ({**begun, **self.guesses}, self.guesses):
            kernel = kernel_of(self.graph, whole)
            found = solve_sparsely(kernel, branch.values, guesses, self.budget)
            values = next((a.values for a in found.answers if a.double is None), {})
            negative = any(v < 0.0 and self.graph.turn(n) is None for n, v in values.items())
            if values and not (forked and negative):
                break
        else:
            return None
        self.budget.cut = True
        self._begin()
        self.note(False, equations, unknowns, [values], False)
        for step in solved:
            if isinstance(step, SolveBlock):
                branch.attempts[step] = found.attempts
            self._learn(branch, step, {name: values[name] for name in given_by(step)})
        return branch

    def _follow(
        self, branch: Branch, steps: Sequence[Step], start: int = 0, ends: bool = True
    ) -> bool | Iterator[Pending]:
        """Run the steps from ``start``: True if the branch must be planned again, False if it
        ended, and its forks, each with its remaining steps, if it forked, or is to be solved as one
        block. With only a part of the steps it does not end after them."""
        for place in range(start, len(steps)):
            expect_time()
            if self.model.requirements and self._broken(branch):
                self._finish(branch)
                return False
            step = steps[place]
            again: bool | Forks | None
            match step:
                case Evaluate(equation=equation, unknown=unknown):
                    again = self._evaluate(branch, step, equation, unknown)
                case Select():
                    again = self._select(branch, step)
                case SolveBlock() if self._too_many_searches:
                    return iter([(branch, steps, place)])
                case SolveBlock():
                    again = self._block(branch, step)
                case Check(equation=equation):
                    again = self._check(branch, step, equation)
                case Decide(conditions=conditions):
                    branch.decided.update(self.analysis.outcomes(conditions, branch))
                    branch.steps.append(step)
                    return True
                case Assume():
                    return self._assume(branch, step)
            if isinstance(again, bool):
                return again
            if again is not None:
                return ((fork, steps, place + 1) for fork in again)
        if not ends:
            return True
        # blocks that determined too little, and of which more is known now, are solved again
        lost = {e: fact.free for e, fact in branch.inactive.items() if isinstance(fact, RankLoss)}
        more = [e for e, free in lost.items() if any(name in branch.values for name in free)]
        for number in more:
            del branch.inactive[number]
            branch.checked.discard(number)
        if not more:
            self._finish(branch)
        return bool(more)

    def _broken(self, branch: Branch) -> bool:
        """Whether known values violate a requirement, so that the branch leads to no answer. Whole
        turns of an angle are decided at its end."""
        broken = unmet(self.model, branch.values, branch.decided)
        asked = (self.model.requirements[fact.requirement].names for fact in broken)
        return any(all(self.graph.turn(name) is None for name in names) for names in asked)

    def _learn(self, branch: Branch, step: Step, found: Values) -> None:
        self.budget.used += STEP
        branch.values.update(found)
        branch.origins.update(dict.fromkeys(found, step))
        branch.steps.append(step)
        if not isinstance(step, Select):
            branch.checked.update(equations_of(step))

    def _evaluate(
        self, branch: Branch, step: Step, equation: int, unknown: str
    ) -> bool | Forks | None:
        """None: continue; True: plan again; False: ended; else the forks."""
        outcome, cut, turns = self._stepped(branch, equation, unknown), False, False
        if not outcome.complete or unknown in self.graph.weighed:
            isolation, _ = self.graph.isolated(equation, self.graph.number[unknown])
            cut = not outcome.complete and isolation is not None and isolation.proven
            turns = isolation is None or isolation.period is not None
        values = [self._unless_rounding(branch, equation, unknown, v) for v in outcome.values]
        listed = [{unknown: value} for value in values]
        self.note(outcome.complete, (equation,), (unknown,), listed, cut, turns)
        self.delicate |= outcome.delicate
        self.rounded |= outcome.rounded
        if outcome.fact is not None:
            if isinstance(outcome.fact, OutOfRange) and self._turns(equation):
                self.turned = True
            if isinstance(outcome.fact, AsksNothing):
                branch.inactive[equation] = outcome.fact
            else:
                return self._blank(branch, (unknown,), outcome.fact)
            return True
        double = () if outcome.double is None else (outcome.double,)
        return self._forks(branch, step, [(values, double) for values in listed])

    def _turns(self, equation: int) -> bool:
        """Whether a rule adds angles of which whole turns are free, so that it has other values."""
        rule, variables = self.model.equations[equation], self.model.variables
        free = (n for n in rule.names if n not in self.inputs and not variables[n].ranged)
        return is_angle_sum(*rule.sides) and any(map(self.graph.tied_turn, free))

    def _unless_rounding(self, branch: Branch, equation: int, unknown: str, number: Value) -> Value:
        """The number; 0 if it is a sum of computed numbers that leaves no more than their last
        places, as the flow through a shut valve, which balances others."""
        rule = self.model.equations[equation]
        if isinstance(number, str) or not is_balance(rule):
            return number
        others = {n: branch.values.get(n) for n in rule.names if n != unknown}
        largest = max((abs(v) for v in others.values() if isinstance(v, float)), default=0.0)
        if abs(number) > ROUNDED * largest:
            return number
        meant = others.keys() <= self.inputs.keys() or not self.model.variables[unknown].admits(0.0)
        return number if meant else 0.0

    def _stepped(self, branch: Branch, equation: int, unknown: str) -> StepOutcome:
        guess = self.guesses.get(unknown)
        asked = self.graph, equation, unknown, branch.values, guess, self.careful
        return StepSolver(*asked, branch.origins).outcome()

    def _forks(
        self, branch: Branch, step: Step, found: Sequence[tuple[Values, Facts]]
    ) -> Forks | None:
        """Continue with the only value (None), or with a fork for each."""

        def each() -> Forks:  # made after those before it have been followed to their ends
            for values, facts in found:
                if self._is_full(branch):
                    break
                fork = branch.fork()
                fork.facts = (*fork.facts, *facts)
                self._learn(fork, step, values)
                yield fork

        if len(found) != 1:
            self.forked = len(found)
            return each()
        ((values, facts),) = found
        branch.facts = (*branch.facts, *facts)
        self._learn(branch, step, values)
        return None

    def _select(self, branch: Branch, step: Select) -> bool | Forks | None:
        equations = self.model.equations
        for equation in step.equations:
            guard = [premise.condition for premise in equations[equation].guard]
            waiting = [condition for condition in guard if condition not in branch.decided]
            branch.decided.update(self.analysis.outcomes(waiting, branch))
            if activity(equations[equation], branch.conditions):
                return self._evaluate(branch, step, equation, step.unknown)
        return True

    def _check(self, branch: Branch, step: Step, equation: int) -> bool | None:
        if equation in branch.checked:
            return None
        branch.checked.add(equation)
        branch.steps.append(step)
        check = check_rule(self.model.equations[equation], branch.values)
        if check.holds or agreed(self.graph, branch, equation, self.inputs):
            return None
        self.delicate |= check.delicate
        self._finish(branch)
        return False

    def _block(self, branch: Branch, step: SolveBlock) -> bool | Forks | None:
        outcome = self._solved(step, branch)
        listed = [answer.values for answer in outcome.answers]
        unknowns = tuple(dict.fromkeys((*kernel_of(self.graph, step).repeating, *step.unknowns)))
        self.note(outcome.complete, step.equations, unknowns, listed, outcome.cut)
        self.delicate |= outcome.delicate
        branch.attempts[step] = outcome.attempts
        if outcome.free:
            lost = next(fact for fact in outcome.facts if isinstance(fact, RankLoss))
            # Without a rule that follows from the others, these may determine more with other
            # rules; where they determine something now, its rounding may make them contradict one
            # another.
            determined = outcome.answers[0].values
            spare = lost.dependent if lost.everywhere and not determined else ()
            branch.inactive.update(dict.fromkeys(spare or step.equations, lost))
            self._learn(branch, step, determined)
            return True
        if not outcome.answers:
            return self._blank(branch, step.unknowns, outcome.facts[-1])
        beside = tuple(fact for fact in outcome.facts if isinstance(fact, Beside))
        found: list[tuple[Values, Facts]] = [
            (
                self._without_rounding(branch, step, answer.values),
                beside if answer.double is None else (*beside, answer.double),
            )
            for answer in outcome.answers
        ]
        return self._forks(branch, step, found)

    def _without_rounding(self, branch: Branch, step: SolveBlock, found: Values) -> Values:
        """An answer of a block with 0 for what is no larger than its error, and with the decimals
        that it stands for: other rules may have no value beside these."""
        kernel, own = kernel_of(self.graph, step), frozenset(step.equations)
        numbers = {name: float(found[name]) for name in kernel.unknowns}
        size = CANCELLED * max(map(abs, numbers.values()), default=0.0)
        tiny = any(0.0 < abs(v) <= size for v in numbers.values())
        is_read = not all(own.issuperset(self.graph.users[name]) for name in step.unknowns)
        if not (tiny or is_read):
            return found
        problem = BlockProblem(kernel, branch.values, self.guesses)
        if tiny:
            errors = zip(numbers.items(), uncertainty(problem, numbers, EPS).errors, strict=True)
            zeros = {n: 0.0 for (n, v), e in errors if abs(v) <= min(size, SAFETY * e)}
            cleared = {**numbers, **zeros}
            if problem.outside(cleared) is None and problem.holds(cleared):
                found = {**found, **zeros}
        short = {name: rounded(float(v), 12) for name, v in found.items()}
        values = {**branch.values, **found}
        if not (is_read and all(may_hold(rule, values, short) for rule in kernel.equations)):
            return found
        if short == found or problem.outside(short) or not problem.holds(short):
            return found
        from solver.kernel.written import WrittenNumbers  # most values are no decimals

        written = WrittenNumbers(self.graph, {**branch.values, **short}, branch.origins)
        return {**short} if written.satisfy(step) else found

    def _solved(self, step: SolveBlock, branch: Branch, before: Row | None = None) -> BlockOutcome:
        """The outcome of a block, which is searched at most once for the same known numbers, or for
        those ``before``."""
        kernel, values, assumed = kernel_of(self.graph, step), branch.values, bool(branch.signs)
        known = {name: values[name] for name in kernel.known}
        fits = partial(self._fits, branch, known) if assumed or self.model.requirements else None
        key = step, before or tuple(known.values())
        if key not in self.outcomes:
            again = len(self.outcomes) - len(self._searched)
            if step in self._searched and again >= MAX_SEARCHES and not kernel.linear:
                return BlockOutcome(facts=(NoRoot(step.equations, step.unknowns, proven=False),))
            first = step not in self._searched
            self.budget.begin_block(self.complete, assumed or not first)
            self._searched.add(step)
            self.outcomes[key] = solve_block(
                kernel, values, self.guesses, self.budget, partial(self._off, branch), fits, assumed
            )
            if first and any(attempt.method in SEARCHES for attempt in self.outcomes[key].attempts):
                self._sought[kind_of(self.model, step)] += 1
        outcome: BlockOutcome = self.outcomes[key]
        return outcome

    def _fits(self, branch: Branch, known: Values, found: Mapping[str, float]) -> bool:
        """Whether values of a block meet the requirements on it, and lie in the case that its
        branch assumes."""
        if self._broken(replace(branch, values={**self.inputs, **known, **found})):
            return False
        there = replace(branch, values={**branch.values, **found})
        return not (branch.signs and self.analysis.contradicted(there))

    def _blank(self, branch: Branch, unknowns: Sequence[str], fact: Fact) -> bool:
        """No value of these satisfies the known rules: they stay blank, and rules with them are
        idle. Whether the branch goes on: where answers alone are looked for, it does not without
        what is asked for.

        If a rule is 0/0, that does not exclude a value.
        """
        branch.blank.update(unknowns)
        asked = (name for name in unknowns if name in self.judged)
        if self.enough and any(not self.model.variables[name].passed for name in asked):
            self.leaves.append(Leaf(branch, tuple(unknowns), (), 0.0, 0))
            return False
        failing = about(fact) if isinstance(fact, NoValue | NoRoot) else ()
        told = (indeterminacy(self.model.equations[e], branch.values) for e in failing)
        why = next(filter(None, told), fact)
        for name in unknowns:
            for equation in self.graph.users[name]:
                branch.inactive.setdefault(equation, why)
        return True

    # --- case by case ---

    def _assume(self, branch: Branch, step: Assume) -> bool:
        """The cases of one comparison; each is dropped once its outcome is known to be another."""
        if not self._stays_in_case(branch):
            return False
        self.analysis.infer(branch)
        pair = self.analysis.open_pair(branch, step.condition)
        if pair is None:
            return True
        blank = (name for name in self.judged if name in branch.blank)
        if not all(infinite(self.model, branch, name) for name in blank):
            self._finish(branch)
            return False
        self.cases += 1
        if len(branch.signs) >= MAX_ASSUMPTIONS or self.cases > MAX_CASES:
            self._truncate(branch, "cases")
            self._finish(branch)
            return False
        if self.expected is None and not branch.signs:
            self.expected = self._settled(branch, step)
        before = len(self.open_cases)
        for sign in self._as_expected(pair):
            if sign == EQUAL and self._underdetermined_since(before):
                self.complete = False
                continue
            case = self.analysis.assumed(branch, pair, sign)
            if case is not None and (away := self._away(case)) <= 1:
                case.steps.append(step)
                with self._nearby(away):
                    self._explore(case)
            if self._settling:
                return False
        if self._underdetermined_since(before):
            self._finish(branch, underdetermined=True)
        return False

    def _as_expected(self, pair: Pair) -> Sequence[Sign]:
        """The cases of a pair, the expected one first."""
        expected = (self.expected or {}).get(pair)
        return sorted(self.analysis.cases(pair), key=lambda sign: sign != expected)

    def _away(self, case: Branch) -> int:
        """In how many comparisons a case differs from that of an answer of a network, whose answers
        cannot be known to be all; else 0."""
        known = self._known
        if not self.expected or self.complete or known is None:
            return 0
        blocks = (step for step in known.branch.steps if isinstance(step, SolveBlock))
        if not any(map(self._is_network, blocks)):
            return 0
        return sum(self.expected.get(pair) != sign for pair, sign in case.signs.items())

    def _is_network(self, step: SolveBlock) -> bool:
        """Whether a block may have more answers than anybody wants: a large one without angles."""
        large = len(step.unknowns) > MAX_SEARCHED[0]
        return large and not any(map(self.graph.turn, step.unknowns))

    @contextmanager
    def _nearby(self, away: int) -> Iterator[None]:
        """What differs from the case of an answer is only sought near that."""
        kept = self.budget.nearby, self.guesses
        if away and (known := self._known) is not None:
            values = known.branch.values.items()
            numbers = {name: v for name, v in values if isinstance(v, float)}
            self.budget.nearby, self.guesses = True, {**numbers, **self.guesses}
        try:
            yield
        finally:
            self.budget.nearby, self.guesses = kept

    def _settled(self, branch: Branch, step: Assume) -> Mapping[Pair, Sign]:
        """The case that many are to begin with, whose answer lies in it: where that of another lies
        outside, all comparisons that it does not meet are changed, or only one of them.

        Empty if the cases are few, or if this leads to none.
        """
        conditions = (c for i, c in enumerate(self.model.conditions) if i not in branch.conditions)
        atoms = chain.from_iterable(map(comparisons, conditions))
        if 2 ** len({(atom.left, atom.right) for atom in atoms}) <= FEW_CASES:
            return {}
        probe, tried, waiting = copy(self), list[Mapping[Pair, Sign]](), [dict[Pair, Sign]()]
        probe._settling = True
        while waiting and len(tried) < MAX_SETTLING:
            probe._begin()
            probe.expected = waiting.pop()
            probe._assume(branch.fork(), step)
            ends = (*probe.leaves, *probe.outside_case, *probe.open_cases)
            end = next(map(_nearest, ends), None)
            if end is None or 2 ** len(end.signs) <= FEW_CASES:
                return {}
            if probe._known is not None:
                return probe._known.branch.signs
            tried.append(end.signs)
            fitting = {pair: self.analysis.case_of(pair, end) for pair in end.signs}
            changed = {p: sign for p, sign in fitting.items() if sign and sign != end.signs[p]}
            ways = [{pair: sign} for pair, sign in changed.items()][::-1]
            cases = ({**end.signs, **way} for way in (*ways, changed))
            waiting += [case for case in cases if case not in (*tried, *waiting)]
        if not probe.complete:  # a proof that there is none is out of reach
            self.cases = max(self.cases, MAX_CASES - FEW_CASES)
        return {}


def _nearest(leaf: Leaf) -> Branch:
    """The branch of a leaf, with the nearest miss of blocks that have no answer."""
    branch, missed = leaf.branch.fork(), leaf.branch.reasons
    for fact in missed:
        if isinstance(fact, NoRoot):
            branch.values.update(fact.best)
    return branch
