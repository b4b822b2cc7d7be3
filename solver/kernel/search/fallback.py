"""The last resort, where the search of ranges and damped Newton have found nothing: trust regions.

Damped Newton keeps the direction of a step and shortens it; in a trust region it turns downhill as it is
shortened (M. J. D. Powell, 1970; K. Levenberg, 1944, and D. Marquardt, 1963), which gets round where the
Jacobian is nearly singular.
"""

from __future__ import annotations

from solver.attempts import Method
from solver.kernel.candidates import Candidates
from solver.kernel.question import Question
from solver.numerics.multistart import starting_points
from solver.numerics.newton import TRUST_REGIONS, scipy_root

STARTS = 24


def fall_back(question: Question, candidates: Candidates) -> None:
    """Try trust regions from the guess and from many starts until ``candidates`` has an answer."""
    ranges, scale = [question.domain(name) for name in question.unknowns], question.scale()
    evaluations = 0
    for start in starting_points(question.guess(), ranges, scale, STARTS):
        for method in TRUST_REGIONS:
            end = scipy_root(question.residual, question.jacobian, start, method, scale)
            evaluations += end.evaluations
            candidates.refine(end.x)
            if not candidates.fruitless:
                candidates.tried(Method.TRUST_REGION, iterations=evaluations)
                return
    candidates.tried(Method.TRUST_REGION, iterations=evaluations)
