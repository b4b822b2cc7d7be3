"""Expressions and conditions turned into numbers, slopes and enclosures."""

from rulesheets.evaluate.calculus import NotDifferentiable, differentiate, simplify
from rulesheets.evaluate.conditions import holds
from rulesheets.evaluate.gradient import derivatives
from rulesheets.evaluate.number import Undefined, value

__all__ = [
    "NotDifferentiable",
    "Undefined",
    "derivatives",
    "differentiate",
    "holds",
    "simplify",
    "value",
]
