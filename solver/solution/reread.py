"""Rules read again if a verdict is open: without vanishing factors, or at 0/0 by limits.

If rules lose an unknown (above all at a dead centre), they are solved again without vanishing
factors. If a block has no answer, its equations may be 0/0 at one, or determine a given number
otherwise.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import chain, product
from typing import Any

from rulesheets.deadline import TimeIsUp
from rulesheets.evaluate import Undefined, value
from rulesheets.evaluate.digits import (
    DIGITS,
    beside,
    extended,
    extended_derivatives,
    indeterminate,
    is_known,
    vanishes,
)
from rulesheets.evaluate.number import rounded
from rulesheets.functions import named
from rulesheets.model import Equation, Model, Values
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Name, Number, Quotient, calls, exchange, walk
from solver.accuracy.rule_check import check_rule
from solver.accuracy.rule_sides import gross, half_unit
from solver.facts import (
    AsksNothing,
    Conflict,
    DoubleRoot,
    Fact,
    Filled,
    Fixed,
    Indeterminacy,
    NoRoot,
    NoValue,
    RankLoss,
    Status,
)
from solver.kernel.step import OTHERWISE
from solver.leaves import Asked, Exploration, Leaf, indeterminacy, unmet
from solver.numerics.tolerances import BACKWARD, NEIGHBOURS, ROUGHLY, SAME_VALUE
from solver.path import activity, known_rules
from solver.path.cases import outcomes
from solver.path.planner import planner
from solver.solution.explore import explore
from solver.solution.remedy import Patience
from solver.solution.verdict import Verdict, explore_refined, explore_required, judge

# --- removable singularities: rules that are 0/0 are taken by their limits ---
#
# Forward, the limit stands in for the part that is 0/0. Backward, where the place itself is
# unknown, an answer is the common limit of the answers for one input a little larger and a little
# smaller (L. F. Richardson's deferred approach, Phil. Trans. A 226, 1927), and it stands only if
# every rule holds there, those that are 0/0 by their limits from all sides.

ROUNDS = 8
STEPS = (2.0**-20, 2.0**-21, 2.0**-22)
"""How far an input is moved, in units of the power of two next to it."""
WEIGHTS = (1, -6, 8)
"""Those of the mean answers at the three steps, times their sum, so that the first and second
powers of the step cancel on each side: the larger of two capacity flows has a kink where they are
equal."""
APART = 1e-2
"""Relative distance within which answers on both sides belong together."""
NO_LIMIT = 1e-12
"""Share of the answers beside it below which an extrapolated number is 0."""
NEAR = 1e-4
"""Relative distance within which an answer near a known one is the same, moved."""
PLACES = 6
"""Decimals and digits to which a nearest miss is rounded, to see whether a rule is 0/0 there, and
to which rules must hold."""
MOST_MOVED = 6
"""Inputs that are moved, one after another, until answers are found."""
TINY = 1e-30
"""The distance from an answer at which a rule is evaluated, relative to its values."""


def with_limits(asked: Asked, found: Exploration) -> tuple[Model, Exploration]:
    """The results with limits, and the model with the limits in place of parts of its rules.

    Forward, limits replace parts that are 0/0 at values that do not depend on them, and the path is
    followed again.
    """
    by = asked.model
    filled: dict[int, float] = {}
    for _ in range(ROUNDS):
        ends = (*found.leaves, *found.contradicted)
        limits = dict(_filled(by, ends[0].branch.values)) if len(ends) == 1 else {}
        if not limits:
            break
        equations = tuple(limits[e.index][0] if e.index in limits else e for e in by.equations)
        filled |= {index: limit for index, (_, limit) in limits.items()}
        by = replace(by, equations=equations)
        found = explore_required(asked._replace(model=by))
    limits_taken = tuple(Filled(*pair) for pair in filled.items())
    leaves = tuple(leaf.but(facts=(*leaf.branch.facts, *limits_taken)) for leaf in found.leaves)
    solved = tuple(leaf for leaf in leaves if leaf.solved)
    whole = found.complete and not any(outcome.holes for outcome in found.outcomes.values())
    if (solved and whole) or not (more := answers_between(asked, solved)):
        return by, replace(found, leaves=leaves)
    return asked.model, replace(found, leaves=(*solved, *more), complete=False)


def _filled(model: Model, values: Values) -> Iterator[tuple[int, tuple[Equation, float]]]:
    """The equations that are 0/0 at the values, with the limit of that part in its place, and that
    limit."""
    for equation in model.equations:
        for side in equation.sides:
            found = indeterminate(side, values)
            if found is not None and found.limit is not None:
                left, right = (exchange(s, found.part, Number(found.limit)) for s in equation.sides)
                yield equation.index, (equation.but(left, right), found.limit)
                break


# --- backward -------------------------------------------------------------------------


def answers_between(asked: Asked, known: Sequence[Leaf] = ()) -> tuple[Leaf, ...]:
    """Answers at which rules are 0/0, as common limits of answers for slightly smaller and slightly
    larger inputs, except the ``known`` ones."""
    model, inputs = asked.model, asked.inputs
    every = walk(*(side for e in model.equations for side in e.sides))
    if not any(isinstance(part, Quotient) for part in every):
        return ()
    read = Counter(name for e in model.equations for name in e.names)
    said = {  # the rules that only give a number, ``C = 2000``
        rule.left.name: (rule, rule.right.value)
        for rule in model.equations
        if isinstance(rule.left, Name) and isinstance(rule.right, Number) and not rule.guard
    }
    given = {**{name: number for name, (_, number) in said.items()}, **inputs}
    numbers = {n: v for n, v in given.items() if isinstance(v, float) and read[n]}
    for name in sorted(numbers, key=lambda name: (numbers[name] != 1.0, -read[name]))[:MOST_MOVED]:
        number = numbers[name]
        size = 2.0 ** math.frexp(number)[1] if number else 1.0  # both results hold the step exactly
        moved = (number + sign * step * size for step in STEPS for sign in (1, -1))
        free = model if name in inputs else _without_rule(model, said[name][0])
        trials = (asked._replace(model=free, inputs={**inputs, name: there}) for there in moved)
        sides = list[tuple[Leaf, ...]]()
        for leaves in map(_beside, trials):
            if not any(all(_distance(leaf, old) > NEAR for old in known) for leaf in leaves):
                break
            sides.append(leaves)
        if len(sides) < 2 * len(STEPS):
            continue
        found = (_between(leaf, sides, {**inputs, name: number}) for leaf in sides[-1])
        standing = (_standing(model, leaf, inputs) for leaf in found if leaf is not None)
        if leaves := tuple(leaf for leaf in standing if leaf is not None):
            return leaves
    return ()


def _without_rule(model: Model, rule: Equation) -> Model:
    """The model with an empty rule in place of one."""
    equations = (e.but(e.left, e.left) if e is rule else e for e in model.equations)
    return replace(model, equations=tuple(equations))


def _beside(asked: Asked) -> tuple[Leaf, ...]:
    floats = explore(asked, brief=True)
    ended = any(leaf.solved or leaf.conflicts for leaf in (*floats.leaves, *floats.contradicted))
    if not ended and not floats.delicate:
        return ()
    from solver.solution.precise_search import explore_precisely

    found = explore_precisely(asked, floats) or floats
    return tuple(leaf for leaf in found.leaves if leaf.solved)


def _between(leaf: Leaf, sides: Sequence[Sequence[Leaf]], inputs: Values) -> Leaf | None:
    """The common limit of the answers that belong to this one; None if they do not converge."""
    nearest = [min(side, key=lambda other: _distance(leaf, other)) for side in sides]
    if max(_distance(leaf, other) for other in nearest) > APART:
        return None
    precise = dict[str, Any]()
    for name, here in leaf.branch.values.items():
        if isinstance(here, str) or name in inputs:
            continue
        numbers: list[Any] = [
            b.precise.get(name, b.values[name]) for b in (one.branch for one in nearest)
        ]
        means = [(one + other) / 2 for one, other in zip(numbers[::2], numbers[1::2], strict=True)]
        total = sum(weight * mean for weight, mean in zip(WEIGHTS, means, strict=True))
        limit = total / sum(WEIGHTS)
        precise[name] = 0 * limit if abs(limit) <= NO_LIMIT * max(map(abs, numbers)) else limit
    floats = {name: float(limit) for name, limit in precise.items()}
    return leaf.but(values={**leaf.branch.values, **floats, **inputs}, precise=precise)


def _distance(one: Leaf, other: Leaf) -> float:
    a, b = one.branch.values, other.branch.values
    if a.keys() != b.keys() or any(isinstance(v, str) and b[n] != v for n, v in a.items()):
        return math.inf
    pairs = ((v, w) for n, v in a.items() if isinstance(v, float) and isinstance(w := b[n], float))
    small = 4 * STEPS[0]
    return max(
        (abs(v - w) / max(abs(v), abs(w), small) for v, w in pairs if abs(v - w) > small),
        default=0.0,
    )


def _standing(model: Model, leaf: Leaf, inputs: Values) -> Leaf | None:
    """The answer with the limits of its rules; None if one of them does not hold, or none is
    0/0."""
    values = leaf.branch.values
    decided = outcomes(model, values, inputs)
    facts = []
    for equation in known_rules(model, decided, values):
        parts = (indeterminate(side, values) for side in equation.sides)
        limits = [part.limit for part in parts if part is not None]
        if None in limits or not (
            _holds_beside(equation, values) if limits else check_rule(equation, values).holds
        ):
            return None
        facts += [Filled(equation.index, limit) for limit in limits if limit is not None]
    admitted = all(
        v.admits(x) for n, v in model.variables.items() if isinstance(x := values.get(n), float)
    )
    if not facts or not admitted or any(unmet(model, values, decided)):
        return None
    leaf = leaf.but(decided={**leaf.branch.decided, **decided}, facts=tuple(facts))
    return replace(leaf, worst=0.0)


def _holds_beside(equation: Equation, values: Values) -> bool:
    """Whether a rule holds in the limit: its residual on both sides of a point, to first order."""
    line = {name: 1.0 + 0.1 * (k % 3) for k, name in enumerate(equation.names)}
    form = equation.form
    try:
        there = beside(values, line, -TINY)
        miss, slopes = extended_derivatives(form, there, DIGITS)
        miss += extended(form, beside(values, line, TINY), DIGITS)
    except Undefined:
        return False
    total = sum(float(abs(slope * there[name])) for name, slope in slopes.items())
    return bool(abs(miss) / 2 <= BACKWARD * total)


# --- blocks whose equations are 0/0 where there would be an answer, or another one ---


def undefined_beside(asked: Asked, found: Exploration, known: Values) -> Iterator[Indeterminacy]:
    """Rules that are 0/0 at points where those of a block hold in the limit, beside the ``known``
    answer."""
    for (step, _), outcome in found.outcomes.items():
        rules = [asked.model.equations[e] for e in step.equations]
        for point in outcome.holes:
            there = {**known, **_rounded(point)}
            for name, by in (one for rule in rules for one in rule.definitions):
                if name in point:
                    with suppress(Undefined):
                        there[name] = value(by, there)
            undefined = [at for rule in rules if (at := indeterminacy(rule, there)) is not None]
            if any(at.limit is not None for at in undefined) and all(
                _holds_beside(rule, there) for rule in rules
            ):
                yield undefined[0]


def joined(asked: Asked, found: Exploration) -> Asked:
    """The question with unknowns of blocks that are 0/0 somewhere replaced by what other rules say
    they are: ``q/x`` and ``q = sin(x)`` have a limit only together."""
    rules = list(asked.model.equations)
    blocks = [step for (step, _), outcome in found.outcomes.items() if outcome.holes]
    for block, index in ((one, index) for one in blocks for index in one.equations):
        for name, by in () if rules[index].guard else rules[index].definitions:
            for place in {*block.equations} - {index} if name in block.unknowns else ():
                sides = (exchange(side, Name(name), by) for side in rules[place].sides)
                rules[place] = rules[place].but(*sides)
    whole = replace(asked.model, equations=tuple(rules)) if blocks else asked.model
    return asked._replace(model=whole)


def _rounded(point: Mapping[str, float]) -> dict[str, float]:
    return {name: rounded(round(x, PLACES), PLACES) + 0.0 for name, x in point.items()}


def hole(asked: Asked, leaf: Leaf, fact: NoRoot) -> Indeterminacy | None:
    """A rule that is 0/0 next to the nearest miss of a block, where rules nearly hold, and its
    limit at the presumed answer."""
    model, best = asked.model, {**leaf.branch.values, **fact.best}
    there = {**best, **_rounded(fact.best)}
    rules = [model.equations[e] for e in fact.equations]
    sizes = zip(rules, fact.misses, strict=False)
    if any(abs(miss) > 10.0**-PLACES * gross(rule, best) for rule, miss in sizes):
        return None
    found = [rule for rule in rules if (at := indeterminacy(rule, there)) and at.limit is not None]
    answers = [there] if all(_holds_beside(rule, there) for rule in found) else []
    answers = answers or [other.branch.values for other in answers_between(asked)]
    holes = (indeterminacy(rule, answer) for rule in found for answer in answers)
    return next((hole for hole in holes if hole and hole.limit is not None), None)


# --- given numbers that the rules fix otherwise, whatever the unknowns are ---
#
# A ratio of speeds does not depend on the free speed. A search for a speed with the given ratio
# finds none, or approaches 0; but the rules give the ratio the same value at any speed.

TRIALS = (1.3247180, 7.3890561, 0.0207880, 1.1e-4)
"""Shares of its size at which an unknown is tried."""
EVERYDAY = 0.7548777
"""Another trial value: for tiny inputs ``exp(x) - x`` is 1 at all other trials."""
MOST = 4
"""The most unknowns, and given numbers, that are examined."""
LITTLE = 10_000
"""Work that this may take: what is proven at every trial takes some hundreds."""
_FLAT = named(lambda row: not row.smooth)
"""Functions that are constant, or without a part of their arguments, over a range of them."""


def fixed_otherwise(asked: Asked, refusals: Sequence[Fact]) -> Fixed | None:
    """The given number that contradicts the rules at any value of an unknown; None if none does."""
    patience = Patience(LITTLE)
    for fact in refusals:  # the rules of which it is said that nothing satisfies them
        match fact:
            case NoRoot(equations=equations, unknowns=unknowns):
                pass
            case NoValue(e, u, reading, pole) if pole or reading.startswith(OTHERWISE):
                equations, unknowns = (e,), (u,)
            case _:
                continue
        rules = [asked.model.equations[e] for e in equations]
        flat = (call.function in _FLAT for rule in rules for call in calls(*rule.sides))
        if any(rule.guard for rule in rules) or any(flat):
            continue  # what they say may differ from one range of their variables to the next
        if (found := next(_fixed(asked, rules, unknowns, patience), None)) is not None:
            return found
    return None


def _fixed(
    asked: Asked, rules: Sequence[Equation], unknowns: Sequence[str], patience: Patience
) -> Iterator[Fixed]:
    read = [name for rule in rules for name in rule.names]
    alone = {side.name for rule in rules for side in rule.sides if isinstance(side, Name)}
    own = {name: variable.value for name, variable in asked.model.variables.items()}
    numbers = {n: v for n, v in asked.inputs.items() if n in read and isinstance(v, float)}
    given = sorted(
        numbers, key=lambda name: (own[name] == numbers[name], name not in alone, read.count(name))
    )
    free = sorted(
        (n for n in unknowns if n in read), key=lambda name: (own[name] is None, name in alone)
    )
    moving = set[str]()  # those that follow an unknown
    for unknown, name in product(free[:MOST], given[:MOST]):
        number = numbers[name]
        if name not in moving and (ends := _ends(asked, name, unknown, patience)):
            size = max(map(abs, ends))
            if ends[1] - ends[0] > SAME_VALUE * size:
                moving.add(name)
                continue
            slack = BACKWARD * max(size, abs(number))
            if not ends[0] - slack <= number <= ends[1] + slack:
                yield Fixed(name, ends[0], number, unknown, tuple(rule.index for rule in rules))


def _ends(asked: Asked, name: str, unknown: str, patience: Patience) -> tuple[float, float] | None:
    """The least and the greatest value that the rules give a variable at trials of an unknown, up
    to the first that differ by more than rounding; None if they may have others at one of them."""
    rest = {n: v for n, v in asked.inputs.items() if n != name}
    sizes = [abs(v) for v in rest.values() if isinstance(v, float) and v]
    size = math.exp(sum(map(math.log, sizes)) / len(sizes)) if sizes else 1.0
    found: set[float] = set()
    trials, variable = [share * size for share in TRIALS], asked.model.variables[unknown]
    for at in [*trials, EVERYDAY] if variable.admits(EVERYDAY) else trials:
        trial = {**rest, unknown: at}
        if patience.lost or not variable.admits(at):
            return None
        tried = patience.shown(explore(Asked(asked.model, trial, None, {}, (name,)), brief=True))
        values = [leaf.branch.values[name] for leaf in tried.leaves if leaf.solved]
        found.update(value for value in values if isinstance(value, float))
        if found and max(found) - min(found) > SAME_VALUE * max(map(abs, found)):
            break
        if len(values) != 1 or not tried.complete or not found:
            return None
    return min(found), max(found)


def contradicted_otherwise(asked: Asked, found: Exploration) -> Verdict | None:
    """The verdict that a rule contradicts every answer of the others; None where these may have
    more.

    What the rule was solved for itself may be only some of its answers, as of ``tan(E/2) = u``.
    """
    for gap in found.gaps[:MOST]:
        rule = asked.model.equations[gap.equations[0]] if len(gap.equations) == 1 else None
        if rule is None or rule.guard:
            continue
        others = explore(asked._replace(model=_without_rule(asked.model, rule)))
        ends = [leaf for leaf in others.leaves if leaf.branch.values.keys() >= {*rule.names}]
        checks = [check_rule(rule, leaf.branch.values) for leaf in ends]
        clear = others.complete and not others.delicate and len(ends) == len(others.leaves)
        if ends and clear and not any(check.holds or check.delicate for check in checks):
            conflict = Conflict((rule.index,), checks[0].miss, ends[0].branch.values)
            return Verdict(Status.INCONSISTENT, (ends[0],), (conflict,))
    return None


def without_copies(asked: Asked, missed: Exploration, prove: bool) -> Exploration | None:
    """The answers of the rules without a given number that they give back to its last places; None
    if there is none, or if all that was found ``missed`` a rule by far.

    A number that was copied from an answer carries its rounding, which the rules may amplify.
    """
    facts = [fact for leaf in missed.contradicted for fact in leaf.conflicts]
    conflicts, rules = [fact for fact in facts if isinstance(fact, Conflict)], asked.model.equations
    slight = any(
        fact.miss is not None
        and abs(fact.miss)
        <= ROUGHLY * max(gross(rules[index], fact.values) for index in fact.equations)
        for fact in conflicts
    )
    reasons = [fact for leaf in missed.leaves for fact in leaf.branch.reasons]
    clear = not missed.delicate and all(isinstance(fact, NoValue) for fact in reasons)
    if (conflicts and not slight) or (not conflicts and reasons and clear):
        return None
    for name, number in asked.inputs.items():
        if not isinstance(number, float) or not half_unit(number):
            continue
        others = {other: given for other, given in asked.inputs.items() if other != name}
        if name in planner(asked.model).path(frozenset(others), {}).undetermined:
            continue
        want = asked.want and (*asked.want, name)
        free = asked._replace(inputs=others, want=want, judged=(*asked.judged, name))
        found = explore_required(free, always=prove)
        leaves = []  # those that have the number up to a unit in its last place, with it
        for leaf in (leaf for leaf in found.leaves if leaf.solved):
            told = leaf.branch.values[name]
            leaf = leaf.but(values={**leaf.branch.values, name: number})
            near = isinstance(told, float) and abs(told - number) <= NEIGHBOURS * abs(number)
            if near and not _conflicts(asked.model, leaf):
                leaves.append(leaf)
        if leaves:
            return replace(found, leaves=tuple(leaves))
    return None


# --- rules that lose an unknown ---
#
# A product with a factor that is 0 at known values does not depend on its other factor, so a rule
# with such a product does not relate that unknown to the others. Without the product the rules may
# determine the unknown: at dead centre the slider's acceleration gives the speed of the crank,
# which its velocity does not.


def without_vanishing_factors(
    asked: Asked, found: Exploration, verdict: Verdict, always: bool
) -> tuple[Model, Exploration, Verdict] | None:
    """The rules without products that vanish, and the verdict on them; None if that is no better.

    For an open ``verdict`` on what was ``found``. Coinciding answers stay: there the rules are at
    the boundary between the two.
    """
    if any(isinstance(fact, DoubleRoot) for fact in verdict.facts):
        return None
    inactive = [fact for leaf in found.leaves for fact in leaf.branch.reasons]
    if not any(isinstance(fact, RankLoss | AsksNothing) for fact in inactive):
        return None
    model, first = asked.model, found.leaves[0].branch.values
    values = {  # numbers that all leaves have
        name: value
        for name, value in first.items()
        if isinstance(value, float)
        and all(leaf.branch.values.get(name) == value for leaf in found.leaves)
    }
    reduced, open_ = _reduced(model, values)
    if not open_:
        return None
    again = explore_refined(asked._replace(model=reduced), always)
    checked = [replace(leaf, conflicts=_conflicts(model, leaf)) for leaf in again.leaves]
    refused = (leaf for leaf in checked if leaf.conflicts)
    again = replace(
        again,
        leaves=tuple(leaf for leaf in checked if not leaf.conflicts),
        contradicted=(*again.contradicted, *refused),
    )
    told = judge(asked._replace(model=reduced), again)._replace(reread=True)
    if told.status not in (Status.INFEASIBLE, Status.INCONSISTENT):
        if not again.leaves:
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
    """The determined values, by the leaves that know most; the reduced rules say what is not
    determined."""
    fewest = min(len(leaf.missing) for leaf in told.leaves)
    leaves = tuple(leaf for leaf in told.leaves if len(leaf.missing) == fewest)
    decided = leaves[0].branch.conditions
    facts = tuple(
        fact
        for fact in open_
        if fact.unknown not in leaves[0].branch.values
        and activity(model.equations[fact.equation], decided)
    )
    return told._replace(
        status=Status.SINGULAR, leaves=leaves, facts=facts[:1] or told.facts, structural=()
    )


def _conflicts(model: Model, leaf: Leaf) -> tuple[Fact, ...]:
    """The rules as written that can be evaluated, and do not hold."""
    values, decided = leaf.branch.values, leaf.branch.conditions
    checks = ((rule, check_rule(rule, values)) for rule in known_rules(model, decided, values))
    return tuple(
        Conflict((rule.index,), check.miss, values) for rule, check in checks if not check.holds
    )


def _reduced(model: Model, values: Mapping[str, float]) -> tuple[Model, tuple[AsksNothing, ...]]:
    """The model without vanishing products; and which rule does not determine which unknown."""
    equations: list[Equation] = []
    told_nothing: list[AsksNothing] = []
    for equation in model.equations:
        left, right = (_without(side, values) for side in equation.sides)
        without = equation.but(left, right)
        lost = set(equation.names) - set(without.names) - values.keys()
        if lost and (not values.keys() >= set(without.names) or check_rule(without, values).holds):
            told_nothing += [
                AsksNothing(equation.index, name) for name in equation.names if name in lost
            ]
            equation = without
        # one that is left with a contradiction has no value for what it loses
        equations.append(equation)
    return replace(model, equations=tuple(equations)), tuple(dict.fromkeys(told_nothing))


def _without(side: nodes.Expression, values: Mapping[str, float]) -> nodes.Expression:
    """The expression with 0 for products and quotients of zeros with unknowns."""
    done: list[nodes.Expression] = []
    # a loop, for one frame a level: trees may be hundreds of levels deep
    for part in side.parts:
        done.append(_without(part, values))
    pairs = [done] if isinstance(side, nodes.Product | nodes.Quotient) else []
    for factor, other in [*pairs, done[::-1]] if isinstance(side, nodes.Product) else pairs:
        nothing = nodes.is_number(factor, 0.0) or vanishes(factor, values)
        if nothing and not is_known(other, values):
            return nodes.ZERO
    return nodes.rebuilt(side, tuple(done))


def judged_again(
    asked: Asked, found: Exploration, verdict: Verdict, prove: bool, limits: bool
) -> tuple[Verdict, Exploration, Model]:
    """The verdict, its exploration, and the model as it was read for it, if they are better than a
    first ``verdict`` on what was ``found``. When the time is up, the last one."""
    by, refused = asked.model, (Status.FAILED, Status.INFEASIBLE)
    whole = joined(asked, found)
    if verdict.status in (Status.SINGULAR, Status.PARTIAL):
        with suppress(TimeIsUp):
            behind = without_vanishing_factors(asked, found, verdict, always=prove)
            by, found, verdict = behind or (by, found, verdict)
    with suppress(TimeIsUp):
        if limits:
            by, found = with_limits(whole, found)
            verdict = judge(asked._replace(model=by), found)._replace(reread=by is not asked.model)
        if verdict.status in refused and verdict.leaves:
            leaf = verdict.leaves[0]
            beside = undefined_beside(whole, found, leaf.branch.values)
            roots = (f for f in verdict.facts if isinstance(f, NoRoot) and not f.proven)
            holes = chain(beside, (hole(asked, leaf, fact) for fact in roots))
            if undefined := tuple(h for h in holes if h is not None and h.limit is not None):
                verdict = Verdict(Status.SINGULAR, verdict.leaves, undefined)
        if verdict.status is Status.FAILED and found.contradicted:
            verdict = contradicted_otherwise(asked, found) or verdict
        # 0 whatever the unknown is: but where another factor is 0, it may have any value
        proven = verdict.status is Status.INFEASIBLE
        fixed = fixed_otherwise(asked, verdict.facts) if verdict.status in refused else None
        if fixed and (proven or fixed.value):
            verdict = verdict._replace(status=Status.INCONSISTENT, facts=(fixed,))
    return verdict, found, by
