"""Branches of a path, the conditions along them, and the leaves at which they end."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from copy import copy
from dataclasses import dataclass, field, fields, replace
from fractions import Fraction
from functools import partial
from itertools import chain
from typing import Any, NamedTuple, TypeAlias

from rulesheets.deadline import TimeIsUp
from rulesheets.evaluate import Undefined, holds, value
from rulesheets.evaluate.number import meets
from rulesheets.model import Equation, Model, Row, Value, Values, reached
from rulesheets.syntax import nodes
from solver.accuracy.forward_error import ForwardErrors, forward_errors
from solver.accuracy.rule_check import check_rule
from solver.accuracy.rule_sides import half_unit
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
    Truncated,
    Unmet,
)
from solver.numerics.linear_algebra import are_alike
from solver.numerics.tolerances import COVERED
from solver.path import SolveBlock, Step, activity, equations_of
from solver.path.cases import (
    AT_LEAST,
    AT_MOST,
    EQUAL,
    MEANING,
    OTHERWISE,
    Pair,
    Sign,
    Signed,
    assumed_outcome,
    cases_of,
    comparisons,
    compatible,
    outcome,
    possible,
    value_of_equality,
)
from solver.path.graph import ModelGraph, is_angle_sum, sum_of_angles
from solver.path.planner import planner


def moved_into_one_turn(
    graph: ModelGraph, values: Values, inputs: Collection[str]
) -> dict[str, Value]:
    """The values with every posted angle that lies outside one turn moved into it.

    Angles that sums tie to it (``angle = wind - course``) move along, those of which a sum gives
    the value only so; a move that violates a rule or a range is not made.
    """
    moved, ways = dict(values), dict[str, dict[str, dict[str, float]]]()
    for name, number, turn in _outside_one_turn(graph, moved, inputs, graph.tied_turn):
        if name not in ways:
            found = _whole_turns(graph, name, inputs)
            ways.update(dict.fromkeys(chain((name, *found), *found.values()), found))
        along, shift = ways[name].get(name, {}), -turn * math.ceil(number / turn - 0.5)
        trial = {
            n: v + shift * along[n] if along.get(n) and isinstance(v, float) else v
            for n, v in moved.items()
        }
        variables = ((graph.model.variables[n], trial.get(n)) for n in along)
        if any(isinstance(v, float) and not variable.admits(v) for variable, v in variables):
            continue
        touched = (graph.model.equations[index] for name in along for index in graph.users[name])
        known = {rule.index: rule for rule in touched if moved.keys() >= {*rule.names}}.values()
        if all(
            check_rule(rule, trial).holds or not check_rule(rule, moved).holds for rule in known
        ):
            moved.update(trial)
    return moved


def within_one_turn(graph: ModelGraph, values: Values, inputs: Collection[str]) -> bool:
    """Whether every posted angle that rules read in parts (``sind(theta/2)``) is in (-180, 180].

    Other angles are moved there; these have different answers in different turns.
    """
    outside = _outside_one_turn(graph, values, inputs, graph.single_turn)
    return all(graph.is_turning(name) for name, _, _ in outside)


def _outside_one_turn(
    graph: ModelGraph,
    values: Values,
    inputs: Collection[str],
    turn_of: Callable[[str], float | None],
) -> Iterator[tuple[str, float, float]]:
    """Posted angles without a range that lie outside (-180, 180], with their whole turns; not
    inputs."""
    for name, variable in graph.model.variables.items():
        number, shown = values.get(name), variable.posted and not variable.ranged
        if name in inputs or not isinstance(number, float) or not shown:
            continue
        turn = turn_of(name) if abs(number) >= math.pi else None  # half a turn in the smallest unit
        if turn is not None and not -turn / 2 < number <= turn / 2:
            yield name, number, turn


def _whole_turns(
    graph: ModelGraph, name: str, inputs: Collection[str]
) -> dict[str, dict[str, float]]:
    """By angle, what a turn of it adds to itself and to those that sums tie to it: of the angles
    that sums tie to a name, and that no sum gives."""
    from solver.numerics.elimination import gauss_jordan  # few angles leave their turn

    seen, rules = reached([name], partial(_tied, graph, inputs)), dict[int, Equation]()
    for one in seen:
        rules.update((e.index, e) for e in _angle_sums(graph, one))
    computed, variables = (
        {n for e in rules.values() for n, _ in e.definitions},
        graph.model.variables,
    )
    names = sorted(
        seen - {*inputs}, key=lambda n: (variables[n].posted, n not in computed, -graph.number[n])
    )
    matrix = [
        [sum((Fraction(*ratio) for n, ratio in terms if n == one), Fraction(0)) for one in names]
        for terms in (sum_of_angles(rule.form) or () for rule in rules.values())
    ]
    rows, pivots = gauss_jordan(matrix, [Fraction(0)] * len(matrix))
    return {
        one: {one: 1.0, **{names[k]: -rows[i][j] / rows[i][k] for i, k in pivots.items()}}
        for j, one in enumerate(names)
        if j not in pivots.values()
    }


def _angle_sums(graph: ModelGraph, name: str) -> Iterator[Equation]:
    for equation in map(graph.model.equations.__getitem__, graph.users[name]):
        if is_angle_sum(equation.left) and is_angle_sum(equation.right):
            yield equation


def _tied(graph: ModelGraph, inputs: Collection[str], name: str) -> Iterator[str]:
    """The names that sums tie to an angle, without inputs."""
    for equation in _angle_sums(graph, name):
        yield from (n for n in equation.names if n not in inputs)


@dataclass
class Branch:
    """The values and outcomes known along one branch of the path.

    ``precise`` are values with more digits than floats, if they were computed.
    """

    values: dict[str, Value]
    decided: dict[int, bool]
    assumed: dict[int, bool] = field(default_factory=dict)
    signs: dict[Pair, Sign] = field(default_factory=dict)
    inactive: dict[int, Fact] = field(default_factory=dict)
    steps: list[Step] = field(default_factory=list)
    checked: set[int] = field(default_factory=set)
    blank: set[str] = field(default_factory=set)
    origins: dict[str, Step] = field(default_factory=dict)
    facts: tuple[Fact, ...] = ()
    attempts: dict[SolveBlock, tuple[Attempt, ...]] = field(default_factory=dict)
    precise: dict[str, Any] = field(default_factory=dict)

    @property
    def conditions(self) -> dict[int, bool]:
        """The outcome of each condition, known or assumed."""
        return {**self.decided, **self.assumed}

    @property
    def on_boundary(self) -> bool:
        """Whether an equality between unknowns was assumed on the way."""
        return EQUAL in self.signs.values()

    @property
    def cut(self) -> bool:
        """Whether it was abandoned before its end."""
        return any(isinstance(fact, Truncated) for fact in self.facts)

    @property
    def reasons(self) -> tuple[Fact, ...]:
        """Why equations are inactive, each reason once."""
        return tuple({id(fact): fact for fact in self.inactive.values()}.values())

    def given(self, inputs: Collection[str]) -> frozenset[str]:
        """The names whose values are inputs, or assumed."""
        equal = (value_of_equality(pair) for pair, sign in self.signs.items() if sign == EQUAL)
        return frozenset((*inputs, *(said[0] for said in equal if said)))

    def without(self, names: Collection[str]) -> Branch:
        """A fork without the values of these names."""
        fork = self.fork()
        fork.values = {name: value for name, value in self.values.items() if name not in names}
        return fork

    def fork(self) -> Branch:
        return Branch(**{one.name: copy(getattr(self, one.name)) for one in fields(self)})


@dataclass(frozen=True)
class Leaf:
    """The end of a branch: all that could be computed along it, checked.

    ``conflicts`` are rules that do not hold there; ``missing`` the wanted names without a value.
    ``worst`` is the largest scaled residual of the ``checked`` rules. ``underdetermined``: its
    cases are neither contradicted nor determined.
    """

    branch: Branch
    missing: tuple[str, ...]
    conflicts: tuple[Fact, ...]
    worst: float
    checked: int

    underdetermined: bool = False

    def but(self, **changes: Any) -> Leaf:
        """The same with changes of its branch."""
        return replace(self, branch=replace(self.branch, **changes))

    @property
    def solved(self) -> bool:
        return not self.missing and not self.conflicts


def leaf_errors(model: Model, leaf: Leaf) -> ForwardErrors:
    """The error bars of the values of a leaf; for values in more digits, their rounding error.

    Computed once for its values.
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


def branch_errors(model: Model, branch: Branch) -> dict[str, float]:
    """The error of each number of a branch, at least half a unit of its last place if it has
    one."""
    found = forward_errors(model, branch.values, branch.steps, branch.conditions)
    numbers = {n: v for n, v in branch.values.items() if isinstance(v, float)}
    return {name: found.error.get(name) or half_unit(number) for name, number in numbers.items()}


def infinite(model: Model, branch: Branch, name: str) -> bool:
    """Whether a variable that calls only pass on has no value because it is infinite."""
    blank = model.variables[name].passed and name not in branch.values
    return blank and any(
        isinstance(fact, NoValue) and fact.pole and fact.unknown == name
        for fact in branch.inactive.values()
    )


def blocked(model: Model, leaf: Leaf) -> bool:
    """Whether a leaf's missing values have a reason other than being free."""
    return any(
        isinstance(fact, Conflict | NoRoot) or excludes(model, fact)
        for fact in leaf.branch.inactive.values()
    )


def excludes(model: Model, fact: Fact) -> bool:
    """Whether a rule excludes every number of its unknown: none satisfies it, none that is finite
    (which one that calls only pass on need not be), or none in the range."""
    match fact:
        case NoValue(unknown=unknown, pole=pole):
            return not (pole and model.variables[unknown].passed)
    return isinstance(fact, OutOfRange)


class Asked(NamedTuple):
    """A question. ``want`` prunes the path, ``judged`` are the names that an answer must have.

    ``guesses`` decide which answer comes first.
    """

    model: Model
    inputs: Values
    want: Sequence[str] | None
    guesses: Mapping[str, float]
    judged: Sequence[str]


Outcomes: TypeAlias = dict[tuple[SolveBlock, Row], Any]
"""The outcomes of a block by its known values."""


@dataclass(frozen=True)
class Exploration:
    """Every leaf that was reached, in order of preference, and whether they are known to be all.

    ``contradicted`` leaves violate a rule; ``open_cases`` violate none, but leave their conditions
    undetermined. ``delicate``: somewhere two roots, or a boundary, were closer than floats can
    tell; ``outcomes`` are the results of the blocks; ``work`` is the work counted (see
    ``kernel/problem.py``); ``gaps`` are the reasons why the leaves may not be all. The values of
    ``outside_case`` leaves contradict the case that was assumed.
    """

    leaves: tuple[Leaf, ...]
    complete: bool
    contradicted: tuple[Leaf, ...]
    open_cases: tuple[Leaf, ...] = ()
    delicate: bool = False
    outcomes: Outcomes = field(default_factory=dict, repr=False, compare=False)
    work: int = 0
    gaps: tuple[Gap, ...] = ()
    outside_case: tuple[Leaf, ...] = ()


class CutOff(TimeIsUp):
    """The time limit was reached: what was ``found`` until then, and the values ``known`` before
    any fork."""

    def __init__(self, found: Exploration, known: Values) -> None:
        super().__init__()
        self.found, self.known = replace(found, complete=False), dict(known)


# --- whether the leaves of an exploration are known to be all: ``complete`` ---
#
# Every step and every block says whether it has all of its values. ``PathSearch`` (``explore.py``)
# records the first that does not as a ``Gap``, and is not complete from then on, nor after it has
# abandoned a branch. At the end of its search an open case counts, unless it hides no answer, and
# so do the whole turns of angles that were left out, if another turn may end otherwise. Where
# floats may have lost an answer, ``explore_refined`` (``verdict.py``) takes it back, unless two
# precisions agree. ``Result`` is complete if its exploration is, and its status has no reservation
# (``is_complete`` there).


def hides_no_answer(model: Model, leaf: Leaf, inputs: Values) -> bool:
    """Whether a case that an open leaf assumes is proven to have no values, or no value satisfies a
    rule that leads to one of its missing values."""
    asked = {name for pair in leaf.branch.signs for name in nodes.names(*pair)}
    facts = leaf.branch.inactive.values()
    refused = [without_value(model, fact) for fact in facts]
    if any(isinstance(fact, Conflict) for fact in facts) or any(
        not asked.isdisjoint(unknowns) for _, unknowns in refused
    ):
        return True
    leading = leading_to_missing(model, leaf, inputs)
    return any(not leading.isdisjoint(equations) for equations, _ in refused)


def leading_to_missing(model: Model, leaf: Leaf, inputs: Values) -> set[int]:
    """The equations on the path to what a leaf misses."""
    given, missing = leaf.branch.given(inputs), frozenset(leaf.missing)
    path = planner(model).path(given, leaf.branch.conditions, want=missing)
    return {equation for step in path.steps for equation in equations_of(step)}


def without_value(model: Model, fact: Fact) -> tuple[tuple[int, ...], tuple[str, ...]]:
    """The equations that no value satisfies according to a proven fact, and the unknowns in
    question."""
    match fact:
        case NoValue() | OutOfRange() if excludes(model, fact):
            return (fact.equation,), (fact.unknown,)
        case NoRoot(proven=True):
            return fact.equations, fact.unknowns
        case _:
            return (), ()


def turns_matter(model: Model, contradicted: Iterable[Leaf]) -> bool:
    """Whether branches with other whole turns of an angle may end otherwise than those that were
    followed, if these all end at a contradiction.

    They cannot if each of these ends at a rule that reads its angles in periodic functions.
    """
    facts = [fact for leaf in contradicted for fact in leaf.conflicts]
    rules = [
        model.equations[i] for fact in facts if isinstance(fact, Conflict) for i in fact.equations
    ]
    sums = any(is_angle_sum(rule.left) and is_angle_sum(rule.right) for rule in rules)
    return bool(sums or len(rules) < len(facts) or model.conditions or model.requirements)


def conditions_without_value(
    asked: Asked, leaf: Leaf
) -> Iterator[tuple[int, nodes.Condition, Undefined]]:
    """The conditions that are undefined at an answer, each with a rule that is active for that."""
    outcomes = leaf.branch.conditions
    for equation in asked.model.equations if outcomes else ():
        for premise in equation.guard if activity(equation, outcomes) else ():
            condition = asked.model.conditions[premise.condition]
            try:
                holds(condition, leaf.branch.values, asked.inputs)
            except Undefined as undefined:
                yield equation.index, condition, undefined
            except KeyError:
                continue


# --- conditions along a branch: what its values settle, what is assumed, what contradicts that ---


class CaseAnalysis:
    """The conditions of a model at given inputs; ``judge`` evaluates one at the values of a branch,
    ``evaluate.holds`` by default."""

    def __init__(
        self,
        model: Model,
        inputs: Values,
        judge: Callable[[nodes.Condition, Branch], bool] | None = None,
    ) -> None:
        self.model = model
        self.judge = judge or (lambda condition, branch: holds(condition, branch.values, inputs))
        self._cases: dict[Pair, tuple[Sign, ...]] = {}

    def cases(self, pair: Pair) -> tuple[Sign, ...]:
        """The assumptions on comparisons, in order."""
        if pair not in self._cases:
            conditions = self.model.conditions
            guards = {
                (conditions[p.condition], p.holds) for e in self.model.equations for p in e.guard
            }
            self._cases[pair] = cases_of(pair, conditions, guards)
        return self._cases[pair]

    def outcomes(self, conditions: Collection[int], branch: Branch) -> dict[int, bool]:
        """The outcomes that the values decide; an ``and`` or ``or`` may be decided by a part of
        it."""
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

    def assumed(self, branch: Branch, pair: Pair, sign: Sign) -> Branch | None:
        """The branch with a sign of a pair assumed; None if that contradicts what is known."""
        case = branch.fork()
        case.signs[pair] = sign
        said = value_of_equality(pair) if sign == EQUAL else None
        if said is not None:
            case.values.setdefault(*said)
        self.infer(case)
        return None if self.contradicted(case) else case

    def infer(self, branch: Branch) -> None:
        """The outcome of every condition that the values and the assumed signs decide."""

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
        """The outcome of a condition at known values; None if they do not decide it."""
        try:
            return self.judge(condition, branch)
        except KeyError:
            return None
        except Undefined:
            return False

    def case_of(self, pair: Pair, branch: Branch) -> Sign | None:
        """The case of a pair in which the values of a branch lie; None if they do not decide it."""
        comparisons = ((sign, nodes.Comparison(MEANING[sign], *pair)) for sign in self.cases(pair))
        return next((sign for sign, atom in comparisons if self._settle(atom, branch)), None)

    def contradicted(self, branch: Branch) -> bool:
        """Whether a comparison has another outcome than assumed, or the assumptions are
        incompatible.

        The ranges of the variables in them count.
        """
        signs: list[Signed] = list(branch.signs.items())
        if any(
            self._settle(nodes.Comparison(MEANING[sign], *pair), branch) is False
            for pair, sign in signs
        ):
            return True
        for name in {name for pair in branch.signs for name in nodes.names(*pair)}:
            variable = self.model.variables[name]
            for limit, sign in ((variable.low, AT_LEAST), (variable.high, AT_MOST)):
                if math.isfinite(limit):
                    signs.append(((nodes.Name(name), nodes.Number(limit)), sign))
        return not possible(signs, branch.values)

    def excluded(self, branch: Branch) -> tuple[Conflict, ...] | None:
        """The rules of cases that read only known values and do not hold, if these exclude every
        case; none if the bounds of the conditions do; None if a case is left."""
        decided, values = branch.conditions, branch.values
        refuted = [
            rule
            for rule in self.model.equations
            if rule.guard and activity(rule, decided) is None and values.keys() >= {*rule.names}
            if not ((check := check_rule(rule, values)).holds or check.delicate)
        ]
        before = -1
        while before < len(decided):
            before = len(decided)
            for rule in refuted:
                open_ = [premise for premise in rule.guard if premise.condition not in decided]
                if activity(rule, decided):
                    return (Conflict(tuple(rule.index for rule in refuted), None, values),)
                if len(open_) == 1 and activity(rule, decided) is None:
                    decided[open_[0].condition] = not open_[0].holds
        outcomes = ((self.model.conditions[i], holds) for i, holds in decided.items())
        return None if not refuted or compatible(outcomes, values) else ()

    def independent_assumptions(self, branch: Branch) -> tuple[nodes.Comparison, ...]:
        """The assumed comparisons of a branch, without those that follow from the others."""
        left = dict(branch.signs)
        for pair, sign in branch.signs.items():
            others = {other: left[other] for other in left if other != pair}
            against = ((*others.items(), (pair, wrong)) for wrong in OTHERWISE[sign])
            if others and not any(possible(signs, branch.values) for signs in against):
                left = others
        return tuple(nodes.Comparison(MEANING[sign], *pair) for pair, sign in left.items())

    def unverified(self, branch: Branch) -> bool:
        return any(
            self._settle(nodes.Comparison("=", *pair), branch) is None for pair in branch.signs
        )


def indeterminacy(equation: Equation, values: Values) -> Indeterminacy | None:
    """The fact that an equation is 0/0 at the values, if so."""
    from rulesheets.evaluate.digits import indeterminate

    for side in equation.sides:
        found = indeterminate(side, values)
        if found is not None:
            read = {name: values[name] for name in equation.names if name in values}
            return Indeterminacy(equation.index, found.form, found.limit, found.is_open, read)
    return None


def unmet(model: Model, values: Values, decided: Mapping[int, bool]) -> Iterator[Unmet]:
    """The requirements that these values violate; those with unknown values are skipped.

    Each with the distance of the smaller side from the larger one; None if a side is not a number.
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


def different(rows: Sequence[Sequence[Value]]) -> list[int]:
    """The places of the rows of values that differ from all earlier rows by more than rounding."""
    places = list[int]()
    for place, row in enumerate(rows):
        if not any(are_alike(row, rows[other], COVERED) for other in places):
            places.append(place)
    return places
