"""What is tried on a block when the search of ranges and damped Newton have found nothing.

Every further method is one that can go where damped Newton can't: uphill, through a minimum of |F|, round
where the Jacobian is nearly singular. They are tried in the order of the chain, from the guess first and then
from starts all over the ranges, until one answers.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeAlias

from solver.attempts import Method
from solver.kernel.candidates import Candidates
from solver.kernel.question import Question
from solver.numerics.dogleg import TrustLimits, dogleg
from solver.numerics.full_newton import full_newton
from solver.numerics.homotopy import HomotopyLimits
from solver.numerics.multistart import starting_points
from solver.numerics.newton import NewtonResult
from solver.numerics.release import fix_and_release

Point: TypeAlias = Sequence[float]
Search: TypeAlias = Callable[[Point], NewtonResult]

STARTS, FEW_STARTS = 48, 12
"""Starts of full Newton, of which a step costs little, and of the other methods."""
HELD, FEW_HELD = 6, 3
"""Unknowns that are fixed in turn, at the guess and at a start: those first that the block is torn at."""
SHORT_TRUST = TrustLimits(iterations=80)
SHORT_CURVE = HomotopyLimits(steps=120)


def fall_back(question: Question, candidates: Candidates, methods: Sequence[Method]) -> None:
    """Try one of the ``methods`` after another until ``candidates`` has an answer, be it a blurred one."""
    guess, *others = starting_points(
        question.guess(),
        [question.domain(name) for name in question.unknowns],
        question.scale(),
        STARTS,
    )
    import numpy as np

    for method in methods:
        search, starts = _way(method, question, guess, others)
        with np.errstate(all="ignore"):  # what overflows is refused as not finite
            iterations = _attempt(question, candidates, search, starts)
        candidates.tried(method, iterations=iterations)
        if not candidates.fruitless:
            break


def _way(
    method: Method, question: Question, guess: Point, others: Sequence[Point]
) -> tuple[Search, Sequence[Point]]:
    """The search of a method, and where from."""
    residual, jacobian, scale = question.residual, question.jacobian, question.scale()

    def full(start: Point) -> NewtonResult:
        return full_newton(residual, jacobian, start, scale)

    def trust(start: Point) -> NewtonResult:
        return dogleg(residual, jacobian, start, scale)

    def short_trust(start: Point) -> NewtonResult:
        return dogleg(residual, jacobian, start, scale, SHORT_TRUST)

    def release(start: Point) -> NewtonResult:
        return _released(question, start, HELD)

    def short_release(start: Point) -> NewtonResult:
        return _released(question, start, FEW_HELD)

    few = others[:FEW_STARTS]
    ways: dict[Method, tuple[Search, Sequence[Point]]] = {
        Method.FULL: (full, [guess]),
        Method.DOGLEG: (trust, [guess]),
        Method.RELEASE: (release, [guess]),
        Method.FULL_STARTS: (full, others),
        Method.DOGLEG_STARTS: (short_trust, few),
        Method.RELEASE_STARTS: (short_release, few),
    }
    return ways[method]


def _released(question: Question, start: Point, most: int) -> NewtonResult:
    """Fix one unknown after another at the start, until one release leads to a root."""
    residual, jacobian, scale = question.residual, question.jacobian, question.scale()
    order = list(dict.fromkeys((*question.kernel.block.tears, *question.unknowns)))[:most]
    used = 0
    for name in order:
        held = question.unknowns.index(name)
        end = fix_and_release(residual, jacobian, start, scale, held, SHORT_CURVE)
        used += end.iterations
        if end.outcome.found:
            break
    return replace(end, iterations=used)


def _attempt(question: Question, candidates: Candidates, search: Search, starts: Sequence[Point]) -> int:
    """Search from each start, up to the first that leads to an answer; the iterations."""
    iterations = 0
    for start in starts:
        end = search(start)
        iterations += end.iterations
        if end.outcome.found:
            candidates.refine(end.x)
        else:
            candidates.note(question.named(end.x))
        if not candidates.fruitless:
            break
    return iterations
