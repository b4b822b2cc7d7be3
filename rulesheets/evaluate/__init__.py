"""Expressions and conditions turned into numbers, slopes and enclosures.

What a plain solve has no need of is loaded at its first use: symbolic derivatives, and ``enclose``,
``extended`` and ``extended_derivatives``, which need mpmath.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rulesheets.evaluate.conditions import holds
from rulesheets.evaluate.gradient import derivatives, rounded_derivatives
from rulesheets.evaluate.number import Undefined, value

if TYPE_CHECKING:
    from rulesheets.evaluate.calculus import NotDifferentiable, differentiate, simplify
    from rulesheets.evaluate.enclosure import enclose
    from rulesheets.evaluate.precise import extended
    from rulesheets.evaluate.precise_gradient import extended_derivatives

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
    match name:
        case "NotDifferentiable" | "differentiate" | "simplify":
            from rulesheets.evaluate import calculus

            return getattr(calculus, name)
        case "enclose":
            from rulesheets.evaluate.enclosure import enclose

            return enclose
        case "extended":
            from rulesheets.evaluate.precise import extended

            return extended
        case "extended_derivatives":
            from rulesheets.evaluate.precise_gradient import extended_derivatives

            return extended_derivatives
        case _:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
