"""Rules that ask a function for the end of its image that it never attains: ``erfc(u) = 2``, whatever u is.

A search over an infinite range can't tell: towards infinity the function comes as near to the end as floats
are to one another, and nearer. The rule itself tells, where what the function has to be follows from given
numbers by sums, products and quotients alone, which fractions compute without rounding.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from fractions import Fraction
from math import inf, isfinite

from rulesheets.evaluate.exactly import Inexact, exactly
from rulesheets.evaluate.number import number_text
from rulesheets.functions import TABLE
from rulesheets.nodes import Call, Expression, Negative, Product, Quotient, Sum, names
from solver.facts import NoValue
from solver.kernel.question import Question

_ERROR_FUNCTIONS = {"erf": (-1.0, 1.0), "erfc": (0.0, 2.0)}
"""Ends of images, both never attained, of functions that no formula undoes."""


def unattained(question: Question, given: Collection[str]) -> NoValue | None:
    """The rule of a block that a function would have to leave the inside of its image for, if there is one.

    ``given``: the known names whose values are exact; others are rounded, and prove nothing.
    """
    numbers = {name: value for name, value in question.here.items() if name in given}
    exact = {n: Fraction(v) for n, v in numbers.items() if not isinstance(v, str) and isfinite(v)}
    for index, equation in zip(question.equations, question.kernel.equations, strict=True):
        for side, other in ((equation.left, equation.right), (equation.right, equation.left)):
            if set(question.unknowns).isdisjoint(names(other)):
                try:
                    function, target = _asked(side, exactly(other, exact), exact)
                except (Inexact, ZeroDivisionError):
                    continue
                if _outside(function, target):
                    unknown = next(name for name in question.unknowns if name in names(side))
                    return NoValue(index, unknown, f"{function} = {number_text(_nearest(target))}")
    return None


def _asked(part: Expression, target: Fraction, exact: Mapping[str, Fraction]) -> tuple[str, Fraction]:
    """The function with the unknowns in it that ``part`` is made of, and what it must be for ``part`` to be
    the target."""
    while not isinstance(part, Call):
        match part:
            case Negative(operand):
                part, target = operand, -target
            case Sum(terms):
                inside = [term for term in terms if not _known(term, exact)]
                if len(inside) != 1:
                    raise Inexact("several parts")
                target -= sum(exactly(term, exact) for term in terms if term is not inside[0])
                part = inside[0]
            case Product(left, right):
                factor, part = (left, right) if _known(left, exact) else (right, left)
                target /= exactly(factor, exact)
            case Quotient(left, right) if _known(right, exact):
                part, target = left, target * exactly(right, exact)
            case _:
                raise Inexact("another operation")
    return part.function, target


def _outside(function: str, target: Fraction) -> bool:
    """Whether a function never is the target. (Ends such as π/2 are no floats: they say nothing.)"""
    preimage = TABLE[function].preimage if function in TABLE else None
    if function in _ERROR_FUNCTIONS:
        low, high = _ERROR_FUNCTIONS[function]
        open_ends = True, True
    elif preimage is not None:
        low, high = preimage.low, preimage.high
        open_ends = preimage.low_open, preimage.high_open
    else:
        return False
    if not all(end in (inf, -inf) or end.is_integer() for end in (low, high)):
        return False
    at_end = (open_ends[0] and target == low) or (open_ends[1] and target == high)
    return at_end or target < low or target > high


def _known(part: Expression, exact: Mapping[str, Fraction]) -> bool:
    return all(name in exact for name in names(part))


def _nearest(target: Fraction) -> float:
    try:
        return float(target)
    except OverflowError:
        return inf if target > 0 else -inf
