"""A block that its tearing turns into polynomials in one tear or two: every answer, by an exact
count of roots.

The known numbers are the exact fractions of their floats, and the steps are polynomials in the tear
with such coefficients. Nothing is compiled, and nothing is rounded before the roots.

``counted``: whether the answers of a block with one tear, found otherwise, are all, because every
root of its eliminant is accounted for.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TypeAlias

from rulesheets.deadline import expect_time
from rulesheets.evaluate import Undefined, value
from rulesheets.evaluate.exact import as_written
from rulesheets.syntax.nodes import Expression, terms
from solver.kernel.candidates import Candidates
from solver.kernel.problem import BlockProblem, InputErrors
from solver.kernel.quotients import (
    NOT_RATIONAL,
    Coefficients,
    Eliminant,
    Exact,
    Quotients,
    dense,
    eliminants,
)
from solver.kernel.root_check import is_clearly_violated
from solver.numerics.linear_algebra import are_alike
from solver.numerics.one_unknown import real_roots, simple_part
from solver.numerics.tolerances import (
    BACKWARD,
    BESIDE_HOLE,
    POLISHED,
    ROUGHLY,
    SAFETY,
    SAME_VALUE,
    SMALL,
    TOUCHING,
)
from solver.path.polynomial import UNIT, Polynomial

Forms: TypeAlias = Sequence[tuple[str, Expression]]

MAX_RADICALS = 3
"""Radicals that are eliminated, where a search has left something open."""

FLAT = Fraction(1, 1000)
"""Share of the terms of a slope, x p'(x), that is left where more roots are near x than one."""


HIGHEST_OF_TWO, HIGHEST_RESULTANT = 6, 15
"""Degree of two residuals in each tear, and of their resultants."""


def solve_polynomials(problem: BlockProblem, candidates: Candidates, off: InputErrors) -> bool:
    """Find the answers; False if the block leads to no such polynomials, or rounding leaves an
    answer in doubt. ``off``: the errors of the known numbers."""
    forms = _explicit_forms(problem)
    if forms is None:
        return False
    steps = _Steps(problem, forms, candidates, off)
    return steps.solve_one() if len(problem.kernel.block.tears) == 1 else steps.solve_two()


def counted(problem: BlockProblem, candidates: Candidates, off: InputErrors) -> bool:
    """Whether the answers are known to be all; a missing one is added to them.

    Only for algebraic blocks, whose eliminant has no root that rounding might have split or hidden.
    """
    block = problem.kernel.block
    if len(block.tears) != 1 or problem.turn(block.tears[0]) is not None or candidates.unresolved:
        return False
    forms = _explicit_forms(problem)
    return forms is not None and _Steps(problem, forms, candidates, off).are_all()


def _explicit_forms(problem: BlockProblem) -> Forms | None:
    """The steps of the block as explicit forms; None if one has several or may have none."""
    graph, found = problem.graph, []
    for step in problem.kernel.block.order:
        isolation = graph.isolation(step.equation, graph.number[step.unknown])
        if isolation is None or isolation.branches != 1 or isolation.verify or isolation.period:
            return None
        found.append((step.unknown, isolation.forms()[0]))
    return found


class _Steps:
    """A block whose unknowns follow from its tears by explicit ``forms``."""

    def __init__(
        self, problem: BlockProblem, forms: Forms, candidates: Candidates, off: InputErrors
    ) -> None:
        self.problem, self.forms, self.candidates, self.off = problem, forms, candidates, off
        self.known = dict(zip(problem.kernel.known, problem.known, strict=True))
        block = problem.kernel.block
        self.tears, self.tear = block.tears, block.tears[0]
        self.rules = [problem.graph.model.equations[number] for number in block.residuals]

    # --- one polynomial in one tear ---

    def solve_one(self) -> bool:
        """Multiple roots are those of the exact numbers; or of the decimals as written: (x - 1.6)^3
        expanded has a triple root, which rounding splits."""
        problem, domain = self.problem, self.problem.domain(self.tear)
        # of a range with what rounding may lead beyond its ends
        slack = BACKWARD * max([abs(end) for end in domain if math.isfinite(end)], default=0.0)
        within = domain[0] - slack, domain[1] + slack
        simple, several = self._simple(Fraction)
        roots = _clear_roots(simple, *within)
        if simple and not several and (roots is None or _has_neighbours(simple, roots)):
            written, several = self._simple(as_written)
            roots = _clear_roots(written, *within) if several else roots
        if not simple or roots is None:
            return False
        trial = Candidates(problem)
        for root in roots:
            if self._is_rounded_pole(root):
                continue
            point = self._point_at(root)
            if point is None:
                return False
            if several and problem.holds(point):
                trial.keep(point, singular=True, counted=True)
            elif not (is_clearly_violated(problem, point) if several else trial.settles(point)):
                return False
        self.candidates.take(trial)
        return True

    def are_all(self) -> bool:
        """Whether every root of the eliminants is accounted for."""
        found = self._eliminants(Fraction, MAX_RADICALS)
        for one in found:
            roots = _clear_roots(simple_part(one.polynomial), *self.problem.domain(self.tear))
            if roots is None or not self._excludes_holes(one):
                return False
            within = (root for root in roots if _is_within(one.positive, root))
            if not all(map(self._is_accounted_for, within)):
                return False
        return bool(found)

    def _eliminants(
        self, exact: Exact, radicals: int = 0, moved: Mapping[str, float] | None = None
    ) -> list[Eliminant]:
        known = {**self.known, **(moved or {})}
        return eliminants(self.rules[0], self.tear, self.forms, known, exact, radicals)

    def _simple(self, exact: Exact) -> tuple[Coefficients, bool]:
        """The polynomial in the tear with each of its roots once, and whether some are multiple;
        empty if there is none. By the decimals as written if a coefficient is no more than the
        rounding of its terms: the last digit of 0.2 must not lead to a root of 1e20."""
        match self._eliminants(exact):
            case [Eliminant(polynomial, clear=True) as one] if self._excludes_holes(one):
                simple = simple_part(polynomial)
                return simple, len(simple) < len(polynomial)
            case [Eliminant(clear=False)] if exact is not as_written:
                return self._simple(as_written)
        return [], False

    def _excludes_holes(self, one: Eliminant) -> bool:
        """Whether there is no answer at any point at which a form is 0/0: its unknown is free
        there, unless a rule as written divides by 0."""
        holes = [real_roots(simple_part(factor)) for factor in one.indeterminate]
        return None not in holes and not any(
            _is_within(one.positive, x) and self._may_hold(factor, x)
            for factor, some in zip(one.indeterminate, holes, strict=True)
            for x in some or ()
        )

    def _may_hold(self, factor: Coefficients, hole: float) -> bool:
        """Whether the residual may be 0 at a root of a factor, for some values of free unknowns."""
        if sum(_terms(factor, hole)):
            return True  # it is known to rounding only
        there = Quotients((), {**self.known, self.tear: hole})
        there.follow(self.forms, free=True)
        try:
            if not all(there.of(divisor).top for divisor in self.problem.kernel.divisors):
                return self._holds_beside(hole)
            miss = there.of(self.rules[0].left - self.rules[0].right)
        except NOT_RATIONAL:
            return True
        left, gross = (parts.get(UNIT, Fraction(0)) for parts in (miss.top, miss.gross))
        return bool(miss.top.generators) or abs(left) <= TOUCHING * gross

    def _holds_beside(self, hole: float) -> bool:
        """Whether rules nearly hold on a side of a point at which one has no value."""
        reach, nearly = BESIDE_HOLE * (abs(hole) or 1.0), Candidates(self.problem).nearly
        beside = (self._point_at(at) for at in (hole - reach, hole + reach))
        return any(point is not None and nearly(point, ROUGHLY) for point in beside)

    def _point_at(self, *tears: float) -> dict[str, float] | None:
        """The unknowns at these values of the tears; None if a step has none there."""
        point = dict(zip(self.tears, tears, strict=True))
        try:
            for name, form in self.forms:
                point[name] = value(form, {**self.problem.here, **point})
        except Undefined:
            return None
        return {name: point[name] for name in self.problem.unknowns}

    def _is_rounded_pole(self, root: float) -> bool:
        """Whether a rule divides by 0 at a root, which only the last places of known numbers move
        off there, and rules hold on neither side."""
        if not self._is_pole(root, BESIDE_HOLE) or self._holds_beside(root):
            return False
        errors, found = self.off(), self._eliminants(Fraction, MAX_RADICALS)
        shares = [_share(one.polynomial, root) for one in found]
        slopes = [_share(one.polynomial, root * (1.0 + BESIDE_HOLE)) for one in found]
        moves = [Fraction(0)] * len(found)
        for name in self.known.keys() & errors.keys():
            moved = {name: self.known[name] + errors[name]}
            others = self._eliminants(Fraction, MAX_RADICALS, moved)
            if len(others) != len(found):
                return False
            for place, one in enumerate(others):
                moves[place] += Fraction(SAFETY) * abs(_share(one.polynomial, root) - shares[place])
        reach = max(move / (abs(slope) or 1) for move, slope in zip(moves, slopes, strict=True))
        explained = all(abs(share) <= move for share, move in zip(shares, moves, strict=True))
        return explained and self._is_pole(root, BACKWARD + BESIDE_HOLE * float(reach))

    def _is_pole(self, root: float, reach: float) -> bool:
        """Whether a rule divides by 0 within ``reach``, a share of a root, or has no value
        there."""
        at, beside = map(self._point_at, (root, root * (1.0 + BESIDE_HOLE)))
        if at is None:
            return True
        points = [{**self.problem.here, **one} for one in (at, beside or at)]
        for divisor in self.problem.kernel.divisors:
            here, there = (value(divisor, point) for point in points)
            size = sum(abs(value(term, points[0])) for term in terms(divisor))
            if abs(here) <= max(BACKWARD * size, reach * abs(there - here) / BESIDE_HOLE):
                return True
        return False

    def _is_listed(self, root: float) -> bool:
        listed = (answer.values[self.tear] for answer in self.candidates.answers)
        return any(abs(x - root) <= SAME_VALUE * abs(root) for x in listed)

    def _is_accounted_for(self, root: float) -> bool:
        """Whether a root is one of the answers, or becomes one, or clearly is none."""
        if self._is_listed(root):
            return True
        # beside it no pole nor the end of a domain hides the unknowns
        problem, reach = self.problem, SAME_VALUE * (abs(root) or 1.0)
        points = map(self._point_at, (root, root - reach, root + reach))
        there = [point for point in points if point is not None]
        values = [list(point.values()) for point in there]
        if all(is_clearly_violated(problem, point) for point in there):
            # a change of sign between them: at a root between two floats, or at a pole
            place = problem.equations.index(self.rules[0].index)
            return len({problem.residual(one)[place] > 0.0 for one in values}) < 2
        for one in values:
            self.candidates.refine(one)
        return self._is_listed(root) or self._is_rounded_pole(root)

    # --- two polynomials in two tears ---
    #
    # Where two polynomials p and q of x and y have a common root, their resultant by y, a
    # polynomial of x, is 0, and so is that by x, a polynomial of y (D. Cox, J. Little, D. O'Shea,
    # *Ideals, Varieties, and Algorithms*, section 3.6): the real roots of both are counted, and
    # tried in pairs. Of p and q with a common factor, a curve, one of the two is 0 everywhere.
    # Where a divisor is 0 too, there is no answer: factors that p or q has in common with one are
    # left out.

    def solve_two(self) -> bool:
        """Find the answers among the pairs of roots."""
        tears = self.tears
        try:
            quotients = Quotients(tears, self.known)
            quotients.follow(self.forms)
            if quotients.common:
                return False  # where a step is 0/0 its unknown is free
            p, q = (quotients.of(rule.left - rule.right).top for rule in self.rules)
        except NOT_RATIONAL:
            return False
        if not (p and q):
            return False
        from rulesheets.algebra import resultant, without_factors  # brings sympy

        for pole in quotients.poles:
            p, q = (Polynomial(without_factors(f, dict(pole))) for f in (p, q))
        if not all(0 < max(f.degree(tear) for f in (p, q)) <= HIGHEST_OF_TWO for tear in tears):
            return False
        roots = []
        for eliminated in tears[::-1]:
            whole = dense(Polynomial(resultant(p, q, eliminated)))
            counted = 0 < len(whole) <= HIGHEST_RESULTANT + 1
            found = _clear_roots(simple_part(whole)) if counted else None
            if found is None:
                return False
            roots.append(found)
        trial, undefined = Candidates(self.problem), False
        for pair in itertools.product(*roots):
            expect_time()
            at = dict(zip(tears, pair, strict=True))
            if _misses(p, at) or _misses(q, at):
                continue
            exact = not (sum(_terms_at(p, at)) or sum(_terms_at(q, at)))
            if exact and not all(sum(_terms_at(Polynomial(pole), at)) for pole in quotients.poles):
                undefined = True
            elif not self._refined(trial, pair):
                return False
        if undefined and trial.is_empty:
            return False
        self.candidates.take(trial)
        return True

    def _refined(self, trial: Candidates, tears: Sequence[float]) -> bool:
        """Whether the point with these tears is next to an answer, which is kept, or to one out of
        range."""
        point = self._point_at(*tears)
        if point is None:
            return False
        outside = trial.outside
        trial.refine(list(point.values()))
        sizes = self.problem.sizes_at(list(point.values()), SMALL)
        near = (
            are_alike(point.values(), map(one.values.get, point), POLISHED, sizes)
            for one in trial.answers
        )
        return trial.outside is not outside or any(near)


# --- the roots of polynomials ---


def _cancels(terms: Sequence[Fraction], share: Fraction) -> bool:
    """Whether the sum is at most so large a share of its terms."""
    return abs(sum(terms, Fraction(0))) <= share * sum(map(abs, terms), Fraction(0))


def _terms(coefficients: Coefficients, x: float) -> list[Fraction]:
    """The terms of a polynomial at a point."""
    return [c * Fraction(x) ** k for k, c in enumerate(coefficients)]


def _has_neighbours(simple: Coefficients, roots: Sequence[float]) -> bool:
    """Whether a polynomial is so flat at one of these roots that others, real or not, must be
    near."""
    slope = [k * c for k, c in enumerate(simple)]
    return any(_cancels(_terms(slope, x), FLAT) for x in roots)


def _clear_roots(
    simple: Coefficients, low: float = -math.inf, high: float = math.inf
) -> tuple[float, ...] | None:
    """The real roots in a range of a polynomial without multiple roots; None if they are unknown,
    or an extremum may be a double root but for the rounding of the inputs."""
    roots = real_roots(simple, low, high)
    slope = [k * c for k, c in enumerate(simple)][1:]
    extrema = real_roots(simple_part(slope)) if len(simple) > 2 else ()
    if extrema is None:
        return None
    return None if any(_cancels(_terms(simple, x), TOUCHING) for x in extrema) else roots


def _share(polynomial: Coefficients, root: float) -> Fraction:
    """The value of a polynomial at a point, as a share of its terms."""
    some = _terms(polynomial, root)
    return sum(some, Fraction(0)) / (sum(map(abs, some)) or 1)


def _is_within(positive: Sequence[Coefficients], root: float) -> bool:
    """Whether no polynomial is clearly negative at a root."""
    terms = [_terms(polynomial, root) for polynomial in positive]
    return all(sum(some) >= 0 or _cancels(some, TOUCHING) for some in terms)


def _terms_at(polynomial: Polynomial, at: Mapping[str, float]) -> list[Fraction]:
    return [
        c * math.prod(Fraction(at[name]) ** exponent for name, exponent in monomial)
        for monomial, c in polynomial.items()
    ]


def _misses(polynomial: Polynomial, at: Mapping[str, float]) -> bool:
    """Whether a polynomial is not 0 anywhere near a point, by more than the rounding of the
    inputs."""
    return not _cancels(_terms_at(polynomial, at), 2 * TOUCHING * HIGHEST_OF_TWO)
