"""Expressions and conditions turned into numbers, slopes and enclosures.

``extended`` and ``extended_derivatives``, which need mpmath, are loaded at their first use.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from rulesheets.evaluate.gradient import (
    NotDifferentiable,
    derivatives,
    differentiate,
    rounded_derivatives,
    simplify,
)
from rulesheets.evaluate.number import Undefined, enclose, holds, value

if TYPE_CHECKING:
    from rulesheets.evaluate.digits import extended, extended_derivatives

__all__ = [
    "NotDifferentiable",
    "Undefined",
    "derivatives",
    "differentiate",
    "enclose",
    "extended",
    "extended_derivatives",
    "holds",
    "rounded_derivatives",
    "simplify",
    "value",
]


def __getattr__(name: str) -> Any:
    if name not in ("extended", "extended_derivatives"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module("rulesheets.evaluate.digits"), name)
