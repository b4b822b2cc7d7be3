"""Which variables are angles: their sign and their size say nothing of an answer."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rulesheets.functions import TABLE
from rulesheets.model import Equation, Model
from rulesheets.syntax.nodes import Call, Expression, Name, Negative, Number, Product, Quotient, Sum, operands
from rulesheets.units.unit import ANGLE, Unit


def angles(model: Model) -> frozenset[str]:
    """Variables in degrees or radians, arguments of sines, results of their inverses, and what is
    added to any of these.
    """
    found = {n for n, variable in model.variables.items() if _is_angular(variable.measure)}
    sums: list[frozenset[str]] = []
    for equation in model.equations:
        for call in _calls(equation):
            if TABLE[call.function].turn:
                found.update(_terms(call.arguments[0]))
        added = frozenset((*_terms(equation.left), *_terms(equation.right)))
        if _has_inverse(equation):
            found |= added
        if len(added) > 1:
            sums.append(added)
    before = -1
    while len(found) > before:
        before = len(found)
        found.update(name for added in sums if not added.isdisjoint(found) for name in added)
    return frozenset(found)


def _is_angular(unit: Unit | None) -> bool:
    return unit is not None and unit.bases == {ANGLE: 1}


def _calls(equation: Equation) -> Iterator[Call]:
    stack: list[Expression] = [equation.left, equation.right]
    while stack:
        node = stack.pop()
        if isinstance(node, Call):
            yield node
        stack.extend(operands(node))


def _added(node: Expression) -> Iterator[Expression]:
    """The terms of a sum, without signs and numerical factors."""
    match node:
        case Sum(terms):
            for term in terms:
                yield from _added(term)
        case (
            Negative(inner) | Product(Number(), inner) | Product(inner, Number()) | Quotient(inner, Number())
        ):
            yield from _added(inner)
        case _:
            yield node


def _terms(node: Expression) -> Iterable[str]:
    """The variables that are terms of a sum by themselves."""
    return [term.name for term in _added(node) if isinstance(term, Name)]


def _has_inverse(equation: Equation) -> bool:
    terms = (*_added(equation.left), *_added(equation.right))
    return any(isinstance(term, Call) and TABLE[term.function].angle for term in terms)
