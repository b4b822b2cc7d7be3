"""Expressions and conditions turned into numbers, slopes and enclosures.

``extended`` and ``extended_derivatives``, which need mpmath, are loaded at their first use.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from rulesheets.evaluate.calculus import NotDifferentiable, differentiate, simplify
from rulesheets.evaluate.conditions import holds
from rulesheets.evaluate.enclosure import enclose
from rulesheets.evaluate.gradient import derivatives, rounded_derivatives
from rulesheets.evaluate.number import value
from rulesheets.evaluate.undefined import Undefined

if TYPE_CHECKING:
    from rulesheets.evaluate.precise import extended, extended_derivatives

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
    return getattr(import_module("rulesheets.evaluate.precise"), name)
