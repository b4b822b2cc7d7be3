"""Algebraic proofs that a block has no answer at given numbers, whatever its unknowns are."""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection
from fractions import Fraction
from math import inf, isfinite, isinf

from rulesheets.evaluate import Undefined, value
from rulesheets.evaluate.exact import Inexact, exactly
from rulesheets.evaluate.number import number_text
from rulesheets.functions import TABLE, named
from rulesheets.syntax.nodes import Call, Expression, names
from rulesheets.syntax.program import walk
from solver.facts import Conflict, NoValue
from solver.kernel.problem import BlockProblem
from solver.numerics.elimination import gauss_jordan, solve_linear
from solver.numerics.tolerances import BACKWARD, CLEAR
from solver.path.polynomial import UNIT, Monomial, NoForm, in_parts

# Rules may contradict each other, or a function.
#
# ``x*y = 6`` contradicts ``x*y = 7``: every rule is linear in its monomials. ``erfc(u) = 2`` and
# ``exp(w) = 0`` ask for a value outside an image. A search over an infinite range cannot exclude an
# end of an image that is never attained. A linear combination of rules can, if only the function
# and a number, computed in fractions, are left of it. Monomials are products of powers of parts
# that are not sums. ``x/y`` is one, and a rule is multiplied by its divisors, which are not 0 at
# any answer.

MAX_RULES = 40


def contradiction(problem: BlockProblem) -> Conflict | None:
    """The rules of a block that contradict each other, as shown by linear algebra."""
    forms = problem.kernel.forms
    if len(forms) > MAX_RULES:
        return None
    unknowns = frozenset(problem.unknowns)

    def number(part: Expression) -> Fraction | None:
        return Fraction(value(part, problem.here)) if unknowns.isdisjoint(names(part)) else None

    try:
        meaning = dict[Expression, str]()
        rows = [in_parts(form, number, meaning) for form in forms]
        columns = list(dict.fromkeys(monomial for row in rows for monomial in row if monomial))
        matrix = [[float(row.get(monomial, 0.0)) for monomial in columns] for row in rows]
        rhs = [-float(row.get(UNIT, 0.0)) for row in rows]
    except (NoForm, Undefined, ArithmeticError, ValueError):
        return None
    facts = solve_linear(matrix, rhs)
    size = max(
        (abs(m * rhs[row]) for row, m in zip(facts.conflict, facts.multipliers, strict=True)),
        default=0.0,
    )
    if not facts.conflict or abs(facts.miss) <= CLEAR * size:
        return None
    equations = tuple(problem.equations[row] for row in facts.conflict)
    return Conflict(equations, facts.miss, dict(problem.values))


HUGE = 10**300
"""Numbers beyond this are shown as infinite."""
_LIMITED = named(
    lambda row: row.image or (row.inverse and (row.inverse.low, row.inverse.high) != (-inf, inf))
)
"""Functions that have an image with ends."""


def unattained(problem: BlockProblem, given: Collection[str]) -> NoValue | None:
    """The rule of a block that asks a function for an end of its image that it never attains, if
    there is one.

    ``given``: the known names whose values are exact; others are rounded, and prove nothing.
    """
    if len(problem.equations) > MAX_RULES:
        return None
    calls, meaning = dict[Monomial, tuple[Call, int]](), dict[Expression, str]()
    for index, rule in zip(problem.equations, problem.kernel.equations, strict=True):
        for part in itertools.chain(walk(rule.left), walk(rule.right)):
            if isinstance(part, Call) and part.function in _LIMITED:
                name = meaning.setdefault(part, f"#{len(meaning)}")
                calls.setdefault(((name, 1),), (part, index))
    if not calls:
        return None
    numbers = {name: value for name, value in problem.here.items() if name in given}
    exact = {n: Fraction(v) for n, v in numbers.items() if not isinstance(v, str) and isfinite(v)}

    def number(part: Expression) -> Fraction | None:
        try:
            return exactly(part, exact)
        except (Inexact, ZeroDivisionError):
            return None

    try:
        rows = [in_parts(form, number, meaning).cleared() for form in problem.kernel.forms]
    except (NoForm, ZeroDivisionError):
        return None
    columns = sorted({m for row in rows for m in row if m}, key=calls.__contains__)
    matrix = [[row.get(monomial, Fraction(0)) for monomial in columns] for row in rows]
    found, _ = gauss_jordan(matrix, [-row.get(UNIT, Fraction(0)) for row in rows])
    for *entries, constant in (row[: len(columns) + 1] for row in found):
        asked = [
            (monomial, entry) for monomial, entry in zip(columns, entries, strict=True) if entry
        ]
        if len(asked) != 1 or asked[0][0] not in calls:
            continue
        (call, index), target = calls[asked[0][0]], Fraction(constant, asked[0][1])
        if _outside(call.function, target):
            unknown = next(
                name for name in (*names(call), *problem.unknowns) if name in problem.unknowns
            )
            shown = float(target) if abs(target) < HUGE else math.copysign(inf, target)
            return NoValue(index, unknown, f"{call.function} = {number_text(shown)}")
    return None


def _outside(function: str, target: Fraction) -> bool:
    """Whether a function never attains the target. (π/2 is not a float and proves nothing.)"""
    row = TABLE[function]
    low, high, low_open, high_open = -inf, inf, True, True
    if row.image is not None:
        low, high = row.image
    elif row.inverse is not None:
        _, low, high, low_open, high_open, _ = row.inverse
    if not all(isinf(end) or end.is_integer() for end in (low, high)):
        return False
    at_end = (low_open and target == low) or (high_open and target == high)
    return at_end or any(  # below an end by more than the rounding of what it was made of
        end != -inf
        and number < Fraction(end) - Fraction(BACKWARD) * max(Fraction(1), abs(Fraction(end)))
        for end, number in ((low, target), (-high, -target))
    )
