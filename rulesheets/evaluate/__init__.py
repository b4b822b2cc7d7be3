"""Expressions and conditions turned into numbers, slopes and enclosures."""

from rulesheets.evaluate.gradient import (
    NotDifferentiable,
    derivatives,
    differentiate,
    less_one,
    rounded_derivatives,
    slopes_by_name,
)
from rulesheets.evaluate.number import Undefined, enclose, holds, value

__all__ = [
    "NotDifferentiable",
    "Undefined",
    "derivatives",
    "differentiate",
    "enclose",
    "holds",
    "less_one",
    "rounded_derivatives",
    "slopes_by_name",
    "value",
]
