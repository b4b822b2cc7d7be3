"""Rules that ask a function for a value outside its image, or the end of it that it never attains:
``erfc(u) = 2``, ``exp(w) = 0``.

A search over an infinite range can't tell: towards infinity the function comes as near to the end as floats
are to one another, and nearer. The rules themselves tell, where a sum of multiples of them leaves nothing
but the function and a number, computed in fractions.
"""

from __future__ import annotations

from collections.abc import Collection
from fractions import Fraction
from math import inf, isfinite

from rulesheets.evaluate.exactly import Inexact, exactly
from rulesheets.evaluate.number import number_text
from rulesheets.functions import TABLE
from rulesheets.syntax.nodes import Call, Expression, names
from rulesheets.syntax.program import walk
from solver.facts import NoValue
from solver.kernel.elimination.monomials import ONE, Monomial, monomials, reduced
from solver.kernel.question import Question

"""Ends of images, both never attained, of functions that no formula undoes."""
MAX_RULES = 40
ROUNDING = Fraction(1, 2**46)
"""64 ulp of a number of size 1: what the check of a rule allows."""


def unattained(question: Question, given: Collection[str]) -> NoValue | None:
    """The rule of a block that a function would have to leave the inside of its image for, if there is one.

    ``given``: the known names whose values are exact; others are rounded, and prove nothing.
    """
    equations = question.kernel.equations
    if len(equations) > MAX_RULES or not any(_limited(e.left) or _limited(e.right) for e in equations):
        return None
    numbers = {name: value for name, value in question.here.items() if name in given}
    exact = {n: Fraction(v) for n, v in numbers.items() if not isinstance(v, str) and isfinite(v)}

    def number(part: Expression) -> Fraction | None:
        try:
            return exactly(part, exact)
        except (Inexact, ZeroDivisionError):
            return None

    try:
        rows = [monomials(form, number) for form in question.kernel.forms]
    except ZeroDivisionError:
        return None
    for row in reduced(rows, lambda monomial: _call(monomial) is not None):
        asked = [monomial for monomial in row if monomial]
        call = _call(asked[0]) if len(asked) == 1 else None
        if call is not None and _outside(call.function, -row.get(ONE, Fraction(0)) / row[asked[0]]):
            return _no_value(question, call, -row.get(ONE, Fraction(0)) / row[asked[0]])
    return None


def _no_value(question: Question, call: Call, target: Fraction) -> NoValue:
    unknown = next(name for name in (*names(call), *question.unknowns) if name in question.unknowns)
    index = next(
        index
        for index, equation in zip(question.equations, question.kernel.equations, strict=True)
        if call in _parts(equation.left) or call in _parts(equation.right)
    )
    return NoValue(index, unknown, f"{call.function} = {number_text(_nearest(target))}")


def _parts(expression: Expression) -> list[Expression]:
    return [part for part in walk(expression) if isinstance(part, Call)]


def _limited(expression: Expression) -> bool:
    return any(_image(call.function) is not None for call in _parts(expression) if isinstance(call, Call))


def _call(monomial: Monomial) -> Call | None:
    """The call that a monomial consists of."""
    match tuple(monomial):
        case ((Call() as call, 1),):
            return call
        case _:
            return None


def _image(function: str) -> tuple[float, float, bool, bool] | None:
    """The ends of the image of a function, and which of them it never attains."""
    row = TABLE[function]
    if row.image is not None:
        return (*row.image, True, True)
    preimage = row.inverse
    if preimage is None or row.source is not None or (preimage.low, preimage.high) == (-inf, inf):
        return None
    return preimage.low, preimage.high, preimage.low_open, preimage.high_open


def _outside(function: str, target: Fraction) -> bool:
    """Whether a function never is the target. (Ends such as π/2 are no floats: they say nothing.)"""
    image = _image(function)
    if image is None or not all(end in (inf, -inf) or end.is_integer() for end in image[:2]):
        return False
    low, high, low_open, high_open = image
    at_end = (low_open and target == low) or (high_open and target == high)
    return at_end or _beyond(low, target) or _beyond(-high, -target)


def _beyond(low: float, target: Fraction) -> bool:
    """Whether a number is below the end of an image by more than the rounding of what it was made of."""
    return low != -inf and target < Fraction(low) - ROUNDING * max(Fraction(1), abs(Fraction(low)))


def _nearest(target: Fraction) -> float:
    try:
        return float(target)
    except OverflowError:
        return inf if target > 0 else -inf
