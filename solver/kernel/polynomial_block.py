"""A block that its tearing makes one polynomial in the tear: every answer, by an exact count of its roots.

The known numbers are taken as the exact fractions that floats are, and the chain is followed in polynomials
of the tear with such coefficients. Nothing is compiled, and nothing is rounded before the roots are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TypeAlias

from rulesheets.evaluate import Undefined, value
from rulesheets.nodes import (
    Expression,
    Name,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
)
from solver.facts import OutOfRange
from solver.kernel.candidates import Answer, Candidates
from solver.kernel.question import Question
from solver.numerics.sturm import real_roots

HIGHEST_DEGREE = 12
TOUCHING = Fraction(1, 10**9)
"""An extremum this near to 0 beside its terms may be a double root that rounding of the inputs has parted."""

Polynomial: TypeAlias = list[Fraction]
"""Coefficients, lowest degree first."""


class NotPolynomial(Exception):
    """Something that is no polynomial of low degree, or whose coefficients are not exact."""


def solve_as_polynomial(question: Question, candidates: Candidates) -> bool:
    """Find the answers; False where the block is no such polynomial, or rounding leaves a doubt about one."""
    block = question.kernel.block
    if len(block.tears) != 1 or question.turn(block.tears[0]) is not None:
        return False
    forms = _forms(question)
    if forms is None:
        return False
    try:
        polynomial = _closing(question, forms)
    except NotPolynomial:
        return False
    roots = real_roots(polynomial, *question.domain(block.tears[0]))
    if roots is None or _touches(polynomial):
        return False
    points = [_settled(question, _point(question, forms, root)) for root in roots]
    if None in points:
        return False
    for point in filter(None, points):
        name = question.outside(point)
        if name is None:
            candidates.answers.append(Answer(point))
        else:
            candidates.outside = OutOfRange(question.equations[0], name, point[name])
    return True


Forms: TypeAlias = Sequence[tuple[str, Expression]]


def _forms(question: Question) -> Forms | None:
    """The steps of the block as explicit forms; None where one has several or may be refused."""
    graph, found = question.graph, []
    for step in question.kernel.block.order:
        isolation = graph.isolation(step.equation, graph.number[step.unknown])
        if isolation is None or isolation.branches != 1 or isolation.verify or isolation.period:
            return None
        found.append((step.unknown, isolation.forms()[0]))
    return found


def _closing(question: Question, forms: Forms) -> Polynomial:
    """What must vanish. Raises NotPolynomial."""
    block = question.kernel.block
    known = {name: [Fraction(v)] for name, v in zip(question.kernel.known, question.known, strict=True)}
    moving: dict[str, Polynomial] = {**known, block.tears[0]: [Fraction(0), Fraction(1)]}
    for name, form in forms:
        moving[name] = _polynomial(form, moving)
    equation = question.graph.model.equations[block.residuals[0]]
    return _plus(_polynomial(equation.left, moving), _polynomial(equation.right, moving), -1)


def _polynomial(node: Expression, known: dict[str, Polynomial]) -> Polynomial:
    match node:
        case Number(number):
            return [Fraction(number)]
        case Name(name):
            return known[name]
        case Negative(operand):
            return [-c for c in _polynomial(operand, known)]
        case Sum(terms):
            total = _polynomial(terms[0], known)
            for term in terms[1:]:
                total = _plus(total, _polynomial(term, known), 1)
            return total
        case Product(left, right):
            return _times(_polynomial(left, known), _polynomial(right, known))
        case Quotient(left, right):
            divisor = _polynomial(right, known)
            if len(divisor) > 1 or not divisor[0]:
                raise NotPolynomial
            return [c / divisor[0] for c in _polynomial(left, known)]
        case Power(base, Number(exponent)) if exponent in range(1, HIGHEST_DEGREE + 1):
            factor = power = _polynomial(base, known)
            for _ in range(int(exponent) - 1):
                power = _times(power, factor)
            return power
        case _:
            raise NotPolynomial


def _plus(a: Polynomial, b: Polynomial, sign: int) -> Polynomial:
    size = max(len(a), len(b))
    padded = ([*p, *[Fraction(0)] * (size - len(p))] for p in (a, b))
    return _trimmed([x + sign * y for x, y in zip(*padded, strict=True)])


def _times(a: Polynomial, b: Polynomial) -> Polynomial:
    if len(a) + len(b) - 2 > HIGHEST_DEGREE:
        raise NotPolynomial
    product = [Fraction(0)] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        for j, y in enumerate(b):
            product[i + j] += x * y
    return _trimmed(product)


def _trimmed(polynomial: Polynomial) -> Polynomial:
    while len(polynomial) > 1 and not polynomial[-1]:
        polynomial.pop()
    return polynomial


def _touches(polynomial: Polynomial) -> bool:
    """Whether an extremum may be a double root but for the rounding of the inputs."""
    if len(polynomial) <= 2:
        return False
    extrema = real_roots([k * c for k, c in enumerate(polynomial)][1:])
    if extrema is None:
        return True
    for x in map(Fraction, extrema):
        terms = [c * x**k for k, c in enumerate(polynomial)]
        if abs(sum(terms, Fraction(0))) <= TOUCHING * sum(map(abs, terms), Fraction(0)):
            return True
    return False


def _settled(question: Question, point: Mapping[str, float] | None) -> Mapping[str, float] | None:
    """The point, or the answer that it leads to where the steps from the tear have lost digits."""
    if point is None or question.holds(point):
        return point
    trial = Candidates(question)
    trial.refine(list(point.values()))
    return trial.answers[0].values if len(trial.answers) == 1 and not trial.answers[0].double else None


def _point(question: Question, forms: Forms, root: float) -> dict[str, float] | None:
    """The unknowns at a root of the tear."""
    point = {question.kernel.block.tears[0]: root}
    try:
        for name, form in forms:
            point[name] = value(form, {**question.here, **point})
    except Undefined:
        return None
    return {name: point[name] for name in question.unknowns}
