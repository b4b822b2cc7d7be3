"""A simultaneous block at given numbers: every answer that can be found, and whether that is all.

The methods of ``first_methods`` are tried one after another until the answers are known to be all; where they
found nothing, trust regions are. Damped Newton keeps the direction of a step and shortens it; in a trust
region it turns downhill as it is shortened (M. J. D. Powell, 1970; K. Levenberg, 1944, and D. Marquardt,
1963), which gets round where the Jacobian is nearly singular.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence

from rulesheets.functions import named
from rulesheets.model import Value
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Call
from rulesheets.syntax.program import walk
from solver.facts import Attempt, Method, NoRoot
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
    n, tears = len(kernel.unknowns), kernel.block.tears
    if kernel.linear:
        yield Method.LINEAR
    elif is_large(kernel):
        yield Method.SPARSE
    # Those that count the answers. A polynomial in half an angle has a higher degree than a formula.
    turning = any(map(kernel.graph.turn, tears))
    if not turning and may_be_polynomial(kernel):
        yield Method.POLYNOMIAL
    if kernel.closed is not None:
        yield Method.FORMULA
    if turning and may_be_polynomial(kernel):
        yield Method.POLYNOMIAL
    # A block of some size without angles may be a network, most of whose answers nobody asks about, or the
    # speeds of a mechanism, whose few answers all count.
    some = MAX_SEARCHED[0] < n <= MAX_SEARCHED[1]
    if some and not kernel.linear and not any(map(kernel.graph.turn, kernel.unknowns)):
        yield Method.SPARSE
    if len(tears) == 1:
        yield Method.RANGE
    elif reduced(kernel) is not None:
        yield Method.SUBSTITUTION
    most = MAX_PROOF_UNKNOWNS if thorough else MAX_BOX_UNKNOWNS
    if (thorough or len(tears) > 1) and n <= most and kernel.finite:
        yield Method.BOXES
    yield Method.STARTS


def is_large(kernel: BlockKernel) -> bool:
    """Whether one answer is looked for before any others. (Several assemblies of a mechanism are of interest,
    and it has angles; but phasors, angles beside magnitudes, have one answer that is sensible.)"""
    n, tears = len(kernel.unknowns), len(kernel.block.tears)
    turning = sum(kernel.graph.turn(name) is not None for name in kernel.unknowns)
    if n <= MAX_SEARCHED[0]:
        return n > MAX_BOX_UNKNOWNS and tears > MANY_TEARS and 0 < turning < n
    return n > MAX_SEARCHED[1] or (turning > 0 and (tears > FEW_TEARS or not kernel.exhaustive))


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
    search = _Search(question, budget, off)
    candidates = search.candidates

    def refuted() -> BlockOutcome | None:
        """Why the rules can't hold, whatever the unknowns are; None where that is not known."""
        conflict = contradiction(question) if candidates.fruitless else None
        why = conflict or unattained(question, given)
        return None if why is None else BlockOutcome(complete=True, facts=(why,))

    for method in first_methods(question.kernel, budget.thorough):
        if method is Method.STARTS and (found := refuted()) is not None:
            return found
        outcome = search.tried(method)
        if method is Method.SPARSE and candidates.answers and not budget.thorough:
            if is_large(question.kernel):
                return search.outcome()
            candidates.sensible = None if budget.every else candidates.answers[0]
        if outcome is not None:
            if assumed or (outcome.answers and not any(answer.double for answer in outcome.answers)):
                return outcome
            return search.without_curves(outcome)
        if search.complete:
            break
        if method is Method.RANGE and candidates.sensible is not None:
            return search.outcome()
    if search.complete and candidates.fruitless and (found := refuted()) is not None:
        return found
    if not assumed and (curve := search.curve()) is not None:
        return curve
    if candidates.fruitless and not (search.complete or assumed) and budget.last_resort():
        fall_back(question, candidates)
    outcome = search.outcome()
    return outcome if assumed or budget.brief else without_curves(question, outcome)


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

    def tried(self, method: Method) -> BlockOutcome | None:
        """What a method says that settles the block; else it has added to what is known."""
        question, candidates, kernel = self.question, self.candidates, self.kernel
        torn_once, solved = len(kernel.block.tears) == 1, False
        match method:
            case Method.LINEAR:
                return self._linear()
            case Method.POLYNOMIAL:
                from solver.kernel import polynomial_block as polynomial

                polynomials = polynomial.solve_as_polynomial if torn_once else polynomial.solve_by_resultant
                solved = polynomials(question, candidates)
            case Method.FORMULA:
                closed = kernel.closed
                solved = closed is not None and solve_by_formula(question, candidates, closed)
            case Method.RANGE:
                return self._over_tear(method, (kernel, *kernel.others))
            case Method.SUBSTITUTION if (torn := reduced(kernel)) is not None:
                return self._over_tear(method, (torn,))
            case Method.BOXES if not self.whole:
                self.complete = search_boxes(question, candidates, self.budget.thorough)
                candidates.tried(method, self.complete)
            case Method.SPARSE:
                search_sparsely(question, candidates)
                candidates.tried(method)
            case Method.STARTS:
                self._starts()
        return self._all(method) if solved else None

    def outcome(self) -> BlockOutcome:
        question, candidates = self.question, self.candidates
        return _found(question, candidates, self.complete and not candidates.withheld)._replace(
            whole=(self.whole or self.complete) and not candidates.remote,
            stretches=self.stretches,
            attempts=tuple(candidates.attempts),
            suspects=tuple(candidates.suspects),
            refused=tuple(candidates.refused),
            remote=candidates.remote,
        )

    def curve(self) -> BlockOutcome | None:
        """Where no answer was found in its range: a curve of answers, if there is one."""
        if self.budget.brief or self.kernel.linear or self.candidates.answers:
            return None
        found = free_curve(self.question)
        attempts = (*self.candidates.attempts, Attempt(Method.CURVE, 1))
        return found and found._replace(attempts=attempts)

    def without_curves(self, outcome: BlockOutcome) -> BlockOutcome:
        """The outcome; a curve of answers instead where it has none, for rounding may have parted what all
        but meets, or where its answers are no more than points of one.
        """
        if not outcome.answers:
            return self.curve() or outcome
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

    def _all(self, method: Method) -> BlockOutcome:
        self.candidates.tried(method, complete=True)
        self.complete = True
        return self.outcome()

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
            few = (s for s in searches if 0 < len(s.stretches) <= MAX_STRETCHES and not s.doubts)
            settleable = next(few, None)  # it failed to prove that it has all in a few short stretches alone
            self.stretches = () if self.whole or settleable is None else tuple(settleable.stretches)
        self.complete = self.whole and not candidates.withheld
        candidates.tried(method, self.complete)
        return None if candidates.answers else every[0].flat_stretch()

    def _starts(self) -> None:
        search_from_starts(self.question, self.candidates, self.budget)
        if len(self.kernel.block.tears) > FEW_TEARS:
            search_sparsely(self.question, self.candidates, every=True)
        self.candidates.tried(Method.STARTS)
        torn_once = len(self.kernel.block.tears) == 1
        if torn_once and not self.candidates.answers and not self.kernel.exhaustive:
            from solver.kernel.tear_search import TearSearch

            TearSearch(self.question, self.candidates, self.kernel, self.budget).run()


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
