"""The algebraic proof that rules of a block contradict each other, whatever its unknowns are."""

from __future__ import annotations

from fractions import Fraction

from rulesheets.evaluate import Undefined, value
from rulesheets.syntax.nodes import Expression, names
from solver.facts import Conflict
from solver.kernel.problem import BlockProblem
from solver.numerics.elimination import solve_linear
from solver.numerics.tolerances import CLEAR
from solver.path.polynomial import UNIT, NoForm, in_parts

# ``x*y = 6`` contradicts ``x*y = 7``: every rule is linear in its monomials, which are products of
# powers of parts that are not sums.

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
