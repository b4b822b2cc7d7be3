"""Remedies for a refusal: inputs that would help, rules that conflict, limits of single inputs."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import replace
from itertools import chain, combinations, islice, product
from typing import NamedTuple

from rulesheets.evaluate.number import rounded
from rulesheets.model import Equation, Model, Value, Values
from rulesheets.syntax import nodes
from solver.facts import Conflict, about
from solver.kernel.emitter import enclose
from solver.leaves import Asked, Branch, Exploration, Leaf
from solver.numerics.tolerances import BACKWARD
from solver.path import activity, equations_of
from solver.path.cases import comparisons, outcomes, value_said
from solver.path.planner import planner
from solver.solution.explore import explore
from solver.solution.verdict import unsettled
from solver.structure.decomposition import Incidence, dulmage_mendelsohn, undetermined

MAX_SIZE, MAX_SETS = 4, 400
"""Inputs of a set that may be missing, and how many sets are tried at most."""
MAX_READ = 300_000
"""Occurrences of variables in rules that are read for it: fewer sets of a large sheet are tried."""
MAX_FILTER = 60
CLOSELY, DIGITS = 1e-6, 6
"""How closely an edge is found, relative to it, and the digits that are shown of it."""
ROUGH = 2e-6
"""How near to a number, relative to the given value, an edge is taken for that number."""
LOOSELY = 1e-3
"""The same for an edge that nothing proves."""
NEAR_AND_FAR = (-0.1, 0.1, -0.98, 30.0, -0.54, 3.0, -0.77, 9.0, -0.93, 0.4, 1.2, -0.3)
CHANGES = (*NEAR_AND_FAR, -0.995, 100.0, -0.9992, 1000.0)
OTHER_SIGNS = (-1.0, -2.5, -5.0)
"""Changes of an input, relative to it, that are tried, and at last 0 and those of the other sign: a
little beyond an edge the nearest one helps, else most often a far one."""
FEW = 3
"""How many of them look for the other end of a gap."""
DEAR = 1_000
"""Work from which on a search without success is not repeated where many starts serve."""
NEAR = 1e-9
"""How near to 0 as a bound that does not belong to them feasible values must come, relative to
their size."""
BEYOND = (0.25, 0.5, 0.75, 0.99)
"""Shares of the way to an edge, at which nothing is feasible if it is one."""
MANY = 3
"""Steps towards a value that seemed infeasible after which it is asked again."""
ATTEMPTS = 2
"""How often an edge is looked for nearer to the given value than a first one."""

# --- under-determined: what to give ------------------------------------------------------


PATIENCE = 40_000
"""Work that the search for remedies of a solve may take: they are advice, the verdict stands
without them."""


class Patience:
    """A limit on the work of several explorations: counted, so the same on any machine.

    One is shared by all messages about a solve.
    """

    def __init__(self, work: int = PATIENCE) -> None:
        self._left = work

    @property
    def lost(self) -> bool:
        return self._left <= 0

    def shown(self, found: Exploration) -> Exploration:
        self._left -= found.work
        return found


class Givings(NamedTuple):
    """The smallest ``sets`` of inputs that each determine all missing variables, in the order of
    the sheet; if none is small, the single input that determines ``most``; neither if no inputs are
    sufficient."""

    sets: tuple[tuple[str, ...], ...] = ()
    most: str | None = None


def givings(asked: Asked, branch: Branch, missing: Set[str], useless: Set[str]) -> Givings:
    """Which further inputs, ``useless`` ones aside, would determine ``missing``, by the rules'
    structure.

    At least as many are needed as of ``missing`` itself, and these are among what that determines.
    All but one of a set given, whatever a missing variable determines completes the set (but for
    what guards read, which does not follow from the rules that they guard).
    """
    names, system = _undetermined_part(asked, branch)
    guarded = any(len(system.occurs[e]) > len(system.resolvable[e]) for e in system.block.equations)
    lacking = [u for u, name in enumerate(names) if name in missing]
    posted = [u for u, name in enumerate(names) if asked.model.variables[name].posted] or range(
        len(names)
    )
    useful = [u for u in posted if names[u] not in useless]
    if not useful or not undetermined(system, {*useful}).isdisjoint(lacking):
        return Givings()
    basis, left = tuple[int, ...](), undetermined(system, ())
    while (more := [u for u in lacking if u in left]) and len(basis) <= MAX_SIZE:
        basis = *basis, more[0]
        left = undetermined(system, basis)
    candidates, found = sorted(useful, key=left.__contains__), list[tuple[int, ...]]()
    sizes = range(len(basis) or MAX_SIZE + 1, MAX_SIZE + 1)
    starts = chain.from_iterable(combinations(range(len(candidates)), size - 1) for size in sizes)
    trials = min(MAX_SETS, MAX_READ // (system.edges + 1) + 1)
    for places in islice(starts, trials):
        if found and (len(found[0]) <= len(places) or len(found) > MAX_SETS):
            break
        start = tuple([candidates[k] for k in places])
        before = undetermined(system, start)
        more = [u for u in lacking if u in before]
        left = undetermined(system, (*start, *more[:1]))
        if not more:  # what guards read follows from other rules
            found.append(start)
        elif left.isdisjoint(more):
            rest = candidates[places[-1] + 1 :] if places else candidates
            sets = [(*start, u) for u in rest if u in before and u not in left]
            if guarded:
                sets = [one for one in sets[:trials] if undetermined(system, one).isdisjoint(more)]
            found += sets
    if not found:
        most = min(useful[:trials], key=lambda u: len(undetermined(system, (u,))))
        return Givings((), names[most])
    least = min(map(len, found))
    return Givings(tuple(tuple([names[u] for u in one]) for one in found if len(one) == least))


def _undetermined_part(asked: Asked, branch: Branch) -> tuple[tuple[str, ...], Incidence]:
    """The variables that the inputs do not determine, and the rules for them, with the variables of
    guards.

    Conditions on such a variable have their outcome at arbitrary values: different numbers, and
    symbols where they are compared with one.
    """
    model, plan, decided = asked.model, planner(asked.model), branch.conditions
    names = plan.path(frozenset(asked.inputs), decided).undetermined
    place = {plan.graph.number[name]: u for u, name in enumerate(names)}
    arbitrary: dict[str, Value] = {
        name: 1.0 + 1.0 / (2 + k) for k, name in enumerate(model.variables)
    }
    for comparison in chain.from_iterable(map(comparisons, model.conditions)):
        match value_said(comparison):
            case str(name), str(symbol):
                arbitrary[name] = symbol
    case = {**outcomes(model, {**arbitrary, **branch.values}, asked.inputs), **decided}
    rows, own = list[tuple[int, ...]](), list[dict[int, int]]()
    for equation in model.equations:
        if activity(equation, case):
            body = plan.graph.occurs[equation.index]
            awaited = (
                premise.condition for premise in equation.guard if premise.condition not in decided
            )
            read = {v for condition in awaited for v in plan.graph.condition_occurs[condition]}
            rows.append(tuple(sorted(place[v] for v in read.union(body) if v in place)))
            own.append({place[v]: 0 for v in body if v in place})
    return names, Incidence(tuple(rows), tuple(own), len(names))


# --- inconsistent: the smallest conflicting set --------------------------------------------


def clash(
    asked: Asked, leaf: Leaf, equations: Sequence[int], patience: Patience
) -> tuple[list[int], list[str]]:
    """Rules (by equation) and inputs that contradict each other: a minimal part of the derivation
    of a contradiction."""
    rules, given = derivation(asked, leaf, equations)
    if len(rules) + len(given) > MAX_FILTER:
        return rules, given
    # else rules repeat one another by their numbers
    counts = _is_overdetermined(asked.model, rules, given)
    for item in (*reversed(rules), *reversed(given)):
        if patience.lost:
            break
        fewer = [e for e in rules if e != item], [n for n in given if n != item]
        if not fewer[0] or (counts and not _is_overdetermined(asked.model, *fewer)):
            continue
        if _contradictory(asked, *fewer, patience):
            rules, given = fewer
    return rules, given


def _is_overdetermined(model: Model, rules: Sequence[int], given: Sequence[str]) -> bool:
    """Whether some of the rules have fewer unknowns than equations."""
    number: dict[str, int] = {}
    read = ([name for name in model.equations[e].names if name not in given] for e in rules)
    occurs = tuple(
        tuple(sorted(number.setdefault(name, len(number)) for name in names)) for names in read
    )
    system = Incidence(occurs, ({},) * len(occurs), len(number))
    return bool(dulmage_mendelsohn(system).over.equations)


def derivation(
    asked: Asked, leaf: Leaf, equations: Sequence[int], read: Sequence[str] = ()
) -> tuple[list[int], list[str]]:
    """Every rule and input from which the values in ``equations``, and those ``read``, follow."""
    model, inputs = asked.model, asked.inputs
    rules = set(equations)
    names = [*read, *(name for e in equations for name in _reads(model, e))]
    seen: set[str] = set()
    while names:
        name = names.pop()
        if name in seen:
            continue
        seen.add(name)
        step = leaf.branch.origins.get(name)
        for equation in () if step is None else equations_of(step):
            rules.add(equation)
            names.extend(_reads(model, equation))
    return sorted(rules), [name for name in inputs if name in seen]


def _reads(model: Model, equation: int) -> Iterator[str]:
    body = model.equations[equation]
    yield from body.names
    for premise in body.guard:
        yield from nodes.names(model.conditions[premise.condition])


def _contradictory(
    asked: Asked, rules: Sequence[int], given: Sequence[str], patience: Patience
) -> bool:
    """Whether some rules contradict each other, given the variables that they and the conditions
    use."""
    model = asked.model
    read = {name for e in rules for name in _reads(model, e)}
    read.update(nodes.names(*model.conditions))
    variables = {name: variable for name, variable in model.variables.items() if name in read}
    kept = tuple(replace(model.equations[e], index=i) for i, e in enumerate(rules))
    part = Model(model.name, variables, kept, model.conditions)
    values = {name: asked.inputs[name] for name in given if name in variables}
    found = patience.shown(explore(Asked(part, values, None, {}, ()), brief=True, enough=_possible))
    return not any(map(_possible, found.leaves)) and bool(found.contradicted or found.leaves)


def _possible(leaf: Leaf) -> bool:
    return leaf.solved and not any(
        isinstance(fact, Conflict) for fact in leaf.branch.inactive.values()
    )


# --- what an input could be ---------------------------------------------------------------------


def cures(
    asked: Asked, names: Sequence[str], known: Mapping[str, float], patience: Patience
) -> tuple[tuple[str, Value], ...]:
    """Inputs without which nothing contradicts the rest, each with the value that then follows.

    Newton's method from the ``known`` values, those of the contradiction, comes first.
    """
    found: dict[str, Value] = {}
    for nearby, name in product((True, False), names):
        if name in found or patience.lost:
            continue
        rest = {n: v for n, v in asked.inputs.items() if n != name}
        without = asked._replace(inputs=rest, guesses=known)
        tried = patience.shown(explore(without, brief=True, nearby=nearby))
        possible = (
            leaf.branch.values
            for leaf in tried.leaves
            if not (leaf.conflicts or leaf.branch.blank or _is_open(without, leaf, name))
        )
        values = [one[name] for one in possible if name in one]
        given, numbers = asked.inputs[name], [value for value in values if isinstance(value, float)]
        if isinstance(given, float) and numbers:
            values = [min(numbers, key=lambda number: abs(number - given))]
        if values:
            found[name] = values[0]
    return tuple((name, found[name]) for name in names if name in found)


def _is_open(asked: Asked, leaf: Leaf, name: str) -> bool:
    """Whether the value of a name rests on a double root, or on rounding."""
    rules, _ = derivation(asked, leaf, (), (name,))
    return any(not {*about(fact)}.isdisjoint(rules) for fact in unsettled(leaf))


class Bound(NamedTuple):
    """The input ``name`` admits a solution where it is in ``relation`` (``≤``, ``>``, ``≠``) to
    ``value``; ``near``: that of a value near to it."""

    name: str
    relation: str
    value: float
    near: Mapping[str, float] = {}


def bounds(
    asked: Asked, names: Sequence[str], judged: Sequence[str], patience: Patience
) -> tuple[Bound, ...]:
    """The limit of each single input within its range for the whole to have a solution, which is
    mostly that for the ``judged`` names to have values; else the limits for these alone.

    What the sheet itself gives as a positive number, and is no angle, stays positive; an angle
    stays within a turn.
    """
    near = _limits(asked._replace(want=judged, judged=judged), names, patience)
    checking = Patience(PATIENCE // 2)  # the search may have used up the other
    enough = tuple(bound for bound in near if _suffices(asked, bound, checking))
    return enough or _limits(asked, names, patience) or near


def _suffices(asked: Asked, bound: Bound, patience: Patience) -> bool:
    """Whether the whole has a solution at a bound, or next to it."""
    name, relation, value, _ = bound
    inward = {"<": -LOOSELY, ">": LOOSELY}.get(relation, 0.0)
    value += inward * abs(value or float(asked.inputs[name]))
    trials = _Trials(asked, name, patience, bound.near)
    return relation == "≠" or trials.beside(value) or trials.anywhere(value)


def _as_it_stands(asked: Asked, patience: Patience) -> Mapping[str, float]:
    """The numbers of a solution of the sheet with its own inputs, if these are not those that were
    asked."""
    own = {n: v.value for n, v in asked.model.variables.items() if v.value is not None}
    if own == asked.inputs:
        return {}
    whole = Asked(asked.model, own, None, {}, tuple(asked.inputs))
    tried = explore(whole, brief=True, enough=lambda leaf: leaf.solved)
    leaves = (leaf.branch.values for leaf in patience.shown(tried).leaves if leaf.solved)
    return {n: v for n, v in next(leaves, {}).items() if isinstance(v, float)}


def _limits(asked: Asked, names: Sequence[str], patience: Patience) -> tuple[Bound, ...]:
    turn, found, stands = planner(asked.model).graph.turn, [], _as_it_stands(asked, patience)
    for name in names:
        given, own = asked.inputs[name], asked.model.variables[name].value
        if not isinstance(given, float) or patience.lost:
            continue
        trials = _Trials(asked, name, patience, stands=stands)
        trials.positive = given == own and given > 0.0 and turn(name) is None
        trials.most = max(turn(name) or math.inf, abs(given))
        values = [given + change * (given or 1.0) for change in CHANGES]
        others = [given + change * (given or 1.0) for change in OTHER_SIGNS]
        first = (own,) if isinstance(own, float) and own != given else ()
        last = (stands[name],) if name in stands and stands[name] not in (own, given) else ()
        bound = _bound(trials, given, (*first, *values, *others, *last))
        if bound is not None and not patience.lost:
            found.append(bound)
            trials.known = {}  # a solution on this side leads to none beyond the gap
            below = bound.relation in (">", "≥")
            few = [value for value in values if (value < given) is below][:FEW]
            told = bound.relation == "≠" or trials.dear
            beyond = None if told else _bound(trials, given, few)
            found += [] if beyond is None else [beyond]  # of a gap
    return tuple(found)


def found_near(
    asked: Asked, names: Sequence[str], miss: Mapping[str, float], patience: Patience
) -> tuple[tuple[str, float], ...]:
    """Values of single inputs near the given ones, where Newton's method leads to a solution from
    the nearest ``miss``: for each input the nearest value that a short search tells."""
    found, changes = list[tuple[str, float]](), sorted((*CHANGES, *OTHER_SIGNS), key=abs)
    stands = _as_it_stands(asked, patience)
    for name in names:
        given, own = asked.inputs[name], stands.get(name)
        trials = _Trials(asked, name, patience, miss, stands)
        if not isinstance(given, float):
            continue
        values = [given + change * (given or 1.0) for change in changes]
        if own is not None and trials.anywhere(own, stands):
            values.insert(0, own)
        if (edge := _edge(trials, given, values, LOOSELY)) is not None:
            short = rounded(edge, 3)
            # at a fold itself two answers coincide
            fits = short != given and trials.beside(short) and trials.isolated
            found.append((name, short if fits else edge))
    return tuple(found)


class _Trials:
    """Whether there is a solution at other values of one input, or at ``positive`` ones; ``known``
    is the last one that was found, ``isolated`` or not, or a point to begin at, and a search for
    all of them is ``dear`` if one without success took long. ``most`` is the largest size. For the
    value that the sheet as it ``stands`` leads to, its solution is one to begin at."""

    def __init__(
        self,
        asked: Asked,
        name: str,
        patience: Patience,
        known: Mapping[str, float] = {},
        stands: Mapping[str, float] = {},
    ) -> None:
        self.asked, self.name, self.patience = asked, name, patience
        self.known, self.stands, self.positive, self.dear = known, stands, False, False
        self.isolated, self.most = False, math.inf

    def beside(self, value: float) -> bool:
        """Whether Newton's method leads to a solution from the known one, or a search to any."""
        guesses = self.stands if value == self.stands.get(self.name) else {}
        return self.anywhere(value, self.known or guesses)

    def anywhere(self, value: float, guesses: Mapping[str, float] = {}) -> bool:
        """Whether there is one at all, or one that Newton's method leads to from the guesses."""
        asked, name, nearby = self.asked, self.name, bool(guesses) or self.dear
        if self.patience.lost or not asked.model.variables[name].admits(value):
            return False
        if (self.positive and value <= 0.0) or abs(value) > self.most:
            return False
        inputs = {**asked.inputs, name: value}
        moved = asked._replace(inputs=inputs, guesses=guesses or asked.guesses)
        tried = explore(moved, brief=True, enough=lambda leaf: leaf.solved, nearby=nearby)
        leaf = next((leaf for leaf in self.patience.shown(tried).leaves if leaf.solved), None)
        if leaf is not None:
            self.known = {n: v for n, v in leaf.branch.values.items() if isinstance(v, float)}
            self.isolated = not unsettled(leaf)
        else:
            self.dear = self.dear or tried.work > DEAR
        return leaf is not None


def _bound(trials: _Trials, given: float, values: Iterable[float]) -> Bound | None:
    """A tested bound from the edge of the feasible values among which one of these is: whether it
    belongs to them, rounded to one that does.

    None if there is none, or if a value on the far side of it is feasible, too: then it is not an
    edge.
    """
    name, feasible = trials.name, trials.anywhere
    size, edge = abs(given) or 1.0, _edge(trials, given, values)
    size = min(size, abs(trials.stands.get(name, 0.0)) or size)
    if edge is None:
        return None
    inward = 1.0 if edge > given else -1.0
    for attempt in range(ATTEMPTS):
        if abs(edge - given) <= ROUGH * size and feasible(2 * given - edge):
            return Bound(name, "≠", given)
        points = [given + share * (edge - given) for share in (0.0, *BEYOND)]
        nearer = next(filter(feasible, points[1:]), None)
        if nearer is None:
            break
        if attempt + 1 == ATTEMPTS:
            return None
        edge = _closed_in(trials, nearer, points[points.index(nearer) - 1])
    shown = 0.0 if abs(edge) <= ROUGH * size and given != 0.0 else rounded(edge, DIGITS)
    if shown != given and trials.beside(shown):
        return Bound(name, "≥" if inward > 0 else "≤", shown, trials.known)
    near = ROUGH if shown == rounded(edge, 4) else CLOSELY * LOOSELY
    if abs(shown - edge) <= near * abs(edge) or trials.beside(shown + inward * NEAR * size):
        return Bound(name, ">" if inward > 0 else "<", shown, trials.known)
    unit = 10.0 ** (math.floor(math.log10(abs(edge))) + 1 - DIGITS) if edge else 1.0
    shown = rounded((math.ceil if inward > 0 else math.floor)(edge / unit) * unit)
    relation = "≥" if inward > 0 else "≤"
    return Bound(name, relation, shown, trials.known) if feasible(shown) else None


def _edge(
    trials: _Trials, given: float, values: Iterable[float], close: float = CLOSELY
) -> float | None:
    """The end, towards the given value, of the feasible values among which is the first feasible
    one of these; None if there is none."""
    tried = [given]
    for inside in values:
        if trials.beside(inside):
            between = [v for v in tried if (v - given) * (inside - v) >= 0.0]
            outside = min(between, key=lambda v: abs(v - inside))
            return _closed_in(trials, inside, outside, close)
        tried.append(inside)
    return None


def _closed_in(trials: _Trials, inside: float, outside: float, close: float = CLOSELY) -> float:
    """The last feasible value from one ``inside`` towards one ``outside``.

    Where Newton's method fails far from a solution is asked again from a near one.
    """
    if inside * outside <= 0.0:  # zero is where many of them end
        tiny = math.copysign(NEAR * abs(outside or inside), inside or outside)
        if trials.anywhere(tiny) is not bool(inside):
            inside, outside = (inside, tiny) if inside else (tiny, outside)
        elif inside * outside < 0.0 and trials.beside(-tiny):
            inside = -tiny
        else:
            return tiny if inside else 0.0
    outsides, steps = [outside], 0
    while True:
        outside = outsides[-1]
        is_closed = abs(outside - inside) <= close * max(abs(inside), close)
        if (is_closed or steps == MANY) and len(outsides) > 1 and trials.beside(outside):
            inside, steps = outsides.pop(), 0
            continue
        if is_closed or trials.patience.lost:
            return inside
        ratio, steps = outside / inside, steps + 1
        middle = 0.5 * (outside + inside) if 0.1 < ratio < 10.0 else math.sqrt(ratio) * inside
        if trials.beside(middle):
            inside = middle
        else:
            outsides.append(middle)
            steps = 0


FARTHEST = 1e30
"""The size up to which values are tried one after another."""


def stretch(equation: Equation, values: Values, name: str) -> tuple[float, float]:
    """The interval around the value of ``name`` on which interval arithmetic shows that a rule
    holds; infinite where it goes on, as wide as a point where nothing is shown."""
    box = {other: (v, v) for other, v in values.items() if isinstance(v, float)}

    def holds(other: float) -> bool:
        there = {**box, name: (min(other, start), max(other, start))}
        ends = enclose(equation.form, there)
        return max(map(abs, ends)) <= BACKWARD * max(map(abs, enclose(equation.left, there)))

    def end(sign: int) -> float:
        inside, step = start, sign * (abs(start) or 1.0)
        while abs(step) < FARTHEST and holds(inside + step):
            inside, step = inside + step, 2 * step
        if abs(step) >= FARTHEST:
            return sign * math.inf
        while abs(step) > NEAR * abs(start or 1.0):
            inside, step = inside + step * holds(inside + step), step / 2
        return inside

    start, _ = box[name]
    return end(-1), end(1)
