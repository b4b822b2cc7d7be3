"""What the signs of variables say: of angles, and of what follows from angles alone, nothing.

Nor do those of a kind of quantity that has negative values anyhow: where a crank turns clockwise, its pin has
a negative velocity, and that of the slider may have either sign. Variables are angles by their unit or by the
functions that they stand in.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from rulesheets.functions import TABLE
from rulesheets.library import ANGLE, Unit
from rulesheets.model import Equation, Model, Variable
from rulesheets.syntax.nodes import Call, Expression, Name, Negative, Number, Product, Quotient, Sum, children
from solver.path.graph import shape_of
from solver.ranking.sizes import MANY, Scalings, Suggestions


def angles(model: Model) -> frozenset[str]:
    """Variables in degrees or radians, arguments of sines, results of their inverses, and what is
    added to any of these.
    """
    found = {n for n, variable in model.variables.items() if _is_angular(variable.measure)}
    told: dict[Any, bool] = {}
    for equation in model.equations:
        shape, _ = shape_of(equation)
        if shape not in told:
            told[shape] = any(TABLE[c.function].turn or TABLE[c.function].angle for c in _calls(equation))
        if not told[shape]:
            continue
        for call in _calls(equation):
            if TABLE[call.function].turn:
                found.update(_terms(call.arguments[0]))
        if _has_inverse(equation):
            found.update(_terms(equation.left), _terms(equation.right))
    if not found:
        return frozenset()
    every = (frozenset((*_terms(e.left), *_terms(e.right))) for e in model.equations)
    sums = [added for added in every if len(added) > 1]
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
        stack.extend(children(node))


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


DIGITS = 6
ABSOLUTE = frozenset({"bar", "mbar", "atm", "psia", "torr", "Torr", "mmHg", "inHg"})
"""Units of pressure in which no stress is given."""


class Signs:
    """``angles``, the ``aside`` ones whose signs do not count, and the ``kinds`` of the others by number.

    The sizes that a model suggests are kept here as well, by the pattern of its inputs.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        self.angles = angles(model)
        self.aside = self._following() | {n for n, v in model.variables.items() if _reaches_below(v)}
        self._suggestions: dict[tuple[Sequence[str], Sequence[str]], Suggestions] = {}

    def suggestions(self, known: tuple[str, ...], names: tuple[str, ...]) -> Suggestions:
        """The sizes of ``names`` that follow from those of ``known``."""
        pattern = known, names
        if pattern not in self._suggestions:
            self._suggestions[pattern] = Suggestions(self.model, known, names)
        return self._suggestions[pattern]

    def _following(self) -> frozenset[str]:
        """The angles, and what rules tell from them alone."""
        found = set(self.angles)
        if not found:
            return self.angles
        rules = [frozenset(equation.names) for equation in self.model.equations]
        before = -1
        while len(found) > before:
            before = len(found)
            for names in rules:
                if len(names) > 1 and len(names - found) == 1:
                    found |= names
        return frozenset(found)

    @cached_property
    def kinds(self) -> Mapping[str, int]:
        """Quantities that the rules scale alike have one number; dimensionless ones have none."""
        names = list(self.model.variables)
        if len(names) > MANY:
            return {}
        exponents = np.round(Scalings(self.model.equations, names).exponents, DIGITS) + 0.0
        number: dict[bytes, int] = {}
        return {
            name: number.setdefault(row.tobytes(), len(number))
            for name, row in zip(names, exponents, strict=True)
            if row.any()
        }

    @cached_property
    def differences(self) -> frozenset[str]:
        """Names that a rule gives as a difference: one below 0 says nothing of others of its kind."""
        return frozenset(
            side.name
            for rule in self.model.equations
            for side, other in ((rule.left, rule.right), (rule.right, rule.left))
            if isinstance(side, Name) and isinstance(other, Sum)
            if 0 < sum(isinstance(term, Negative) for term in other.terms) < len(other.terms)
        )

    def floor(self, name: str) -> float:
        """The least reading of an absolute temperature, a mass or an absolute pressure; else minus infinity.

        Pa and its multiples measure stresses as well, which have either sign.
        """
        variable = self.model.variables[name]
        unit = variable.measure
        if unit is None or variable.difference:
            return -np.inf
        bounded = unit.offset or unit.bases in ({"K": 1}, {"kg": 1}) or variable.unit in ABSOLUTE
        return float(-unit.offset / unit.factor) if bounded else -np.inf


def signs_of(model: Model) -> Signs:
    """The signs of a model, found out once."""
    if "_signs" not in model.__dict__:
        model.__dict__["_signs"] = Signs(model)
    found: Signs = model.__dict__["_signs"]
    return found


def _reaches_below(variable: Variable) -> bool:
    ranged = variable.low > -np.inf or variable.high < np.inf
    return ranged and variable.low < 0.0
