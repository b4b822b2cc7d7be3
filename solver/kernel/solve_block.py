"""A simultaneous block at given numbers: every answer that can be found, and whether that is all.

The methods of ``first_methods`` are tried one after another until the answers are known to be all; where they
found nothing, trust regions are. Damped Newton keeps the direction of a step and shortens it; in a trust
region it turns downhill as it is shortened (M. J. D. Powell, 1970; K. Levenberg, 1944, and D. Marquardt,
1963), which gets round where the Jacobian is nearly singular.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from rulesheets.functions import named
from rulesheets.model import Value
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Call
from rulesheets.syntax.program import walk
from solver.facts import Attempt, Fact, Method, NoRoot
from solver.kernel.algebra import contradiction, solve_by_formula, unattained
from solver.kernel.block import BlockKernel, reduced
from solver.kernel.candidates import MOST_ANSWERS, BlockOutcome, Candidates, Stretch
from solver.kernel.full_search import (
    fall_back,
    free_curve,
    search_boxes,
    search_from_starts,
    with_isolated,
    without_curves,
)
from solver.kernel.linear_block import Blur, solve_linear_block
from solver.kernel.question import Budget, Question
from solver.kernel.sparse_search import search_sparsely

if TYPE_CHECKING:
    from solver.kernel.tear_search import TearSearch

MAX_BOX_UNKNOWNS, MAX_PROOF_UNKNOWNS = 6, 40
"""Unknowns of a block up to which boxes are searched; the same where a proof is asked for."""
MAX_SEARCHED = 12, 30
"""Unknowns of a block up to which all answers are searched for; the same where it has few tears."""
FEW_TEARS, MANY_TEARS = 3, 4
"""Tears of a block up to which starts at random are sure to come across the sensible answer; the same of a
small one with phasors."""

_CIRCULAR = named(lambda row: row.turn and not row.half_turn)


def first_methods(kernel: BlockKernel, thorough: bool = False) -> Iterator[Method]:
    """The methods in order, up to the last resort; ``thorough`` where a proof is asked for.

    What a method needs to know of the block is found out when its turn comes. Numbers may still rule one out.
    """
    if kernel.linear:
        yield Method.LINEAR
    elif is_large(kernel):
        yield Method.SPARSE
    yield from _counts(kernel)
    if _is_network(kernel):
        yield Method.SPARSE
    yield from _searches(kernel, thorough)


def is_large(kernel: BlockKernel) -> bool:
    """Whether one answer is looked for before any others. (Several assemblies of a mechanism are of interest,
    and it has angles; but phasors, angles beside magnitudes, have one answer that is sensible.)"""
    n, tears = len(kernel.unknowns), len(kernel.block.tears)
    turning = sum(kernel.graph.turn(name) is not None for name in kernel.unknowns)
    if n <= MAX_SEARCHED[0]:
        return n > MAX_BOX_UNKNOWNS and tears > MANY_TEARS and 0 < turning < n
    return n > MAX_SEARCHED[1] or (turning > 0 and (tears > FEW_TEARS or not kernel.exhaustive))


def _is_network(kernel: BlockKernel) -> bool:
    """Whether a block of some size has no angles: it may be a network, most of whose answers nobody asks
    about, or the speeds of a mechanism, whose few answers all count."""
    some = MAX_SEARCHED[0] < len(kernel.unknowns) <= MAX_SEARCHED[1]
    return some and not kernel.linear and not any(map(kernel.graph.turn, kernel.unknowns))


def _counts(kernel: BlockKernel) -> Iterator[Method]:
    """Those that count the answers. A polynomial in half an angle has a higher degree than a formula."""
    turning = any(kernel.graph.turn(tear) for tear in kernel.block.tears)
    if not turning and may_be_polynomial(kernel):
        yield Method.POLYNOMIAL
    if kernel.closed is not None:
        yield Method.FORMULA
    if turning and may_be_polynomial(kernel):
        yield Method.POLYNOMIAL


def _searches(kernel: BlockKernel, thorough: bool) -> Iterator[Method]:
    torn_once = len(kernel.block.tears) == 1
    if torn_once:
        yield Method.RANGE
    elif reduced(kernel) is not None:
        yield Method.SUBSTITUTION
    most = MAX_PROOF_UNKNOWNS if thorough else MAX_BOX_UNKNOWNS
    if (thorough or not torn_once) and len(kernel.unknowns) <= most and kernel.finite:
        yield Method.BOXES
    yield Method.STARTS


def may_be_polynomial(kernel: BlockKernel) -> bool:
    """Whether the block may lead to one polynomial in a tear, or in the tangent of half of it."""
    tears, unknowns = kernel.block.tears, frozenset(kernel.unknowns)
    turning = any(kernel.graph.turn(tear) for tear in tears)
    if not 1 <= len(tears) <= 2 or (turning and len(tears) == 2):
        return False
    admitted = _CIRCULAR if turning else frozenset[str]()
    return all(
        node.function in admitted
        for form in kernel.forms
        for node in walk(form)
        if isinstance(node, Call) and not unknowns.isdisjoint(nodes.names(node))
    )


DENSE = 300
"""Unknowns of a linear block beyond which its matrix is first taken as a sparse one."""
MAX_STRETCHES = 6
"""Intervals that a search left open, beyond which it is no use to settle them."""


def solve_block(
    kernel: BlockKernel,
    values: Mapping[str, Value],
    guesses: Mapping[str, float],
    budget: Budget | None = None,
    assumed: bool = False,
    off: Blur = dict,
    given: Collection[str] = (),
) -> BlockOutcome:
    """All answers of the block that can be found at the known ``values``, within the ``budget`` begun for it.

    ``off`` tells how far these may be from what they stand for, by name. ``assumed``: the block belongs to a
    case that may well have no answer, so that last resorts are left out. ``given``: the known names whose
    values are exact.
    """
    if budget is None:
        budget = Budget()
        budget.begin_block()
    question = Question(kernel, values, guesses, budget)
    if question.symbolic:
        block = kernel.block
        return BlockOutcome(complete=True, facts=(NoRoot(block.equations, block.unknowns, True),))
    outcome = _searched(question, budget, assumed, off, given)
    if not outcome.free or assumed or budget.brief or kernel.linear:
        return outcome
    return with_isolated(question, outcome)


def _searched(
    question: Question, budget: Budget, assumed: bool, off: Blur, given: Collection[str]
) -> BlockOutcome:
    kernel, search = question.kernel, _Search(question, budget, off)
    for method in first_methods(kernel, budget.thorough):
        if method is Method.STARTS and (found := _refuted(question, search.candidates, given)) is not None:
            return BlockOutcome(complete=True, facts=(found,))
        outcome = search.methods[method]()
        if method is Method.SPARSE and search.candidates.answers and not budget.thorough:
            if is_large(kernel):
                return search.outcome()
            search.candidates.sensible = None if budget.every else search.candidates.answers[0]
        if outcome is not None:
            if assumed or (outcome.answers and not any(answer.double for answer in outcome.answers)):
                return outcome
            # rounding may have parted what all but meets, and double roots may be points of a curve
            return search.isolated(outcome) if outcome.answers else search.curve() or outcome
        if search.complete:
            break
        if method is Method.RANGE and search.candidates.sensible is not None:
            return search.outcome()
    if search.complete and search.candidates.fruitless:
        why = _refuted(question, search.candidates, given)
        if why is not None:
            return BlockOutcome(complete=True, facts=(why,))
    if not assumed and (curve := search.curve()) is not None:
        return curve
    if search.candidates.fruitless and not (search.complete or assumed) and budget.last_resort():
        fall_back(question, search.candidates)
    return search.outcome() if assumed else search.isolated(search.outcome())


def _refuted(question: Question, candidates: Candidates, given: Collection[str]) -> Fact | None:
    """Why the rules can't hold, whatever the unknowns are; None where that is not known."""
    if candidates.fruitless and (found := contradiction(question)) is not None:
        return found
    return unattained(question, given)


class _Search:
    """What is known of the answers so far; the methods to know more return what settles the block.

    Those that isolate roots are imported when their turn comes: a closed form starts 3 ms sooner without.
    """

    def __init__(self, question: Question, budget: Budget, off: Blur) -> None:
        self.question, self.budget, self.kernel = question, budget, question.kernel
        self.off = off
        self.candidates = Candidates(question)
        self.complete = self.whole = False
        self.stretches: tuple[Stretch, ...] = ()
        self.methods: Mapping[Method, Callable[[], BlockOutcome | None]] = {
            Method.LINEAR: self._linear,
            Method.POLYNOMIAL: self._polynomial,
            Method.FORMULA: self._formula,
            Method.RANGE: self._range,
            Method.SUBSTITUTION: self._substitution,
            Method.BOXES: self._boxes,
            Method.STARTS: self._starts,
            Method.SPARSE: self._sparse,
        }

    def outcome(self) -> BlockOutcome:
        found = _outcome(self.question, self.candidates, self.complete)
        whole = (self.whole or found.whole) and not self.candidates.remote
        return found._replace(stretches=self.stretches, whole=whole)

    def curve(self) -> BlockOutcome | None:
        """Where no answer was found in its range: a curve of answers, if there is one."""
        if self.budget.brief or self.kernel.linear or self.candidates.answers:
            return None

        found = free_curve(self.question)
        attempts = (*self.candidates.attempts, Attempt(Method.CURVE, 1))
        return found and found._replace(attempts=attempts)

    def isolated(self, outcome: BlockOutcome) -> BlockOutcome:
        """The outcome without points of a curve."""
        return outcome if self.budget.brief else without_curves(self.question, outcome)

    def _linear(self) -> BlockOutcome | None:
        if len(self.kernel.unknowns) > DENSE:
            search_sparsely(self.question, self.candidates)
            if self.candidates.answers:
                return self._all(Method.LINEAR)
        linear = solve_linear_block(self.question, self.off)
        if linear is None:
            return None
        attempt = Attempt(Method.LINEAR, len(linear.answers), linear.complete)
        return linear._replace(attempts=(attempt,))

    def _polynomial(self) -> BlockOutcome | None:
        from solver.kernel import polynomial_block as polynomial

        torn_once = len(self.kernel.block.tears) == 1
        method = polynomial.solve_as_polynomial if torn_once else polynomial.solve_by_resultant
        solved = method(self.question, self.candidates)
        return self._all(Method.POLYNOMIAL) if solved else None

    def _formula(self) -> BlockOutcome | None:
        closed = self.kernel.closed
        solved = closed is not None and solve_by_formula(self.question, self.candidates, closed)
        return self._all(Method.FORMULA) if solved else None

    def _sparse(self) -> None:
        search_sparsely(self.question, self.candidates)
        self.candidates.tried(Method.SPARSE)

    def _all(self, method: Method) -> BlockOutcome:
        self.candidates.tried(method, complete=True)
        return _outcome(self.question, self.candidates, complete=True)

    def _range(self) -> BlockOutcome | None:
        return self._over_tear(Method.RANGE, (self.kernel, *self.kernel.others))

    def _substitution(self) -> BlockOutcome | None:
        torn = reduced(self.kernel)
        return None if torn is None else self._over_tear(Method.SUBSTITUTION, (torn,))

    def _over_tear(self, method: Method, kernels: Sequence[BlockKernel]) -> BlockOutcome | None:
        """Search the range of the tear, of one tearing after another until all answers are known."""
        from solver.kernel.polynomial_block import counted
        from solver.kernel.tear_search import TearSearch

        question, candidates = self.question, self.candidates
        every = [TearSearch(question, candidates, kernel, self.budget) for kernel in kernels]
        if (freedom := every[0].freedom()) is not None:
            return freedom
        searches = [search for search in every if search.kernel.exhaustive]
        self.whole = any(search.run() for search in searches)
        if method is Method.RANGE and not self.whole:
            self.whole = not self.budget.brief and counted(question, candidates)
            self.stretches = () if self.whole else _settleable(searches)
        self.complete = self.whole and not candidates.withheld
        candidates.tried(method, self.complete)
        return None if candidates.answers else every[0].flat_stretch()

    def _boxes(self) -> None:
        if self.whole:
            return
        self.complete = search_boxes(self.question, self.candidates, self.budget.thorough)
        self.candidates.tried(Method.BOXES, self.complete)

    def _starts(self) -> None:
        search_from_starts(self.question, self.candidates, self.budget)
        if len(self.kernel.block.tears) > FEW_TEARS:
            search_sparsely(self.question, self.candidates, every=True)
        self.candidates.tried(Method.STARTS)
        torn_once = len(self.kernel.block.tears) == 1
        if torn_once and not self.candidates.answers and not self.kernel.exhaustive:
            from solver.kernel.tear_search import TearSearch

            TearSearch(self.question, self.candidates, self.kernel, self.budget).run()


def _settleable(searches: Sequence[TearSearch]) -> tuple[Stretch, ...]:
    """Where the first search failed to prove that it had found all, if only in a few short stretches."""
    for search in searches:
        if search.stretches and not search.doubts and len(search.stretches) <= MAX_STRETCHES:
            return tuple(search.stretches)
    return ()


def _outcome(question: Question, candidates: Candidates, complete: bool) -> BlockOutcome:
    known = complete and not candidates.withheld
    found = _found(question, candidates, known)
    return found._replace(
        whole=complete and not candidates.remote,
        attempts=tuple(candidates.attempts),
        suspects=tuple(candidates.suspects),
        refused=tuple(candidates.refused),
        remote=candidates.remote,
    )


def _found(question: Question, candidates: Candidates, complete: bool) -> BlockOutcome:
    block = question.kernel.block
    alone = candidates.crowded or len(block.tears) == 1
    if candidates.sensible is not None and alone and not complete:
        question.budget.cut = question.budget.cut or len(candidates.answers) > 1
        return BlockOutcome((candidates.sensible,))
    answers = sorted(candidates.answers, key=lambda answer: question.preference(answer.values))
    if answers:
        cut = len(answers) >= MOST_ANSWERS
        return BlockOutcome(tuple(answers), complete and not cut, cut=cut)
    if candidates.outside is not None:
        return BlockOutcome(complete=complete, facts=(candidates.outside,))
    best = candidates.nearest
    misses = tuple(question.residual(list(best.values()))) if best else ()
    fact = NoRoot(block.equations, block.unknowns, complete, best, misses)
    return BlockOutcome(complete=complete, facts=(fact,))
