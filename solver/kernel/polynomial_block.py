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
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import reduce
from operator import or_
from typing import NamedTuple, TypeAlias

from rulesheets.deadline import expect_time
from rulesheets.evaluate import Undefined, value
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import (
    Call,
    Expression,
    Name,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    walk,
)
from solver.kernel.candidates import Candidates
from solver.kernel.problem import BlockProblem
from solver.kernel.root_check import is_clearly_violated
from solver.numerics.linear_algebra import are_alike
from solver.numerics.one_unknown import have_common_root, real_roots, simple_part, without_roots
from solver.numerics.tolerances import BACKWARD, POLISHED, SAME_VALUE, SMALL, TOUCHING
from solver.path.isolate import smooth
from solver.path.polynomial import UNIT, Monomial, NoForm, Polynomial, constant, generator

HIGHEST_DEGREE = 12
ALGEBRAIC = frozenset({"sqrt", "abs", "min", "max", "pi"})
"""Functions that an eliminant admits."""

Coefficients: TypeAlias = Sequence[Fraction]
"""Of a polynomial in one tear, lowest degree first."""
Forms: TypeAlias = Sequence[tuple[str, Expression]]

Divisor: TypeAlias = tuple[tuple[Monomial, Fraction], ...]
"""The sorted terms of a polynomial of which the last coefficient is 1."""


class Ratio(NamedTuple):
    """A polynomial, what it would be if nothing cancelled in it, and its divisors with their
    exponents."""

    top: Polynomial
    gross: Polynomial
    divisors: Counter[Divisor]


Exact: TypeAlias = Callable[[float], Fraction]
"""The exact value of a float: its binary fraction, or the decimal as written."""

FLAT = Fraction(1, 1000)
"""Share of the terms of a slope, x p'(x), that is left where more roots are near x than one."""


class NotPolynomial(Exception):
    """The form is not a polynomial of low degree, or its coefficients are not exact."""


class _Steps:
    """The steps of a block as polynomials of its tears."""

    def __init__(self, problem: BlockProblem, forms: Forms, exact: Exact) -> None:
        self.exact = exact
        self.known = dict(zip(problem.kernel.known, problem.known, strict=True))
        self.values = {
            n: self._number(v) for n, v in zip(problem.kernel.known, problem.known, strict=True)
        }
        tears = problem.kernel.block.tears
        self.values |= {tear: _plain(generator(tear)) for tear in tears}
        self.torn_once = len(tears) == 1
        self.poles = dict[Divisor, None]()
        """Where they are 0, a step or a rule has no value."""
        for name, form in forms:
            expect_time()
            self.values[name] = self._value(form)

    def residuals(self, problem: BlockProblem) -> list[Ratio]:
        """The residuals. Raises NotPolynomial."""
        equations = (
            problem.graph.model.equations[number] for number in problem.kernel.block.residuals
        )
        return [self._value(smooth(*equation.sides)) for equation in equations]

    def _value(self, node: Expression) -> Ratio:
        match node:
            case Number(number):
                return self._number(number)
            case Name(name) if name in self.values:
                return self.values[name]
            case Negative(operand):
                return _scaled(self._value(operand), Fraction(-1))
            case Sum(terms):
                return self._sum([self._value(term) for term in terms])
            case Product(left, right):
                return self._times(self._value(left), self._value(right))
            case Quotient(left, right):
                return self._quotient(self._value(left), self._value(right))
            case Power(base, Number(exponent)) if exponent in range(1, HIGHEST_DEGREE + 1):
                return reduce(self._times, [self._value(base)] * int(exponent))
            case Power(base, Number(exponent)) if -exponent in range(1, HIGHEST_DEGREE + 1):
                divisors = [self._value(base)] * int(-exponent)
                return reduce(self._quotient, divisors, self._number(1.0))
            case Call() | Power():
                return self._evaluated(node)
            case _:
                raise NotPolynomial

    def _evaluated(self, node: Expression) -> Ratio:
        """A function of known numbers, rounded as one of them is."""
        try:
            return self._number(value(node, self.known))
        except (KeyError, Undefined):
            raise NotPolynomial from None

    def _sum(self, parts: Sequence[Ratio]) -> Ratio:
        """Over the least common divisors."""
        common = reduce(or_, (part.divisors for part in parts))
        tops, gross = Polynomial(), Polynomial()
        for part in parts:
            for factor in (common - part.divisors).elements():
                part = self._times(part, _plain(Polynomial(factor)))
            tops, gross = tops + part.top, gross + part.gross
        return Ratio(tops, gross, common)

    def _times(self, a: Ratio, b: Ratio) -> Ratio:
        expect_time()
        if self._degree(a.top) + self._degree(b.top) > HIGHEST_DEGREE:
            raise NotPolynomial
        return Ratio(a.top * b.top, a.gross * b.gross, a.divisors + b.divisors)

    def _quotient(self, a: Ratio, b: Ratio) -> Ratio:
        """Raises NotPolynomial where it may be 0/0, and for a divisor with more than one tear."""
        for factor in b.divisors.elements():
            a = self._times(a, _plain(Polynomial(factor)))
        *terms, (lead, by) = sorted(b.top.items()) or [(UNIT, Fraction(0))]
        if abs(by) <= TOUCHING * b.gross.get(lead, 0):
            raise NotPolynomial
        divided = _scaled(a, 1 / by)
        if not b.gross.generators:
            return divided
        if not self.torn_once or have_common_root(_dense(a.top), _dense(b.top)):
            raise NotPolynomial
        factor = *((monomial, c / by) for monomial, c in terms), (lead, Fraction(1))
        self.poles[factor] = None
        return divided._replace(divisors=a.divisors + Counter([factor]))

    def _degree(self, polynomial: Polynomial) -> int:
        """The highest degree in one of its tears."""
        return max((exponent for monomial in polynomial for _, exponent in monomial), default=0)

    def _number(self, number: float) -> Ratio:
        if not math.isfinite(number):
            raise NotPolynomial
        return _plain(constant(self.exact(number)))


def _scaled(ratio: Ratio, factor: Fraction) -> Ratio:
    return ratio._replace(top=ratio.top * factor, gross=ratio.gross * abs(factor))


def _plain(polynomial: Polynomial) -> Ratio:
    gross = Polynomial({monomial: abs(c) for monomial, c in polynomial.items()})
    return Ratio(polynomial, gross, Counter())


def _dense(polynomial: Polynomial) -> list[Fraction]:
    by_degree = {sum(exponent for _, exponent in monomial): c for monomial, c in polynomial.items()}
    return [by_degree.get(k, Fraction(0)) for k in range(max(by_degree, default=-1) + 1)]


class _OnePolynomial(NamedTuple):
    """A block as a polynomial in its tear: ``simple`` has each of its roots once, ``several`` tells
    whether some are multiple."""

    forms: Forms
    simple: Coefficients
    several: bool

    def has_neighbours(self, roots: Sequence[float]) -> bool:
        """Whether it is so flat at one of these roots that others, real or not, must be near."""
        return any(
            _cancels([k * c * x**k for k, c in enumerate(self.simple)], FLAT)
            for x in map(Fraction, roots)
        )


def _cancels(terms: Sequence[Fraction], share: Fraction) -> bool:
    """Whether the sum is at most so large a share of its terms."""
    return abs(sum(terms, Fraction(0))) <= share * sum(map(abs, terms), Fraction(0))


def _one_polynomial(problem: BlockProblem, exact: Exact = Fraction) -> _OnePolynomial | None:
    followed = _followed(problem, exact)
    if followed is None:
        return None
    forms, ((whole, gross, _),), poles = followed
    doubtful = (abs(c) <= TOUCHING * gross.get(monomial, 0) for monomial, c in whole.items())
    if not whole or any(doubtful):
        return None
    polynomial = _dense(whole)
    for pole in poles:
        polynomial = without_roots(polynomial, _dense(pole))
    simple = simple_part(polynomial)
    return _OnePolynomial(forms, simple, len(simple) < len(polynomial))


def solve_as_polynomial(problem: BlockProblem, candidates: Candidates) -> bool:
    """Find the answers; False if the block is not such a polynomial, or rounding leaves one in
    doubt.

    Multiple roots are those of the exact numbers; or of the decimals as written: (x - 1.6)^3
    expanded has a triple root, which rounding splits.
    """
    (tear,) = problem.kernel.block.tears
    domain = problem.domain(tear)
    # of a range with what rounding may lead beyond its ends
    slack = BACKWARD * max([abs(end) for end in domain if math.isfinite(end)], default=0.0)
    within = domain[0] - slack, domain[1] + slack
    found = _one_polynomial(problem)
    roots = found and _clear_roots(found.simple, *within)
    if found and not found.several and (roots is None or found.has_neighbours(roots)):
        written = _one_polynomial(problem, lambda number: Fraction(repr(number)))
        if written and written.several:
            found, roots = written, _clear_roots(written.simple, *within)
    if found is None or roots is None:
        return False
    trial = Candidates(problem)
    for root in roots:
        point = _point_at(problem, found.forms, {tear: root})
        if point is None:
            return False
        if found.several and problem.holds(point):
            trial.keep(point, singular=True, counted=True)
        elif not (is_clearly_violated(problem, point) if found.several else trial.settles(point)):
            return False
    candidates.take(trial)
    return True


def _followed(
    problem: BlockProblem, exact: Exact = Fraction
) -> tuple[Forms, list[Ratio], list[Polynomial]] | None:
    """The explicit forms of the steps, the residuals, and polynomials that are not 0; None if the
    residuals are not quotients of polynomials."""
    forms = _explicit_forms(problem)
    if forms is None:
        return None
    try:
        steps = _Steps(problem, forms, exact)
        return forms, steps.residuals(problem), list(map(Polynomial, steps.poles))
    except (NotPolynomial, NoForm, OverflowError):
        return None


def _explicit_forms(problem: BlockProblem) -> Forms | None:
    """The steps of the block as explicit forms; None if one has several or may have none."""
    graph, found = problem.graph, []
    for step in problem.kernel.block.order:
        isolation = graph.isolation(step.equation, graph.number[step.unknown])
        if isolation is None or isolation.branches != 1 or isolation.verify or isolation.period:
            return None
        found.append((step.unknown, isolation.forms()[0]))
    return found


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
    touches = (
        _cancels([c * x**k for k, c in enumerate(simple)], TOUCHING) for x in map(Fraction, extrema)
    )
    return None if any(touches) else roots


def _point_at(
    problem: BlockProblem, forms: Forms, tears: Mapping[str, float]
) -> dict[str, float] | None:
    """The unknowns at these values of the tears; None if a step has none there."""
    point = dict(tears)
    try:
        for name, form in forms:
            point[name] = value(form, {**problem.here, **point})
    except Undefined:
        return None
    return {name: point[name] for name in problem.unknowns}


def counted(problem: BlockProblem, candidates: Candidates) -> bool:
    """Whether the answers are known to be all; a missing one is added to them.

    Only for algebraic blocks, whose eliminant has no root that rounding might have split or hidden.
    """
    block = problem.kernel.block
    if len(block.tears) != 1 or problem.turn(block.tears[0]) is not None or candidates.unresolved:
        return False
    forms = _explicit_forms(problem)
    if forms is None or not problem.kernel.once("algebraic", lambda: _is_algebraic(problem)):
        return False
    # sympy waits until a search has left something open
    from rulesheets.algebra import eliminants

    equation = problem.graph.model.equations[block.residuals[0]]
    known = {name: value for name, value in problem.here.items() if isinstance(value, float)}
    found = eliminants(equation.left, equation.right, block.tears[0], forms, known)
    if found is None:
        return False
    domain = problem.domain(block.tears[0])
    for one in found:
        roots = _clear_roots(simple_part(one.polynomial), *domain) if one.polynomial else ()
        holes = [real_roots(simple_part(factor)) for factor in one.indeterminate]
        if roots is None or None in holes:
            return False
        if any(_is_within(one.positive, x) for some in holes for x in some or ()):
            return False  # where a form is 0/0 its unknown is free
        within = (root for root in roots if _is_within(one.positive, root))
        if not all(_is_accounted_for(problem, candidates, forms, root) for root in within):
            return False
    return True


def _is_within(positive: Sequence[Coefficients], root: float) -> bool:
    """Whether no polynomial is clearly negative at a root."""
    exact = Fraction(root)
    terms = ([c * exact**k for k, c in enumerate(polynomial)] for polynomial in positive)
    return all(sum(some) >= 0 or _cancels(some, TOUCHING) for some in terms)


def _is_algebraic(problem: BlockProblem) -> bool:
    """Whether no function or exponent of an unknown prevents an eliminant."""
    unknowns = frozenset(problem.unknowns)
    for node in (part for form in problem.kernel.forms for part in walk(form)):
        match node:
            case Call(function) if function not in ALGEBRAIC and not unknowns.isdisjoint(
                nodes.names(node)
            ):
                return False
            case Power(_, exponent) if not unknowns.isdisjoint(nodes.names(exponent)):
                return False
    return True


def _is_accounted_for(
    problem: BlockProblem, candidates: Candidates, forms: Forms, root: float
) -> bool:
    """Whether a root is one of the answers, or becomes one, or clearly is none."""
    block = problem.kernel.block
    tear, place = block.tears[0], problem.equations.index(block.residuals[0])

    def is_listed() -> bool:
        return any(
            abs(answer.values[tear] - root) <= SAME_VALUE * abs(root)
            for answer in candidates.answers
        )

    if is_listed():
        return True
    # beside it no pole nor the end of a domain hides the unknowns
    reach = SAME_VALUE * (abs(root) or 1.0)
    points = [_point_at(problem, forms, {tear: at}) for at in (root, root - reach, root + reach)]
    if all(point is None or is_clearly_violated(problem, point) for point in points):
        # a change of sign between them: at a root between two floats, or at a pole
        signs = {
            problem.residual(list(point.values()))[place] > 0.0
            for point in points
            if point is not None
        }
        return len(signs) < 2
    for point in points:
        if point is not None:
            candidates.refine(list(point.values()))
    return is_listed()


# --- two polynomials in two tears ---
#
# Where two polynomials p and q of x and y have a common root, their resultant by y, a polynomial of
# x, is 0, and so is that by x, a polynomial of y (D. Cox, J. Little, D. O'Shea, *Ideals, Varieties,
# and Algorithms*, section 3.6): the real roots of both are counted, and tried in pairs. Of p and q
# with a common factor, a curve, one of the two is 0 everywhere.


HIGHEST_OF_TWO, HIGHEST_RESULTANT = 6, 15
"""Degree of two residuals in each tear, and of their resultants."""


def solve_by_resultant(problem: BlockProblem, candidates: Candidates) -> bool:
    """Find the answers; False if the block is not such a system, or rounding leaves one in
    doubt."""
    tears = problem.kernel.block.tears
    followed = _followed(problem)
    if followed is None:
        return False
    forms, ((p, *_), (q, *_)), _ = followed
    if not all(0 < max(f.degree(tear) for f in (p, q)) <= HIGHEST_OF_TWO for tear in tears):
        return False
    from rulesheets.algebra import resultant_of  # brings sympy

    roots = []
    for unknowns in (tears[::-1], tears):
        resultant = resultant_of(*(polynomial.by_exponents(unknowns) for polynomial in (p, q)))
        found = (
            _clear_roots(simple_part(resultant))
            if 0 < len(resultant) <= HIGHEST_RESULTANT + 1
            else None
        )
        if found is None:
            return False
        roots.append(found)
    trial = Candidates(problem)
    for pair in itertools.product(*roots):
        expect_time()
        at = dict(zip(tears, pair, strict=True))
        if not (_misses(p, at) or _misses(q, at) or _refined(problem, trial, forms, at)):
            return False
    candidates.take(trial)
    return True


def _misses(polynomial: Polynomial, at: Mapping[str, float]) -> bool:
    """Whether a polynomial is not 0 anywhere near a point, by more than the rounding of the
    inputs."""
    terms = [
        c * math.prod(Fraction(at[name]) ** exponent for name, exponent in monomial)
        for monomial, c in polynomial.items()
    ]
    return not _cancels(terms, TOUCHING * HIGHEST_DEGREE)


def _refined(
    problem: BlockProblem, trial: Candidates, forms: Forms, tears: dict[str, float]
) -> bool:
    """Whether the point with these tears is next to an answer, which is kept, or to one out of
    range."""
    point = _point_at(problem, forms, tears)
    if point is None:
        return False
    outside = trial.outside
    trial.refine(list(point.values()))
    sizes = problem.sizes_at(list(point.values()), SMALL)
    near = (
        are_alike(point.values(), map(one.values.get, point), POLISHED, sizes)
        for one in trial.answers
    )
    return trial.outside is not outside or any(near)
