"""Searches over all unknowns of a block at once: by boxes, from starts, by sparse Newton steps, for a curve.

Where all unknowns have finite ranges, their box is subdivided with proof (``numerics/subdivision.py``).

Half of the starts are tears spread over their ranges, the rest by the block's own steps: following the chains
of the tearing puts every start on all equations but the residual ones; where a step would leave the domain it
is held at the edge of it. Where descent finds nothing, trust regions do.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rulesheets.model import Equation
from rulesheets.syntax.nodes import Call, Expression, Name, Negative, Product, Quotient, Sum
from rulesheets.syntax.program import walk
from solver.accuracy.alike import MANY
from solver.facts import Attempt, Beside, Method, RankLoss
from solver.kernel.block import FEW
from solver.kernel.candidates import BlockOutcome, Candidates, left_free
from solver.kernel.emitter import IntervalEmitter
from solver.kernel.lifting import Lifting
from solver.kernel.question import Budget, Question
from solver.kernel.tangents import Tangents
from solver.numerics.linear_algebra import Array, connected
from solver.numerics.newton import (
    GAUSS_NEWTON,
    NEWTON,
    STANDARD_LIMITS,
    TRUST_REGIONS,
    Iteration,
    NewtonLimits,
    arrivals,
    newton,
    scipy_root,
    spread,
    starting_points,
)
from solver.numerics.sparse_newton import Map, SparseFactor, SparseRoot, Triplets, itself, sparse_newton
from solver.numerics.tolerances import FREE, MOVED, SAME_END
from solver.ranking.sizes import nearly_balanced

# --- box by box ---

LIMITS, THOROUGH = (20_000, 2_000), (600_000, 400_000)
"""Boxes in all, and at once; the same where a proof is asked for."""


def search_boxes(question: Question, candidates: Candidates, thorough: bool = False) -> bool:
    """Refine every box that may hold a root. True where the roots are proven to be all."""
    from solver.numerics.subdivision import SubdivisionLimits, branch_and_prune  # few blocks come to this

    kernel = question.kernel
    ranges, n = [question.domain(name) for name in question.unknowns], len(question.unknowns)
    residual = _bounds(kernel.forms, question, (n,))
    jacobian = _bounds([slope for slope in kernel.partials if slope is not None], question, (n, n))
    limits = SubdivisionLimits(*(THOROUGH if thorough else LIMITS))
    found = branch_and_prune(residual, jacobian, ranges, limits)
    for root in found.roots:
        candidates.refine(list(root))
    return found.complete


def _bounds(forms: Sequence[Expression], question: Question, shape: tuple[int, ...]) -> Any:
    """Bounds (k, *shape) of as many forms over boxes (k, n), compiled."""
    emitter = IntervalEmitter(question.unknowns, question.kernel.known)
    ends = [end for form in forms for end in emitter.of(form)]
    on_box = emitter.function(ends)(*question.known)

    def bounds(low: Array, high: Array) -> tuple[Array, Array]:
        boxes = np.stack([low, high], axis=2).reshape(len(low), 2 * low.shape[1]).tolist()
        found = np.array([on_box(*box) for box in boxes]).reshape(len(low), *shape, 2)
        return found[..., 0], found[..., 1]

    return bounds


# --- from many starts ---

STARTS = 24
FEW_STARTS = 6
START_LIMITS = NewtonLimits(iterations=40, escapes=2)
MAX_BATCH_UNKNOWNS = 60


def search_from_starts(question: Question, candidates: Candidates, budget: Budget) -> None:
    """Find roots from the guess and from starts spread over the ranges; nothing is proven of others."""
    kernel = question.kernel
    batches = kernel.smooth and len(kernel.unknowns) <= MAX_BATCH_UNKNOWNS
    if question.guesses or not batches:  # one by one: the guess is worth a longer search
        starts = _guess_and_beside(question, FEW_STARTS if candidates.answers else STARTS)
        for number, start in enumerate(starts):
            limits = START_LIMITS if number else STANDARD_LIMITS
            end = newton(question.residual, question.jacobian, start, question.scale, limits)
            if end.outcome.found:
                candidates.refine(end.x)
            else:
                candidates.note(question.named(end.x))
            if candidates.endless:
                break
    if batches:
        try:
            _in_batches(question, candidates, budget)
        except ZeroDivisionError:  # between numbers of the rules themselves, whatever the unknowns are
            return


def _guess_and_beside(question: Question, count: int) -> Iterator[list[float]]:
    """The guess, 1 for an unknown without one, and points that fill the ranges."""
    guess = [question.guesses.get(name, 1.0) for name in question.unknowns]
    return starting_points(guess, [*map(question.domain, question.unknowns)], question.scale, count)


# --- hundreds of starts at once ---

ROUNDS = ((0, 128), (128, 512), (512, 1024))
"""From which start of a sequence to which a round goes, of each of the two kinds; two rounds at least."""
MOST = 48
"""Ends of a round that are looked at, those of ordinary size first: many may lie along a curve or far out."""
FINISH = NewtonLimits(iterations=60, escapes=0)
NEAR_ZERO = 1e-6
"""Share of its size below which an unknown is on its way to 0."""


def _in_batches(question: Question, candidates: Candidates, budget: Budget) -> None:
    """Refine what the starts lead to, round after round, until a round brings nothing new."""
    scale = question.sizes
    found: list[Array] = []
    for turn, (first, last) in enumerate(ROUNDS):
        starts = starts_of(question, first, last)
        ends = _arrivals(question, starts)
        with np.errstate(over="ignore"):  # an end that is too far out comes last
            new = _distinct(question, ends, found)
            nearest = sorted(new, key=lambda end: float(np.max(abs(end) / scale)))
        for end in nearest[:MOST]:
            candidates.refine(end.tolist(), FINISH)
            if candidates.endless:
                _beside_zeros(question, candidates, starts)
                return
        if turn == 0 and not new:
            with np.errstate(all="ignore"):  # a start of least residual tells how near the search came
                misses = abs(question.kernel.arrays.residual(question.known, starts)).max(axis=1)
            if np.isfinite(misses).any():
                candidates.note(question.named(starts[np.nanargmin(misses)].tolist()))
        if (turn and not new) or not budget.another_round():
            break
        found += new


def _arrivals(
    question: Question,
    starts: Array,
    ranges: tuple[Array, Array] | None = None,
    by: Iteration = NEWTON,
) -> Array:
    arrays, known = question.kernel.arrays, question.known
    residual, jacobian = partial(arrays.residual, known), partial(arrays.jacobian, known)
    return arrivals(residual, jacobian, starts, question.sizes, by, ranges)


def _beside_zeros(question: Question, candidates: Candidates, starts: Array) -> None:
    """Where the starts led to a curve along which unknowns are 0 (a mass, say, that all terms contain): the
    same starts again, on ways that do not cross those zeros."""
    points = np.array([list(answer.values.values()) for answer in candidates.answers])
    zero = (points == 0.0).all(axis=0) if len(points) else np.zeros(len(question.unknowns), dtype=bool)
    if not zero.any():
        return
    ranges = np.where(zero, 0.0, -np.inf), np.where(zero, 0.0, np.inf)
    ends = _arrivals(question, starts, ranges)
    away = ends[(abs(ends[:, zero]) > NEAR_ZERO * question.sizes[zero]).all(axis=1)]
    for end in _distinct(question, away, [])[:MOST]:
        candidates.refine(end.tolist(), FINISH)


def starts_of(question: Question, first: int, last: int) -> Array:
    """Half of them along the chains, the others with every unknown on its own."""
    sizes = question.named(question.sizes.tolist())

    def points(names: Sequence[str]) -> Array:
        """Those (last - first, names) of a sequence that is spread over the ranges of unknowns."""
        around = [sizes[name] for name in names]
        return np.array(list(spread([*map(question.domain, names)], around, last - first, first)))

    with np.errstate(all="ignore"):
        along = question.kernel.arrays.starts(question.known, points(question.kernel.block.tears))
    apart = points(question.unknowns)
    return np.concatenate([np.where(np.isfinite(along), along, apart), apart])


def _distinct(question: Question, ends: Array, known: Sequence[Array]) -> list[Array]:
    """Those that are neither among the ``known`` nor one another, with angles in the turn around 0."""
    ends = ends.copy()
    for place, name in enumerate(question.unknowns):
        turn, (low, high) = question.turn(name), question.domain(name)
        if turn is not None and high - low == turn:
            ends[:, place] -= turn * np.floor((ends[:, place] - low) / turn)
    seen = np.empty((len(known) + len(ends), len(question.unknowns)))
    seen[: len(known)] = np.reshape(known, (-1, len(question.unknowns)))
    count = len(known)
    for end in ends:
        size = np.maximum(abs(end), 1e-3 * question.sizes)
        if not (abs(seen[:count] - end) <= SAME_END * size).all(axis=1).any():
            seen[count] = end
            count += 1
    return list(seen[len(known) : count])


# --- trust regions ---

TRUST_REGION_STARTS = 24


def fall_back(question: Question, candidates: Candidates) -> None:
    """Try trust regions from the guess and from many starts until ``candidates`` has an answer."""
    evaluations = 0
    for start in _guess_and_beside(question, TRUST_REGION_STARTS):
        for method in TRUST_REGIONS:
            end = scipy_root(question.residual, question.jacobian, start, method, question.scale)
            evaluations += end.evaluations
            candidates.refine(end.x)
            if not candidates.fruitless:
                candidates.tried(Method.TRUST_REGION, iterations=evaluations)
                return
    candidates.tried(Method.TRUST_REGION, iterations=evaluations)


# --- a curve of answers: a block that leaves its unknowns free, however it is torn ---
#
# Where rules say the same at the numbers at hand, be it in a roundabout way, the answers are no points but a
# curve. No search for points finds it, and exact arithmetic may even prove that there is nothing: numbers
# that agree to their last places contradict one another beyond these. Here points are sought that satisfy the
# rule check; one from which a way leads on along which all rules still hold is a point of a curve. A block
# may have isolated answers beside a curve of them, such as where a common factor is 0.

WORK = 400
"""Starts times unknowns of a search."""
FEWEST_STARTS, MOST_STARTS = 6, 32
ENDS = 6
"""Ends of a search that are looked at."""
AWAY = 0.02
"""How far along a direction, in units of the unknowns, rules have to hold still."""
CORRECTIONS = 4


def free_curve(question: Question, point: Mapping[str, float] | None = None) -> BlockOutcome | None:
    """What a block leaves free at an answer of it, or at a point that is looked for; None where there is
    none, or no way leads on from there."""
    if len(question.unknowns) > MAX_BATCH_UNKNOWNS or not question.kernel.smooth:
        return None
    with np.errstate(all="ignore"):
        try:
            curve = _Curve(question)
            given = [] if point is None else [np.array([point[name] for name in question.unknowns])]
            return next(filter(None, map(curve.through, given or curve.points())), None)
        except (ArithmeticError, ValueError, np.linalg.LinAlgError):
            return None


class _Curve:
    def __init__(self, question: Question) -> None:
        self.question, self.scale = question, question.sizes
        low, high = np.array([(variable.low, variable.high) for variable in question.variables]).T
        self.projected = partial(_arrivals, question, ranges=(low, high), by=GAUSS_NEWTON)

    def points(self) -> Iterator[Array]:
        """Points at which every rule holds, of a few starts."""
        count = min(max(WORK // len(self.scale), FEWEST_STARTS), MOST_STARTS)
        ends = self.projected(starts_of(self.question, 0, count // 2))
        nearest = sorted(ends, key=lambda x: float(max(abs(x) / self.scale)))[:ENDS]
        return (point for end in nearest if (point := self._settled(end)) is not None)

    def _settled(self, x: Array) -> Array | None:
        """The point with a few corrections of least norm, if every rule holds there and it is in range."""
        question = self.question
        for _ in range(CORRECTIONS):
            point = question.named(x.tolist())
            if question.holds(point):
                return x if question.outside(point) is None else None
            matrix, weight, rows = self._scaled(x)
            miss = np.array(question.residual(x.tolist())) / rows
            x = x - weight * np.linalg.lstsq(matrix, miss, rcond=FREE)[0]
        return None

    def _scaled(self, x: Array) -> tuple[Array, Array, Array]:
        """The Jacobian in units of the unknowns and of the rules, and these units."""
        weight = np.maximum(abs(x), 1e-3 * self.scale)
        matrix = np.array(self.question.jacobian(x.tolist()), dtype=float) * weight
        rows = abs(matrix).max(axis=1)
        if not np.isfinite(rows).all():
            raise ValueError("a slope is infinite")
        rows = np.where(rows > 0.0, rows, 1.0)
        return matrix / rows[:, None], weight, rows

    def through(self, x: Array) -> BlockOutcome | None:
        """What is free along every direction from the point in which all rules hold on."""
        matrix, weight, _ = self._scaled(x)
        _, singular, right = np.linalg.svd(matrix)
        ways = [direction for s, direction in zip(singular, right, strict=True) if s <= FREE * singular[0]]
        others = [there for way in ways if (there := self._along(x, way * weight)) is not None]
        if not others:
            return None
        changes = np.max([abs(there - x) / weight for there in others], axis=0)
        question, point = self.question, self.question.named(x.tolist())
        free = tuple(n for n, moves in zip(question.unknowns, changes, strict=True) if moves > MOVED)
        if not free:
            return None
        change = question.named((others[0] - x).tolist())
        largest = max(abs(change[name]) for name in free) or 1.0
        direction = {name: far / largest if name in free else 0.0 for name, far in change.items()}
        return left_free(question, point, direction, free)

    def _along(self, x: Array, way: Array) -> Array | None:
        """A point some way on at which every rule holds, on either side."""
        meant = float(abs(AWAY * way).max())
        for there in self.projected(x + np.outer((AWAY, -AWAY), way)):
            settled = self._settled(there)
            if (
                settled is not None
                and 0.1 * meant <= float(abs(settled - x).max()) <= 10.0 * meant < math.inf
            ):
                return settled
        return None


ISOLATED_STARTS = 32
MOST_BESIDE = 12
"""Unknowns of a block up to which isolated answers are sought beside a curve."""


def with_isolated(question: Question, curve: BlockOutcome) -> BlockOutcome:
    """The isolated answers, if any are found from a few starts, with the curve as a note; else the curve."""
    known = curve.answers[0].values if curve.answers else {}
    if not known or len(question.unknowns) > MOST_BESIDE or not question.kernel.smooth:
        return curve
    found = Candidates(question)
    for start in starts_of(question, 0, ISOLATED_STARTS // 2).tolist():
        found.refine(start, START_LIMITS)
    regular = [answer for answer in found.answers if answer.double is None]
    answers = tuple(answer for answer in regular if free_curve(question, answer.values) is None)
    return BlockOutcome(answers, facts=(beside(curve),), attempts=curve.attempts) if answers else curve


def beside(curve: BlockOutcome) -> Beside:
    """The note on a curve that there are other answers than those on it."""
    known = tuple(curve.answers[0].values.items()) if curve.answers else ()
    equations = next((f.equations for f in curve.facts if isinstance(f, RankLoss)), ())
    return Beside(equations, curve.free, known)


MOST_SUSPECTS = 12
"""Answers that are looked at; what is flat beyond these counts as what they are."""


def without_curves(question: Question, outcome: BlockOutcome) -> BlockOutcome:
    """The outcome without answers that lie on a curve; what the curve leaves free, where it has no others.

    A list of some points of a curve says nothing of the others, so that it is never complete.
    """
    suspects = [answer for answer in outcome.answers if answer.double]
    if not suspects or outcome.free or len(question.unknowns) == 1:
        return outcome
    looked_at = [(answer, free_curve(question, answer.values)) for answer in suspects[:MOST_SUSPECTS]]
    curves = [curve for _, curve in looked_at if curve is not None]
    if not curves:
        return outcome
    alone = [answer for answer, curve in looked_at if curve is None]
    others = tuple(a for a in outcome.answers if not a.double or any(a is one for one in alone))
    if others:
        facts = (*outcome.facts, beside(curves[0]))
        return outcome._replace(answers=others, complete=False, whole=False, stretches=(), facts=facts)
    return curves[0]._replace(attempts=(*outcome.attempts, Attempt(Method.CURVE, 1)))


# --- by sparse Newton steps: one answer of a large block, the sensible one, none of its unknowns torn ---

MOST_ITERATIONS, POSITIVE_ITERATIONS = 100, 40
LIMIT = 0.2
"""The share of its size by which an unknown may move in a limited step."""
HALF = 0.5
"""The share of their sizes at which unknowns begin again: at these themselves differences may be 0."""


def search_sparsely(question: Question, candidates: Candidates, every: bool = False) -> None:
    """Try starts in turn until an answer stands that none is to be preferred to, or ``every`` one.

    An answer with no negative number ends the search; one with some is kept, and looked for is one that keeps
    to positive numbers.
    """
    if question.sparse is None:
        return
    free = {v.name for v in question.variables if v.low == -math.inf and question.turn(v.name) is None}
    for start in _sparse_starts(question):
        if candidates.answers and not (start.positive or every):
            continue
        root = _arrived(question, start)
        if not np.isfinite(root.x).all():
            continue
        point = question.named(root.x.tolist())
        if root.converged and len(point) <= MANY:
            candidates.refine(root.x.tolist())
        elif root.converged and (settled := _corrected(question, question.sparse[1], root.x)) is not None:
            candidates.keep(settled, alone=root.alone)
        else:
            candidates.note(point)
        signs = [min((v for n, v in a.values.items() if n in free), default=0.0) for a in candidates.answers]
        if signs and not every and (question.guesses or max(signs) >= 0.0):
            candidates.answers.insert(0, candidates.answers.pop(signs.index(max(signs))))
            return


def _arrived(question: Question, begin: Start) -> SparseRoot:
    """Where Newton's method comes to from a start, on the rules as they are or as ``begin`` changes them."""
    assert question.sparse is not None
    (start, sizes, positive, told, limit, tangents, lifting), plain = begin, question.sparse
    most = POSITIVE_ITERATIONS if positive or tangents else MOST_ITERATIONS
    if lifting is not None:
        lifted = lifting.start(start)
        wide = None if sizes is None else np.concatenate([sizes, lifted[len(sizes) :]])
        root = sparse_newton(*lifting.system.at(question.known), lifted, wide, positive, most, limit=limit)
        here = root._replace(x=root.x[: len(start)])
        return sparse_newton(*plain, here.x, sizes) if root.converged else here
    functions = plain if tangents is None else tangents.system.at(question.known)
    root = sparse_newton(*functions, start, sizes, positive, most, told, limit)
    for _ in range(most if tangents is not None else 0):
        if not root.converged or tangents is None or tangents.touch(root.x):
            break  # else some exponential is still far above its tangent
        root = sparse_newton(*functions, root.x, sizes, positive, most, told, limit)
    if tangents is not None and root.converged and tangents.cancels:
        polished = sparse_newton(*plain, root.x, sizes)  # the digits that tangents lose
        root = root._replace(x=polished.x) if polished.converged else root
    return root


CORRECTED = 2


def _corrected(
    question: Question, jacobian: Callable[[Array], Triplets], x: Array
) -> dict[str, float] | None:
    """The point at which every rule holds; where rounding of its own evaluation keeps one from that
    (``exp(x) - 1`` at a small x), after corrections by what it misses in many digits. None elsewhere."""
    for left in reversed(range(CORRECTED + 1)):
        point = question.named(x.tolist())
        misses = question.misses(point) if np.isfinite(x).all() else None
        if misses is None:
            before, x = x, _with_zeros(question, x)
            if (x == before).all():
                return None
            continue
        if not misses.any():
            return point
        try:
            x = x - SparseFactor(jacobian(x), len(x)).solve(misses) if left else x
        except ArithmeticError:
            return None
    return None


def _with_zeros(question: Question, x: Array) -> Array:
    """The point (n,) with every unknown at 0 of which a rule tells that: the flow through a closed valve, of
    which rounding has left a trace."""
    system = question.kernel.sparse
    return x if system is None else np.where(system.with_told(x, question.known) == 0.0, 0.0, x)


_EXPONENTIALS = frozenset({"exp", "sinh", "cosh"})


class Start(NamedTuple):
    """A point (n,) to start from, the ``sizes`` (n,) of the unknowns, and how to go on from there, as
    ``sparse_newton`` has it; with ``tangents`` in place of exponentials, or ``lifting`` of differences."""

    x: Array
    sizes: Array | None
    positive: bool = False
    told: Map = itself
    limit: float | None = None
    tangents: Tangents | None = None
    lifting: Lifting | None = None


def _sparse_starts(question: Question) -> Iterator[Start]:
    """Points to start from in turn, and how.

    The guesses where there are any, else 0, where the first step solves the linearised rules, exponentials
    replaced by tangents if need be; positive numbers of the sizes that balance the rules; and 1. What a rule
    tells outright is as that has it, at last after each step too: auxiliary unknowns, such as friction
    factors, do not hold back the others.
    """
    names, guesses, system = question.unknowns, question.guesses, question.kernel.sparse
    low, high = np.array([(v.low, v.high) for v in question.variables]).T

    def told(x: Array) -> Array:
        return np.clip(x if system is None else system.with_told(x, question.known), low, high)

    nothing = np.clip(np.zeros(len(names)), low, high)
    zero = told(nothing)
    if not guesses:
        yield Start(zero, None)
        tangents = None if system is None else Tangents(system, question.known)
        if tangents is not None and tangents.some:
            yield Start(nothing, None, told=tangents.follow, limit=math.inf, tangents=tangents)
    known = {name: v for name in question.kernel.known if isinstance(v := question.here[name], float)}
    turns = np.array([question.turn(name) or math.nan for name in names])
    guessed, turning = np.abs([guesses.get(name, 0.0) for name in names]), ~np.isnan(turns)
    balanced = nearly_balanced(question.kernel.alike, names, known)
    sizes = np.where(guessed > 0.0, guessed, np.where(turning, turns / 4, balanced))
    inside = np.clip(np.where(turning, 0.0, sizes), low, high)
    if guesses:
        guess = np.array([guesses.get(n, v) for n, v in zip(names, inside, strict=True)])
        yield Start(guess, sizes)
        yield Start(zero, sizes)
    ones = np.clip(np.where(turning, 0.0, 1.0), low, high)
    yield Start(inside, sizes, positive=True)
    yield Start(ones, sizes, positive=True)
    if len(names) > FEW:
        yield Start(np.clip(HALF * inside, low, high), sizes, positive=True)
    yield Start(ones, sizes)
    yield Start(inside, sizes)
    level = _exponents(question)
    if level.any():
        yield Start(np.clip(np.where(level, 0.0, inside), low, high), sizes)
    lifting = None if system is None or len(names) <= FEW else Lifting(system, question.known)
    if lifting is not None and lifting.some:
        for start in (inside, HALF * inside, ones):
            yield Start(np.clip(start, low, high), sizes, positive=True, lifting=lifting)
        yield Start(inside, sizes, limit=LIMIT, lifting=lifting)
    flat = _beside_known(question, inside)
    if flat is not None:
        yield Start(told(flat), sizes)
    if len(names) > FEW:
        beside = [inside] if flat is None else [inside, flat]
        yield from (Start(start, sizes, told=told) for start in (zero, *beside))
        if not turning.any():  # a mechanism has several answers, which starts at random find
            for start in beside:
                yield Start(start, sizes, told=told, limit=LIMIT)
                yield Start(start, sizes, limit=LIMIT)
            yield Start(np.clip(HALF * inside, low, high), sizes, limit=LIMIT)


def _beside_known(question: Question, start: Array) -> Array | None:
    """The start (n,), but that unknowns which rules add to known numbers, or take from them, directly or by
    way of others, begin as these: the flat start of power systems. None where there are none."""
    rules, known = question.kernel.alike, question.here
    pairs = [family.columns[[one, other]] for family in rules.families for one, other in _added(family.first)]
    if not pairs:
        return None
    kind = connected(np.concatenate(pairs, axis=1), len(rules.names))
    numbers = np.array([v if isinstance(v := known.get(name), float) else math.nan for name in rules.names])
    count = np.bincount(kind, ~np.isnan(numbers))
    means = np.bincount(kind, np.nan_to_num(numbers)) / np.maximum(count, 1.0)
    place = {name: i for i, name in enumerate(rules.names)}
    own = kind[[place[name] for name in question.unknowns]]
    return np.where(count[own] > 0.0, means[own], start) if count[own].any() else None


def _exponents(question: Question) -> NDArray[np.bool_]:
    """Which unknowns (n,) exponents of e are sums of, with factors: utilities, potentials. These may have
    either sign, and no size but that of 1."""
    place = {name: i for i, name in enumerate(question.unknowns)}
    rules, found = question.kernel.alike, np.zeros(len(place), dtype=bool)
    columns = np.array([place.get(name, -1) for name in rules.names], dtype=np.intp)
    for family in rules.families:
        for name in dict.fromkeys(_terms_of_exponents(family.first)):
            mine = columns[family.columns[family.first.names.index(name)]]
            found[mine[mine >= 0]] = True
    return found


def _terms_of_exponents(rule: Equation) -> Iterator[str]:
    waiting = [
        node.arguments[0]
        for node in walk(rule.left, rule.right)
        if isinstance(node, Call) and node.function in _EXPONENTIALS
    ]
    while waiting:
        match waiting.pop():
            case Name(name):
                yield name
            case Sum(terms):
                waiting += terms
            case Negative(one) | Quotient(one, _):
                waiting.append(one)
            case Product(one, other):
                waiting += (one, other)


def _added(rule: Equation) -> Iterator[tuple[int, int]]:
    """Pairs of names of a rule, by their places, that it adds to one another or takes from one another."""
    for node in walk(rule.left, rule.right):
        terms = node.terms if isinstance(node, Sum) else ()
        plain = [term.operand if isinstance(term, Negative) else term for term in terms]
        places = [rule.names.index(term.name) for term in plain if isinstance(term, Name)]
        yield from ((places[0], other) for other in places[1:])
