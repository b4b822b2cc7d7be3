"""Rules of a block that contradict each other whatever the values: ``x*y = 6`` and ``x*y = 7``.

Every rule is taken as linear in what it adds up, an unknown or any other expression with unknowns in it. If
the rules contradict each other so, then at all values of these expressions, whatever the unknowns are.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TypeAlias

from rulesheets.evaluate import Undefined, value
from rulesheets.model import Value
from rulesheets.syntax.nodes import Expression, Negative, Product, Quotient, Sum, names
from solver.facts import Conflict
from solver.kernel.question import Question
from solver.numerics.linear import solve_linear

CLEAR = 1e-9
"""Least share of the constants of the rules that they have to miss each other by."""
MAX_RULES = 40

Terms: TypeAlias = "dict[object, float]"
"""Factors of expressions with unknowns in them; of the constant under None."""


def contradiction(question: Question) -> Conflict | None:
    """The rules of a block that can't hold together, where linear algebra shows it."""
    forms = question.kernel.forms
    if len(forms) > MAX_RULES:
        return None
    rows = [_terms(form, question.unknowns, question.here) for form in forms]
    if any(row is None for row in rows):
        return None
    found = [row for row in rows if row is not None]
    atoms = list(dict.fromkeys(atom for row in found for atom in row if atom is not None))
    matrix = [[row.get(atom, 0.0) for atom in atoms] for row in found]
    rhs = [-row.get(None, 0.0) for row in found]
    if not all(math.isfinite(number) for row in (*matrix, rhs) for number in row):
        return None
    facts = solve_linear(matrix, rhs)
    size = max(
        (abs(m * rhs[row]) for row, m in zip(facts.conflict, facts.multipliers, strict=True)), default=0.0
    )
    if not facts.conflict or abs(facts.miss) <= CLEAR * size:
        return None
    equations = tuple(question.equations[row] for row in facts.conflict)
    return Conflict(equations, facts.miss, dict(question.values))


def _terms(form: Expression, unknowns: tuple[str, ...], here: Mapping[str, Value]) -> Terms | None:
    """A rule as a sum; None where a factor or a constant has no value."""
    total: Terms = {}

    def constant(part: Expression) -> bool:
        return not set(names(part)).intersection(unknowns)

    def add(part: Expression, factor: float) -> None:
        match part:
            case _ if constant(part):
                total[None] = total.get(None, 0.0) + factor * value(part, here)
            case Negative(operand):
                add(operand, -factor)
            case Sum(terms):
                for term in terms:
                    add(term, factor)
            case Product(left, right) if constant(left):
                add(right, factor * value(left, here))
            case Product(left, right) if constant(right):
                add(left, factor * value(right, here))
            case Quotient(left, right) if constant(right):
                add(left, factor / value(right, here))
            case Product():
                number, key = _product(part, constant, here)
                total[key] = total.get(key, 0.0) + factor * number
            case _:
                total[part] = total.get(part, 0.0) + factor

    try:
        add(form, 1.0)
    except (Undefined, ArithmeticError):
        return None
    return total


def _product(
    part: Product, constant: Callable[[Expression], bool], here: Mapping[str, Value]
) -> tuple[float, object]:
    """A product as a number and its factors in no order: ``x*y`` and ``y*x`` are the same."""
    number, factors, stack = 1.0, [], [part.left, part.right]
    while stack:
        factor = stack.pop()
        if constant(factor):
            number *= value(factor, here)
        elif isinstance(factor, Product):
            stack += [factor.left, factor.right]
        elif isinstance(factor, Negative):
            number, stack = -number, [*stack, factor.operand]
        else:
            factors.append(factor)
    counts = {factor: factors.count(factor) for factor in factors}
    return number, frozenset(counts.items())
