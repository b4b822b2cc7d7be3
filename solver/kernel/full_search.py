"""Searches over all unknowns of a block at once: box by box with proof, and from many starts without.

Where all unknowns have finite ranges, their box is subdivided (``numerics/subdivision.py``).

Half of the starts are tears spread over their ranges, the rest by the block's own steps: following the chains
of the tearing puts every start on all equations but the residual ones; where a step would leave the domain it
is held at the edge of it. Where descent finds nothing, trust regions do.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from rulesheets.syntax.nodes import Expression
from solver.facts import Method
from solver.kernel.candidates import Candidates
from solver.kernel.emitter import IntervalEmitter
from solver.kernel.interval_forms import ARRAYS
from solver.kernel.question import Budget, Question
from solver.numerics.multistart import Array, arrivals, spread, starting_points
from solver.numerics.newton import STANDARD_LIMITS, TRUST_REGIONS, NewtonLimits, newton, scipy_root
from solver.numerics.subdivision import BoxFunction, SubdivisionLimits, branch_and_prune
from solver.numerics.tolerances import SAME_END

# --- box by box ---

LIMITS = SubdivisionLimits(boxes=20_000, alive=2_000)
THOROUGH = SubdivisionLimits(boxes=600_000, alive=400_000)


def search_boxes(question: Question, candidates: Candidates, thorough: bool = False) -> bool:
    """Refine every box that may hold a root. True where the roots are proven to be all.

    ``thorough``: with thirty times the boxes.
    """
    kernel = question.kernel
    ranges = [question.domain(name) for name in question.unknowns]
    partials = [partial for partial in kernel.partials if partial is not None]
    n = len(question.unknowns)
    residual = _bounds(kernel.forms, question, (n,))
    jacobian = _bounds(partials, question, (n, n))
    limits = THOROUGH if thorough else LIMITS
    found = branch_and_prune(residual, jacobian, ranges, limits)
    for root in found.roots:
        candidates.refine(list(root))
    return found.complete


def _bounds(forms: Sequence[Expression], question: Question, shape: tuple[int, ...]) -> BoxFunction:
    """Bounds (k, *shape) of as many forms over boxes (k, n), compiled."""
    emitter = IntervalEmitter(question.unknowns, question.kernel.known, ARRAYS)
    ends = [end for form in forms for end in emitter.of(form)]
    compiled = emitter.function(", ".join(ends))
    known = [np.float64(number) for number in question.known]

    def bounds(low: Array, high: Array) -> tuple[Array, Array]:
        corners = [corner[:, i] for i in range(low.shape[1]) for corner in (low, high)]
        found = [np.broadcast_to(end, len(low)) for end in compiled(*corners, *known)]
        below, above = np.stack(found[0::2], 1), np.stack(found[1::2], 1)
        return below.reshape(-1, *shape), above.reshape(-1, *shape)

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
    if question.guesses or not batches:
        _one_by_one(question, candidates)
    if batches:
        try:
            _in_batches(question, candidates, budget)
        except ZeroDivisionError:  # between numbers of the rules themselves, whatever the unknowns are
            return


def _one_by_one(question: Question, candidates: Candidates) -> None:
    """Damped Newton from the guess, which is worth a longer search, and from a few further points."""
    ranges, scale = [question.domain(name) for name in question.unknowns], question.scale()
    count = FEW_STARTS if candidates.answers else STARTS
    for number, start in enumerate(starting_points(question.guess(), ranges, scale, count)):
        limits = START_LIMITS if number else STANDARD_LIMITS
        end = newton(question.residual, question.jacobian, start, scale, limits)
        if end.outcome.found:
            candidates.refine(end.x)
        else:
            candidates.note(question.named(end.x))
        if candidates.endless:
            return


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
    sizes = sizes_of(question)
    scale = np.array([sizes[name] for name in question.unknowns])
    found: list[Array] = []
    for turn, (first, last) in enumerate(ROUNDS):
        starts = starts_of(question, sizes, first, last)
        ends = _arrivals(question, starts, scale)
        with np.errstate(over="ignore"):  # an end that is too far out comes last
            new = _distinct(_wrapped(question, ends), found, scale)
            nearest = sorted(new, key=lambda end: float(np.max(abs(end) / scale)))
        for end in nearest[:MOST]:
            candidates.refine(end.tolist(), FINISH)
            if candidates.endless:
                _beside_zeros(question, candidates, starts, scale)
                return
        if turn == 0 and not new:
            _note_the_best(question, candidates, starts)
        if (turn and not new) or not budget.another_round():
            break
        found += new


def _arrivals(
    question: Question, starts: Array, scale: Array, ranges: tuple[Array, Array] | None = None
) -> Array:
    arrays, known = question.kernel.arrays, question.known
    residual, jacobian = partial(arrays.residual, known), partial(arrays.jacobian, known)
    return arrivals(residual, jacobian, starts, scale, ranges=ranges)


def _beside_zeros(question: Question, candidates: Candidates, starts: Array, scale: Array) -> None:
    """Where the starts led to a curve along which unknowns are 0 (a mass, say, that all terms contain): the
    same starts again, on ways that do not cross those zeros."""
    points = np.array([list(answer.values.values()) for answer in candidates.answers])
    zero = (points == 0.0).all(axis=0) if len(points) else np.zeros(len(scale), dtype=bool)
    if not zero.any():
        return
    ranges = np.where(zero, 0.0, -np.inf), np.where(zero, 0.0, np.inf)
    ends = _arrivals(question, starts, scale, ranges)
    away = ends[(abs(ends[:, zero]) > NEAR_ZERO * scale[zero]).all(axis=1)]
    for end in _distinct(_wrapped(question, away), [], scale)[:MOST]:
        candidates.refine(end.tolist(), FINISH)


def _note_the_best(question: Question, candidates: Candidates, starts: Array) -> None:
    """A start of least residual, for a search that finds no root to tell how near it came."""
    with np.errstate(all="ignore"):
        misses = abs(question.kernel.arrays.residual(question.known, starts)).max(axis=1)
    if np.isfinite(misses).any():
        candidates.note(question.named(starts[np.nanargmin(misses)].tolist()))


def starts_of(question: Question, sizes: Mapping[str, float], first: int, last: int) -> Array:
    """Half of them along the chains, the others with every unknown on its own."""
    block = question.kernel.block
    with np.errstate(all="ignore"):
        tears = _points(question, block.tears, sizes, first, last)
        along = question.kernel.arrays.starts(question.known, tears)
    apart = _points(question, question.unknowns, sizes, first, last)
    return np.concatenate([np.where(np.isfinite(along), along, apart), apart])


def _points(
    question: Question, names: Sequence[str], sizes: Mapping[str, float], first: int, last: int
) -> Array:
    """The points (last - first, names) of a sequence that is spread over the ranges of unknowns."""
    ranges = [question.domain(name) for name in names]
    return np.array(list(spread(ranges, [sizes[name] for name in names], last - first, first)))


def sizes_of(question: Question) -> Mapping[str, float]:
    """The size of every unknown: that of its guess, else what the known numbers make of it."""
    known = dict(zip(question.kernel.known, question.known, strict=True))
    sizes = question.kernel.arrays.scalings.sizes(known)
    guesses = question.guesses
    return {
        name: turn / 4 if (turn := question.turn(name)) else abs(guesses.get(name, 0.0)) or sizes[name]
        for name in question.unknowns
    }


def _wrapped(question: Question, ends: Array) -> Array:
    """The same with angles in the turn around 0."""
    ends = ends.copy()
    for place, name in enumerate(question.unknowns):
        turn, (low, high) = question.turn(name), question.domain(name)
        if turn is not None and high - low == turn:
            ends[:, place] -= turn * np.floor((ends[:, place] - low) / turn)
    return ends


def _distinct(ends: Array, known: Sequence[Array], scale: Array) -> list[Array]:
    """Those that are neither among the ``known`` nor one another."""
    seen = np.empty((len(known) + len(ends), len(scale)))
    seen[: len(known)] = np.reshape(known, (-1, len(scale)))
    count = len(known)
    for end in ends:
        size = np.maximum(abs(end), 1e-3 * scale)
        if not (abs(seen[:count] - end) <= SAME_END * size).all(axis=1).any():
            seen[count] = end
            count += 1
    return list(seen[len(known) : count])


# --- trust regions ---

TRUST_REGION_STARTS = 24


def fall_back(question: Question, candidates: Candidates) -> None:
    """Try trust regions from the guess and from many starts until ``candidates`` has an answer."""
    ranges, scale = [question.domain(name) for name in question.unknowns], question.scale()
    evaluations = 0
    for start in starting_points(question.guess(), ranges, scale, TRUST_REGION_STARTS):
        for method in TRUST_REGIONS:
            end = scipy_root(question.residual, question.jacobian, start, method, scale)
            evaluations += end.evaluations
            candidates.refine(end.x)
            if not candidates.fruitless:
                candidates.tried(Method.TRUST_REGION, iterations=evaluations)
                return
    candidates.tried(Method.TRUST_REGION, iterations=evaluations)
