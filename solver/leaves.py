"""Branches of a path, the conditions along them, and the leaves at which they end."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from copy import copy
from dataclasses import dataclass, field, fields, replace
from typing import Any, NamedTuple, TypeAlias

from rulesheets.deadline import TimeIsUp
from rulesheets.evaluate import Undefined, holds, value
from rulesheets.evaluate.number import meets
from rulesheets.model import Equation, Model, Value
from rulesheets.syntax import nodes
from solver.accuracy.forward_error import ForwardErrors, forward_errors
from solver.accuracy.rule_check import check_rule
from solver.facts import (
    Attempt,
    Conflict,
    DoubleRoot,
    Fact,
    Gap,
    Indeterminacy,
    NoRoot,
    NoValue,
    OutOfRange,
    Unmet,
)
from solver.path import SolveBlock, Step
from solver.path.cases import (
    AT_LEAST,
    AT_MOST,
    EQUAL,
    MEANING,
    OTHERWISE,
    Pair,
    Sign,
    Signed,
    activity,
    assumed_outcome,
    cases_of,
    comparisons,
    outcome,
    possible,
)
from solver.path.graph import ModelGraph, is_angle_sum


def settled(graph: ModelGraph, values: Mapping[str, Value], inputs: Collection[str]) -> dict[str, Value]:
    """The values with every posted angle that lies outside one turn moved into it.

    Angles that are tied to it by a sum (``beta = alpha + 90``) move along; a move that some rule does not
    admit is not made.
    """
    moved, groups, refused = dict(values), dict[str, set[str]](), set[tuple[int, float]]()
    for name, number, turn in _outside_one_turn(graph, moved, inputs, graph.turn):
        if name not in groups:
            tied = _tied(graph, name, inputs)
            groups.update(dict.fromkeys(tied, tied))
        shift, group = -turn * math.ceil(number / turn - 0.5), groups[name]
        if (id(group), shift) in refused:
            continue
        trial = {n: v + shift if n in group and isinstance(v, float) else v for n, v in moved.items()}
        touched = (graph.model.equations[index] for name in group for index in graph.users[name])
        known = {rule.index: rule for rule in touched if moved.keys() >= {*rule.names}}.values()
        if all(check_rule(rule, trial).holds or not check_rule(rule, moved).holds for rule in known):
            moved.update(trial)
            refused.clear()
        else:
            refused.add((id(group), shift))
    return moved


def within_one_turn(graph: ModelGraph, values: Mapping[str, Value], inputs: Collection[str]) -> bool:
    """Whether every posted angle that rules read in parts (``sind(theta/2)``) is in (-180, 180].

    Other angles are moved there; these have answers in two turns and more, each another one.
    """
    outside = _outside_one_turn(graph, values, inputs, graph.single_turn)
    return all(graph.is_turning(name) for name, _, _ in outside)


def _outside_one_turn(
    graph: ModelGraph,
    values: Mapping[str, Value],
    inputs: Collection[str],
    turn_of: Callable[[str], float | None],
) -> Iterator[tuple[str, float, float]]:
    """Posted angles without a range that lie outside (-180, 180], with their whole turns; no inputs."""
    for name, variable in graph.model.variables.items():
        number, free = values.get(name), variable.low == -math.inf and variable.high == math.inf
        if name in inputs or not isinstance(number, float) or not variable.posted or not free:
            continue
        turn = turn_of(name) if abs(number) >= math.pi else None  # half a turn in the smallest unit
        if turn is not None and not -turn / 2 < number <= turn / 2:
            yield name, number, turn


def _tied(graph: ModelGraph, name: str, inputs: Collection[str]) -> set[str]:
    """The angle and those that sums tie it to, inputs left out."""
    group, waiting = {name}, [name]
    while waiting:
        for index in graph.users[waiting.pop()]:
            equation = graph.model.equations[index]
            if is_angle_sum(equation.left) and is_angle_sum(equation.right):
                new = {n for n in equation.names if n not in inputs} - group
                group |= new
                waiting += sorted(new)
    return group


@dataclass
class Branch:
    """What is known along one way through the path.

    ``precise`` are values to more digits than floats have, where they were computed so.
    """

    values: dict[str, Value]
    decided: dict[int, bool]
    assumed: dict[int, bool] = field(default_factory=dict)
    signs: dict[Pair, Sign] = field(default_factory=dict)
    inactive: dict[int, Fact] = field(default_factory=dict)
    steps: list[Step] = field(default_factory=list)
    settled: set[int] = field(default_factory=set)
    blank: set[str] = field(default_factory=set)
    origins: dict[str, Step] = field(default_factory=dict)
    facts: tuple[Fact, ...] = ()
    attempts: dict[SolveBlock, tuple[Attempt, ...]] = field(default_factory=dict)
    precise: dict[str, Any] = field(default_factory=dict)

    @property
    def conditions(self) -> dict[int, bool]:
        """How each condition came out, or is assumed to."""
        return {**self.decided, **self.assumed}

    @property
    def reasons(self) -> tuple[Fact, ...]:
        """Why equations are inactive, each reason once."""
        return tuple({id(fact): fact for fact in self.inactive.values()}.values())

    def without(self, names: Collection[str]) -> Branch:
        """A fork that lacks the values of these names."""
        fork = self.fork()
        fork.values = {name: value for name, value in self.values.items() if name not in names}
        return fork

    def fork(self) -> Branch:
        return Branch(**{one.name: copy(getattr(self, one.name)) for one in fields(self)})


@dataclass(frozen=True)
class Leaf:
    """The end of a branch: all that could be computed along it, checked.

    ``conflicts`` are rules that do not hold there; ``missing`` the wanted names without a value.
    ``worst`` is the largest scaled residual of the ``checked`` rules. ``underdetermined``: nothing
    contradicts the cases that follow, and nothing determines them.
    """

    branch: Branch
    missing: tuple[str, ...]
    conflicts: tuple[Fact, ...]
    worst: float
    checked: int

    underdetermined: bool = False

    @property
    def solved(self) -> bool:
        return not self.missing and not self.conflicts

    @property
    def on_edge(self) -> bool:
        """Whether an equality between unknowns was assumed on the way."""
        return EQUAL in self.branch.signs.values()


def leaf_errors(model: Model, leaf: Leaf) -> ForwardErrors:
    """The error bars of the values of a leaf: of those known to more digits, what rounding them has cost.

    Found once for the values that it has.
    """
    branch = leaf.branch
    kept: tuple[dict[str, Value], Model, ForwardErrors] | None = leaf.__dict__.get("_errors")
    if kept is not None and kept[0] == branch.values and kept[1] is model:
        return kept[2]
    doubles = [fact for fact in branch.facts if isinstance(fact, DoubleRoot)]
    found = forward_errors(model, branch.values, branch.steps, branch.conditions, doubles)
    if branch.precise and not doubles:
        rounded = {}
        for name, exact in branch.precise.items():
            number = branch.values[name]
            distance = 0.0 if isinstance(number, str) else float(abs(exact - number))
            rounded[name] = math.nextafter(distance, math.inf) if distance else 0.0
        found = ForwardErrors({**found.error, **rounded}, found.blocks, found.cancelled)
    leaf.__dict__["_errors"] = dict(branch.values), model, found
    return found


def infinite(model: Model, branch: Branch, name: str) -> bool:
    """Whether a variable that calls only pass on to one another has no value because it is infinite there."""
    blank = model.variables[name].passed and name not in branch.values
    return blank and any(
        isinstance(fact, NoValue) and fact.pole and fact.unknown == name for fact in branch.inactive.values()
    )


def blocked(leaf: Leaf) -> bool:
    """Whether something stands in the way of a leaf's missing values, other than freedom."""
    return any(
        isinstance(fact, Conflict | NoRoot | OutOfRange) or (isinstance(fact, NoValue) and not fact.pole)
        for fact in leaf.branch.inactive.values()
    )


def excluded(leaf: Leaf) -> bool:
    """Whether it is proven that no value fits a case that the leaf assumes: nothing is hidden there."""
    asked = {name for pair in leaf.branch.signs for side in pair for name in nodes.names(side)}
    return any(
        isinstance(fact, Conflict) or not asked.isdisjoint(without_value(fact)[1])
        for fact in leaf.branch.inactive.values()
    )


def without_value(fact: Fact) -> tuple[tuple[int, ...], tuple[str, ...]]:
    """The equations that a fact says no value satisfies, and the unknowns of which they ask it, proven."""
    match fact:
        case NoValue(pole=False) | OutOfRange():
            return (fact.equation,), (fact.unknown,)
        case NoRoot(proven=True):
            return fact.equations, fact.unknowns
        case _:
            return (), ()


class Asked(NamedTuple):
    """A question. ``want`` prunes the path, ``judged`` are the names that an answer must have.

    ``guesses`` say which answer comes first.
    """

    model: Model
    inputs: Mapping[str, Value]
    want: Sequence[str] | None
    guesses: Mapping[str, float]
    judged: Sequence[str]


Outcomes: TypeAlias = dict[tuple[SolveBlock, tuple[Value, ...]], Any]
"""What a block came to at the values that it was met at."""


@dataclass(frozen=True)
class Exploration:
    """Every leaf that was reached, in order of preference, and whether they are known to be all.

    ``contradicted`` leaves break a rule; ``open_cases`` contradict nothing, but leave undetermined what
    they were assumed on. ``delicate``: somewhere two roots, or an edge, lay closer than
    floats can tell; ``outcomes`` are what the blocks came to;
    ``work`` is what it took, counted (see ``kernel/problem.py``); ``gaps`` are why they may not be all.
    """

    leaves: tuple[Leaf, ...]
    complete: bool
    contradicted: tuple[Leaf, ...]
    open_cases: tuple[Leaf, ...] = ()
    delicate: bool = False
    outcomes: Outcomes = field(default_factory=dict, repr=False, compare=False)
    work: int = 0
    gaps: tuple[Gap, ...] = ()


PATIENCE = 50_000
"""Work that the search for remedies of a solve may take: they are advice, the verdict stands without them."""


class Patience:
    """Runs out with the work of the explorations it is shown: counted, so the same anywhere.

    One for all that is said of a solve.
    """

    def __init__(self, work: int = PATIENCE) -> None:
        self._left = work

    @property
    def lost(self) -> bool:
        return self._left <= 0

    def shown(self, found: Exploration) -> Exploration:
        self._left -= found.work
        return found


class CutOff(TimeIsUp):
    """The limit in time was met: what was ``found`` until then, and the values ``known`` before any fork."""

    def __init__(self, found: Exploration, known: Mapping[str, Value]) -> None:
        super().__init__()
        self.found, self.known = replace(found, complete=False), dict(known)


# --- conditions along a branch: what its values settle, what is assumed, what contradicts that ---


class CaseAnalysis:
    """The conditions of a model at given inputs; ``judge`` tells how one comes out at the values of a branch,
    ``evaluate.holds`` if it is not given."""

    def __init__(
        self,
        model: Model,
        inputs: Mapping[str, Value],
        judge: Callable[[nodes.Condition, Branch], bool] | None = None,
    ) -> None:
        self.model = model
        self.judge = judge or (lambda condition, branch: holds(condition, branch.values, inputs))
        self._cases: dict[Pair, tuple[Sign, ...]] = {}

    def cases(self, pair: Pair) -> tuple[Sign, ...]:
        """What is assumed of a comparison, one after another."""
        if pair not in self._cases:
            conditions = self.model.conditions
            guards = {(conditions[p.condition], p.holds) for e in self.model.equations for p in e.guard}
            self._cases[pair] = cases_of(pair, conditions, guards)
        return self._cases[pair]

    def outcomes(self, conditions: Collection[int], branch: Branch) -> dict[int, bool]:
        """The conditions that the values settle; an ``and`` or ``or`` may be, before all of it is known."""
        found = {}
        for index in conditions:
            known = self._settle(self.model.conditions[index], branch)
            if known is not None:
                found[index] = known
        return found

    def open_pair(self, branch: Branch, condition: int) -> Pair | None:
        """The first comparison of a condition that is neither known nor assumed."""
        for atom in comparisons(self.model.conditions[condition]):
            if self._settle(atom, branch) is None and assumed_outcome(atom, branch.signs) is None:
                return atom.left, atom.right
        return None

    def infer(self, branch: Branch) -> None:
        """What the values and the assumed signs tell about every condition."""

        def settle(atom: nodes.Condition) -> bool | None:
            known = self._settle(atom, branch)
            if known is None and isinstance(atom, nodes.Comparison):
                return assumed_outcome(atom, branch.signs)
            return known

        for index, condition in enumerate(self.model.conditions):
            if index not in branch.decided:
                found = outcome(condition, settle)
                if found is not None:
                    branch.assumed[index] = found

    def _settle(self, condition: nodes.Condition, branch: Branch) -> bool | None:
        """How a condition comes out at known values; None where they do not tell."""
        try:
            return self.judge(condition, branch)
        except KeyError:
            return None
        except Undefined:
            return False

    def contradicted(self, branch: Branch) -> bool:
        """Whether a comparison came out otherwise than assumed, or all of them cannot come out so.

        The ranges of the variables that they read have a say in it.
        """
        signs: list[Signed] = list(branch.signs.items())
        if any(self._settle(nodes.Comparison(MEANING[sign], *pair), branch) is False for pair, sign in signs):
            return True
        for name in {name for pair in branch.signs for side in pair for name in nodes.names(side)}:
            variable = self.model.variables[name]
            for limit, sign in ((variable.low, AT_LEAST), (variable.high, AT_MOST)):
                if math.isfinite(limit):
                    signs.append(((nodes.Name(name), nodes.Number(limit)), sign))
        return not possible(signs, branch.values)

    def told(self, branch: Branch) -> tuple[nodes.Comparison, ...]:
        """The assumed comparisons of a branch, without those that follow from the others."""
        left = dict(branch.signs)
        for pair, sign in branch.signs.items():
            others = {other: left[other] for other in left if other != pair}
            against = ((*others.items(), (pair, wrong)) for wrong in OTHERWISE[sign])
            if others and not any(possible(signs, branch.values) for signs in against):
                left = others
        return tuple(nodes.Comparison(MEANING[sign], *pair) for pair, sign in left.items())

    def unverified(self, branch: Branch) -> bool:
        return any(self._settle(nodes.Comparison("=", *pair), branch) is None for pair in branch.signs)


def indeterminacy(equation: Equation, values: Mapping[str, Value]) -> Indeterminacy | None:
    """The fact that an equation is 0/0 at the values, if it is."""
    from rulesheets.evaluate.digits import indeterminate

    for side in (equation.left, equation.right):
        found = indeterminate(side, values)
        if found is not None:
            read = {name: values[name] for name in equation.names if name in values}
            return Indeterminacy(equation.index, found.form, found.limit, found.is_open, read)
    return None


def unmet(model: Model, values: Mapping[str, Value], decided: Mapping[int, bool]) -> Iterator[Unmet]:
    """The requirements that these values break; those that read what has no value are not asked.

    Of each how far the smaller side is from where it has to be; None where a side is no number.
    """
    for index, requirement in enumerate(model.requirements):
        if activity(requirement, decided) and all(name in values for name in requirement.names):
            comparison, miss = requirement.comparison, math.inf
            with suppress(Undefined):
                if meets(comparison, values):
                    continue
            with suppress(Undefined, TypeError):
                miss = abs(value(comparison.left, values) - value(comparison.right, values))
            yield Unmet(index, miss if math.isfinite(miss) else None, values)


ALIKE = 1e-12
"""How near values are taken for the same, relative to them."""


def different(rows: Sequence[Sequence[Value]]) -> list[int]:
    """The places of the rows of values that differ from every row before by more than rounding."""
    places = list[int]()
    for place, row in enumerate(rows):
        if not any(are_alike(row, rows[other], ALIKE) for other in places):
            places.append(place)
    return places


def are_alike(row: Iterable[Any], other: Iterable[Any], tolerance: float) -> bool:
    """Whether values are the same, numbers but for a share of the larger of each two."""

    def near(a: Any, b: Any) -> bool:
        if isinstance(a, str) or isinstance(b, str) or a == b:
            return bool(a == b)
        return abs(a - b) <= tolerance * max(abs(a), abs(b)) or (math.isnan(a) and math.isnan(b))

    return all(map(near, row, other))
