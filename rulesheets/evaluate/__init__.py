"""Expressions and conditions turned into numbers and slopes."""

from rulesheets.evaluate.gradient import (
    derivatives,
    differentiate,
    rounded_derivatives,
    slopes_by_name,
)
from rulesheets.evaluate.number import Undefined, holds, value

__all__ = [
    "Undefined",
    "derivatives",
    "differentiate",
    "holds",
    "rounded_derivatives",
    "slopes_by_name",
    "value",
]
