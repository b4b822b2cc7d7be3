"""Whether a condition holds."""

from __future__ import annotations

from collections.abc import Callable, Collection
from sys import float_info
from typing import TypeAlias

from rulesheets.evaluate.number import Undefined, Values, value
from rulesheets.syntax.nodes import And, Comparison, Condition, Expression, Given, Name, Not, Or, Symbol

_TOLERANCE = 16.0 * float_info.epsilon


def equal(left: float, right: float) -> bool:
    """Equality of floats within the comparison tolerance, 16 eps of the larger."""
    return abs(left - right) <= _TOLERANCE * max(abs(left), abs(right))


Same: TypeAlias = Callable[[Comparison, float, float], bool]
"""Whether the two sides of a comparison, of these values, are equal."""


def _equal_sides(comparison: Comparison, left: float, right: float) -> bool:
    return equal(left, right)


def holds(
    condition: Condition, values: Values, given: Collection[str] = (), same: Same = _equal_sides
) -> bool:
    """Whether ``condition`` is true; ``given`` are the names of the inputs.

    ``=`` and ``<>`` of numbers use the comparison tolerance (or ``same``), the orders are exact. A symbol
    equals itself only; compared with anything else every relation but ``<>`` is false.
    Terms of ``and`` and ``or`` that cannot be evaluated do not matter where another term
    settles the outcome. Raises KeyError (a variable without a value) or Undefined where
    the condition cannot be settled.
    """
    match condition:
        case Comparison():
            return _compare(condition, values, same)
        case And(terms):
            return not _any(terms, False, values, given, same)
        case Or(terms):
            return _any(terms, True, values, given, same)
        case Not(term):
            return not holds(term, values, given, same)
        case Given():
            return condition.name in given


def meets(comparison: Comparison, values: Values) -> bool:
    """Whether numbers are as a requirement asks, with the comparison tolerance in every relation.

    Numbers that are equal within it satisfy ``<=`` and ``>=``, and neither ``<`` nor ``>``.
    Raises KeyError and Undefined as :func:`holds` does.
    """
    operator, left, right = comparison.operator, comparison.left, comparison.right
    if operator not in ("=", "<>") and _compare(Comparison("=", left, right), values, _equal_sides):
        return operator in ("<=", ">=")
    return _compare(comparison, values, _equal_sides)


def _any(
    terms: tuple[Condition, ...], wanted: bool, values: Values, given: Collection[str], same: Same
) -> bool:
    """Whether some term comes out as ``wanted``."""
    obstacle: KeyError | Undefined | None = None
    for term in terms:
        try:
            if holds(term, values, given, same) is wanted:
                return True
        except (KeyError, Undefined) as error:
            obstacle = obstacle or error
    if obstacle is not None:
        raise obstacle
    return False


def _operand(expression: Expression, values: Values) -> float | str:
    if isinstance(expression, Name):
        return values[expression.name]
    if isinstance(expression, Symbol):
        return expression.name
    return value(expression, values)


def _compare(comparison: Comparison, values: Values, same: Same) -> bool:
    left = _operand(comparison.left, values)
    right = _operand(comparison.right, values)
    if isinstance(left, str) or isinstance(right, str):
        return (left == right) is (comparison.operator == "=") and comparison.operator in ("=", "<>")
    match comparison.operator:
        case "=":
            return same(comparison, left, right)
        case "<>":
            return not same(comparison, left, right)
        case "<":
            return left < right
        case "<=":
            return left <= right
        case ">":
            return left > right
        case _:
            return left >= right
