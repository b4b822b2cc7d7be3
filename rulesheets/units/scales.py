"""How large the units of expressions are: 1000 where a rule adds kN to N without a factor."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from itertools import combinations

from rulesheets.nodes import (
    Call,
    Expression,
    Name,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    bare,
    children,
)
from rulesheets.units.library import library
from rulesheets.units.unit import ANGLE, Unit

RELATIVE = 1e-3
"""How near a factor must be to numbers of the rule for these to explain it: 3.6, 9.81, 1.8 are rounded."""


def alike(node: Expression) -> Iterator[tuple[Expression, Expression]]:
    """Pairs of terms that are added, in an expression and all its parts."""
    if isinstance(node, Sum):
        first = next((term for term in node.terms if not bare(term)), None)
        for term in node.terms:
            if first is not None and term is not first and not bare(term):
                yield first, term
    for part in children(node):
        yield from alike(part)  # type: ignore[arg-type]


def scale(node: Expression, units: Mapping[str, Unit]) -> float | None:
    """One of the unit of an expression in base units, numbers aside; None where it is not known."""
    match node:
        case Number(unit=None):
            return 1.0
        case Name() | Number():
            unit = units.get(node.name) if isinstance(node, Name) else library().unit(node.unit or "")
            return None if unit is None or unit.bases.get(ANGLE) else unit.scale
        case Negative(operand):
            return scale(operand, units)
        case Sum(terms):
            return next((found for t in terms if not bare(t) and (found := scale(t, units))), None)
        case Product(left, right) | Quotient(left, right):
            one, other = scale(left, units), scale(right, units)
            if one is None or other is None:
                return None
            return one * other if isinstance(node, Product) else one / other
        case Power(base, Number(exponent)):
            below = scale(base, units)
            return None if below is None else below**exponent
        case Call("sqrt", (argument,)):
            below = scale(argument, units)
            return None if below is None else math.sqrt(below)
        case Call("pi" | "e", ()):
            return 1.0
        case _:
            return None


def explained(factor: float, written: Iterable[float]) -> bool:
    """Whether a factor is 1, a product of powers of numbers in the rule, or a divisor of one (32000)."""
    if math.isclose(factor, 1.0, rel_tol=1e-9):
        return True
    usual = [number for number in written if number not in (0.0, 1.0)]
    if any(number % max(factor, 1 / factor) == 0.0 for number in usual):
        return True
    powers = [number**e for number in usual for e in (1, -1, 2, -2, 0.5, -0.5)]
    products = (*powers, *(a * b for a, b in combinations(powers, 2)))
    return any(math.isclose(factor, product, rel_tol=RELATIVE) for product in products)
