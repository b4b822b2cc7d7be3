"""Follow a path: from inputs to every answer, each one checked by the independent witness."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial

from rulesheets import nodes
from rulesheets.evaluate import Undefined, holds
from rulesheets.model import Model, Value
from rulesheets.record import dataclass, field, replace
from solver.facts import AsksNothing, Conflict, Fact, NoRoot, NoValue, OutOfRange, RankLoss, Truncated
from solver.kernel.step import solve_step
from solver.path.activity import activity
from solver.path.cases import (
    DIFFERENT,
    EQUAL,
    GREATER,
    LESS,
    Pair,
    assumed_outcome,
    cases_of,
    comparisons,
    outcome,
    possible,
    value_of_equality,
)
from solver.path.planner import Planner
from solver.path.steps import Assume, Check, Decide, Evaluate, Select, SolveBlock, Step
from solver.turns import settled
from solver.witness import testify

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import TypeAlias

    from solver.attempts import Attempt
    from solver.forward_error import ForwardErrors
    from solver.kernel.block import BlockKernel
    from solver.kernel.outcome import BlockOutcome

MAX_LEAVES = 256
MAX_ASSUMPTIONS = 16
MAX_CASES = 100
MAX_SEARCHES = 150
"""Searches of nonlinear blocks at other values, after the first search of each block."""
_MEANING = {LESS: "<", EQUAL: "=", GREATER: ">", DIFFERENT: "<>"}


@dataclass
class Branch:
    """What is known along one way through the path."""

    values: dict[str, Value]
    decided: dict[int, bool]
    assumed: dict[int, bool] = field(default_factory=dict)
    signs: dict[Pair, int] = field(default_factory=dict)
    void: dict[int, Fact] = field(default_factory=dict)
    steps: list[Step] = field(default_factory=list)
    settled: set[int] = field(default_factory=set)
    blank: set[str] = field(default_factory=set)
    origins: dict[str, Step] = field(default_factory=dict)
    facts: tuple[Fact, ...] = ()
    attempts: dict[SolveBlock, tuple[Attempt, ...]] = field(default_factory=dict)

    def fork(self) -> Branch:
        return replace(
            self,
            values=dict(self.values),
            decided=dict(self.decided),
            assumed=dict(self.assumed),
            signs=dict(self.signs),
            void=dict(self.void),
            steps=list(self.steps),
            settled=set(self.settled),
            blank=set(self.blank),
            origins=dict(self.origins),
            attempts=dict(self.attempts),
        )


@dataclass(frozen=True)
class Leaf:
    """The end of a branch: all that could be computed along it, checked.

    ``conflicts`` are rules that do not hold there; ``missing`` the wanted names without a value.
    ``worst`` is the largest scaled residual of the ``checked`` rules. ``loose``: nothing contradicts
    the cases that follow, and nothing determines them.
    """

    branch: Branch
    missing: tuple[str, ...]
    conflicts: tuple[Fact, ...]
    worst: float
    checked: int

    loose: bool = False

    @property
    def solved(self) -> bool:
        return not self.missing and not self.conflicts

    @property
    def on_edge(self) -> bool:
        """Whether an equality between unknowns was assumed on the way."""
        return EQUAL in self.branch.signs.values()


def leaf_errors(model: Model, leaf: Leaf) -> ForwardErrors:
    """The error bars of the values of a leaf."""
    from solver.forward_error import forward_errors

    branch = leaf.branch
    decided = {**branch.decided, **branch.assumed}
    return forward_errors(model, branch.values, branch.steps, lambda e: activity(e, decided))


def blocked(leaf: Leaf) -> bool:
    """Whether something stands in the way of a leaf's missing values, other than freedom."""
    facts = leaf.branch.void.values()
    return any(isinstance(f, NoRoot | OutOfRange) or (isinstance(f, NoValue) and not f.pole) for f in facts)


@dataclass(frozen=True)
class Exploration:
    """Every leaf that was reached, in order of preference, and whether they are known to be all.

    ``dead`` leaves contradict a rule; ``adrift`` are cases that nothing contradicts, but that leave
    undetermined what they were assumed on.
    """

    leaves: tuple[Leaf, ...]
    complete: bool
    dead: tuple[Leaf, ...]
    adrift: tuple[Leaf, ...] = ()


Rest: TypeAlias = Callable[[Branch], bool]
"""The steps after the one at hand, for a fork to go on with: true where it must be planned anew."""


def planner(model: Model) -> Planner:
    """The planner of a model, with every path that it has found so far."""
    found = model.__dict__.get("_planner")
    if found is None:
        found = Planner(model)
        model.__dict__["_planner"] = found
    return found


def explore(
    model: Model,
    inputs: Mapping[str, Value],
    want: Sequence[str] | None,
    guesses: Mapping[str, float],
    judged: Sequence[str],
) -> Exploration:
    """Every answer for these inputs. ``want`` prunes the path; ``judged`` are the names a leaf must have."""
    return _Explorer(model, inputs, want, guesses, judged).run()


class _Explorer:
    def __init__(
        self,
        model: Model,
        inputs: Mapping[str, Value],
        want: Sequence[str] | None,
        guesses: Mapping[str, float],
        judged: Sequence[str],
    ) -> None:
        self.model, self.inputs, self.guesses, self.judged = model, dict(inputs), guesses, judged
        self.want = None if want is None else frozenset(want)
        self.planner = planner(model)
        self.graph = self.planner.graph
        self.leaves: list[Leaf] = []
        self.dead: list[Leaf] = []
        self.adrift: list[Leaf] = []
        self.complete = True
        self.cases = 0
        self.outcomes: dict[tuple[SolveBlock, tuple[Value, ...]], BlockOutcome] = {}
        self.searched: set[SolveBlock] = set()

    def run(self) -> Exploration:
        decided = self._outcomes(range(len(self.model.conditions)), self.inputs)
        self._explore(Branch(dict(self.inputs), decided))
        return Exploration(
            tuple(self.leaves), self.complete and not self.adrift, tuple(self.dead), tuple(self.adrift)
        )

    # --- conditions: an ``and`` or ``or`` may be settled before all of it is known ---

    def _outcomes(self, conditions: Collection[int], values: Mapping[str, Value]) -> dict[int, bool]:
        found = {}
        for index in conditions:
            known = self._settle(self.model.conditions[index], values)
            if known is not None:
                found[index] = known
        return found

    # --- following a path ---

    def _explore(self, branch: Branch) -> None:
        """Plan from what is known, follow, and plan again where an outcome asks for it."""
        while True:
            if self._full():
                self._truncate(branch, "answers")
                return
            known = frozenset(branch.values)
            decided = {**branch.decided, **branch.assumed}
            path = self.planner.path(known, decided, frozenset(branch.void), self.want)
            if not self._follow(branch, path.steps):
                return

    def _truncate(self, branch: Branch, what: str) -> None:
        self.complete = False
        branch.facts = (*branch.facts, Truncated(what))

    def _follow(self, branch: Branch, steps: Sequence[Step], start: int = 0) -> bool:
        """Run the steps from ``start``: True where the branch must be planned anew, False where it ended."""
        for place in range(start, len(steps)):
            step = steps[place]
            rest = partial(self._follow, steps=steps, start=place + 1)
            match step:
                case Evaluate(equation=equation, unknown=unknown):
                    again = self._evaluate(branch, step, equation, unknown, rest)
                case Select():
                    again = self._select(branch, step, rest)
                case SolveBlock():
                    again = self._block(branch, step, rest)
                case Check(equation=equation):
                    again = self._check(branch, step, equation)
                case Decide(conditions=conditions):
                    branch.decided.update(self._outcomes(conditions, branch.values))
                    branch.steps.append(step)
                    return True
                case Assume():
                    return self._assume(branch, step)
            if again is not None:
                return again
        self._finish(branch)
        return False

    def _learn(self, branch: Branch, step: Step, found: Mapping[str, Value]) -> None:
        branch.values.update(found)
        branch.origins.update(dict.fromkeys(found, step))
        branch.steps.append(step)
        match step:
            case Evaluate(equation=equation):
                branch.settled.add(equation)
            case SolveBlock(equations=equations):
                branch.settled.update(equations)

    def _evaluate(self, branch: Branch, step: Step, equation: int, unknown: str, rest: Rest) -> bool | None:
        """None: go on; True: plan anew; False: ended (each fork has gone its own way)."""
        isolation = self.graph.isolation(equation, self.graph.number[unknown])
        assert isolation is not None
        outcome = solve_step(self.graph, equation, isolation, branch.values)
        self.complete = self.complete and outcome.complete
        if outcome.fact is not None:
            if isinstance(outcome.fact, AsksNothing):
                branch.void[equation] = outcome.fact
            else:
                self._blank(branch, (unknown,), outcome.fact)
            return True
        facts = [() if outcome.double is None else (outcome.double,)] * len(outcome.values)
        return self._forks(branch, step, [{unknown: v} for v in outcome.values], facts, rest)

    def _forks(
        self,
        branch: Branch,
        step: Step,
        found: Sequence[Mapping[str, Value]],
        facts: Sequence[tuple[Fact, ...]],
        rest: Rest,
    ) -> bool | None:
        """Go on with the one value there is (None), or send a fork on its way with each (False)."""
        if len(found) == 1:
            branch.facts = (*branch.facts, *facts[0])
            self._learn(branch, step, found[0])
            return None
        for values, known in zip(found, facts, strict=True):
            if self._full():
                self._truncate(branch, "answers")
                break
            fork = branch.fork()
            fork.facts = (*fork.facts, *known)
            self._learn(fork, step, values)
            if rest(fork):
                self._explore(fork)
        return False

    def _full(self) -> bool:
        return len(self.leaves) + len(self.dead) + len(self.adrift) >= MAX_LEAVES

    def _select(self, branch: Branch, step: Select, rest: Rest) -> bool | None:
        equations = self.model.equations
        for equation in step.equations:
            conditions = [p.condition for p in equations[equation].guard if p.condition not in branch.decided]
            branch.decided.update(self._outcomes(conditions, branch.values))
            if activity(equations[equation], {**branch.decided, **branch.assumed}):
                return self._evaluate(branch, step, equation, step.unknown, rest)
        return True

    def _check(self, branch: Branch, step: Step, equation: int) -> bool | None:
        if equation in branch.settled:
            return None
        branch.settled.add(equation)
        branch.steps.append(step)
        testimony = testify(self.model.equations[equation], branch.values)
        if testimony.holds:
            return None
        self._finish(branch)
        return False

    def _block(self, branch: Branch, step: SolveBlock, rest: Rest) -> bool | None:
        outcome = self._solved(step, branch.values)
        self.complete = self.complete and outcome.complete
        branch.attempts[step] = outcome.attempts
        if outcome.free:
            lost = next(fact for fact in outcome.facts if isinstance(fact, RankLoss))
            branch.void.update(dict.fromkeys(step.equations, lost))
            self._learn(branch, step, outcome.answers[0].values)
            return True
        if not outcome.answers:
            self._blank(branch, step.unknowns, outcome.facts[-1])
            return True
        facts = [() if answer.double is None else (answer.double,) for answer in outcome.answers]
        return self._forks(branch, step, [answer.values for answer in outcome.answers], facts, rest)

    def _solved(self, step: SolveBlock, values: Mapping[str, Value]) -> BlockOutcome:
        """The outcome of a block; cases that meet it again at the same values share it."""
        from solver.kernel.outcome import BlockOutcome
        from solver.kernel.solve_block import solve_block

        kernel = self._kernel(step)
        key = (step, tuple(values[name] for name in kernel.known))
        if key not in self.outcomes:
            again = len(self.outcomes) - len(self.searched)
            if step in self.searched and again >= MAX_SEARCHES and not kernel.linear:
                return BlockOutcome(facts=(NoRoot(step.equations, step.unknowns, proven=False),))
            self.searched.add(step)
            self.outcomes[key] = solve_block(kernel, values, self.guesses)
        return self.outcomes[key]

    def _blank(self, branch: Branch, unknowns: Sequence[str], fact: Fact) -> None:
        """No value of these satisfies what is known: they stay blank, and rules that read them are idle."""
        branch.blank.update(unknowns)
        for name in unknowns:
            for equation in self.graph.users(name):
                branch.void.setdefault(equation, fact)

    def _kernel(self, step: SolveBlock) -> BlockKernel:
        kernels: dict[SolveBlock, BlockKernel] = self.graph.kernels
        if step not in kernels:
            from solver.kernel.block import BlockKernel

            kernels[step] = BlockKernel(self.graph, step)
        return kernels[step]

    # --- case by case ---

    def _assume(self, branch: Branch, step: Assume) -> bool:
        """The cases of one comparison; each is dropped once it is known to come out otherwise."""
        self._infer(branch)
        pair = self._open_pair(branch, step.condition)
        if pair is None:
            return True
        if any(name in branch.blank for name in self.judged):
            self._finish(branch)
            return False
        self.cases += 1
        if len(branch.signs) >= MAX_ASSUMPTIONS or self.cases > MAX_CASES:
            self._truncate(branch, "cases")
            self._finish(branch)
            return False
        adrift = len(self.adrift)
        for sign in cases_of(pair, self.model.conditions):
            if sign == EQUAL and self._loose(adrift):
                self.complete = False
            else:
                self._case(branch, step, pair, sign)
        if self._loose(adrift):
            self._finish(branch, loose=True)
        return False

    def _loose(self, adrift: int) -> bool:
        """Whether the cases since then leave a continuum that nothing contradicts.

        Answers of other cases do not make it a solved one; a case of equality is but its edge.
        """
        return any(not blocked(leaf) and not leaf.on_edge for leaf in self.adrift[adrift:])

    def _case(self, branch: Branch, step: Assume, pair: Pair, sign: int) -> None:
        case = branch.fork()
        case.signs[pair] = sign
        case.steps.append(step)
        said = value_of_equality(pair) if sign == EQUAL else None
        if said is not None:
            case.values.setdefault(*said)
        self._infer(case)
        if possible(case.signs) and not self._contradicted(case):
            self._explore(case)

    def _open_pair(self, branch: Branch, condition: int) -> Pair | None:
        """The first comparison of a condition that is neither known nor assumed."""
        for atom in comparisons(self.model.conditions[condition]):
            if self._settle(atom, branch.values) is None and assumed_outcome(atom, branch.signs) is None:
                return atom.left, atom.right
        return None

    def _infer(self, branch: Branch) -> None:
        """What the values and the assumed signs tell about every condition."""

        def settle(atom: nodes.Condition) -> bool | None:
            known = self._settle(atom, branch.values)
            if known is None and isinstance(atom, nodes.Comparison):
                return assumed_outcome(atom, branch.signs)
            return known

        for index, condition in enumerate(self.model.conditions):
            if index not in branch.decided:
                found = outcome(condition, settle)
                if found is not None:
                    branch.assumed[index] = found

    def _settle(self, condition: nodes.Condition, values: Mapping[str, Value]) -> bool | None:
        """How a condition comes out at known values; None where they do not tell."""
        try:
            return holds(condition, values, self.inputs)
        except KeyError:
            return None
        except Undefined:
            return False

    def _contradicted(self, branch: Branch) -> bool:
        """Whether a comparison came out otherwise than assumed."""
        return any(
            self._settle(nodes.Comparison(_MEANING[sign], *pair), branch.values) is False
            for pair, sign in branch.signs.items()
        )

    def _unverified(self, branch: Branch) -> bool:
        return any(self._settle(nodes.Comparison("=", *pair), branch.values) is None for pair in branch.signs)

    # --- the end of a branch ---

    def _finish(self, branch: Branch, loose: bool = False) -> None:
        if self._contradicted(branch):
            return
        branch.values = values = settled(self.graph, branch.values, self.inputs)
        conflicts: list[Fact] = []
        worst, checked = 0.0, 0
        decided = {**branch.assumed, **self._outcomes(range(len(self.model.conditions)), values)}
        for equation in self.model.equations:
            if not activity(equation, decided) or not all(name in values for name in equation.names):
                continue
            testimony = testify(equation, values)
            checked += 1
            if testimony.holds:
                worst = max(worst, testimony.scaled)
            else:
                conflicts.append(Conflict((equation.index,), testimony.miss, values))
        missing = tuple(name for name in self.judged if name not in values)
        leaf = Leaf(branch, missing, tuple(conflicts), worst, checked, loose)
        if conflicts:
            self.dead.append(leaf)
        else:
            (self.adrift if missing and self._unverified(branch) else self.leaves).append(leaf)
