"""From a question to its verdict: explored in as many digits as needed, and judged by its leaves.

The given values are exact numbers, so an answer exists to all digits, however ill-conditioned. If
the error bar of an answer shows that floats lose more than their rounding, the path is followed
again in higher precision, and in twice that, until two precisions agree: then every value is the
float nearest to the exact one. If they never agree, the answer in floats stands with its error
bars, unless those leave no digit of a value.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import chain
from typing import NamedTuple

from rulesheets.deadline import TimeIsUp, grace
from rulesheets.evaluate import Undefined, holds, value
from rulesheets.model import Model, Value, Values, Variable
from rulesheets.syntax.nodes import Comparison, Name
from solver import facts
from solver.accuracy.forward_error import ForwardErrors, forward_errors
from solver.accuracy.rule_sides import explained
from solver.facts import Conflict, DoubleRoot, Fact, Status
from solver.leaves import (
    Asked,
    CaseAnalysis,
    CutOff,
    Exploration,
    Leaf,
    blocked,
    leading_to_missing,
    leaf_errors,
    within_one_turn,
    without_value,
)
from solver.numerics.linear_algebra import are_alike
from solver.numerics.tolerances import (
    LOST,
    MAX_UNKNOWNS,
    MEANINGLESS,
    NEIGHBOURS,
    NO_DIGIT,
    SAFETY,
    SAME_ANSWER,
    VAGUE,
)
from solver.path import Evaluate, SolveBlock, equations_of
from solver.path.cases import MIRRORED
from solver.path.planner import planner
from solver.ranking.ranking import Ranking, settled
from solver.solution.explore import GRACE, explore

MAX_STEPS = 2_000
"""The most steps of a path, over all answers, that are followed in extended precision."""


def explore_refined(asked: Asked, always: bool = False) -> Exploration:
    """As ``explore``, with every judged number right to the last digit of a float.

    Leaves that are refined hold their values to more digits in ``branch.precise``; ``always``: all
    are, needed or not. Raises CutOff at the time limit.
    """
    try:
        found = explore(asked, thorough=always)
    except CutOff as reached:
        known = asked.inputs if reached.found.delicate else reached.known
        raise CutOff(certain(asked, reached.found), known) from None
    leaves = (*found.leaves, *found.contradicted)
    too_long = sum(len(leaf.branch.steps) for leaf in leaves) > MAX_STEPS
    too_long = too_long or any(len(gap.unknowns) > MAX_UNKNOWNS for gap in found.gaps)
    kept = found.leaves
    try:
        if always or not too_long:
            if not (always or needs_digits(asked, found)):
                return found
            from rulesheets.evaluate.digits import in_many_digits  # floats are mostly enough
            from solver.solution.precise_search import explore_precisely

            sides = (side for rule in asked.model.equations for side in rule.sides)
            if all(map(in_many_digits, sides)) and (precise := explore_precisely(asked, found)):
                return precise
            kept = tuple(leaf for leaf in kept if not (leaf.solved and _meaningless(asked, leaf)))
        lost = found.complete and any(_vague(asked, leaf) for leaf in found.contradicted)
    except TimeIsUp:
        raise CutOff(certain(asked, found), asked.inputs) from None
    complete = found.complete and not lost and len(kept) == len(found.leaves)
    return replace(found, leaves=kept, complete=complete)


def needs_digits(asked: Asked, found: Exploration) -> bool:
    """Whether floats may say too little of some answer, or of a branch that contradicts a rule."""
    leaves = (*found.leaves, *found.contradicted)
    return found.delicate or any(_vague(asked, leaf) for leaf in leaves)


def _meaningless(asked: Asked, leaf: Leaf) -> bool:
    """Whether some value is only rounding: the sine of 1e90 + x is any number for values of 1e90
    that are next to one another, and the rule holds for any x. What only floats lose in a rule
    (``exp(x) - 1`` at a small x) does not make an answer meaningless."""
    branch = leaf.branch
    numbers = {
        n: abs(v) for n in asked.judged if isinstance(v := branch.values.get(n), float) and v
    }

    def open_by(errors: ForwardErrors) -> bool:
        return any(MEANINGLESS * v < errors.error[n] < math.inf for n, v in numbers.items())

    if not open_by(leaf_errors(asked.model, leaf)):
        return False
    doubles = [fact for fact in branch.facts if isinstance(fact, DoubleRoot)]
    held = forward_errors(
        asked.model, branch.values, branch.steps, branch.conditions, doubles, held=not doubles
    )
    return open_by(held)


def certain(asked: Asked, found: Exploration) -> Exploration:
    """The answers that floats are sure of: the only useful part of an interrupted search."""
    leaves: tuple[Leaf, ...] = ()
    with grace(GRACE), suppress(TimeIsUp):
        if not found.delicate:
            leaves = tuple(one for one in found.leaves if one.solved and not _vague(asked, one))
    return replace(found, leaves=leaves, contradicted=(), open_cases=(), complete=False)


def _vague(asked: Asked, leaf: Leaf) -> bool:
    """Whether floats may have lost digits of an answer, or leave open whether there is one."""
    told, values = leaf_errors(asked.model, leaf), leaf.branch.values
    errors = told.error
    numbers = {name: abs(v) for name, v in values.items() if isinstance(v, float)}
    names, limit = (asked.judged, VAGUE) if leaf.solved else (tuple(numbers), LOST)
    if (
        told.cancelled
        or any(errors[name] > limit * numbers[name] for name in names if name in numbers)
        or any(errors[name] >= NO_DIGIT * size > 0.0 for name, size in numbers.items())
    ):
        return True
    for conflict in (fact for fact in leaf.conflicts if isinstance(fact, Conflict)):
        for index in conflict.equations:  # missed by no more than the errors of the values explain
            if explained(asked.model.equations[index], values, conflict.miss, errors):
                return True
    return False


# --- requirements on single unknowns as ranges, for a search that cannot cover everything ---


def explore_required(asked: Asked, always: bool = False) -> Exploration:
    """As ``explore_refined``; if that leaves something open, again within the ranges that
    requirements allow.

    Answers that violate a requirement remain known from the first search.
    """
    found = explore_refined(asked, always)
    if found.complete or not asked.model.requirements:
        return found
    within = narrowed(asked.model, asked.inputs)
    if within is None:
        return found
    try:
        inside = explore_refined(asked._replace(model=within), always)
    except TimeIsUp:
        raise CutOff(certain(asked, found), asked.inputs) from None
    some, before = (sum(leaf.solved for leaf in one.leaves) for one in (inside, found))
    better = some >= before if inside.complete else some > 0 == before
    contradicted = inside.contradicted or found.contradicted
    return replace(inside, contradicted=contradicted) if better else found


def narrowed(model: Model, inputs: Values) -> Model | None:
    """The model with the ranges that requirements imply at these inputs; None if they are no
    narrower."""
    variables = dict(model.variables)
    for requirement in model.requirements:
        comparison, guarded = requirement.comparison, bool(requirement.guard)
        left, operator, right = comparison.left, comparison.operator, comparison.right
        for side, relation, other in ((left, operator, right), (right, MIRRORED[operator], left)):
            if guarded or not isinstance(side, Name) or side.name in inputs:
                continue
            with suppress(Undefined, TypeError, KeyError):
                limit = value(other, inputs)
                if relation != "<>" and math.isfinite(limit):
                    variables[side.name] = _within(variables[side.name], relation, limit)
    if variables == dict(model.variables) or any(v.low > v.high for v in variables.values()):
        return None
    kept: Model | None = model.__dict__.get("_narrowed")
    if kept is None or kept.variables != variables:
        kept = model.__dict__["_narrowed"] = replace(model, variables=variables)
    return kept


def _within(variable: Variable, operator: str, limit: float) -> Variable:
    is_open = len(operator) == 1
    if operator[0] == ">" and (limit, is_open) > (variable.low, variable.low_open):
        return replace(variable, low=limit, low_open=is_open)
    if operator[0] == "<" and (limit, not is_open) < (variable.high, not variable.high_open):
        return replace(variable, high=limit, high_open=is_open)
    return variable


# --- judged ---


class Verdict(NamedTuple):
    """``leaves`` are the answers (or their determined parts), the primary first.

    ``facts`` are the reasons for the status; ``structural`` the names that these inputs could not
    determine at any values. ``reread``: rules were read as they are only at these values, so it
    says nothing about others. (Rules that are only left out still count.)
    """

    status: Status
    leaves: tuple[Leaf, ...]
    facts: tuple[Fact, ...] = ()
    structural: tuple[str, ...] = ()
    reread: bool = False


def is_complete(verdict: Verdict, found: Exploration) -> bool:
    """Whether the answers of a verdict are known to be all there are.

    ``leaves.py`` says what makes an exploration complete.
    """
    solved = verdict.status is Status.SOLVED and found.complete and not verdict.facts
    return solved or verdict.status is Status.INFEASIBLE


def judge(asked: Asked, found: Exploration) -> Verdict:
    """The status of a solve, from its leaves."""
    model, inputs = asked.model, asked.inputs
    underdetermined = [leaf for leaf in found.leaves if leaf.underdetermined and leaf.missing]
    uncovered = _uncovered(model, found) if underdetermined else ()
    solved = [
        leaf
        for leaf in found.leaves
        if leaf.solved and not any(_continues(leaf, case) for case in uncovered)
    ]
    apart = any(not leaf.branch.on_boundary for leaf in solved)
    if underdetermined and not (uncovered and apart):
        return _unfinished(model, underdetermined, inputs)
    solved = _distinct(model, solved)
    graph = planner(model).graph
    near = [leaf for leaf in solved if within_one_turn(graph, leaf.branch.values, inputs)]
    solved = _ordered(asked, near or solved)
    solved.sort(key=lambda leaf: (bool(unsettled(leaf)), _lacks_a_local(leaf)))
    if solved:
        assumed = CaseAnalysis(model, inputs).independent_assumptions
        free = [facts.Uncovered(assumed(leaf.branch), leaf.missing) for leaf in uncovered]
        if not unsettled(solved[0]):
            beside: list[Fact] = [*_curves(model, found, inputs), *free]
            return Verdict(Status.SOLVED, tuple(solved), tuple(dict.fromkeys(beside)))
        fixed, unfixed = zip(*(_fixed(model, leaf) for leaf in solved), strict=True)
        return Verdict(Status.SINGULAR, fixed, (*unsettled(solved[0]), *unfixed[0], *free))
    if found.leaves:
        leaves = _open(model, found.leaves, inputs)
        fewest = min(len(leaf.missing) for leaf in leaves)
        leaves = [leaf for leaf in leaves if len(leaf.missing) == fewest]
        verdict = _unfinished(model, _ordered(asked, leaves), inputs)
        if verdict.status in (Status.INFEASIBLE, Status.INCONSISTENT) and not _conclusive(found):
            ends = [
                f
                for f in verdict.facts
                if isinstance(f, facts.NoValue | facts.OutOfRange | facts.NoRoot)
            ]
            if any(_on_every_branch(model, found, leaves[0], fact) for fact in ends):
                return verdict
            before = next((gap.unknowns for gap in found.gaps if gap.unknowns), ())
            dead = tuple(facts.DeadEnd(fact, before) for fact in ends[:1])
            return Verdict(Status.FAILED, verdict.leaves, dead)
        if verdict.status is Status.INFEASIBLE and found.contradicted:
            return _contradicted(found)  # a branch has every value, and only a rule contradicts it
        return verdict
    # what contradicts an equality that was assumed says no more than that it is no answer
    inside = tuple(leaf for leaf in found.contradicted if not leaf.branch.on_boundary)
    refused = [leaf.branch for leaf in found.open_cases if not leaf.branch.on_boundary]
    farthest = max(refused, key=lambda branch: len(branch.values), default=None)
    cases = found.complete and all(leaf.branch.signs for leaf in inside)
    beyond = farthest is not None and all(
        len(leaf.branch.values) < len(farthest.values) for leaf in inside
    )
    outside = any(not leaf.branch.on_boundary for leaf in found.outside_case)
    if inside and not (cases and (beyond or outside)):  # a case in which more is known tells more
        return _contradicted(replace(found, contradicted=inside))
    if not found.complete:
        return Verdict(Status.FAILED, ())
    return Verdict(Status.INFEASIBLE, (), () if farthest is None else farthest.reasons)


def _curves(model: Model, found: Exploration, inputs: Values) -> Iterator[facts.Beside]:
    """The branches that end with wanted variables free: answers, but not isolated ones."""
    for leaf in found.leaves:
        why = leaf.branch.reasons
        if (
            leaf.missing
            and why
            and all(isinstance(fact, facts.AsksNothing | facts.RankLoss) for fact in why)
        ):
            values = leaf.branch.values.items()
            known = ((n, v) for n, v in values if isinstance(v, float) and n not in inputs)
            posted = tuple((n, v) for n, v in known if model.variables[n].posted)
            yield facts.Beside(facts.about(why[0]), leaf.missing, posted)


def _uncovered(model: Model, found: Exploration) -> Sequence[Leaf]:
    """The cases without contradiction in which no rule determines a wanted variable."""
    return [
        leaf
        for leaf in found.open_cases
        if not (leaf.underdetermined or leaf.branch.on_boundary or blocked(model, leaf))
    ]


def _continues(answer: Leaf, case: Leaf) -> bool:
    """Whether an answer lies at the end of a case that leaves something free, as 5 does where ``if
    a > 5 then y = 5 else y = a``: it is not isolated."""
    values, known = answer.branch.values, case.branch.values
    shared = [name for name in known if name in values]
    ends = (Comparison("=", *pair) for pair in case.branch.signs)
    with suppress(KeyError, Undefined):
        alike = are_alike(map(known.get, shared), map(values.get, shared), SAME_ANSWER)
        reasons = case.branch.reasons  # a rule may hold for any value, where others jump at the end
        idle = any(isinstance(why, facts.AsksNothing | facts.RankLoss) for why in reasons)
        return (alike or idle) and any(holds(end, values) for end in ends)
    return False


def _open(model: Model, leaves: Sequence[Leaf], inputs: Values) -> Sequence[Leaf]:
    """The leaves at which something is free, and nothing refused; all, if there are none of these.

    One of two roots may lead to a contradiction: that does not affect the other.
    """
    if len(leaves) == 1:
        return leaves
    open_ = (Status.PARTIAL, Status.SINGULAR)
    return [leaf for leaf in leaves if _unfinished(model, [leaf], inputs).status in open_] or leaves


def unsettled(leaf: Leaf) -> tuple[facts.DoubleRoot | facts.RestsOnRounding, ...]:
    """Why values of a leaf are not an isolated answer."""
    return tuple(
        fact
        for fact in leaf.branch.facts
        if isinstance(fact, facts.DoubleRoot | facts.RestsOnRounding)
    )


def _fixed(model: Model, leaf: Leaf) -> tuple[Leaf, tuple[facts.Unfixed, ...]]:
    """A leaf at a double root without the numbers that the rules do not determine there."""
    why = unsettled(leaf)
    resting = {fact.unknown for fact in why if isinstance(fact, facts.RestsOnRounding)}
    leaf = replace(leaf, branch=leaf.branch.without(resting))
    doubles = [fact for fact in why if isinstance(fact, facts.DoubleRoot)]
    if not doubles:
        return leaf, ()
    error, branch = leaf_errors(model, leaf).error, leaf.branch
    lost = tuple(n for n in branch.values if n in branch.origins and error.get(n) == math.inf)
    return replace(leaf, branch=branch.without(lost)), (
        facts.Unfixed(lost, doubles[0]),
    ) if lost else ()


def _unfinished(model: Model, leaves: list[Leaf], inputs: Values) -> Verdict:
    """Wanted variables are missing: because of values (inactive rules), or of the inputs'
    pattern."""
    leaves = _distinct(model, leaves)
    leaf = leaves[0]
    given = leaf.branch.given(inputs)
    undetermined = {*planner(model).path(given, leaf.branch.conditions).undetermined}
    structural = tuple(name for name in leaf.missing if name in undetermined)  # for any values
    # what stands in the way of the missing names; all there is, where none of it is on their path
    every = leaf.branch.reasons
    used = leading_to_missing(model, leaf, inputs)
    why = tuple(fact for fact in every if used.intersection(facts.about(fact))) or every
    status = Status.PARTIAL
    if len(structural) < len(leaf.missing) or (why and not structural):
        status = _worst(why)
    if status is Status.PARTIAL and leaf.branch.cut:
        status = Status.FAILED
    doubles = tuple(fact for fact in leaf.branch.facts if isinstance(fact, facts.DoubleRoot))
    if status is Status.SINGULAR and doubles:
        told = any(isinstance(fact, facts.AsksNothing) for fact in why)
        why = (*doubles, *why, *(() if told else (facts.Unfixed(leaf.missing, doubles[0]),)))
    kept = tuple(leaves) if status in (Status.PARTIAL, Status.SINGULAR) else tuple(leaves[:1])
    return Verdict(status, kept, why, structural)


_SEVERITY: tuple[tuple[Status, type[object]], ...] = (
    (Status.INCONSISTENT, facts.Conflict),
    (Status.SINGULAR, facts.Indeterminacy),
    (Status.INFEASIBLE, facts.NoValue),
    (Status.INFEASIBLE, facts.OutOfRange),
    (Status.FAILED, facts.BeyondFloats),
)


def _worst(why: Sequence[Fact]) -> Status:
    for status, kind in _SEVERITY:
        if any(isinstance(fact, kind) for fact in why):
            return status
    roots = [fact for fact in why if isinstance(fact, facts.NoRoot)]
    if roots:
        return Status.INFEASIBLE if any(fact.proven for fact in roots) else Status.FAILED
    lost = [fact for fact in why if isinstance(fact, facts.RankLoss)]
    if any(isinstance(fact, facts.AsksNothing) for fact in why) or any(
        not f.everywhere for f in lost
    ):
        return Status.SINGULAR
    return Status.PARTIAL


def _contradicted(found: Exploration) -> Verdict:
    """Every branch ended at a rule that does not hold."""
    conclusive = _conclusive(found)
    refused = [
        leaf
        for leaf in found.contradicted
        if all(isinstance(fact, facts.Unmet) for fact in leaf.conflicts)
    ]
    if refused:

        def broken(leaf: Leaf) -> tuple[int, float]:
            """How many requirements, and the worst by how much."""
            misses = [fact.miss for fact in leaf.conflicts if isinstance(fact, facts.Unmet)]
            return len(misses), max(math.inf if miss is None else miss for miss in misses)

        leaf = min(refused, key=broken)
        return Verdict(Status.INFEASIBLE if conclusive else Status.FAILED, (leaf,), leaf.conflicts)
    for leaf in found.contradicted:
        if all(isinstance(fact, facts.Indeterminacy | facts.Unmet) for fact in leaf.conflicts):
            return Verdict(Status.SINGULAR, (leaf,), leaf.conflicts)
    leaf = min(found.contradicted, key=lambda leaf: len(leaf.conflicts))
    if len(leaf.conflicts) == 1 and isinstance(conflict := leaf.conflicts[0], facts.Conflict):
        # a single rule that fails for the very unknown that it was solved for contradicts nothing
        for name, step in leaf.branch.origins.items():
            if isinstance(step, Evaluate) and (step.equation,) == conflict.equations:
                return Verdict(Status.FAILED, (leaf,), (facts.BeyondFloats(step.equation, name),))
    if conclusive:
        return Verdict(Status.INCONSISTENT, (leaf,), leaf.conflicts)
    # blocks may have answers beside those that the leaf was led to, and contradicts rules with
    numbers = {
        name: value for name, value in leaf.branch.values.items() if isinstance(value, float)
    }
    open_ = tuple(
        facts.NoRoot(
            gap.equations,
            gap.unknowns,
            False,
            {n: numbers[n] for n in gap.unknowns if n in numbers},
        )
        for gap in found.gaps
        if gap.equations
    )
    return Verdict(Status.FAILED, (leaf,), open_)


def _conclusive(found: Exploration) -> bool:
    """Whether refusals on every branch prove that there is no answer.

    They do if every branch was followed to its end; or if there was only one, of direct steps, none
    of which has more values than it could count.
    """
    ends = (*found.leaves, *found.contradicted, *found.open_cases)
    direct = not any(
        leaf.branch.attempts or any(isinstance(step, SolveBlock) for step in leaf.branch.steps)
        for leaf in ends
    ) and not any(gap.uncounted for gap in found.gaps)
    return found.complete or (len(ends) == 1 and not ends[0].branch.signs and direct)


def _on_every_branch(model: Model, found: Exploration, leaf: Leaf, fact: Fact) -> bool:
    """Whether what refuses a leaf refuses every branch: the values that it follows from, by rules
    without conditions, are the same at all ends, and none belongs to a block with a gap."""
    equations, unknowns = without_value(model, fact)
    read, left = set(unknowns), [*equations]
    while left:
        rule = model.equations[left.pop()]
        if rule.guard:
            return False
        for name in set(rule.names) - read:
            read.add(name)
            left += equations_of(origin) if (origin := leaf.branch.origins.get(name)) else ()
    ends = (*found.leaves, *found.contradicted, *found.open_cases)
    values = [[end.branch.values.get(name) for name in sorted(read)] for end in ends]
    open_ = {name for gap in found.gaps for name in gap.unknowns}
    return bool(equations) and open_.isdisjoint(read) and values[1:] == values[:-1]


# --- which answer comes first -------------------------------------------------------


def _lacks_a_local(leaf: Leaf) -> bool:
    """Whether an auxiliary has no value; a pole is no reason, as it has a limit."""
    return any(
        isinstance(fact, facts.NoValue | facts.OutOfRange)
        and fact.unknown not in leaf.branch.values
        and not getattr(fact, "pole", False)
        for fact in leaf.branch.reasons
    )


def _distinct(model: Model, leaves: Sequence[Leaf]) -> list[Leaf]:
    """The leaves that lead to different answers."""
    first: dict[str, Value] = {}
    every = ((name, value) for leaf in leaves for name, value in leaf.branch.values.items())
    varying = list(
        dict.fromkeys(name for name, value in every if first.setdefault(name, value) != value)
    )
    distinct: list[Leaf] = []
    for leaf in leaves:
        if not any(_same_leaf(model, leaf, other, varying) for other in distinct):
            distinct.append(leaf)
    return distinct


def _same_leaf(model: Model, leaf: Leaf, other: Leaf, varying: Sequence[str]) -> bool:
    """Whether two branches lead to one answer: to the same floats, or to others within rounding.

    ``varying``: the names whose values differ between leaves.
    """
    one, two = leaf.branch.values, other.branch.values
    if one.keys() != two.keys():
        return False
    if not are_alike(map(one.get, varying), map(two.get, varying), SAME_ANSWER):
        return False
    near = are_alike(map(one.get, varying), map(two.get, varying), NEIGHBOURS)
    if near or (leaf.branch.precise and other.branch.precise):
        return near
    errors, others = leaf_errors(model, leaf).error, leaf_errors(model, other).error
    return not any(
        abs(number - at) > SAFETY * (errors[name] + others[name])
        for name, number in one.items()
        if isinstance(number, float) and isinstance(at := two[name], float)
    )


def _ordered(asked: Asked, leaves: list[Leaf]) -> list[Leaf]:
    if len(leaves) < 2:
        return leaves
    answers = [leaf.branch.values for leaf in leaves]
    known = settled(asked.model, asked.inputs, answers)
    ranking = Ranking(asked.model, known, {*chain(*answers)}, asked.guesses)
    order = ranking.order(answers)
    return [leaves[place] for place in order]
