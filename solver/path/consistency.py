"""Whether comparisons can hold together: the bounds that they put on one quantity must leave it a value.

With known values in, ``left - right`` is read as an affine form; forms that differ by a factor and a constant
bound the same quantity (``x - a < 0`` and ``2*x >= b``). What is not affine counts as an unknown of its own
(``x^2``, ``sin(t)``). Bounds are exact fractions, relaxed by the rounding errors of both sides: underflow
aside, nothing is excluded that a comparison of floats admits.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache, reduce
from itertools import chain, islice, product
from sys import float_info
from typing import TypeAlias

from rulesheets import nodes
from rulesheets.evaluate import Undefined, value
from rulesheets.model import Value
from rulesheets.nodes import And, Comparison, Condition, Expression, Negative, Not, Or, Product, Quotient, Sum
from solver.path.cases import AT_LEAST, AT_MOST, DIFFERENT, EQUAL, GREATER, LESS, Pair

MAX_ALTERNATIVES = 256
"""Combinations of the terms of ``and`` and ``or`` that are tried; beyond, nothing is excluded."""

ZERO = Fraction(0)
ROUNDING = Fraction(float_info.epsilon)
EQUALITY = 17
"""The tolerance of ``=`` between numbers, 16 ε of the larger, in ε of either."""

UNKNOWN_SIZE = Fraction(2) ** -26
"""Relaxation in the constant where a bounded quantity, such as ``x - y``, says nothing of the size of its
terms: good for terms 1e8 times as large."""

Signed: TypeAlias = tuple[Pair, int]
Quantity: TypeAlias = frozenset[tuple[Expression, Fraction]]
Bound: TypeAlias = tuple[Fraction | float, int]
"""A number, and where the bound is strict 1 for a lower and -1 for an upper one: then bounds compare."""

_UNBOUNDED: tuple[Bound, Bound] = ((-math.inf, 0), (math.inf, 0))
_ASSUMED = {
    (operator, holds): sign
    for holds, signs in (
        (True, (LESS, AT_MOST, GREATER, AT_LEAST, EQUAL, DIFFERENT)),
        (False, (AT_LEAST, GREATER, AT_MOST, LESS, DIFFERENT, EQUAL)),
    )
    for operator, sign in zip(("<", "<=", ">", ">=", "=", "<>"), signs, strict=True)
}


def possible(signs: Iterable[Signed], known: Mapping[str, Value]) -> bool:
    """Whether the assumed signs leave every quantity a value."""
    bounds: dict[Quantity, list[tuple[Bound, Bound]]] = {}
    for pair, sign in signs:
        names = (name for side in pair for name in nodes.names(side) if name in known)
        found = _bounds(pair, sign, tuple((name, known[name]) for name in names))
        if found is not None:
            bounds.setdefault(found[0], []).append(found[1])
    return all(
        max(low for low, _ in each) <= min(high for _, high in each)
        for each in bounds.values()
        if len(each) > 1
    )


def compatible(premises: Iterable[tuple[Condition, bool]], known: Mapping[str, Value]) -> bool:
    """Whether conditions can come out so together: some choice of their alternatives is possible."""
    choices = list(islice(product(*(_ways(*premise) for premise in premises)), MAX_ALTERNATIVES + 1))
    if len(choices) > MAX_ALTERNATIVES:
        return True
    return any(possible(chain.from_iterable(choice), known) for choice in choices)


def _ways(condition: Condition, holds: bool) -> list[tuple[Signed, ...]]:
    """The alternatives that each make a condition come out so."""
    match condition:
        case Comparison(operator, left, right):
            return [(((left, right), _ASSUMED[operator, holds]),)]
        case Not(term):
            return _ways(term, not holds)
        case And(terms) | Or(terms):
            parts = [_ways(term, holds) for term in terms]
            if isinstance(condition, Or) is holds:
                return list(chain.from_iterable(parts))
            together = islice(product(*parts), MAX_ALTERNATIVES + 1)
            return [tuple(chain.from_iterable(choice)) for choice in together]
        case _:
            return [()]


@lru_cache(4096)
def _bounds(
    pair: Pair, sign: int, values: tuple[tuple[str, Value], ...]
) -> tuple[Quantity, tuple[Bound, Bound]] | None:
    """The quantity that a comparison bounds, with its bounds; None where it bounds none."""
    known = dict(values)
    try:
        left, right = (_affine(side, known) for side in pair)
    except (Undefined, OverflowError):
        return None
    difference = left.plus(right.times(Fraction(-1)))
    slopes = {part: slope for part, slope in difference.slopes.items() if slope}
    if not slopes or sign == DIFFERENT:
        return None
    lead = slopes[min(slopes, key=repr)]
    at = -difference.constant / lead
    last = int(left.zero or right.zero)  # the sign of a rounded result is that of the exact one
    places = max(difference.operations - last, 0) + (EQUALITY if sign == EQUAL else 0)
    slack = _slack(difference, lead, at, places * ROUNDING) if places else Fraction(0)
    if slack is None:
        return None
    if lead < 0 and sign != EQUAL:
        sign = -sign
    low: Bound = (at - slack, int(sign == GREATER and not slack))
    high: Bound = (at + slack, -int(sign == LESS and not slack))
    return (
        frozenset((part, slope / lead) for part, slope in slopes.items()),
        (
            low if sign in (GREATER, AT_LEAST, EQUAL) else _UNBOUNDED[0],
            high if sign in (LESS, AT_MOST, EQUAL) else _UNBOUNDED[1],
        ),
    )


def _slack(difference: _Affine, lead: Fraction, at: Fraction, error: Fraction) -> Fraction | None:
    """How far from ``at`` the rounding of sides with this relative ``error`` may put a value."""
    if len(difference.sizes) > 1:
        return UNKNOWN_SIZE * difference.size / abs(lead) if error < EQUALITY * ROUNDING else None
    (size,) = difference.sizes.values()
    if 2 * error * size > abs(lead):
        return None
    return 2 * error * (size * abs(at) + difference.size) / abs(lead)


@dataclass(frozen=True, slots=True)
class _Affine:
    """``Σ slope · part + constant``; sizes are the same sums of absolute values.

    ``operations`` counts those that round when floats compute it.
    """

    slopes: Mapping[Expression, Fraction]
    sizes: Mapping[Expression, Fraction]
    constant: Fraction
    size: Fraction
    operations: int = 0

    @property
    def zero(self) -> bool:
        return not self.sizes and not self.constant

    def plus(self, other: _Affine) -> _Affine:
        return _Affine(
            _sum(self.slopes, other.slopes),
            _sum(self.sizes, other.sizes),
            self.constant + other.constant,
            self.size + other.size,
            self.operations + other.operations,
        )

    def times(self, factor: Fraction) -> _Affine:
        size = abs(factor)
        exact = abs(math.frexp(factor)[0]) == 0.5
        return _Affine(
            {part: slope * factor for part, slope in self.slopes.items()},
            {part: each * size for part, each in self.sizes.items()},
            self.constant * factor,
            self.size * size,
            self.operations + (not exact),
        )


def _sum(
    left: Mapping[Expression, Fraction], right: Mapping[Expression, Fraction]
) -> dict[Expression, Fraction]:
    return {part: left.get(part, ZERO) + right.get(part, ZERO) for part in (*left, *right)}


def _affine(expression: Expression, known: Mapping[str, Value]) -> _Affine:
    """Raises Undefined where a known part has no value."""
    if all(name in known for name in nodes.names(expression)):
        constant = Fraction(value(expression, known))
        return _Affine({}, {}, constant, abs(constant))
    match expression:
        case Negative(operand):
            return _affine(operand, known).times(Fraction(-1))
        case Sum(terms):
            total = reduce(_Affine.plus, (_affine(term, known) for term in terms))
            return replace(total, operations=total.operations + len(terms) - 1)
        case Product(left, right):
            one, other = _affine(left, known), _affine(right, known)
            if not one.sizes:
                return other.times(one.constant)
            if not other.sizes:
                return one.times(other.constant)
        case Quotient(left, right):
            divisor = _affine(right, known)
            if not divisor.sizes and divisor.constant:
                return _affine(left, known).times(1 / divisor.constant)
    return _Affine({expression: Fraction(1)}, {expression: Fraction(1)}, ZERO, ZERO)
