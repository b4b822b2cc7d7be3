"""A polynomial block with two tears: every answer, by the resultant of its two residuals.

With one tear x fixed, the residuals are polynomials p and q of the other, y. Where they have a common root,
the resultant of p and q, a polynomial of x, is 0 (D. Cox, J. Little, D. O'Shea, *Ideals, Varieties, and
Algorithms*, section 3.6). It is computed in exact fractions at as many x as determine it; its real roots are
counted after Sturm, and at each of them the roots of p are tried.
"""

from __future__ import annotations

from cmath import isfinite
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import zip_longest

from rulesheets.deadline import expect_time
from solver.kernel.candidates import Candidates
from solver.kernel.polynomial_block import (
    Forms,
    NotPolynomial,
    Polynomial,
    doubtful_extremum,
    explicit_forms,
    point_at,
    residuals_in,
)
from solver.kernel.question import Question
from solver.kernel.root_check import astray
from solver.numerics.sturm import real_roots, simple_part

SAMPLES = 20
"""Values of x at which the resultant is computed; its degree has to be smaller by ``SPARE`` at least."""
SPARE = 4
HIGHEST = 6
"""Degree of the residuals in y."""
REAL = 1e-4
"""How far from the real axis a root may be, relative to its size, that may be a real one but for rounding."""
KEPT = Fraction(1, 10**8)
"""Share of its terms that a polynomial may keep at the real part of such a root, however far that is."""
STRANGE = 1e-3
"""A point that misses an equation by more than this, relative to its terms, is no answer."""
BESIDE = 2.0**-20
FADED = Fraction(1, 2**10)
"""Share of its size so far beside a root which is left of a residual that holds there whatever y is."""
SAME = 1e-2
"""Relative distance of an answer from the point that was refined to it."""


def solve_by_resultant(question: Question, candidates: Candidates) -> bool:
    """Find the answers; False where the block is no such system, or rounding leaves a doubt about one."""
    tears = question.kernel.block.tears
    if len(tears) != 2 or any(question.turn(tear) is not None for tear in tears):
        return False
    forms = explicit_forms(question)
    if forms is None:
        return False
    try:
        resultant = _resultant(question, forms)
    except (NotPolynomial, OverflowError):
        return False
    if not any(resultant):
        return False
    simple = simple_part(resultant)
    roots = real_roots(simple)
    if roots is None or doubtful_extremum(simple):
        return False
    trial = Candidates(question)
    for x in roots:
        expect_time()
        try:
            here = _residuals(question, forms, Fraction(x))
            beside = _residuals(question, forms, Fraction(x) + Fraction(max(abs(x), 1.0) * BESIDE))
            pairs = [(p, q) for p, q in zip(here, beside, strict=True) if _size(p) > FADED * _size(q)]
            if not pairs:
                return False  # both hold for any y: a curve, of which this x may be but a part
            found = list(_real_parts(*max(pairs, key=lambda pair: len(pair[0]) > 1)))
        except (NotPolynomial, OverflowError):
            return False
        for y in found:
            if not _tried(question, trial, forms, {tears[0]: x, tears[1]: y}):
                return False
    candidates.take(trial)
    return True


def _resultant(question: Question, forms: Forms) -> Polynomial:
    """The resultant as a polynomial of the first tear. Raises NotPolynomial."""
    at = [Fraction(k, 2) for k in range(1 - SAMPLES, SAMPLES, 2)]
    pairs = [_residuals(question, forms, x) for x in at]
    m, n = (max(len(pair[side]) for pair in pairs) - 1 for side in (0, 1))
    if not 0 < max(m, n) <= HIGHEST:
        raise NotPolynomial
    found = _interpolated(at, [_determinant(_sylvester(p, q, m, n)) for p, q in pairs])
    if any(found[-SPARE:]):
        raise NotPolynomial  # of a higher degree than the samples tell
    return found


def _residuals(question: Question, forms: Forms, x: Fraction) -> tuple[Polynomial, ...]:
    """The two residuals as polynomials of the second tear, the first being x. Raises NotPolynomial."""
    first, second = question.kernel.block.tears
    return residuals_in(question, forms, {first: x}, second)


def _size(polynomial: Polynomial) -> Fraction:
    return max(map(abs, polynomial), default=Fraction(0))


def _sylvester(p: Polynomial, q: Polynomial, m: int, n: int) -> list[list[Fraction]]:
    """The matrix (m + n, m + n) whose determinant is the resultant of degrees m and n."""
    zero = Fraction(0)
    high = [[*reversed([*p, *[zero] * (m + 1 - len(p))])], [*reversed([*q, *[zero] * (n + 1 - len(q))])]]
    rows = []
    for coefficients, count in ((high[0], n), (high[1], m)):
        for shift in range(count):
            row = [zero] * shift + coefficients
            rows.append(row + [zero] * (m + n - len(row)))
    return rows


def _determinant(rows: list[list[Fraction]]) -> Fraction:
    total = Fraction(1)
    for k in range(len(rows)):
        expect_time()
        chosen = next((i for i in range(k, len(rows)) if rows[i][k]), None)
        if chosen is None:
            return Fraction(0)
        if chosen != k:
            rows[k], rows[chosen], total = rows[chosen], rows[k], -total
        top = rows[k]
        total *= top[k]
        for i in range(k + 1, len(rows)):
            expect_time()
            if factor := rows[i][k] / top[k]:
                rows[i] = [a - factor * b for a, b in zip(rows[i], top, strict=True)]
    return total


def _interpolated(at: Sequence[Fraction], values: Sequence[Fraction]) -> Polynomial:
    """The coefficients of the polynomial through these points, by Newton's divided differences."""
    n, differences = len(at), list(values)
    for order in range(1, n):
        expect_time()
        for k in range(n - 1, order - 1, -1):
            differences[k] = (differences[k] - differences[k - 1]) / (at[k] - at[k - order])
    found = [Fraction(0)] * n
    for k in range(n - 1, -1, -1):
        shifted = [Fraction(0), *found[:-1]]
        found = [s - at[k] * c for s, c in zip(shifted, found, strict=True)]
        found[0] += differences[k]
    return found


def _real_parts(polynomial: Polynomial, beside: Polynomial) -> Iterator[float]:
    """The real parts of the roots that may be real but for the rounding of the coefficients.

    ``beside``: the polynomial at a first tear that is further off than its digits are.
    """
    pairs = zip_longest(polynomial, beside, fillvalue=Fraction(0))
    slack = [abs(c) * KEPT + abs(other - c) for c, other in pairs]
    for root in _roots(polynomial):
        real, size = Fraction(complex(root).real), Fraction(abs(root))
        kept = abs(sum((c * real**k for k, c in enumerate(polynomial)), Fraction(0)))
        if abs(complex(root).imag) <= REAL * abs(root) or kept <= sum(
            share * size**k for k, share in enumerate(slack)
        ):
            yield complex(root).real


def _roots(polynomial: Polynomial) -> list[complex]:
    """All roots, to floats. Raises OverflowError where one is beyond these."""
    import numpy as np

    largest = _size(polynomial) or Fraction(1)
    with np.errstate(all="ignore"):  # seen to below
        try:
            roots: list[complex] = np.roots([float(c / largest) for c in reversed(polynomial)]).tolist()
        except np.linalg.LinAlgError:
            raise OverflowError from None
    if not all(map(isfinite, roots)):
        raise OverflowError
    return roots


def _tried(question: Question, trial: Candidates, forms: Forms, tears: dict[str, float]) -> bool:
    """Whether it is plain that the point with these tears is an answer (then kept), or that it is none."""
    point = point_at(question, forms, tears)
    if point is None:
        return False
    if astray(question, point, STRANGE):
        return True
    outside = trial.outside
    trial.refine(list(point.values()))
    return trial.outside is not outside or any(_near(question, point, one.values) for one in trial.answers)


def _near(question: Question, point: Mapping[str, float], other: Mapping[str, float]) -> bool:
    sizes = zip(point.items(), question.scale(), strict=True)
    return all(abs(v - other[name]) <= SAME * max(abs(v), 1e-3 * scale) for (name, v), scale in sizes)
