"""One question to its verdict: explored, judged by its leaves, and judged again where more can be said.

Where rules lose an unknown (at a dead centre, above all), they are read again without what vanishes. Where a
block has no answer, its equations may be 0/0 where there would be one, or fix a given number otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import NamedTuple

from rulesheets.deadline import TimeIsUp
from rulesheets.evaluate import Undefined
from rulesheets.evaluate.digits import vanishes
from rulesheets.model import Equation, Model, Value
from rulesheets.syntax import nodes
from solver import facts
from solver.accuracy.rule_check import check_rule, sides
from solver.facts import AsksNothing, DoubleRoot, Fact, RankLoss, Status
from solver.leaves import Asked, Casework, Exploration, Leaf, blocked, leaf_errors, within_one_turn
from solver.numerics.linear_algebra import null_direction
from solver.numerics.tolerances import NEIGHBOURS, SAFETY, SAME_ANSWER
from solver.path import Evaluate, SolveBlock, equations_of
from solver.path.cases import activity, known_rules
from solver.path.planner import planner
from solver.ranking.ranking import Ranking
from solver.solution.refinement import (
    at_a_limit,
    explore_refined,
    explore_required,
    fixed_otherwise,
    with_limits,
)


class Verdict(NamedTuple):
    """``leaves`` are the answers (or what is determined of them), the primary first.

    ``facts`` are what the status rests on; ``structural`` the names that these inputs could not determine at
    any values.
    ``reread``: by rules as they read at these values alone, so that it tells nothing of others. (Rules that
    are only left out still count.)
    """

    status: Status
    leaves: tuple[Leaf, ...]
    facts: tuple[Fact, ...] = ()
    structural: tuple[str, ...] = ()
    reread: bool = False


def judge(asked: Asked, found: Exploration) -> Verdict:
    """The status of a solve, by what its leaves reached."""
    model, inputs = asked.model, asked.inputs
    loose = [leaf for leaf in found.leaves if leaf.loose and leaf.missing]
    uncovered = _uncovered(model, found, inputs) if loose else ()
    if loose and not (uncovered and any(leaf.solved and not leaf.on_edge for leaf in found.leaves)):
        return _unfinished(model, loose, inputs)
    solved = _preferred(model, [leaf for leaf in found.leaves if leaf.solved])
    graph = planner(model).graph
    near = [leaf for leaf in solved if within_one_turn(graph, leaf.branch.values, inputs)]
    solved = _ordered(asked, near or solved)
    solved.sort(key=lambda leaf: bool(_unsettled(leaf)))
    if solved:
        if not _unsettled(solved[0]):
            beside: list[Fact] = [*_curves(model, found, inputs), *uncovered]
            return Verdict(Status.SOLVED, tuple(solved), tuple(dict.fromkeys(beside)))
        fixed, unfixed = zip(*(_fixed(model, leaf) for leaf in solved), strict=True)
        return Verdict(Status.SINGULAR, fixed, (*_unsettled(solved[0]), *unfixed[0]))
    if found.leaves:
        leaves = _open(model, found.leaves, inputs)
        fewest = min(len(leaf.missing) for leaf in leaves)
        leaves = [leaf for leaf in leaves if len(leaf.missing) == fewest]
        verdict = _unfinished(model, _ordered(asked, leaves), inputs)
        if verdict.status in (Status.INFEASIBLE, Status.INCONSISTENT) and not _conclusive(found):
            return Verdict(Status.FAILED, verdict.leaves)
        if verdict.status is Status.INFEASIBLE and found.dead:
            return _contradicted(found)  # there is a way that has every value, and only a rule against it
        return verdict
    if found.dead:
        return _contradicted(found)
    return Verdict(Status.INFEASIBLE if found.complete else Status.FAILED, ())


def _curves(model: Model, found: Exploration, inputs: Mapping[str, Value]) -> Iterator[facts.Beside]:
    """The ways that end where the rules leave wanted variables free: answers, but no isolated ones."""
    for leaf in found.leaves:
        why = leaf.branch.reasons
        if leaf.missing and why and all(isinstance(fact, facts.AsksNothing | facts.RankLoss) for fact in why):
            values = leaf.branch.values.items()
            known = ((n, v) for n, v in values if isinstance(v, float) and n not in inputs)
            posted = tuple((n, v) for n, v in known if model.variables[n].posted)
            yield facts.Beside(facts.about(why[0]), leaf.missing, posted)


def _uncovered(model: Model, found: Exploration, inputs: Mapping[str, Value]) -> tuple[facts.Uncovered, ...]:
    """The cases that nothing contradicts, and in which no rule determines what is wanted; none where a rule
    of such a case holds whatever that is: then there is a continuum of answers."""
    leaves = [leaf for leaf in found.adrift if not (leaf.loose or leaf.on_edge or blocked(leaf))]
    why = (fact for leaf in leaves for fact in leaf.branch.reasons)
    if any(isinstance(fact, facts.AsksNothing | facts.RankLoss) for fact in why):
        return ()
    told = Casework(model, inputs).told
    return tuple(facts.Uncovered(told(leaf.branch), leaf.missing) for leaf in leaves)


def _open(model: Model, leaves: Sequence[Leaf], inputs: Mapping[str, Value]) -> Sequence[Leaf]:
    """The leaves at which something is free, and nothing refused; all, where there are none of these.

    One of two roots may lead to a contradiction: that says nothing of the other.
    """
    if len(leaves) == 1:
        return leaves
    open_ = (Status.PARTIAL, Status.SINGULAR)
    return [leaf for leaf in leaves if _unfinished(model, [leaf], inputs).status in open_] or leaves


def _unsettled(leaf: Leaf) -> tuple[facts.DoubleRoot | facts.RestsOnRounding, ...]:
    """Why values of a leaf are no isolated answer."""
    return tuple(
        fact for fact in leaf.branch.facts if isinstance(fact, facts.DoubleRoot | facts.RestsOnRounding)
    )


def _fixed(model: Model, leaf: Leaf) -> tuple[Leaf, tuple[facts.Unfixed, ...]]:
    """A leaf at a double root without the numbers that the rules do not determine there."""
    why = _unsettled(leaf)
    resting = {fact.unknown for fact in why if isinstance(fact, facts.RestsOnRounding)}
    leaf = replace(leaf, branch=leaf.branch.without(resting))
    doubles = [fact for fact in why if isinstance(fact, facts.DoubleRoot)]
    if not doubles:
        return leaf, ()
    error, branch = leaf_errors(model, leaf).error, leaf.branch
    lost = tuple(n for n in branch.values if n in branch.origins and error.get(n) == math.inf)
    return replace(leaf, branch=branch.without(lost)), (facts.Unfixed(lost, doubles[0]),) if lost else ()


def _unfinished(model: Model, leaves: list[Leaf], inputs: Mapping[str, Value]) -> Verdict:
    """Wanted variables are missing: because of values (void rules), or of the inputs' pattern."""
    leaf = leaves[0]
    undetermined = planner(model).path(frozenset(inputs), leaf.branch.conditions).undetermined
    structural = tuple(name for name in leaf.missing if name in undetermined)  # however the values come out
    # what stands in the way of the missing names; all there is, where none of it is on their path
    every = leaf.branch.reasons
    way = planner(model).path(frozenset(inputs), leaf.branch.conditions, want=frozenset(leaf.missing))
    used = {equation for step in way.steps for equation in equations_of(step)}
    why = tuple(fact for fact in every if used.intersection(facts.about(fact))) or every
    status = Status.PARTIAL
    if len(structural) < len(leaf.missing) or (why and not structural):
        status = _worst(why)
    if status is Status.PARTIAL and any(isinstance(f, facts.Truncated) for f in leaf.branch.facts):
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
    if any(isinstance(fact, facts.AsksNothing) for fact in why) or any(not f.everywhere for f in lost):
        return Status.SINGULAR
    return Status.PARTIAL


def _contradicted(found: Exploration) -> Verdict:
    """Every way ended at a rule that does not hold."""
    conclusive = _conclusive(found)
    refused = [leaf for leaf in found.dead if all(isinstance(fact, facts.Unmet) for fact in leaf.conflicts)]
    if refused:  # the one that breaks the fewest requirements, and these by least
        misses = [[fact.miss for fact in leaf.conflicts if isinstance(fact, facts.Unmet)] for leaf in refused]
        worst = [(len(row), max(math.inf if miss is None else miss for miss in row)) for row in misses]
        leaf = refused[worst.index(min(worst))]
        return Verdict(Status.INFEASIBLE if conclusive else Status.FAILED, (leaf,), leaf.conflicts)
    for leaf in found.dead:
        if all(isinstance(fact, facts.Indeterminacy | facts.Unmet) for fact in leaf.conflicts):
            return Verdict(Status.SINGULAR, (leaf,), leaf.conflicts)
    leaf = min(found.dead, key=lambda leaf: len(leaf.conflicts))
    if len(leaf.conflicts) == 1 and isinstance(conflict := leaf.conflicts[0], facts.Conflict):
        # a single rule that fails for the very unknown that it was solved for contradicts nothing
        for name, step in leaf.branch.origins.items():
            if isinstance(step, Evaluate) and (step.equation,) == conflict.equations:
                return Verdict(Status.FAILED, (leaf,), (facts.BeyondFloats(step.equation, name),))
    if conclusive:
        return Verdict(Status.INCONSISTENT, (leaf,), leaf.conflicts)
    # blocks may have answers beside those that the leaf was led to, and contradicts rules with
    numbers = {name: value for name, value in leaf.branch.values.items() if isinstance(value, float)}
    open_ = tuple(
        facts.NoRoot(
            gap.equations, gap.unknowns, False, {n: numbers[n] for n in gap.unknowns if n in numbers}
        )
        for gap in found.gaps
        if gap.equations
    )
    return Verdict(Status.FAILED, (leaf,), open_)


def _conclusive(found: Exploration) -> bool:
    """Whether refusals on every way prove that there is no answer.

    They do if every way was followed to its end; or if there was one way only, of direct steps, none of which
    has more values than it could count.
    """
    ends = (*found.leaves, *found.dead, *found.adrift)
    direct = not any(
        leaf.branch.attempts or any(isinstance(step, SolveBlock) for step in leaf.branch.steps)
        for leaf in ends
    ) and not any(gap.uncounted for gap in found.gaps)
    return found.complete or (len(ends) == 1 and not ends[0].branch.signs and direct)


# --- which answer comes first -------------------------------------------------------


def _preferred(model: Model, leaves: list[Leaf]) -> list[Leaf]:
    """Distinct leaves; one in which an auxiliary has no value gives way to one where all have."""
    whole = [
        leaf
        for leaf in leaves
        if not any(  # an auxiliary outside a domain (a pole is no violation: it has a limit)
            isinstance(fact, facts.NoValue | facts.OutOfRange)
            and fact.unknown not in leaf.branch.values
            and not getattr(fact, "pole", False)
            for fact in leaf.branch.reasons
        )
    ] or leaves
    first: dict[str, Value] = {}
    every = ((name, value) for leaf in whole for name, value in leaf.branch.values.items())
    varying = list(dict.fromkeys(name for name, value in every if first.setdefault(name, value) != value))
    distinct: list[Leaf] = []
    for leaf in whole:
        if not any(_same_leaf(model, leaf, other, varying) for other in distinct):
            distinct.append(leaf)
    return distinct


def _same_leaf(model: Model, leaf: Leaf, other: Leaf, varying: Sequence[str]) -> bool:
    """Whether two ways lead to one answer: to the same floats, or to others that rounding makes of them.

    ``varying``: the names whose values are not alike everywhere.
    """
    one, two = leaf.branch.values, other.branch.values
    if one.keys() != two.keys():
        return False
    if _same(one, two, varying, NEIGHBOURS):
        return True
    if (leaf.branch.precise and other.branch.precise) or not _same(one, two, varying, SAME_ANSWER):
        return False
    errors, others = leaf_errors(model, leaf).error, leaf_errors(model, other).error
    return not any(
        abs(number - at) > SAFETY * (errors[name] + others[name])
        for name, number in one.items()
        if isinstance(number, float) and isinstance(at := two[name], float)
    )


def _same(
    one: Mapping[str, Value], other: Mapping[str, Value], names: Sequence[str], tolerance: float
) -> bool:
    for a, b in ((one[name], other[name]) for name in names if name in one):
        if a != b and (
            isinstance(a, str) or isinstance(b, str) or not abs(a - b) <= tolerance * max(abs(a), abs(b))
        ):
            return False
    return True


def _ordered(asked: Asked, leaves: list[Leaf]) -> list[Leaf]:
    """Leaves by the rule of ``solver.ranking``."""
    if len(leaves) < 2:
        return leaves
    among = {name for leaf in leaves for name in leaf.branch.values}
    order = Ranking(asked.model, asked.inputs, among, asked.guesses).order(
        [leaf.branch.values for leaf in leaves], asked.inputs
    )
    return [leaves[place] for place in order]


# --- rules that lose an unknown ---
#
# A product with a factor that is 0 at what is known tells nothing of its other factor, and a rule that holds
# such a product does not tie that unknown to the others. Without it the rules may determine what was left
# open: at dead centre the slider's acceleration gives the speed of the crank, which its velocity does not.
# The same goes for rules of a block that say the same thing at these values: one of them is left out.


def _look_behind(
    asked: Asked, found: Exploration, verdict: Verdict, always: bool = False
) -> tuple[Model, Exploration, Verdict] | None:
    """The rules without products that vanish, and what comes of them; None where that is no more.

    For a ``verdict`` on what was ``found`` that leaves something open. Where two answers coincide it stands:
    what the rules read there is the edge between those two.
    """
    if any(isinstance(fact, DoubleRoot) for fact in verdict.facts):
        return None
    void = [fact for leaf in found.leaves for fact in leaf.branch.reasons]
    if not any(isinstance(fact, RankLoss | AsksNothing) for fact in void):
        return None
    lost = (fact for fact in void if isinstance(fact, RankLoss))
    model, first = asked.model, found.leaves[0].branch.values
    values = {  # numbers that all leaves have
        name: value
        for name, value in first.items()
        if isinstance(value, float) and all(leaf.branch.values.get(name) == value for leaf in found.leaves)
    }
    reduced, open_ = _reduced(model, values)
    repeated = {place for fact in lost if (place := _repeated(model, fact, values)) is not None}
    if not open_ and not repeated:
        return None
    left = (
        replace(e, left=nodes.ZERO, right=nodes.ZERO) if e.index in repeated else e for e in reduced.equations
    )
    reduced = replace(reduced, equations=tuple(left))
    again = explore_refined(asked._replace(model=reduced), always)
    told = judge(asked._replace(model=reduced), again)._replace(reread=bool(open_))
    if told.status is not Status.INFEASIBLE:
        if not told.leaves or not all(_stands(model, leaf) for leaf in told.leaves):
            return None
        known = [
            sum(name in leaf.branch.values for leaf in one.leaves[:1] for name in asked.judged)
            for one in (verdict, told)
        ]
        if told.status in (Status.PARTIAL, Status.SINGULAR) and known[1] > known[0]:
            told = told if verdict.status is Status.PARTIAL else _singular(model, told, open_)
        elif told.status is not Status.SOLVED:
            return None
    return reduced, again, told


def _singular(model: Model, told: Verdict, open_: Sequence[AsksNothing]) -> Verdict:
    """What is determined, by the leaves that know most; the rules that tell nothing here say what is not."""
    fewest = min(len(leaf.missing) for leaf in told.leaves)
    leaves = tuple(leaf for leaf in told.leaves if len(leaf.missing) == fewest)
    decided = leaves[0].branch.conditions
    facts = tuple(
        fact
        for fact in open_
        if fact.unknown not in leaves[0].branch.values and activity(model.equations[fact.equation], decided)
    )
    return told._replace(status=Status.SINGULAR, leaves=leaves, facts=facts[:1] or told.facts, structural=())


def _stands(model: Model, leaf: Leaf) -> bool:
    """Whether the rules as they are written hold, all that can be read."""
    values, decided = leaf.branch.values, leaf.branch.conditions
    return all(check_rule(rule, values).holds for rule in known_rules(model, decided, values))


def _repeated(model: Model, fact: RankLoss, values: Mapping[str, float]) -> int | None:
    """A rule of a block that follows from its others, to first order: the one that has most part in it."""
    equations = [model.equations[index] for index in fact.equations]
    unknowns = [n for n in dict.fromkeys(n for e in equations for n in e.names) if n not in values]
    at = {**values, **dict.fromkeys(unknowns, 1.0)}
    try:
        slopes = [sides(e, at).slopes for e in equations]
    except Undefined:
        return None
    rows = [[slope.get(n, 0.0) for n in unknowns] for slope in slopes]
    sizes = [max(map(abs, row), default=0.0) for row in rows]
    if len(rows) != len(unknowns) or not all(sizes):
        return None
    unit = [[entry / size for entry in row] for row, size in zip(rows, sizes, strict=True)]
    shares = null_direction(list(zip(*unit, strict=True)), [1.0] * len(rows))
    return fact.equations[max(range(len(shares)), key=lambda place: abs(shares[place]))]


def _reduced(model: Model, values: Mapping[str, float]) -> tuple[Model, tuple[AsksNothing, ...]]:
    """The model without products that vanish at the values; which rule tells nothing of which unknown."""
    equations: list[Equation] = []
    told_nothing: list[AsksNothing] = []
    for equation in model.equations:
        left, right = (_without(side, values) for side in (equation.left, equation.right))
        without = replace(equation, left=left, right=right)
        lost = set(equation.names) - set(without.names) - values.keys()
        if lost and (not values.keys() >= set(without.names) or check_rule(without, values).holds):
            told_nothing += [AsksNothing(equation.index, name) for name in equation.names if name in lost]
            equation = without
        equations.append(equation)  # one that is left with a contradiction has no value for what it loses
    return replace(model, equations=tuple(equations)), tuple(dict.fromkeys(told_nothing))


def _without(side: nodes.Expression, values: Mapping[str, float]) -> nodes.Expression:
    """The expression with 0 for products and quotients of what is 0 at the values with what is unknown."""
    parts = nodes.children(side)
    if not parts:
        return side
    done: list[nodes.Expression] = []
    for part in parts:  # a loop, for one frame a level: trees may be hundreds of levels deep
        done.append(_without(part, values))
    pairs = [done] if isinstance(side, nodes.Product | nodes.Quotient) else []
    for factor, other in [*pairs, done[::-1]] if isinstance(side, nodes.Product) else pairs:
        nothing = nodes.is_number(factor, 0.0) or (_read(factor, values) and vanishes(factor, values))
        if nothing and not _read(other, values):
            return nodes.ZERO
    if all(new is old for new, old in zip(done, parts, strict=True)):
        return side
    match side:
        case nodes.Sum():
            return nodes.add(*done)
        case nodes.Negative():
            return nodes.negative(done[0])
        case nodes.Product():
            return nodes.multiply(*done)
        case _:
            return nodes.rebuilt(side, tuple(done))


def _read(part: nodes.Expression, values: Mapping[str, float]) -> bool:
    return all(name in values for name in nodes.names(part))


def conclude(
    asked: Asked, *, prove: bool = False, limits: bool = False
) -> tuple[Verdict, Exploration, Model]:
    """The verdict on these inputs, what it rests on, and the model as it was read for it.

    When the time is up after the first verdict, that is the last. Raises TimeIsUp before there is one.
    """
    found = explore_required(asked, always=prove)
    verdict, by = judge(asked, found), asked.model
    if verdict.status in (Status.SINGULAR, Status.PARTIAL):
        with suppress(TimeIsUp):
            behind = _look_behind(asked, found, verdict, always=prove)
            by, found, verdict = behind or (by, found, verdict)
    with suppress(TimeIsUp):
        if limits:
            by, found = with_limits(asked, found)
            verdict = judge(asked._replace(model=by), found)._replace(reread=by is not asked.model)
        elif verdict.status is Status.FAILED and verdict.leaves:
            undefined = at_a_limit(asked, verdict.leaves[0], verdict.facts)
            if undefined is not None:
                verdict = Verdict(Status.SINGULAR, verdict.leaves, undefined)
        if verdict.status in (Status.FAILED, Status.INFEASIBLE):
            fixed = fixed_otherwise(asked, verdict.facts)
            verdict = verdict._replace(status=Status.INCONSISTENT, facts=(fixed,)) if fixed else verdict
    return verdict, found, by
