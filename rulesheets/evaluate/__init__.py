"""Expressions and conditions turned into numbers, slopes and enclosures."""

from rulesheets.evaluate.digits import extended, extended_derivatives
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
    "extended",
    "extended_derivatives",
    "holds",
    "less_one",
    "rounded_derivatives",
    "slopes_by_name",
    "value",
]
