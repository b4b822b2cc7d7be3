"""Expressions and conditions turned into numbers, slopes and enclosures.

``enclose`` and ``extended`` are loaded at their first use, because they need numpy and mpmath.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rulesheets.evaluate.calculus import NotDifferentiable, differentiate, simplify
from rulesheets.evaluate.conditions import holds
from rulesheets.evaluate.gradient import derivatives, rounded_derivatives
from rulesheets.evaluate.number import Undefined, value

if TYPE_CHECKING:
    from rulesheets.evaluate.enclosure import enclose
    from rulesheets.evaluate.precise import extended

__all__ = [
    "NotDifferentiable",
    "Undefined",
    "derivatives",
    "differentiate",
    "enclose",
    "extended",
    "holds",
    "rounded_derivatives",
    "simplify",
    "value",
]


def __getattr__(name: str) -> Any:
    match name:
        case "enclose":
            from rulesheets.evaluate.enclosure import enclose

            return enclose
        case "extended":
            from rulesheets.evaluate.precise import extended

            return extended
        case _:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
