"""Explored again: in more digits where floats are vague, within what requirements allow, at 0/0 by limits.

A refusal is looked into as well: a rule may be 0/0 where there would be an answer, or fix a given number.

The given values are exact numbers, so that an answer exists to all digits, however ill-conditioned. Where the
error bar of an answer says that floats lose more than their rounding, the path is followed once more in
numbers of higher precision, and of twice that, until two precisions agree: then every value is the float
nearest to the exact one. Where they never do, what floats found stands, with its error bars, unless those
leave no digit of a value.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import takewhile
from typing import Any

from rulesheets.deadline import TimeIsUp, grace
from rulesheets.evaluate import Undefined, derivatives, extended, value
from rulesheets.evaluate.digits import DIGITS, beside, extended_derivatives, indeterminate
from rulesheets.functions import named
from rulesheets.model import Equation, Model, Value, Variable
from rulesheets.syntax.nodes import Call, Expression, Name, Number, Quotient, exchange, subtract
from rulesheets.syntax.program import walk
from solver.accuracy.digits import MAX_UNKNOWNS
from solver.accuracy.forward_error import ForwardErrors, forward_errors
from solver.accuracy.rule_check import check_rule, sides
from solver.facts import Conflict, DoubleRoot, Fact, Filled, Fixed, Indeterminacy, NoRoot, NoValue
from solver.kernel.step import OTHERWISE
from solver.leaves import Asked, CutOff, Exploration, Leaf, Patience, indeterminacy, leaf_errors, unmet
from solver.numerics.tolerances import BACKWARD, LOST, MEANINGLESS, NO_DIGIT, SAFETY, SAME_VALUE, VAGUE
from solver.path.cases import MIRRORED, known_rules, outcomes
from solver.solution.explore import GRACE, explore

MAX_STEPS = 2_000
"""Steps of a path, over all answers, that are worth following in extended precision."""


def explore_refined(asked: Asked, always: bool = False) -> Exploration:
    """As ``explore``, with every judged value that has a number right to the last digit of a float.

    Leaves that are refined hold their values to more digits in ``branch.precise``; ``always``: all are,
    needed or not. Raises CutOff where a limit in time is met.
    """
    try:
        found = explore(asked, thorough=always)
    except CutOff as reached:
        known = asked.inputs if reached.found.delicate else reached.known
        raise CutOff(certain(asked, reached.found), known) from None
    leaves = (*found.leaves, *found.dead)
    too_long = sum(len(leaf.branch.steps) for leaf in leaves) > MAX_STEPS
    too_long = too_long or any(len(gap.unknowns) > MAX_UNKNOWNS for gap in found.gaps)
    try:
        if not always and (too_long or not (found.delicate or any(_vague(asked, leaf) for leaf in leaves))):
            return found
        from solver.solution.precise_search import explore_precisely  # floats are mostly enough

        if (precise := explore_precisely(asked, found)) is not None:
            return precise
    except TimeIsUp:
        raise CutOff(certain(asked, found), asked.inputs) from None
    kept = [leaf for leaf in found.leaves if not (leaf.solved and _meaningless(asked, leaf))]
    return found if len(kept) == len(found.leaves) else replace(found, leaves=tuple(kept), complete=False)


def _meaningless(asked: Asked, leaf: Leaf) -> bool:
    """Whether some value is nothing but rounding: the sine of 1e90 + x is any number for values of 1e90 that
    are next to one another, and the rule holds whatever x is. What only floats lose in a rule
    (``exp(x) - 1`` at a small x) leaves an answer its meaning."""
    branch = leaf.branch
    numbers = {n: abs(v) for n in asked.judged if isinstance(v := branch.values.get(n), float) and v}

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
    """The answers that floats are sure of: the only part of a search that was cut off that tells anything."""
    leaves: tuple[Leaf, ...] = ()
    with grace(GRACE), suppress(TimeIsUp):
        if not found.delicate:
            leaves = tuple(one for one in found.leaves if one.solved and not _vague(asked, one))
    return replace(found, leaves=leaves, dead=(), adrift=(), complete=False)


def _vague(asked: Asked, leaf: Leaf) -> bool:
    """Whether floats may have lost digits of an answer, or the answer to whether there is one."""
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
            try:
                slopes = sides(asked.model.equations[index], values).slopes
            except Undefined:
                return True
            reach = sum(abs(slope) * errors.get(name, 0.0) for name, slope in slopes.items())
            if conflict.miss is not None and abs(conflict.miss) <= SAFETY * reach:
                return True
    return False


# --- requirements on single unknowns as ranges: a search that cannot cover everything keeps to them ---


def explore_required(asked: Asked, always: bool = False) -> Exploration:
    """As ``explore_refined``; where that leaves something open, again within what requirements allow.

    Answers that break a requirement remain known from the first search.
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
    return replace(inside, dead=inside.dead or found.dead) if better else found


def narrowed(model: Model, inputs: Mapping[str, Value]) -> Model | None:
    """The model with the ranges that requirements amount to at these inputs; None where that is no news."""
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


# --- removable singularities: rules that are 0/0 are taken by their limits ---
#
# Forward, the limit stands in for the part that is 0/0. Backward, where the place itself is unknown, an
# answer is the common limit of the answers for one input a little larger and a little smaller (L. F.
# Richardson's deferred approach, Phil. Trans. A 226, 1927), and it stands only if every rule holds there,
# those that are 0/0 by their limits from all sides.

ROUNDS = 8
STEPS = (2.0**-16, 2.0**-17, 2.0**-18)
"""How far an input is moved, in units of the power of two next to it."""
WEIGHTS = (1 / 45, -20 / 45, 64 / 45)
"""Those of the mean answers at the three steps, so that the second and fourth powers of the step cancel."""
APART = 1e-2
"""Relative distance within which answers on both sides belong together."""
NOTHING = 1e-12
"""Share of the answers beside it below which an extrapolated number is 0."""
MOVED = 6
"""Inputs that are moved, one after another, until answers come of it."""
TINY = 1e-30
"""How far beside an answer a rule is evaluated, relative to its values."""


def with_limits(asked: Asked, found: Exploration) -> tuple[Model, Exploration]:
    """What is found with limits, and the model with the limits that stand for parts of its rules.

    Forward, limits are put in for what is 0/0 at values that do not depend on them, and explored again.
    """
    by = asked.model
    filled: dict[int, float] = {}
    for _ in range(ROUNDS):
        ends = (*found.leaves, *found.dead)
        limits = dict(_filled(by, ends[0].branch.values)) if len(ends) == 1 else {}
        if not limits:
            break
        equations = tuple(limits[e.index][0] if e.index in limits else e for e in by.equations)
        filled |= {index: limit for index, (_, limit) in limits.items()}
        by = replace(by, equations=equations)
        found = explore_required(asked._replace(model=by))
    for leaf in found.leaves:
        leaf.branch.facts = (*leaf.branch.facts, *(Filled(*pair) for pair in filled.items()))
    solved = tuple(leaf for leaf in found.leaves if leaf.solved)
    if (solved and found.complete) or not (more := answers_between(asked)):
        return by, found
    return asked.model, replace(found, leaves=(*solved, *more), complete=False)


def _filled(model: Model, values: Mapping[str, Value]) -> Iterator[tuple[int, tuple[Equation, float]]]:
    """The equations that are 0/0 at the values, with the limit of that part in its place, and that limit."""
    for equation in model.equations:
        for side in (equation.left, equation.right):
            found = indeterminate(side, values)
            if found is not None and found.limit is not None:
                left, right = (
                    exchange(s, found.part, Number(found.limit)) for s in (equation.left, equation.right)
                )
                yield equation.index, (replace(equation, left=left, right=right), found.limit)
                break


# --- backward -------------------------------------------------------------------------


def answers_between(asked: Asked) -> tuple[Leaf, ...]:
    """Answers at which rules are 0/0, and that answers for inputs on both sides of the given ones lead to."""
    model, inputs = asked.model, asked.inputs
    every = walk(*(side for e in model.equations for side in (e.left, e.right)))
    if not any(isinstance(part, Quotient) for part in every):
        return ()
    read = Counter(name for e in model.equations for name in e.names)
    numbers = {name: given for name, given in inputs.items() if isinstance(given, float) and read[name]}
    for name in sorted(numbers, key=lambda name: (numbers[name] != 1.0, -read[name]))[:MOVED]:
        number = numbers[name]
        size = 2.0 ** math.frexp(number)[1] if number else 1.0  # both results hold the step exactly
        moved = (number + sign * step * size for step in STEPS for sign in (1, -1))
        beside = (_beside(asked._replace(inputs={**inputs, name: there})) for there in moved)
        sides = list(takewhile(bool, beside))
        if len(sides) < 2 * len(STEPS):
            continue
        found = (_between(leaf, sides, inputs) for leaf in sides[-1])
        leaves = tuple(filter(None, (_standing(model, leaf, inputs) for leaf in found if leaf is not None)))
        if leaves:
            return leaves
    return ()


def _beside(asked: Asked) -> tuple[Leaf, ...]:
    floats = explore(asked, brief=True)
    ended = any(leaf.solved or leaf.conflicts for leaf in (*floats.leaves, *floats.dead))
    if not ended and not floats.delicate:
        return ()
    from solver.solution.precise_search import explore_precisely

    found = explore_precisely(asked, floats) or floats
    return tuple(leaf for leaf in found.leaves if leaf.solved)


def _between(leaf: Leaf, sides: Sequence[Sequence[Leaf]], inputs: Mapping[str, Value]) -> Leaf | None:
    """The common limit of the answers that belong to this one; None where they do not come together."""
    nearest = [min(side, key=lambda other: _distance(leaf, other)) for side in sides]
    if max(_distance(leaf, other) for other in nearest) > APART:
        return None
    branch = leaf.branch.fork()
    branch.precise = {}
    for name, here in leaf.branch.values.items():
        if isinstance(here, str) or name in inputs:
            continue
        numbers: list[Any] = [b.precise.get(name, b.values[name]) for b in (one.branch for one in nearest)]
        means = [(one + other) / 2 for one, other in zip(numbers[::2], numbers[1::2], strict=True)]
        limit = sum(weight * mean for weight, mean in zip(WEIGHTS, means, strict=True))
        branch.precise[name] = 0 * limit if abs(limit) <= NOTHING * max(map(abs, numbers)) else limit
        branch.values[name] = float(branch.precise[name])
    branch.values = {**branch.values, **inputs}
    return replace(leaf, branch=branch)


def _distance(one: Leaf, other: Leaf) -> float:
    a, b = one.branch.values, other.branch.values
    if a.keys() != b.keys() or any(isinstance(v, str) and b[n] != v for n, v in a.items()):
        return math.inf
    pairs = ((v, w) for n, v in a.items() if isinstance(v, float) and isinstance(w := b[n], float))
    small = 4 * STEPS[0]
    return max((abs(v - w) / max(abs(v), abs(w), small) for v, w in pairs if abs(v - w) > small), default=0.0)


def _standing(model: Model, leaf: Leaf, inputs: Mapping[str, Value]) -> Leaf | None:
    """The answer with what its rules were taken by; None if one of them does not hold, or none is 0/0."""
    values = leaf.branch.values
    decided = outcomes(model, values, inputs)
    facts = []
    for equation in known_rules(model, decided, values):
        parts = (indeterminate(side, values) for side in (equation.left, equation.right))
        limits = [part.limit for part in parts if part is not None]
        if None in limits or not (
            _holds_beside(equation, values) if limits else check_rule(equation, values).holds
        ):
            return None
        facts += [Filled(equation.index, limit) for limit in limits if limit is not None]
    admitted = all(v.admits(x) for n, v in model.variables.items() if isinstance(x := values.get(n), float))
    if not facts or not admitted or any(unmet(model, values, decided)):
        return None
    branch = leaf.branch.fork()
    branch.decided, branch.facts = {**branch.decided, **decided}, tuple(facts)
    return replace(leaf, branch=branch, worst=0.0)


def _holds_beside(equation: Equation, values: Mapping[str, Value]) -> bool:
    """Whether a rule holds in the limit: its residual on both sides of a point, to first order."""
    line = {name: 1.0 + 0.1 * (k % 3) for k, name in enumerate(equation.names)}
    form = subtract(equation.left, equation.right)
    try:
        there = beside(values, line, -TINY)
        miss, slopes = extended_derivatives(form, there, DIGITS)
        miss += extended(form, beside(values, line, TINY), DIGITS)
    except Undefined:
        return False
    total = sum(float(abs(slope * there[name])) for name, slope in slopes.items())
    return bool(abs(miss) / 2 <= BACKWARD * total)


# --- blocks without an answer whose equations are 0/0 where there would be one ---

NEAR = 1e-4
"""Share of the change that its variables make of it, below which a side of a quotient may be 0."""


def at_a_limit(asked: Asked, leaf: Leaf, refusals: Sequence[Fact]) -> tuple[Indeterminacy, ...] | None:
    """The rules that are undefined where there is an answer in the limit; None if there is no such answer."""
    model = asked.model
    for fact in refusals:  # both sides may be 0 where the rules miss least
        if isinstance(fact, NoRoot):
            values = {**leaf.branch.values, **fact.best}
            rules = [model.equations[index] for index in fact.equations]
            parts = walk(*(side for rule in rules for side in (rule.left, rule.right)))
            quotients = (part for part in parts if isinstance(part, Quotient))
            if any(_small(part.left, values) and _small(part.right, values) for part in quotients):
                break
    else:
        return None
    for answer in answers_between(asked)[:1]:
        filled = (fact.equation for fact in answer.branch.facts if isinstance(fact, Filled))
        undefined = (indeterminacy(model.equations[index], answer.branch.values) for index in filled)
        return tuple(filter(None, undefined))
    return None


def _small(part: Expression, values: Mapping[str, Value]) -> bool:
    try:
        number, slopes = derivatives(part, values)
    except (Undefined, KeyError, TypeError):
        return False
    return abs(number) <= NEAR * sum(
        abs(s * v) for n, s in slopes.items() if isinstance(v := values[n], float)
    )


# --- given numbers that the rules fix otherwise, whatever the unknowns are ---
#
# A ratio of speeds does not depend on the speed that is free. A search for the speed at which it comes out as
# given finds nothing, or creeps towards 0; but the rules give the ratio one value at any speed.

TRIALS = (1.3247180, 7.3890561, 0.0207880, 1.1e-4)
"""Shares of its size at which an unknown is tried."""
EVERYDAY = 0.7548777
"""A number at which it is tried as well: beside tiny inputs ``exp(x) - x`` is 1 at all of its trials."""
MOST = 4
"""Unknowns, and given numbers, that are looked at."""
_FLAT = named(lambda row: not row.smooth)
"""Functions that are constant, or without a part of their arguments, over a range of them."""


def fixed_otherwise(asked: Asked, refusals: Sequence[Fact]) -> Fixed | None:
    """The given number that contradicts the rules at any value of an unknown; None if none does."""
    patience = Patience()
    for fact in refusals:  # the rules of which it is said that nothing satisfies them
        match fact:
            case NoRoot(equations=equations, unknowns=unknowns):
                pass
            case NoValue(e, u, reading, pole) if pole or reading.startswith(OTHERWISE):
                equations, unknowns = (e,), (u,)
            case _:
                continue
        rules = [asked.model.equations[e] for e in equations]
        parts = walk(*(side for rule in rules for side in (rule.left, rule.right)))
        if any(rule.guard for rule in rules) or any(
            isinstance(part, Call) and part.function in _FLAT for part in parts
        ):
            continue  # what they say may differ from one range of their variables to the next
        if (found := next(_fixed(asked, rules, unknowns, patience), None)) is not None:
            return found
    return None


def _fixed(
    asked: Asked, rules: Sequence[Equation], unknowns: Sequence[str], patience: Patience
) -> Iterator[Fixed]:
    inputs = asked.inputs
    read = [name for rule in rules for name in rule.names]
    alone = {side.name for rule in rules for side in (rule.left, rule.right) if isinstance(side, Name)}
    own = {name: variable.value for name, variable in asked.model.variables.items()}
    given = [name for name in inputs if name in read and isinstance(inputs[name], float)]
    given.sort(key=lambda name: (own[name] == inputs[name], name not in alone, read.count(name)))
    free = sorted((n for n in unknowns if n in read), key=lambda name: (own[name] is None, name in alone))
    for unknown in free[:MOST]:
        for name in given[:MOST]:
            ends, number = _whatever(asked, name, unknown, patience), inputs[name]
            if ends is None or not isinstance(number, float):
                continue
            slack = BACKWARD * max(map(abs, (*ends, number)))
            if not ends[0] - slack <= number <= ends[1] + slack:
                yield Fixed(name, ends[0], number, unknown, tuple(rule.index for rule in rules))


def _whatever(asked: Asked, name: str, unknown: str, patience: Patience) -> tuple[float, float] | None:
    """The ends of the one value, but for rounding, that the rules give to a variable at any trial of an
    unknown; None if there is none."""
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
        leaves = [leaf for leaf in tried.leaves if leaf.solved]
        if len(leaves) != 1 or not tried.complete:
            return None
        value = leaves[0].branch.values[name]
        if not isinstance(value, float):
            return None
        found.add(value)
    low, high = min(found), max(found)
    return (low, high) if high - low <= SAME_VALUE * max(abs(low), abs(high)) else None
