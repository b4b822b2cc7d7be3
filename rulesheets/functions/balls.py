"""The functions of the language on balls: rigorous enclosures to any precision, by Arb (imported here only).

A ball is a middle and a radius that holds the exact value (F. Johansson, IEEE Trans. Computers 66 (2017)
1281–1292). Outside its domain a function gives a ball that is not finite.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import partial
from typing import Any, TypeAlias

from flint import arb, arb_mat, ctx

from rulesheets.functions.row import Forms, Function
from rulesheets.functions.table import TABLE

Ball: TypeAlias = Any
"""An ``arb`` of python-flint (which has no types of its own)."""


def precision(bits: int) -> Any:
    """A context in which balls are computed with so many bits."""
    return ctx.workprec(bits)


def ball(number: Any) -> Ball:
    """The exact number: a float, an int, or an mpmath number."""
    if hasattr(number, "_mpf_"):
        sign, mantissa, exponent, _ = number._mpf_
        return (arb(-int(mantissa)) if sign else arb(int(mantissa))) * arb(2) ** exponent
    return arb(number)


def exact_ball(number: Fraction) -> Ball:
    """A ball around a rational number; without a radius where it has a short binary form."""
    return arb(number.numerator) / arb(number.denominator)


def exact_fraction(number: Ball) -> Fraction | None:
    """The number that a ball without a radius is; None of any other."""
    if not (number.is_exact() and number.is_finite()):
        return None
    mantissa, exponent = number.mid().man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


def around(middle: Ball, radius: float) -> Ball:
    """Everything within ``radius`` of a number."""
    return middle + arb(0, radius)


def whole_power(base: Ball, exponent: int) -> Ball:
    """An integral power. (Arb takes logarithms of a ball whose middle is 0, unless it is multiplied out.)"""
    if exponent < 1 or not base.mid().is_zero():
        return base**exponent
    reach = base.abs_upper() ** exponent
    return reach.union(arb(0 if exponent % 2 == 0 else -reach))


def preconditioned(
    jacobian: Sequence[Sequence[Ball]], centre: Sequence[Sequence[Ball]], residual: Sequence[Ball]
) -> tuple[list[list[Ball]], list[Ball]] | None:
    """I − Y J and Y F, for Y next to the inverse of the middle of ``centre``; None where that is singular."""
    n = len(residual)
    try:
        inverse = arb_mat([[a.mid() for a in row] for row in centre]).inv()
    except ZeroDivisionError:
        return None
    rough = arb_mat([[inverse[i, j].mid() for j in range(n)] for i in range(n)])
    product = rough * arb_mat([list(row) for row in jacobian])
    shift = rough * arb_mat([[f] for f in residual])
    rest = [[(1 if i == j else 0) - product[i, j] for j in range(n)] for i in range(n)]
    return rest, [shift[i, 0] for i in range(n)]


def solved(matrix: Sequence[Sequence[Ball]], rhs: Sequence[Ball]) -> list[Ball]:
    """x (n,) with A x = b, for every A (n, n) and b (n,) in the balls.

    Raises ZeroDivisionError where an A may be singular.
    """
    found = arb_mat([list(row) for row in matrix]).solve(arb_mat([[b] for b in rhs]))
    return [found[i, 0] for i in range(len(rhs))]


def _form(row: Function) -> Callable[..., Ball]:
    match row.ball:
        case None:
            return lambda *arguments: arb(0, "inf")
        case str() as name:
            function: Callable[..., Ball] = getattr(arb, name)
            return function
        case form:
            return partial(form, arb)


FUNCTIONS = Forms(TABLE, _form)
"""Every function of the table on balls, by name; not finite where nothing is known."""
