"""Rules as sympy equations: the only door to sympy.

Every equation of a model can be had as ``Eq(left, right)`` with its guard, and every model as a listing in
text or LaTeX.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import sympy

from rulesheets.algebra.convert import AS_MATHEMATICS
from rulesheets.algebra.printing import condition_latex, expression_latex, listing
from rulesheets.model import Model
from rulesheets.syntax.source import Span

__all__ = [
    "SympyEquation",
    "condition_latex",
    "expression_latex",
    "listing",
    "sympy_equations",
]


class SympyEquation(NamedTuple):
    """``equation`` holds where ``guard`` does (``true`` for a rule without ``if``); ``place`` is its rule."""

    equation: sympy.Eq
    guard: Any
    place: Span


def sympy_equations(model: Model) -> tuple[SympyEquation, ...]:
    """Every equation of a model in sympy with its guard and its place in the text, in the model's order."""
    return tuple(
        SympyEquation(
            AS_MATHEMATICS.equation(equation), AS_MATHEMATICS.guard(equation.guard, model), equation.rule
        )
        for equation in model.equations
    )
