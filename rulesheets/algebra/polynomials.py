"""Polynomials of several unknowns with fractions for coefficients, by sympy."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from sympy import QQ
from sympy.polys.rings import ring


def generators(names: Sequence[str]) -> tuple[Any, ...]:
    """The unknowns as polynomials, which add, multiply and are raised to whole powers."""
    _, *found = ring(list(names), QQ)
    return tuple(found)


def exact(number: float | Fraction) -> Any:
    """A number as a coefficient."""
    return QQ(*number.as_integer_ratio())


def coefficients(polynomial: Any) -> list[Fraction]:
    """Of a polynomial in one unknown, lowest degree first; none of 0."""
    return [Fraction(int(c.numerator), int(c.denominator)) for c in reversed(polynomial.to_dense())]
