"""A simultaneous block at given numbers: every answer that can be found, and whether these are all.

The methods of ``first_methods`` are tried one after another until the answers are known to be all;
if they find nothing, trust regions are tried. Damped Newton keeps the direction of a step and
shortens it; in a trust region it turns downhill as it is shortened (M. J. D. Powell, 1970; K.
Levenberg, 1944, and D. Marquardt, 1963), which helps where the Jacobian is nearly singular.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from typing import TYPE_CHECKING

from rulesheets.model import Values
from rulesheets.syntax import nodes
from solver.facts import Attempt, Fact, Method, NoRoot
from solver.kernel.block import DENSE, FLOATS, BlockKernel, Unclear, candidates
from solver.kernel.candidates import (
    MOST_ANSWERS,
    MOST_BESIDE,
    MOST_REPEATED,
    BlockOutcome,
    Candidates,
    Undecided,
)
from solver.kernel.problem import BlockProblem, Budget, Fits, InputErrors
from solver.path import ClosedForm

if TYPE_CHECKING:
    from solver.kernel.tear_search import TearSearch

MAX_BOX_UNKNOWNS, MAX_PROOF_UNKNOWNS = 6, 40
"""Unknowns of a block up to which boxes are searched; the same where a proof is asked for."""
MAX_SEARCHED = 12, 30
"""Unknowns of a block up to which all answers are searched for; the same where it has few tears."""
FEW_TEARS, MANY_TEARS = 3, 4
"""Tears of a block up to which starts at random are sure to come across the sensible answer; the
same of a small one with phasors."""


def first_methods(kernel: BlockKernel, thorough: bool = False) -> Iterator[Method]:
    """The methods in order, up to the last resort; ``thorough`` if a proof is requested.

    The properties of the block that a method needs are computed when its turn comes. Numbers may
    still rule one out.
    """
    n, tears = len(kernel.unknowns), kernel.block.tears
    if kernel.linear:
        yield Method.LINEAR
    elif is_large(kernel):
        yield Method.SPARSE
    # those that count the answers
    if may_be_polynomial(kernel):
        yield Method.POLYNOMIAL
    if kernel.closed is not None:
        yield Method.FORMULA
    # A block of some size without angles may be a network, most of whose answers nobody asks about,
    # or the speeds of a mechanism, whose few answers all count.
    some = MAX_SEARCHED[0] < n <= MAX_SEARCHED[1]
    if some and not kernel.linear and not any(map(kernel.graph.turn, kernel.unknowns)):
        yield Method.SPARSE
    if len(tears) == 1:
        yield Method.RANGE
    elif _nested(kernel):
        yield Method.SUBSTITUTION
    most = MAX_PROOF_UNKNOWNS if thorough else MAX_BOX_UNKNOWNS
    if (thorough or len(tears) > 1) and n <= most and kernel.finite:
        yield Method.BOXES
    if n <= DENSE:  # a full matrix of more, also of formulas, fills the memory
        yield Method.STARTS


def _nested(kernel: BlockKernel) -> tuple[BlockKernel, ...]:
    """The block with a single tear and formulas for the others."""
    from solver.kernel.nesting import nested

    return nested(kernel)


def is_large(kernel: BlockKernel) -> bool:
    """Whether one answer is searched for before any others. (A mechanism has angles, and its
    assemblies are all of interest; phasors, angles with magnitudes, have one sensible answer.)"""
    n, tears = len(kernel.unknowns), len(kernel.block.tears)
    turning = sum(kernel.graph.turn(name) is not None for name in kernel.unknowns)
    if n <= MAX_SEARCHED[0]:
        return n > MAX_BOX_UNKNOWNS and tears > MANY_TEARS and 0 < turning < n
    return n > MAX_SEARCHED[1] or (turning > 0 and (tears > FEW_TEARS or not kernel.exhaustive))


def may_be_polynomial(kernel: BlockKernel) -> bool:
    """Whether the block may lead to a polynomial in its tear, or to two in two."""
    tears, unknowns = kernel.block.tears, frozenset(kernel.unknowns)
    if not 1 <= len(tears) <= 2 or any(map(kernel.graph.turn, tears)):
        return False

    def found() -> bool:
        return all(unknowns.isdisjoint(nodes.names(call)) for call in nodes.calls(*kernel.forms))

    return kernel.once("polynomial", found)


SEARCHES = frozenset({Method.RANGE, Method.SUBSTITUTION, Method.BOXES, Method.STARTS})
"""Methods that search for answers everywhere."""
MAX_STRETCHES = 6
"""Intervals that a search left open, beyond which it is no use to settle them."""


def solve_block(
    kernel: BlockKernel,
    values: Values,
    guesses: Mapping[str, float],
    budget: Budget,
    off: InputErrors,
    fits: Fits | None,
    assumed: bool,
) -> BlockOutcome:
    """All answers of the block that can be found at the known ``values``, within the ``budget``
    begun for it.

    ``off``: the errors of these values, by name. ``fits``: whether an answer meets the requirements
    and lies in the case that was ``assumed``. Such a case may well have none, so last resorts are
    left out.
    """
    problem = BlockProblem(kernel, values, guesses, budget, fits)
    if problem.symbolic:
        block = kernel.block
        return BlockOutcome(complete=True, facts=(NoRoot(block.equations, block.unknowns, True),))
    outcome = _Methods(problem, off).run(assumed)
    if not outcome.free or assumed or budget.brief or kernel.linear:
        return outcome
    from solver.kernel.full_search import with_isolated

    return with_isolated(problem, outcome)


def solve_sparsely(
    kernel: BlockKernel, values: Values, guesses: Mapping[str, float], budget: Budget
) -> BlockOutcome:
    """The sensible answer of a block by sparse Newton steps only, if they lead to one."""
    return _Methods(BlockProblem(kernel, values, guesses, budget), dict).sparsely()


class _Methods:
    """The answers so far. ``complete``: they are proven to be all; ``whole``: they would be, if
    floats could represent the unresolved ones.

    Methods that isolate roots are imported when their turn comes: a closed form starts 3 ms sooner.
    """

    def __init__(self, problem: BlockProblem, off: InputErrors) -> None:
        self.problem, self.budget, self.kernel = problem, problem.budget, problem.kernel
        self.off = off
        self.candidates = Candidates(problem)
        self.complete = self.whole = False
        self.stretches: tuple[Undecided, ...] = ()

    def run(self, assumed: bool) -> BlockOutcome:
        """Try one method after another until the answers are known to be all."""
        problem, candidates, budget = self.problem, self.candidates, self.budget
        settled: BlockOutcome | None = None
        for method in first_methods(self.kernel, budget.thorough):
            if (
                budget.nearby
                and method in SEARCHES
                and (problem.guesses or method is not Method.STARTS)
            ):
                candidates.refine([problem.guesses.get(name, 1.0) for name in problem.unknowns])
                if problem.guesses or candidates.answers:
                    return self._outcome()
                continue
            if method is Method.STARTS and (refuted := self._refuted()) is not None:
                return refuted
            settled = self._tried(method)
            first = candidates.answers[0].values if candidates.answers else None
            if method is Method.SPARSE and first and problem.fits(first) and not budget.thorough:
                if is_large(self.kernel):
                    return self._outcome()
                candidates.sensible = None if budget.every else candidates.answers[0]
            if settled is not None or self.complete:
                break
            if method is Method.RANGE and candidates.sensible is not None:
                return self._outcome()
            found = any(answer.double is None for answer in candidates.answers)
            if budget.brief and method in SEARCHES and found:
                return self._outcome()  # that there is one is enough
        if not self.kernel.linear and (refuted := self._refuted()) is not None:
            return refuted
        if not (assumed or budget.brief or self.kernel.linear or candidates.answers):
            # rounding may have separated curves that nearly meet, and left no answer
            from solver.kernel.full_search import free_curve

            curve = free_curve(problem) if settled is None or not settled.answers else None
            if curve is not None:
                return curve._replace(attempts=(*candidates.attempts, Attempt(Method.CURVE, 1)))
        if settled is None:
            if self._worth_a_last_resort(assumed):
                from solver.kernel.full_search import fall_back

                fall_back(problem, candidates)
            settled = self._outcome()
        if budget.brief or not any(answer.double for answer in settled.answers):
            return settled
        from solver.kernel.full_search import without_curves

        return without_curves(problem, settled)

    def sparsely(self) -> BlockOutcome:
        """The first answer that sparse Newton steps find."""
        self._tried(Method.SPARSE)
        del self.candidates.answers[1:]
        return self._outcome()

    def _worth_a_last_resort(self, assumed: bool) -> bool:
        open_ = self.candidates.is_empty and not (self.complete or assumed)
        return open_ and len(self.kernel.unknowns) <= DENSE and self.budget.last_resort()

    def _refuted(self) -> BlockOutcome | None:
        """Why the rules contradict each other, whatever the unknowns are; None if that is unknown.
        Far out they may seem to touch."""
        found = self.candidates
        if found.outside is not None or not all(answer.double for answer in found.answers):
            return None
        from solver.kernel.linear_block import contradiction

        conflict = contradiction(self.problem)
        return None if conflict is None else BlockOutcome(complete=True, facts=(conflict,))

    def _tried(self, method: Method) -> BlockOutcome | None:
        """The outcome of a method, if it settles the block; otherwise its answers are added."""
        problem, candidates, kernel = self.problem, self.candidates, self.kernel
        solved = False
        match method:
            case Method.LINEAR if len(kernel.unknowns) > DENSE:
                self._sparsely()
                solved = bool(candidates.answers)
            case Method.POLYNOMIAL:
                from solver.kernel.polynomial_block import solve_polynomials

                solved = solve_polynomials(problem, candidates, self.off)
            case Method.FORMULA:
                solved = kernel.closed is not None and solve_by_formula(
                    problem, candidates, kernel.closed
                )
            case Method.RANGE:
                return self._over_tear(method, (kernel, *kernel.others))
            case Method.SUBSTITUTION if torn := _nested(kernel):
                return self._over_tear(method, torn)
            case Method.BOXES if not self.whole:
                from solver.kernel.full_search import search_boxes

                self.complete = search_boxes(problem, candidates, self.budget.thorough)
                candidates.tried(method, self.complete)
            case Method.SPARSE:
                self._sparsely()
                candidates.tried(method)
            case Method.STARTS:
                self._from_starts()
        if solved:
            self.complete = True
            candidates.tried(method, complete=True)
            return self._outcome()
        return self._linear() if method is Method.LINEAR else None

    def _linear(self) -> BlockOutcome | None:
        from solver.kernel.linear_block import solve_linear_block

        found = solve_linear_block(self.problem, self.off)
        return found and found._replace(
            attempts=(Attempt(Method.LINEAR, len(found.answers), found.complete),)
        )

    def _sparsely(self, every: bool = False) -> None:
        from solver.kernel.sparse_search import search_sparsely

        search_sparsely(self.problem, self.candidates, every)

    def _over_tear(self, method: Method, kernels: Sequence[BlockKernel]) -> BlockOutcome | None:
        """Search the range of the tear, with one tearing after another until all answers are
        known."""
        from solver.kernel.polynomial_block import counted
        from solver.kernel.tear_search import TearSearch

        problem, candidates = self.problem, self.candidates
        # then others count only where they are proven to be all
        known = candidates.sensible is not None
        tried = kernels[: 1 if known else None]
        every = [
            TearSearch(problem, candidates, kernel, method is not Method.RANGE) for kernel in tried
        ]
        if (freedom := every[0].freedom()) is not None:
            return freedom
        searches = [search for search in every if search.kernel.exhaustive]
        countable = method is Method.RANGE and not self.budget.brief
        self.whole = _any_complete(searches) or (
            countable and counted(problem, candidates, self.off)
        )
        if not self.whole and method is Method.RANGE:
            few = (s for s in searches if 0 < len(s.stretches) <= MAX_STRETCHES and not s.doubts)
            # it failed to prove that it has all in a few short stretches alone
            settleable = next(few, None)
            self.stretches = () if self.whole or settleable is None else tuple(settleable.stretches)
        self.complete = self.whole and not candidates.unresolved
        candidates.tried(method, self.complete)
        curve = every[0].flat_stretch()
        if curve is None or not candidates.answers:
            return curve
        from solver.kernel.full_search import beside

        return self._outcome()._replace(complete=False, facts=(beside(curve),))

    def _from_starts(self) -> None:
        problem, candidates = self.problem, self.candidates
        from solver.kernel.full_search import search_from_starts

        search_from_starts(problem, candidates)
        many = len(self.kernel.block.tears) > FEW_TEARS
        values = [one.values for one in candidates.answers if problem.fits(one.values)]
        positive = any(not problem.negatives(one) for one in values)
        if many or not (positive or self.budget.brief):
            self._sparsely(every=many)
        candidates.tried(Method.STARTS)
        torn_once = len(self.kernel.block.tears) == 1
        if torn_once and not candidates.answers and not self.kernel.exhaustive:
            from solver.kernel.tear_search import TearSearch

            TearSearch(problem, candidates, self.kernel).run()

    def _outcome(self) -> BlockOutcome:
        """The outcome of the answers so far: if there are too many, those with no more negative
        numbers than the preferred one, or it alone."""
        problem, candidates, block = self.problem, self.candidates, self.kernel.block
        complete, facts = self.complete and not candidates.unresolved, tuple[Fact, ...]()
        answers = sorted(candidates.answers, key=lambda answer: problem.preference(answer.values))
        cut = len(answers) >= MOST_ANSWERS
        if not complete and candidates.is_repeating:
            kept = sorted(answers, key=lambda answer: problem.periods(answer.values))[
                :MOST_REPEATED
            ]
            answers, cut = [answer for answer in answers if answer in kept], True
        if candidates.sensible is not None and candidates.has_too_many and not complete:
            self.budget.cut = True
            most = problem.negatives(candidates.sensible.values)
            alike = [one for one in answers if problem.negatives(one.values) <= most]
            answers = alike if len(alike) <= MOST_BESIDE else [candidates.sensible]
            cut = False
        elif candidates.outside is not None and not answers:
            facts = (candidates.outside,)
        elif not answers:
            facts = (NoRoot(block.equations, block.unknowns, complete, *candidates.nearest),)
        return BlockOutcome(
            tuple(answers),
            complete and not cut,
            facts,
            attempts=tuple(candidates.attempts),
            suspects=tuple(candidates.suspects),
            holes=tuple(candidates.holes),
            stretches=self.stretches,
            unresolved=tuple(candidates.unresolved),
            whole=self.whole or self.complete,
            cut=cut,
            accidental=frozenset(candidates.accidental),
        )


def _any_complete(searches: Sequence[TearSearch]) -> bool:
    """Whether a search finds all answers, or those of one tear together: what one of them leaves
    open the next looks into."""
    for _, of_tear in groupby(searches, key=lambda search: search.tear):
        left = None
        for search in of_tear:
            if search.run(left):
                return True
            left = left if search.left is None else search.left
    return False


# --- the answers of a closed form ---

MOST_TURNED = 300
"""The most candidates that whole turns make of one."""


def solve_by_formula(problem: BlockProblem, answers: Candidates, form: ClosedForm) -> bool:
    """Find the answers by the closed form; False if the formula may miss an answer."""
    try:
        found = [values for _, values in candidates(form, FLOATS, problem.values)]
    except (Unclear, ArithmeticError):
        return False
    points = [point for one in found for point in _turned(problem, one)]
    trial = Candidates(problem)
    if not all(map(trial.settles, points)):
        return False
    answers.take(trial)
    for point in points:
        answers.note(point)
    return True


def _turned(problem: BlockProblem, values: Mapping[str, float]) -> list[dict[str, float]]:
    """The candidate with every whole turn of its angles that a declared range admits.

    Of too many the ones nearest to 0, which are still more than are listed.
    """
    points = [{name: values[name] for name in problem.unknowns}]
    ranged = (v for v in problem.variables if v.ranged)
    angles = [(v, turn) for v in ranged if (turn := problem.turn(v.name)) is not None]
    most = round(MOST_TURNED ** (1 / max(len(angles), 1)))
    for variable, turn in angles:
        low, high = problem.domain(variable.name)
        number = values[variable.name]
        turns = range(math.ceil((low - number) / turn), math.floor((high - number) / turn) + 1)
        if len(turns) > most:
            first = min(max(turns.start, round(-number / turn) - most // 2), turns.stop - most)
            turns = range(first, first + most)
        points = [{**p, variable.name: number + k * turn} for p in points for k in turns or (0,)]
    return points
