"""What can be told of linear expressions by looking at them, before anything is isolated or derived."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection

from rulesheets import nodes
from rulesheets.nodes import Expression, Name, Negative, Number, Product, Quotient, Sum


def is_linear(expression: Expression, unknowns: Collection[str]) -> bool:
    """Whether the expression, as it is written, is linear in the unknowns, with any coefficients."""
    stack = [expression]
    while stack:
        match stack.pop():
            case Negative(operand):
                stack.append(operand)
            case Sum(terms):
                stack.extend(terms)
            case Product(left, right) if _free(left, unknowns):
                stack.append(right)
            case Product(left, right) if _free(right, unknowns):
                stack.append(left)
            case Quotient(left, right) if _free(right, unknowns):
                stack.append(left)
            case Name():
                pass
            case part if not _free(part, unknowns):
                return False
    return True


def _free(expression: Expression, unknowns: Collection[str]) -> bool:
    return not any(name in unknowns for name in nodes.names(expression))


def plainly_resolvable(left: Expression, right: Expression) -> frozenset[str]:
    """Unknowns that ``left = right`` gives at no cost: they occur once, in a sum, with a numeric factor.

    Others may be resolvable too; that takes an isolation to tell.
    """
    occurrences = Counter((*nodes.names(left), *nodes.names(right)))
    plain: list[str] = []
    stack = [left, right]
    while stack:
        match stack.pop():
            case Name(name):
                plain.append(name)
            case Negative(operand) | Product(Number(), operand) | Product(operand, Number()):
                stack.append(operand)
            case Quotient(operand, Number()):
                stack.append(operand)
            case Sum(terms):
                stack.extend(terms)
    return frozenset(name for name in plain if occurrences[name] == 1)
