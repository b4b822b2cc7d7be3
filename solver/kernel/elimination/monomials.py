"""Rules as sums of monomials with exact coefficients, and what is left of one by adding others to it.

A monomial is a product of powers of whatever is not added up: names, calls, sums in parentheses. ``x/y`` is
one, and a rule is multiplied by what it divides by, which is not 0 at any answer.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import TypeAlias

from rulesheets.syntax.nodes import Expression, Negative, Power, Product, Quotient, Sum
from rulesheets.syntax.nodes import Number as NumberNode

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
    return _cleared({monomial: c for monomial, c in row.items() if c})


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


def _cleared(row: Row) -> Row:
    """The row times what its monomials divide by."""
    lowest: Counter[Expression] = Counter()
    for monomial in row:
        for factor, exponent in monomial:
            lowest[factor] = min(lowest[factor], exponent)
    below = {factor: -exponent for factor, exponent in lowest.items() if exponent < 0}
    if not below:
        return row
    found: Row = {}
    for monomial, coefficient in row.items():
        powers = dict(monomial)
        raised = {factor: powers.get(factor, 0) + below.get(factor, 0) for factor in {**powers, **below}}
        key = frozenset((factor, exponent) for factor, exponent in raised.items() if exponent)
        found[key] = found.get(key, Fraction(0)) + coefficient
    return {monomial: c for monomial, c in found.items() if c}


def reduced(rows: Sequence[Row], last: Callable[[Monomial], bool]) -> list[Mapping[Monomial, Fraction]]:
    """Rows that follow from these, in reduced echelon form; monomials that are to be left come ``last``."""
    columns = sorted({m for row in rows for m in row if m}, key=last)
    left = [dict(row) for row in rows]
    done: list[Row] = []
    for column in columns:
        pivot = next((row for row in left if row.get(column)), None)
        if pivot is None:
            continue
        left.remove(pivot)
        pivot = {m: c / pivot[column] for m, c in pivot.items()}
        left = [_without(column, row, pivot) for row in left]
        done = [*(_without(column, row, pivot) for row in done), pivot]
    return [*done, *left]


def _without(column: Monomial, row: Row, pivot: Row) -> Row:
    factor = row.get(column)
    if not factor:
        return row
    both = {m: row.get(m, Fraction(0)) - factor * pivot.get(m, Fraction(0)) for m in {**row, **pivot}}
    return {m: c for m, c in both.items() if c}
