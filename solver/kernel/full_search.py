"""Searches over all unknowns of a block at once: by boxes, from starts, for a curve.

If all unknowns have finite ranges, their box is subdivided with proof
(``numerics/box_search.py``).

Half of the starts are tears spread over their ranges, followed along the chains of the tearing.
Such a start satisfies all equations but the residual ones; a step that would leave the domain stays
at its boundary. If descent finds nothing, trust regions are tried.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from rulesheets.syntax.nodes import Expression
from solver.facts import Attempt, Beside, Method, NoRoot, RankLoss
from solver.kernel.candidates import Answer, BlockOutcome, Candidates
from solver.kernel.emitter import IntervalEmitter
from solver.kernel.linear_block import left_free
from solver.kernel.problem import FIRST_ROUND, BlockProblem, uncertainty
from solver.numerics.box_search import (
    GAUSS_NEWTON,
    NEWTON,
    Iteration,
    arrivals,
    branch_and_prune,
    spread,
)
from solver.numerics.linear_algebra import Array, equilibrated
from solver.numerics.newton import STANDARD_LIMITS, TRUST_REGIONS, NewtonLimits, newton, scipy_root
from solver.numerics.tolerances import EPS, FREE, MOVED, SAME_END, SMALL

# --- box by box ---

LIMITS, THOROUGH = (20_000, 2_000), (600_000, 400_000)
"""Boxes in all, and at once; the same where a proof is asked for."""


def search_boxes(problem: BlockProblem, candidates: Candidates, thorough: bool) -> bool:
    """Refine every box that may hold a root. True if the roots are proven to be all."""
    kernel = problem.kernel
    ranges, n = [problem.domain(name) for name in problem.unknowns], len(problem.unknowns)
    residual = _bounds(kernel.forms, problem, (n,))
    jacobian = _bounds(kernel.partials, problem, (n, n))
    found = branch_and_prune(residual, jacobian, ranges, *(THOROUGH if thorough else LIMITS))
    for root in found.roots:
        candidates.refine(list(root))
    return found.complete and len(candidates.answers) >= len(found.roots)


def _bounds(forms: Sequence[Expression], problem: BlockProblem, shape: tuple[int, ...]) -> Any:
    """Bounds (k, *shape) of as many forms over boxes (k, n), compiled."""
    emitter = IntervalEmitter(problem.unknowns, problem.kernel.known)
    ends = [end for form in forms for end in emitter.of(form)]
    on_box = emitter.function(ends)(*problem.known)

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


def search_from_starts(problem: BlockProblem, candidates: Candidates) -> None:
    """Find roots from the guess and from starts spread over the ranges, without proof."""
    kernel = problem.kernel
    batches = len(kernel.unknowns) <= MAX_BATCH_UNKNOWNS
    if problem.guesses or not batches:  # one by one: the guess is worth a longer search
        starts = _guess_and_beside(problem, FEW_STARTS if candidates.answers else STARTS)
        for number, start in enumerate(starts):
            limits = START_LIMITS if number else STANDARD_LIMITS
            end = newton(problem.residual, problem.jacobian, start, problem.scale, limits)
            if end.outcome.found:
                candidates.refine(end.x)
            else:
                candidates.note(problem.named(end.x))
            if candidates.endless:
                break
    if batches:
        try:
            _in_batches(problem, candidates)
        except ZeroDivisionError:
            return  # between numbers of the rules themselves, whatever the unknowns are


def _guess_and_beside(problem: BlockProblem, count: int) -> Iterator[list[float]]:
    """The guess in the ranges, 1 where there is none; and points spread over the ranges."""
    ranges = {name: problem.domain(name) for name in problem.unknowns}
    yield [
        min(max(problem.guesses.get(name, 1.0), low), high) for name, (low, high) in ranges.items()
    ]
    yield from spread([*ranges.values()], problem.scale, count)


# --- hundreds of starts at once ---

ROUNDS = ((0, 128), (128, 512), (512, 1024))
"""The starts of a sequence for each round, for each of the two kinds; two rounds at least."""
MOST = 48
"""The most ends of a round that are examined, those of the case and ordinary sizes first: many may
lie along a curve or far out."""
FINISH = NewtonLimits(iterations=60, escapes=0)


def _in_batches(problem: BlockProblem, candidates: Candidates) -> None:
    """Refine the ends of the starts, round after round, until a round leads to nothing new; or to
    no new answer, if a search of a range has found some."""
    scale = problem.sizes
    found, known = list[Array](), len(candidates.answers)
    problem.budget.used += FIRST_ROUND * len(scale)
    for turn, (first, last) in enumerate(ROUNDS):
        starts = starts_of(problem, first, last)
        ends = _arrivals(problem, starts)
        with np.errstate(over="ignore"):  # an end that is too far out comes last
            new = _distinct(problem, ends, found)
            nearest = sorted(new, key=lambda end: (_misfits(problem, end), max(abs(end) / scale)))
        for end in nearest[:MOST]:
            candidates.refine(end.tolist(), FINISH)
            if candidates.endless:
                return
        if turn == 0 and not new:
            # a start of least residual tells how near the search came
            with np.errstate(all="ignore"):
                misses = abs(problem.kernel.arrays.residual(problem.known, starts)).max(axis=1)
            if np.isfinite(misses).any():
                candidates.note(problem.named(starts[np.nanargmin(misses)].tolist()))
        if (
            known == len(candidates.answers) > 0
            or (turn and not new)
            or not problem.budget.another_round()
        ):
            break
        found += new


def _misfits(problem: BlockProblem, point: Array) -> bool:
    return not problem.fits(problem.named(point.tolist()))


def _arrivals(
    problem: BlockProblem,
    starts: Array,
    ranges: tuple[Array, Array] | None = None,
    by: Iteration = NEWTON,
) -> Array:
    arrays, known = problem.kernel.arrays, problem.known
    residual, jacobian = partial(arrays.residual, known), partial(arrays.jacobian, known)
    return arrivals(residual, jacobian, starts, problem.sizes, by, ranges)


def starts_of(problem: BlockProblem, first: int, last: int) -> Array:
    """Starts along the chains, as many with every unknown independent; after the first round also
    as many positive ones, as most quantities are."""
    sizes = problem.named(problem.sizes.tolist())

    def points(names: Sequence[str]) -> Array:
        """So many points (last - first, names), spread over the ranges of unknowns."""
        around = [sizes[name] for name in names]
        return np.array(list(spread([*map(problem.domain, names)], around, last - first, first)))

    with np.errstate(all="ignore"):
        along = problem.kernel.arrays.starts(problem.known, points(problem.kernel.block.tears))
    apart = points(problem.unknowns)
    starts = [np.where(np.isfinite(along), along, apart), apart]
    if first:
        ends = map(problem.domain, problem.unknowns)
        signed = [low == -math.inf and high == math.inf for low, high in ends]
        starts.append(np.where(signed, abs(apart), apart))
    return np.concatenate(starts)


def _distinct(problem: BlockProblem, ends: Array, known: Sequence[Array]) -> list[Array]:
    """The points that equal none of the ``known`` or earlier ones, with angles in the turn around
    0."""
    ends = ends.copy()
    for place, name in enumerate(problem.unknowns):
        turn, (low, high) = problem.turn(name), problem.domain(name)
        if turn is not None and high - low == turn:
            ends[:, place] -= turn * np.floor((ends[:, place] - low) / turn)
    seen = np.empty((len(known) + len(ends), len(problem.unknowns)))
    seen[: len(known)] = np.reshape(known, (-1, len(problem.unknowns)))
    count = len(known)
    for end in ends:
        size = np.maximum(abs(end), SMALL * problem.sizes)
        if not (abs(seen[:count] - end) <= SAME_END * size).all(axis=1).any():
            seen[count] = end
            count += 1
    return list(seen[len(known) : count])


# --- trust regions ---

TRUST_REGION_STARTS = 24
TRUST_REGION_WORK = 200_000
"""Evaluations of single rules."""


def fall_back(problem: BlockProblem, candidates: Candidates) -> None:
    """Try trust regions from the guess and from many starts until ``candidates`` has an answer."""
    evaluations = 0
    for start, method in product(_guess_and_beside(problem, TRUST_REGION_STARTS), TRUST_REGIONS):
        end = scipy_root(problem.residual, problem.jacobian, start, method, problem.scale)
        evaluations += end.evaluations
        candidates.refine(end.x)
        if not candidates.is_empty or evaluations * len(problem.unknowns) > TRUST_REGION_WORK:
            break
    candidates.tried(Method.TRUST_REGION)


# --- a curve of answers: a block that leaves its unknowns free, however it is torn ---
#
# If rules are dependent at the given numbers, the answers are not points but a curve. No search for
# points finds it, and exact arithmetic may even prove that there is no answer: numbers that agree
# to their last places contradict one another beyond these. This search finds points that satisfy
# the rule check; if all rules also hold along a direction from it, a point lies on a curve. A block
# may have isolated answers besides a curve of them, for example where a common factor is 0.

WORK = 400
"""Starts times unknowns of a search."""
FEWEST_STARTS, MOST_STARTS = 6, 32
ENDS = 6
"""The most ends of a search that are examined."""
AWAY = 0.02
"""The distance along a direction, in usual sizes of unknowns, at which rules must still hold."""
CORRECTIONS = 4


def free_curve(
    problem: BlockProblem, point: Mapping[str, float] | None = None
) -> BlockOutcome | None:
    """The freedom of a block at a point; None if there is none, or it does not continue. A smooth
    rule that holds along a stretch of its only unknown holds at any value of it, which is seen
    before."""
    if not 1 < len(problem.unknowns) <= MAX_BATCH_UNKNOWNS:
        return None
    with np.errstate(all="ignore"):
        try:
            curve = _FreeCurve(problem)
            given = [] if point is None else [np.array([point[name] for name in problem.unknowns])]
            return next(filter(None, map(curve.through, given or curve.points())), None)
        except (ArithmeticError, ValueError, np.linalg.LinAlgError):
            return None


class _FreeCurve:
    def __init__(self, problem: BlockProblem) -> None:
        self.problem, self.scale = problem, problem.sizes
        low, high = np.array([(variable.low, variable.high) for variable in problem.variables]).T
        self.projected = partial(_arrivals, problem, ranges=(low, high), by=GAUSS_NEWTON)

    def points(self) -> Iterator[Array]:
        """Points of the case at which every rule holds, from a few starts."""
        count = min(max(WORK // len(self.scale), FEWEST_STARTS), MOST_STARTS)
        ends = self.projected(starts_of(self.problem, 0, count // 2))
        nearest = sorted(ends, key=lambda x: float(max(abs(x) / self.scale)))[:ENDS]
        points = (point for end in nearest if (point := self._corrected(end)) is not None)
        return (point for point in points if not _misfits(self.problem, point))

    def _corrected(self, x: Array) -> Array | None:
        """The point with a few corrections of least norm, if every rule holds there and it is in
        range."""
        problem = self.problem
        for _ in range(CORRECTIONS):
            for trial in (x, np.where(abs(x) <= EPS * self.scale, 0.0, x)):
                point = problem.named(trial.tolist())
                if problem.holds(point):
                    return trial if problem.outside(point) is None else None
            matrix, weight, rows = self._scaled(x)
            miss = np.array(problem.residual(x.tolist())) / rows
            x = x - weight * np.linalg.lstsq(matrix, miss, rcond=FREE)[0]
        return None

    def _weight(self, x: Array) -> Array:
        """The units (n,) of the unknowns at a point."""
        return np.maximum(abs(x), SMALL * self.scale)

    def _scaled(self, x: Array) -> tuple[Array, Array, Array]:
        """The Jacobian in units of the unknowns and of the rules, and these units."""
        weight = self._weight(x)
        matrix, rows = equilibrated(self.problem.jacobian(x.tolist()), weight)
        return matrix, weight, rows

    def through(self, x: Array) -> BlockOutcome | None:
        """The free unknowns along every direction in which all rules continue to hold."""
        weight = self._weight(x)
        try:
            _, singular, right = np.linalg.svd(self._scaled(x)[0])
            ways = right[singular <= FREE * singular[0]]
        except (ArithmeticError, ValueError):
            ways = np.eye(len(x))  # a slope is infinite: rules may hold along one unknown
        # of an unknown that is 0, too: a double root is flat for less
        unit = np.maximum(abs(x), self.scale)
        steps = (way * weight / max(abs(way * weight) / unit) for way in ways)
        others = [there for step in steps if (there := self._along(x, step)) is not None]
        if not others:
            return None
        changes = np.max([abs(there - x) / weight for there in others], axis=0)
        problem, point = self.problem, self.problem.named(x.tolist())
        free = tuple(n for n, moves in zip(problem.unknowns, changes, strict=True) if moves > MOVED)
        if not free:
            return None
        change = problem.named((others[0] - x).tolist())
        largest = max(abs(change[name]) for name in free) or 1.0
        direction = {name: far / largest if name in free else 0.0 for name, far in change.items()}
        return left_free(problem, point, direction, free)

    def _along(self, x: Array, way: Array) -> Array | None:
        """A point some distance away, on either side, at which every rule holds."""
        meant = float(abs(AWAY * way).max())
        ahead: Array = x + np.outer((AWAY, -AWAY), way)
        there: Array
        for there in ahead:
            point = self.problem.named(there.tolist())
            if self.problem.holds(point) and self.problem.outside(point) is None:
                return there
        for there in self.projected(ahead):
            corrected = self._corrected(there)
            if (
                corrected is not None
                and 0.1 * meant <= float(abs(corrected - x).max()) <= 10.0 * meant < math.inf
            ):
                return corrected
        return None


ISOLATED_STARTS = 32
MOST_BESIDE = 12
"""Unknowns of a block up to which isolated answers are searched besides a curve."""


def with_isolated(problem: BlockProblem, curve: BlockOutcome) -> BlockOutcome:
    """The isolated answers, if a few starts find any, with the curve as a note; else the curve."""
    known = curve.answers[0].values if curve.answers else {}
    if not known or len(problem.unknowns) > MOST_BESIDE:
        return curve
    answers = _isolated(problem, ())
    return (
        BlockOutcome(answers, facts=(beside(curve),), attempts=curve.attempts) if answers else curve
    )


def _isolated(problem: BlockProblem, known: Sequence[Answer]) -> tuple[Answer, ...]:
    """The ``known`` isolated answers, and those that a few starts find."""
    found = Candidates(problem)
    found.answers += known
    for start in starts_of(problem, 0, ISOLATED_STARTS // 2).tolist():
        found.refine(start, START_LIMITS)
    regular = (answer for answer in found.answers[len(known) :] if answer.double is None)
    return (*known, *(answer for answer in regular if free_curve(problem, answer.values) is None))


def beside(curve: BlockOutcome) -> Beside:
    """The note on a curve of answers besides the isolated ones."""
    known = tuple(curve.answers[0].values.items()) if curve.answers else ()
    equations = next((f.equations for f in curve.facts if isinstance(f, RankLoss)), ())
    return Beside(equations, curve.free, known)


MOST_SUSPECTS = 48
"""The most answers that are checked for a curve; further ones count as isolated."""


def _sure(problem: BlockProblem, answers: Sequence[Answer]) -> tuple[Answer, ...]:
    """The answers without double ones that lie in the case by rounding alone, as where a curve
    crosses another one outside it."""

    def is_sure(answer: Answer) -> bool:
        point = answer.values
        errors = zip(point.items(), uncertainty(problem, point).errors, strict=True)
        return all(problem.fits({**point, n: v + s * e}) for (n, v), e in errors for s in (-1, 1))

    return tuple(answer for answer in answers if not answer.double or is_sure(answer))


def without_curves(problem: BlockProblem, outcome: BlockOutcome) -> BlockOutcome:
    """The outcome without answers that lie on a curve; the free unknowns of the curve, if there are
    no others.

    A list of some points of a curve is never complete.
    """
    suspects = [answer for answer in outcome.answers if answer.double]
    if not suspects or outcome.free:
        return outcome
    checked = suspects[:MOST_SUSPECTS]
    curves = [free_curve(problem, answer.values) for answer in checked]
    first = next(filter(None, curves), None)
    if first is None:
        sure = _sure(problem, outcome.answers)
        return outcome if outcome.complete or not sure else outcome._replace(answers=sure)
    simple = [answer for answer in outcome.answers if not answer.double]
    more = simple[: MOST_SUSPECTS - len(checked)]
    curves += [free_curve(problem, answer.values) for answer in more]
    pairs = zip((*checked, *more), curves, strict=True)
    gone = [answer for answer, curve in pairs if curve is not None]
    others = tuple(a for a in outcome.answers if not any(a is one for one in gone))
    fitting = [answer.values for answer in gone if problem.fits(answer.values)]
    if not fitting:
        others = _sure(problem, others)
    if others:
        near = not all(map(problem.is_far_out, fitting))
        facts = (*outcome.facts, beside(first)) if near else outcome.facts
        if len(problem.unknowns) <= MOST_BESIDE:
            others = _isolated(problem, others)
        return outcome._replace(
            answers=others, complete=False, whole=False, stretches=(), facts=facts
        )
    if not fitting:
        return BlockOutcome(facts=(NoRoot(problem.equations, problem.unknowns, False),))
    return first._replace(attempts=(*outcome.attempts, Attempt(Method.CURVE, 1)))
