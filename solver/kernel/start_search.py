"""Roots of a block from many starts: tears spread over their ranges, the rest by the block's own steps.

Following the chains of the tearing puts every start on all equations but the residual ones; where a step
would leave the domain it is held at the edge of it. Nothing is proven about roots that no start leads to.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from solver.kernel.candidates import Candidates
from solver.kernel.question import Budget, Question
from solver.numerics.multistart import Array, arrivals, spread
from solver.numerics.newton import NewtonLimits

ROUNDS = ((0, 128), (128, 512), (512, 1024))
"""From which start of a sequence to which a round goes, of each of the two kinds; two rounds at least."""
MOST = 48
"""Ends of a round that are looked at, those of ordinary size first: many may lie along a curve or far out."""
SAME = 1e-6
FINISH = NewtonLimits(iterations=60, escapes=0)


def search_from_starts(question: Question, candidates: Candidates, budget: Budget) -> None:
    """Refine what the starts lead to, round after round, until a round brings nothing new."""
    arrays = question.kernel.arrays
    known, sizes = question.known, sizes_of(question)
    scale = np.array([sizes[name] for name in question.unknowns])
    found: list[Array] = []
    for turn, (first, last) in enumerate(ROUNDS):
        starts = starts_of(question, sizes, first, last)
        ends = arrivals(partial(arrays.residual, known), partial(arrays.jacobian, known), starts, scale)
        with np.errstate(over="ignore"):  # an end that is too far out comes last
            new = _distinct(_wrapped(question, ends), found, scale)
            nearest = sorted(new, key=lambda end: float(np.max(abs(end) / scale)))
        for end in nearest[:MOST]:
            candidates.refine(end.tolist(), FINISH)
            if candidates.endless:
                return
        if turn == 0 and not new:
            _note_the_best(question, candidates, starts)
        if (turn and not new) or not budget.another_round():
            break
        found += new


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
        if not (abs(seen[:count] - end) <= SAME * size).all(axis=1).any():
            seen[count] = end
            count += 1
    return list(seen[len(known) : count])
