"""A block that its tearing makes two polynomials in two tears: every answer, by their resultant.

Where two polynomials p and q of x and y have a common root, their resultant, a polynomial of x, is 0 (D. Cox,
J. Little, D. O'Shea, *Ideals, Varieties, and Algorithms*, section 3.6): its real roots are counted, and at
each of them the roots y of p are tried.
"""

from __future__ import annotations

from cmath import isfinite
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import zip_longest
from typing import Any

import numpy as np

from rulesheets.algebra.polynomials import coefficients, exact, generators
from rulesheets.deadline import expect_time
from solver.kernel.candidates import Candidates
from solver.kernel.polynomial_block import (
    Forms,
    NotPolynomial,
    Polynomial,
    Steps,
    doubtful_extremum,
    explicit_forms,
    point_at,
)
from solver.kernel.question import Question
from solver.kernel.root_check import astray
from solver.numerics.one_unknown import real_roots, simple_part
from solver.numerics.tolerances import KEPT_AT_REAL, OFF, POLISHED, REAL

HIGHEST_OF_TWO, HIGHEST_RESULTANT = 6, 15
"""Degree of two residuals in the second tear, and of their resultant in the first."""
BESIDE = 2.0**-20
FADED = Fraction(1, 2**10)
"""Share of its size so far beside a root which is left of a residual that holds there whatever y is."""


class _StepsOfTwo(Steps):
    """The steps of a block followed in polynomials of two tears."""

    def begin(self, tears: Sequence[str]) -> dict[str, Any]:
        names = tears[::-1]
        found = dict(zip(names, generators(names), strict=True))
        self.one = found[tears[0]].ring.one
        return found

    def exact(self, number: float) -> Any:
        return self.one * exact(number)

    def constant(self, polynomial: Any) -> Any:
        return polynomial.coeff(1) if polynomial.is_ground else None

    def degree(self, polynomial: Any) -> int:
        return max(0, *map(int, polynomial.degrees()))


def solve_by_resultant(question: Question, candidates: Candidates) -> bool:
    """Find the answers; False where the block is no such system, or rounding leaves a doubt."""
    tears = question.kernel.block.tears
    if len(tears) != 2 or any(question.turn(tear) is not None for tear in tears):
        return False
    forms = explicit_forms(question)
    if forms is None:
        return False
    try:
        p, q = (polynomial for polynomial, _, _ in _StepsOfTwo(question, forms).residuals(question))
    except (NotPolynomial, OverflowError):
        return False
    if not 0 < max(p.degree(), q.degree()) <= HIGHEST_OF_TWO:
        return False
    resultant = coefficients(p.resultant(q))
    if not 0 < len(resultant) <= HIGHEST_RESULTANT + 1:
        return False
    simple = simple_part(resultant)
    roots = real_roots(simple)
    if roots is None or doubtful_extremum(simple):
        return False
    trial = Candidates(question)
    for x in roots:
        expect_time()
        beside = Fraction(x) + Fraction(max(abs(x), 1.0) * BESIDE)
        pairs = [(_at(f, x), _at(f, beside)) for f in (p, q)]
        pairs = [(here, there) for here, there in pairs if _size(here) > FADED * _size(there)]
        if not pairs:
            return False  # both hold for any y: a curve, of which this x may be but a part
        try:
            found = list(_real_parts(*max(pairs, key=lambda pair: len(pair[0]) > 1)))
        except OverflowError:
            return False
        if not all(_tried_beside(question, trial, forms, {tears[0]: x, tears[1]: y}) for y in found):
            return False
    candidates.take(trial)
    return True


def _at(polynomial: Any, x: float | Fraction) -> list[Fraction]:
    """A polynomial of both tears as one of the second, the first being x."""
    return coefficients(polynomial.evaluate(1, exact(x)))


def _size(polynomial: Polynomial) -> Fraction:
    return max(map(abs, polynomial), default=Fraction(0))


def _real_parts(polynomial: Polynomial, beside: Polynomial) -> Iterator[float]:
    """The real parts of the roots that may be real but for the rounding of the coefficients.

    ``beside``: the polynomial at a first tear that is further off than its digits are.
    """
    pairs = zip_longest(polynomial, beside, fillvalue=Fraction(0))
    slack = [abs(c) * KEPT_AT_REAL + abs(other - c) for c, other in pairs]
    for root in _roots(polynomial):
        real, size = Fraction(complex(root).real), Fraction(abs(root))
        kept = abs(sum((c * real**k for k, c in enumerate(polynomial)), Fraction(0)))
        if abs(complex(root).imag) <= REAL * abs(root) or kept <= sum(
            share * size**k for k, share in enumerate(slack)
        ):
            yield complex(root).real


def _roots(polynomial: Polynomial) -> list[complex]:
    """All roots, to floats. Raises OverflowError where one is beyond these."""
    largest = _size(polynomial) or Fraction(1)
    with np.errstate(all="ignore"):  # seen to below
        try:
            roots: list[complex] = np.roots([float(c / largest) for c in reversed(polynomial)]).tolist()
        except np.linalg.LinAlgError:
            raise OverflowError from None
    if not all(map(isfinite, roots)):
        raise OverflowError
    return roots


def _tried_beside(question: Question, trial: Candidates, forms: Forms, tears: dict[str, float]) -> bool:
    """Whether it is plain that the point with these tears is an answer (then kept), or that it is none."""
    point = point_at(question, forms, tears)
    if point is None:
        return False
    if astray(question, point, OFF):
        return True
    outside = trial.outside
    trial.refine(list(point.values()))
    return trial.outside is not outside or any(_near(question, point, one.values) for one in trial.answers)


def _near(question: Question, point: Mapping[str, float], other: Mapping[str, float]) -> bool:
    sizes = zip(point.items(), question.scale(), strict=True)
    return all(abs(v - other[name]) <= POLISHED * max(abs(v), 1e-3 * scale) for (name, v), scale in sizes)
