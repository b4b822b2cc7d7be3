"""A block that its tearing makes one polynomial in the tear: every answer, by an exact count of its roots.

The known numbers are taken as the exact fractions that floats are, and the chain is followed in polynomials
of the tear with such coefficients. Nothing is compiled, and nothing is rounded before the roots are. Where
the tear is an angle θ, the polynomials are those of t = tan(θ/2): cos θ = (1-t²)/(1+t²), sin θ = 2t/(1+t²).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import chain
from typing import TypeAlias

from rulesheets.evaluate import Undefined, value
from rulesheets.syntax.nodes import Expression
from solver.accuracy.rule_check import BACKWARD
from solver.facts import OutOfRange
from solver.kernel.blur import astray, uncertainty
from solver.kernel.candidates import Answer, Candidates
from solver.kernel.elimination.exact import NotPolynomial, Polynomial, Quarters, closing
from solver.kernel.question import Question
from solver.numerics.linear_algebra import last_singular
from solver.numerics.sturm import real_roots, simple_part

TOUCHING = Fraction(1, 10**9)
"""An extremum this near to 0 beside its terms may be a double root that rounding of inputs has parted."""
STRANGE = 1e-6
"""A zero of a squared rule that misses the rule by more than this, beside its terms, has another sign."""

Forms: TypeAlias = Sequence[tuple[str, Expression]]
Point: TypeAlias = Mapping[str, float]


def solve_as_polynomial(question: Question, candidates: Candidates) -> bool:
    """Find the answers; False where the block is no such polynomial, or rounding leaves a doubt about one.

    Multiple roots are what they are in exact numbers.
    """
    tears = question.kernel.block.tears
    forms = None if len(tears) != 1 or question.turn(tears[0]) is not None else explicit_forms(question)
    if forms is None:
        return False
    try:
        polynomial = closing(question, forms)
    except (NotPolynomial, OverflowError):
        return False
    domain = _widened(*question.domain(tears[0]))
    simple, roots = polynomial, real_roots(polynomial, *domain)
    if roots is None:
        simple = simple_part(polynomial)
        roots = real_roots(simple, *domain)
    if roots is None or doubtful_extremum(simple):
        return False
    trial, several = Candidates(question), len(simple) < len(polynomial)
    for root in roots:
        point = _point(question, forms, root)
        if point is None:
            return False
        plain = not several and _plainly(question, trial, point)
        if not plain and not _tried(question, trial, point, several):
            return False
    candidates.take(trial)
    return True


def _widened(low: float, high: float) -> tuple[float, float]:
    """A range with what rounding may lead beyond its ends."""
    slack = BACKWARD * max([abs(end) for end in (low, high) if math.isfinite(end)], default=0.0)
    return low - slack, high + slack


def _plainly(question: Question, trial: Candidates, point: Point) -> bool:
    """Keep a point that holds: a simple root that is counted needs no further look."""
    if not question.holds(point):
        return False
    point = question.inside(dict(point))
    name = question.outside(point)
    if name is None and trial.stands(point, uncertainty(question, point)):
        trial.answers.append(Answer(point))
    elif name is not None:
        trial.outside = OutOfRange(question.equations[0], name, point[name])
    return True


def solve_by_half_angle(question: Question, candidates: Candidates) -> bool:
    """The same where the tear is an angle free to turn; multiple roots are what they are in exact numbers."""
    tears = question.kernel.block.tears
    turn = question.turn(tears[0]) if len(tears) == 1 else None
    if turn is None or not question.graph.is_turning(tears[0]):
        return False
    if question.domain(tears[0]) != (-turn / 2, turn / 2):
        return False
    forms = explicit_forms(question)
    if forms is None:
        return False
    quarters = Quarters(tears[0], turn)
    try:
        polynomial = closing(question, forms, quarters)
    except (NotPolynomial, OverflowError):
        return False
    simple = simple_part(polynomial)
    roots = real_roots(simple)
    if roots is None or doubtful_extremum(simple):
        return False
    angles = [2.0 * math.atan(t) * turn / math.tau for t in roots]
    if quarters.at_half_turn:
        angles.append(turn / 2)
    trial = Candidates(question)
    several = len(simple) < len(polynomial) or quarters.at_half_turn > 1
    for angle in angles:
        point = _point(question, forms, angle)
        if point is None or not _tried(question, trial, point, several):
            return False
    candidates.take(trial)
    return True


def _tried(question: Question, trial: Candidates, point: Point, several: bool) -> bool:
    """Whether it is plain that the point is an answer (then kept), or that it is none."""
    if question.holds(point):
        trial.keep(dict(point), singular=several and _is_singular(question, point))
        return True
    count = len(trial.answers)
    if not several:
        trial.refine(list(point.values()))
    return len(trial.answers) > count or astray(question, point, STRANGE)


def _is_singular(question: Question, point: Point) -> bool:
    try:
        matrix = question.jacobian(list(point.values()))
    except (ArithmeticError, ValueError):
        return False
    sizes = [max(map(abs, row)) or 1.0 for row in matrix]
    rows = [[a / size for a in row] for row, size in zip(matrix, sizes, strict=True)]
    if not all(map(math.isfinite, chain.from_iterable(rows))):
        return False
    values, _ = last_singular(rows)
    return values[0] > 1e8 * values[-1]


def explicit_forms(question: Question) -> Forms | None:
    """The steps of the block as explicit forms; None where one has several or may be refused."""
    graph, found = question.graph, []
    for step in question.kernel.block.order:
        isolation = graph.isolation(step.equation, graph.number[step.unknown])
        if isolation is None or isolation.branches != 1 or isolation.verify or isolation.period:
            return None
        found.append((step.unknown, isolation.forms()[0]))
    return found


def doubtful_extremum(polynomial: Polynomial) -> bool:
    """Whether an extremum may be a double root but for the rounding of the inputs."""
    if len(polynomial) <= 2:
        return False
    extrema = real_roots(simple_part([k * c for k, c in enumerate(polynomial)][1:]))
    if extrema is None:
        return True
    for x in map(Fraction, extrema):
        terms = [c * x**k for k, c in enumerate(polynomial)]
        if abs(sum(terms, Fraction(0))) <= TOUCHING * sum(map(abs, terms), Fraction(0)):
            return True
    return False


def point_at(question: Question, forms: Forms, tears: Mapping[str, float]) -> dict[str, float] | None:
    """The unknowns where the tears have these values; None where a step has none there."""
    point = dict(tears)
    try:
        for name, form in forms:
            point[name] = value(form, {**question.here, **point})
    except Undefined:
        return None
    return {name: point[name] for name in question.unknowns}


def _point(question: Question, forms: Forms, root: float) -> dict[str, float] | None:
    """The unknowns at a root of the only tear."""
    return point_at(question, forms, {question.kernel.block.tears[0]: root})
