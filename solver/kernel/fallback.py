"""What is tried on a block when the search of ranges and damped Newton have found nothing.

Every further method is one that can go where damped Newton can't: uphill, through a minimum of |F|. They are
tried in a fixed order, from the guess first and then from starts all over the ranges, until one answers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeAlias

from solver.attempts import Method
from solver.kernel.candidates import Candidates
from solver.kernel.question import Question
from solver.numerics.full_newton import full_newton
from solver.numerics.homotopy import HomotopyLimits, follow_homotopy
from solver.numerics.multistart import starting_points
from solver.numerics.newton import NewtonResult

Search: TypeAlias = Callable[[Sequence[float]], NewtonResult]

STARTS = 48
CURVES = 12
MAX_CURVED = 40
"""Unknowns of a block up to which curves are followed: a step costs a decomposition of the Jacobian."""
FROM_STARTS = HomotopyLimits(steps=120)


def fall_back(question: Question, candidates: Candidates) -> None:
    """Try one method after another until ``candidates`` has an answer."""
    guess, *others = starting_points(
        question.guess(),
        [question.domain(name) for name in question.unknowns],
        question.scale(),
        STARTS,
    )
    for method, search, starts in _methods(question, guess, others):
        candidates.tried(method, iterations=_attempt(question, candidates, search, starts))
        if candidates.answers:
            break


def _methods(
    question: Question, guess: Sequence[float], others: Sequence[Sequence[float]]
) -> Iterator[tuple[Method, Search, Sequence[Sequence[float]]]]:
    residual, jacobian, scale = question.residual, question.jacobian, question.scale()
    curved = len(question.unknowns) <= MAX_CURVED

    def full(start: Sequence[float]) -> NewtonResult:
        return full_newton(residual, jacobian, start, scale)

    def curve(start: Sequence[float]) -> NewtonResult:
        return follow_homotopy(residual, jacobian, start, scale)

    def short_curve(start: Sequence[float]) -> NewtonResult:
        return follow_homotopy(residual, jacobian, start, scale, FROM_STARTS)

    yield Method.FULL, full, [guess]
    if curved:
        yield Method.HOMOTOPY, curve, [guess]
    yield Method.FULL_STARTS, full, others
    if curved:
        yield Method.HOMOTOPY_STARTS, short_curve, others[:CURVES]


def _attempt(
    question: Question, candidates: Candidates, search: Search, starts: Sequence[Sequence[float]]
) -> int:
    """Search from each start, up to the first that leads to an answer inside the ranges; the iterations."""
    iterations = 0
    for start in starts:
        end = search(start)
        iterations += end.iterations
        if end.outcome.found:
            candidates.refine(end.x)
        else:
            candidates.note(question.named(end.x))
        if candidates.answers:
            break
    return iterations
