"""Roots of a block from many starts: tears spread over their ranges, the rest by the block's own steps.

Following the chains of the tearing puts every start on all equations but the residual ones; where a step
would leave the domain it is held at the edge of it. Nothing is proven about roots that no start leads to.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from solver.kernel.candidates import Candidates
from solver.kernel.question import Question
from solver.numerics.batch_newton import Array, batch_newton
from solver.numerics.multistart import low_discrepancy
from solver.numerics.newton import NewtonLimits

STARTS = {1: 96, 2: 192, 3: 320}
MANY_STARTS = 480
SAME = 1e-6
NEAR = 1e-5
FINISH = NewtonLimits(iterations=15, escapes=0)


def search_from_starts(question: Question, candidates: Candidates) -> None:
    """Refine what the starts lead to."""
    arrays = question.kernel.arrays
    known = question.known
    scale = np.array(question.scale())
    with np.errstate(all="ignore"):
        starts = arrays.starts(known, _tears(question))
    starts = np.where(np.isfinite(starts), starts, scale)
    ends = batch_newton(partial(arrays.residual, known), partial(arrays.jacobian, known), starts, scale)
    for end in _distinct(ends, scale):
        if _of_the_rules(question, end.tolist()):
            candidates.refine(end.tolist(), FINISH)


def _of_the_rules(question: Question, x: list[float]) -> bool:
    """Whether a zero of the smooth forms is one of the rules as they were written, to what it is known."""
    try:
        residual, rows = question.residual(x), question.jacobian(x)
    except (ArithmeticError, ValueError):
        return True  # on the edge of a domain
    sizes = (sum(abs(slope * v) for slope, v in zip(row, x, strict=True)) for row in rows)
    return all(abs(r) <= NEAR * size + 1e-12 for r, size in zip(residual, sizes, strict=True))


def _tears(question: Question) -> Array:
    """Points (k, tears) spread over the ranges of the tears."""
    tears = question.kernel.block.tears
    count = STARTS.get(len(tears), MANY_STARTS)
    spreads = [_spread(question, name) for name in tears]
    shares = low_discrepancy(len(tears), count)
    return np.array([[spread(u) for spread, u in zip(spreads, row, strict=True)] for row in shares])


def _spread(question: Question, name: str) -> Callable[[float], float]:
    """From shares in [0, 1) to values: even over a finite range, else over the decades of what is known."""
    low, high = question.domain(name)
    if math.isfinite(low) and math.isfinite(high):
        return lambda u: low + u * (high - low)
    sizes = [abs(v) for v in question.known if v] or [1.0]
    least, most = math.log(min(sizes) / 10), math.log(max(sizes) * 10)

    def magnitude(u: float) -> float:
        return math.exp(least + u * (most - least))

    if math.isfinite(low):
        return lambda u: low + magnitude(u)
    if math.isfinite(high):
        return lambda u: high - magnitude(u)
    return lambda u: magnitude(2 * u - 1) if u >= 0.5 else -magnitude(1 - 2 * u)


def _distinct(ends: Array, scale: Array) -> list[Array]:
    found: list[Array] = []
    for end in ends:
        size = np.maximum(abs(end), 1e-3 * scale)
        if not any((abs(end - other) <= SAME * size).all() for other in found):
            found.append(end)
    return found
