"""What algebra tells of a block at given numbers: that it has no answer, whatever its unknowns are."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from fractions import Fraction
from typing import TypeAlias

from rulesheets.evaluate import Undefined, value
from rulesheets.syntax.nodes import Expression, Negative, Power, Product, Quotient, Sum, names
from rulesheets.syntax.nodes import Number as NumberNode
from solver.facts import Conflict
from solver.kernel.problem import BlockProblem
from solver.numerics.linear_algebra import solve_linear
from solver.numerics.tolerances import CLEAR

# ``x*y = 6`` contradicts ``x*y = 7``: every rule is taken as linear in the monomials it adds up, products
# of powers of whatever is no sum.

MAX_RULES = 40


def contradiction(problem: BlockProblem) -> Conflict | None:
    """The rules of a block that can't hold together, where linear algebra shows it."""
    forms = problem.kernel.forms
    if len(forms) > MAX_RULES:
        return None
    unknowns = frozenset(problem.unknowns)

    def number(part: Expression) -> Fraction | None:
        return Fraction(value(part, problem.here)) if unknowns.isdisjoint(names(part)) else None

    try:
        rows = [monomials(form, number) for form in forms]
        atoms = list(dict.fromkeys(monomial for row in rows for monomial in row if monomial))
        matrix = [[float(row.get(atom, 0.0)) for atom in atoms] for row in rows]
        rhs = [-float(row.get(ONE, 0.0)) for row in rows]
    except (Undefined, ArithmeticError, ValueError):
        return None
    facts = solve_linear(matrix, rhs)
    size = max(
        (abs(m * rhs[row]) for row, m in zip(facts.conflict, facts.multipliers, strict=True)), default=0.0
    )
    if not facts.conflict or abs(facts.miss) <= CLEAR * size:
        return None
    equations = tuple(problem.equations[row] for row in facts.conflict)
    return Conflict(equations, facts.miss, dict(problem.values))


Monomial: TypeAlias = frozenset[tuple[Expression, int]]
"""Factors with their exponents; none of them for a constant."""

Row: TypeAlias = dict[Monomial, Fraction]
ONE: Monomial = frozenset()


def monomials(expression: Expression, number: Callable[[Expression], Fraction | None]) -> Row:
    """The sum that an expression is; ``number`` gives the parts that are exactly known.

    Raises ZeroDivisionError for a known divisor that is 0.
    """
    row: Row = {}

    def add(part: Expression, factor: Fraction) -> None:
        known = number(part)
        if known is not None:
            row[ONE] = row.get(ONE, Fraction(0)) + factor * known
            return
        match part:
            case Negative(operand):
                add(operand, -factor)
            case Sum(terms):
                for term in terms:
                    add(term, factor)
            case Product(left, right) if (known := number(left)) is not None:
                add(right, factor * known)
            case Product(left, right) if (known := number(right)) is not None:
                add(left, factor * known)
            case Quotient(left, right) if (known := number(right)) is not None:
                add(left, factor / known)
            case _:
                coefficient, monomial = _monomial(part, number)
                row[monomial] = row.get(monomial, Fraction(0)) + factor * coefficient

    add(expression, Fraction(1))
    return {monomial: c for monomial, c in row.items() if c}


def _monomial(part: Expression, number: Callable[[Expression], Fraction | None]) -> tuple[Fraction, Monomial]:
    coefficient, powers = Fraction(1), Counter[Expression]()
    stack = [(part, 1)]
    while stack:
        factor, exponent = stack.pop()
        known = number(factor)
        match factor:
            case _ if known is not None:
                coefficient *= known**exponent
            case Product(left, right):
                stack += [(left, exponent), (right, exponent)]
            case Quotient(left, right):
                stack += [(left, exponent), (right, -exponent)]
            case Negative(operand):
                coefficient, stack = -coefficient, [*stack, (operand, exponent)]
            case Power(base, NumberNode(power)) if power in range(1, 65):
                stack.append((base, exponent * int(power)))
            case _:
                powers[factor] += exponent
    return coefficient, frozenset((factor, exponent) for factor, exponent in powers.items() if exponent)
