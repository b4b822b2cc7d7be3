"""Expressions and conditions turned into numbers, slopes and enclosures."""

from rulesheets.evaluate.gradient import (
    NotDifferentiable,
    derivatives,
    differentiate,
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
    "rounded_derivatives",
    "slopes_by_name",
    "value",
]
