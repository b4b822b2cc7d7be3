"""A simultaneous block at given numbers: every answer that can be found, and whether that is all.

The ways are tried in this order: elimination where the block is linear or leads to formulas; the whole
range of the tear where there is one, or boxes where all ranges are finite; Newton from many starts; and
where all of that found nothing, the methods of ``fallback.py``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rulesheets.model import Value
from rulesheets.record import replace
from solver.attempts import Attempt, Method
from solver.facts import NoRoot
from solver.kernel.block import BlockKernel
from solver.kernel.budget import Budget
from solver.kernel.candidates import Candidates
from solver.kernel.formula import solve_by_formula
from solver.kernel.linear_block import solve_linear_block
from solver.kernel.near_rank import Blur
from solver.kernel.outcome import BlockOutcome, Stretch
from solver.kernel.polynomial_block import solve_as_polynomial, solve_by_half_angle
from solver.kernel.question import Question
from solver.kernel.tear_search import TearSearch
from solver.numerics.newton import NewtonLimits

STARTS = 24
FEW_STARTS = 6
START_LIMITS = NewtonLimits(iterations=40, escapes=2)
MAX_ANSWERS = 64
MAX_BOX_UNKNOWNS = 6
MAX_BATCH_UNKNOWNS = 60
MAX_PROOF_UNKNOWNS = 12
"""The same where a proof is asked for."""
MAX_STRETCHES = 6
"""Intervals that a search left open, beyond which it is no use to settle them."""


def solve_block(
    kernel: BlockKernel,
    values: Mapping[str, Value],
    guesses: Mapping[str, float],
    budget: Budget | None = None,
    assumed: bool = False,
    off: Blur = dict,
) -> BlockOutcome:
    """All answers of the block that can be found at the known ``values``, within the ``budget`` begun for it.

    ``off`` tells how far these may be from what they stand for, by name. ``assumed``: the block belongs to a
    case that may well have no answer, so that last resorts are left out.
    """
    if budget is None:
        budget = Budget()
        budget.begin_block()
    question = Question(kernel, values, guesses)
    block = kernel.block
    if question.symbolic:
        return BlockOutcome(complete=True, facts=(NoRoot(block.equations, block.unknowns, True),))
    linear = solve_linear_block(question, off) if kernel.linear else None
    if linear is not None:
        attempt = Attempt(Method.LINEAR, len(linear.answers), linear.complete)
        return replace(linear, attempts=(attempt,))
    candidates = Candidates(question)
    if solve_as_polynomial(question, candidates):
        candidates.tried(Method.POLYNOMIAL, complete=True)
        return _outcome(question, candidates, complete=True)
    if kernel.closed is not None and solve_by_formula(question, candidates, kernel.closed):
        candidates.tried(Method.FORMULA, complete=True)
        return _outcome(question, candidates, complete=True)
    if solve_by_half_angle(question, candidates):
        candidates.tried(Method.POLYNOMIAL, complete=True)
        return _outcome(question, candidates, complete=True)
    complete = whole = False
    stretches: tuple[Stretch, ...] = ()
    if len(block.tears) == 1:
        search = TearSearch(question, candidates, kernel, budget)
        if (freedom := search.freedom()) is not None:
            return freedom
        others = (TearSearch(question, candidates, other, budget) for other in kernel.others())
        searches = [s for s in (search, *others) if s.kernel.exhaustive]
        whole = any(s.run() for s in searches)
        complete = whole and not candidates.refused
        stretches = () if whole else _settleable(searches)
        candidates.tried(Method.RANGE, complete)
        if not candidates.answers and (freedom := search.flat_stretch()) is not None:
            return freedom
    most = MAX_PROOF_UNKNOWNS if budget.thorough else MAX_BOX_UNKNOWNS
    if question.finite and len(block.unknowns) <= most and (len(block.tears) > 1 or _asked(budget, whole)):
        from solver.kernel.box_search import search_boxes

        complete = search_boxes(question, candidates, budget.thorough)
        candidates.tried(Method.BOXES, complete)
    if not complete:
        _from_starts(question, candidates, budget)
        candidates.tried(Method.STARTS)
        if not candidates.answers and len(block.tears) == 1 and not kernel.exhaustive:
            search.run()
        if not candidates.answers and not assumed and budget.last_resort():
            from solver.kernel.fallback import fall_back

            fall_back(question, candidates)
    return replace(_outcome(question, candidates, complete), stretches=stretches, whole=whole)


def _asked(budget: Budget, whole: bool) -> bool:
    """Whether boxes are to be searched as well where the range of the tear was."""
    return budget.thorough and not whole


def _settleable(searches: Sequence[TearSearch]) -> tuple[Stretch, ...]:
    """Where the first search failed to prove that it had found all, if only in a few short stretches."""
    for search in searches:
        if search.stretches and not search.doubts and len(search.stretches) <= MAX_STRETCHES:
            return tuple(search.stretches)
    return ()


def _from_starts(question: Question, candidates: Candidates, budget: Budget) -> None:
    kernel = question.kernel
    in_batches = kernel.smooth and len(kernel.unknowns) <= MAX_BATCH_UNKNOWNS
    if question.guesses or not in_batches:
        _one_by_one(question, candidates)
    if in_batches:
        from solver.kernel.start_search import search_from_starts

        try:
            search_from_starts(question, candidates, budget)
        except ZeroDivisionError:  # between numbers of the rules themselves, whatever the unknowns are
            return


def _one_by_one(question: Question, candidates: Candidates) -> None:
    from solver.numerics.multistart import multistart

    found = multistart(
        question.residual,
        question.jacobian,
        question.guess(),
        [question.domain(name) for name in question.unknowns],
        question.scale(),
        FEW_STARTS if candidates.answers else STARTS,
        limits=START_LIMITS,
    )
    for root in found.roots:
        candidates.refine(root.x)
    if found.best is not None:
        candidates.note(question.named(found.best.x))


def _outcome(question: Question, candidates: Candidates, complete: bool) -> BlockOutcome:
    return replace(
        _found(question, candidates, complete),
        attempts=tuple(candidates.attempts),
        suspects=tuple(candidates.suspects),
        refused=tuple(candidates.refused),
        blurred=tuple(candidates.blurred),
    )


def _found(question: Question, candidates: Candidates, complete: bool) -> BlockOutcome:
    block = question.kernel.block
    answers = sorted(candidates.answers, key=lambda answer: question.preference(answer.values))
    if answers:
        return BlockOutcome(tuple(answers[:MAX_ANSWERS]), complete and len(answers) <= MAX_ANSWERS)
    if candidates.outside is not None:
        return BlockOutcome(complete=complete, facts=(candidates.outside,))
    best = candidates.nearest
    misses = tuple(question.residual(list(best.values()))) if best else ()
    fact = NoRoot(block.equations, block.unknowns, complete, best, misses)
    return BlockOutcome(complete=complete, facts=(fact,))
