"""Expressions and conditions turned into numbers and slopes."""

from rulesheets.evaluate.gradient import (
    NotDifferentiable,
    derivatives,
    differentiate,
    rounded_derivatives,
    slopes_by_name,
)
from rulesheets.evaluate.number import Undefined, holds, value

__all__ = [
    "NotDifferentiable",
    "Undefined",
    "derivatives",
    "differentiate",
    "holds",
    "rounded_derivatives",
    "slopes_by_name",
    "value",
]
