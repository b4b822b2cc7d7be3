"""A block with several tears whose unknowns all have finite ranges: searched box by box, with proof."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rulesheets.syntax.nodes import Expression
from solver.kernel.candidates import Candidates
from solver.kernel.code.interval_arrays import ARRAYS
from solver.kernel.code.interval_code import IntervalEmitter
from solver.kernel.question import Question
from solver.kernel.search.hull import Hull
from solver.numerics.subdivision import Array, BoxFunction, SubdivisionLimits, branch_and_prune

LIMITS = SubdivisionLimits(boxes=20_000, alive=2_000)
THOROUGH = SubdivisionLimits(boxes=600_000, alive=400_000)


def search_boxes(question: Question, candidates: Candidates, thorough: bool = False) -> bool:
    """Refine every box that may hold a root. True where the roots are proven to be all.

    ``thorough``: with thirty times the boxes.
    """
    kernel = question.kernel
    ranges = [question.domain(name) for name in question.unknowns]
    hull = Hull(kernel.forms, question.unknowns, dict(zip(kernel.known, question.known, strict=True)))
    partials = [partial for partial in kernel.partials if partial is not None]
    n = len(question.unknowns)
    residual = _bounds(kernel.forms, question, (n,))
    jacobian = _bounds(partials, question, (n, n))
    limits = THOROUGH if thorough else LIMITS
    found = branch_and_prune(residual, jacobian, ranges, limits, hull.contract)
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
