"""A double root that is exactly there: rational numbers that satisfy the rules, with a singular Jacobian."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction

from rulesheets.evaluate import Undefined
from rulesheets.evaluate.balls import Ball, around, continuous, exact_ball, exact_fraction, jumps
from rulesheets.evaluate.exactly import Inexact, exactly
from rulesheets.syntax.nodes import Expression, Number, operands
from solver.kernel.balls.krawczyk import Square
from solver.kernel.code.interval_code import ROUNDED
from solver.numerics.elimination import eliminate

DENOMINATORS = (1, 10**3, 10**7)
"""Largest denominators of the rational numbers that floats are taken for, besides what they are."""
RADIAN = math.pi / 180.0
SPECK = 2.0**-200
"""How far around a root its rules must be smooth."""


def exact_double_root(
    square: Square, known: Mapping[str, Ball], near: Sequence[float]
) -> dict[str, Fraction] | None:
    """The exact root next to the floats ``near`` at which the Jacobian is singular; None where there is none
    that is rational, or where a number that it depends on is not known exactly."""
    given = {name: number for name, ball in known.items() if (number := exact_fraction(ball)) is not None}
    for candidate in _candidates(near):
        root = dict(zip(square.unknowns, candidate, strict=True))
        try:
            if _singular_root(square, {**given, **root}):
                return root
        except Inexact:
            continue
    return None


def _candidates(near: Sequence[float]) -> Iterator[tuple[Fraction, ...]]:
    exact = tuple(map(Fraction, near))
    yield exact
    for most in DENOMINATORS:
        yield tuple(number.limit_denominator(most) for number in exact)


def _singular_root(square: Square, numbers: Mapping[str, Fraction]) -> bool:
    """Whether the rules hold, and the determinant of their Jacobian is 0.

    Derivatives by degrees hold π/180, of which the determinant is a polynomial with rational coefficients. As
    π is transcendental, it is 0 if and only if it is 0 for more numbers in place of π/180 than its degree.
    """
    if any(ROUNDED.keys() & set(_numbers(form)) for form in square.forms):
        raise Inexact("a number next to π/180")
    if any(exactly(form, numbers) for form in square.forms) or not _smooth(square, numbers):
        return False
    degree = sum(number in ROUNDED for partial in square.partials for number in _numbers(partial))
    return all(_singular(square, numbers, Fraction(k)) for k in range(1, degree + 2))


def _smooth(square: Square, numbers: Mapping[str, Fraction]) -> bool:
    """Whether neither the rules nor their slopes jump there: a kink is no double root, though 0 stands for
    its slope."""
    calls = jumps((*square.forms, *square.partials), square.unknowns)
    unknown = set(square.unknowns)
    balls = {n: around(exact_ball(v), SPECK if n in unknown else 0.0) for n, v in numbers.items()}
    try:
        return not calls or continuous(calls, balls)
    except Undefined:
        return False


def _singular(square: Square, numbers: Mapping[str, Fraction], radian: Fraction) -> bool:
    n = len(square.unknowns)
    constants = {RADIAN: radian, -RADIAN: -radian, 1 / RADIAN: 1 / radian, -1 / RADIAN: -1 / radian}
    flat = [exactly(partial, numbers, constants) for partial in square.partials]
    return eliminate([flat[i : i + n] for i in range(0, n * n, n)], [Fraction(0)] * n) is None


def _numbers(form: Expression) -> Iterator[float]:
    if isinstance(form, Number):
        yield form.value
    for part in operands(form):
        yield from _numbers(part)
