"""A block with several tears whose unknowns all have finite ranges: searched box by box, with proof."""

from __future__ import annotations

from typing import Any

import numpy as np

from rulesheets.evaluate.enclosure import enclose
from rulesheets.nodes import Expression
from solver.kernel.candidates import Candidates
from solver.kernel.question import Question
from solver.numerics.subdivision import SubdivisionLimits, branch_and_prune

LIMITS = SubdivisionLimits(boxes=20_000, alive=2_000)
THOROUGH = SubdivisionLimits(boxes=600_000, alive=40_000)


def search_boxes(question: Question, candidates: Candidates, thorough: bool = False) -> bool:
    """Refine every box that may hold a root. True where the roots are proven to be all.

    ``thorough``: with thirty times the boxes.
    """
    kernel = question.kernel
    constants = {name: (v, v) for name, v in zip(kernel.known, question.known, strict=True)}
    ranges = [question.domain(name) for name in question.unknowns]

    def bounds(expressions: list[Expression], low: Any, high: Any) -> tuple[Any, Any]:
        boxes = {n: (low[:, i], high[:, i]) for i, n in enumerate(question.unknowns)}
        ends = [enclose(expression, {**constants, **boxes}) for expression in expressions]
        return np.stack([lo for lo, _ in ends], 1), np.stack([hi for _, hi in ends], 1)

    def residual(low: Any, high: Any) -> tuple[Any, Any]:
        return bounds(kernel.forms, low, high)

    def jacobian(low: Any, high: Any) -> tuple[Any, Any]:
        flat = [partial for partial in kernel.partials if partial is not None]
        n = len(question.unknowns)
        lo, hi = bounds(flat, low, high)
        return lo.reshape(-1, n, n), hi.reshape(-1, n, n)

    found = branch_and_prune(residual, jacobian, ranges, THOROUGH if thorough else LIMITS)
    for root in found.roots:
        candidates.refine(list(root))
    return found.complete
