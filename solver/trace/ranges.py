"""Ranges of numbers: what the rule of which answer comes first says of all numbers in them at once.

Interval arithmetic without outward rounding: the rule counts in millionths, and asks for more than that.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from solver.ranking.arithmetic import LEAST, MOST, Arithmetic


@dataclass(frozen=True, slots=True, eq=False)
class Range:
    """The numbers from ``low`` to ``high``; of what is true or false 1 and 0."""

    low: float
    high: float

    def __add__(self, other: Any) -> Range:
        b = range_of(other)
        return Range(self.low + b.low, self.high + b.high)

    __radd__ = __add__

    def __neg__(self) -> Range:
        return Range(-self.high, -self.low)

    def __sub__(self, other: Any) -> Range:
        return self + -range_of(other)

    def __rsub__(self, other: Any) -> Range:
        return range_of(other) - self

    def __mul__(self, other: Any) -> Range:
        b = range_of(other)
        ends = [x * y if x and y else 0.0 for x, y in product((self.low, self.high), (b.low, b.high))]
        return Range(min(ends), max(ends))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Range:
        b = range_of(other)
        return self * Range(1.0 / b.high, 1.0 / b.low) if b.low > 0.0 else Range(-math.inf, math.inf)

    def __rtruediv__(self, other: Any) -> Range:
        return range_of(other) / self

    def __abs__(self) -> Range:
        least = 0.0 if self.low <= 0.0 <= self.high else min(abs(self.low), abs(self.high))
        return Range(least, max(abs(self.low), abs(self.high)))

    def __lt__(self, other: Any) -> Range:
        b = range_of(other)
        return Range(float(self.high < b.low), float(self.low < b.high))

    def __gt__(self, other: Any) -> Range:
        return range_of(other).__lt__(self)

    def __le__(self, other: Any) -> Range:
        b = range_of(other)
        return Range(float(self.high <= b.low), float(self.low <= b.high))

    def __ge__(self, other: Any) -> Range:
        return range_of(other).__le__(self)

    def __ne__(self, other: Any) -> Range:  # type: ignore[override]
        b = range_of(other)
        apart = self.high < b.low or b.high < self.low
        return Range(float(apart), float(apart or self.low < self.high or b.low < b.high))

    def __and__(self, other: Any) -> Range:
        b = range_of(other)
        return Range(min(self.low, b.low), min(self.high, b.high))

    __rand__ = __and__
    __hash__ = None  # type: ignore[assignment]


ANY = Range(-1e200, 1e200)


def range_of(number: Any) -> Range:
    return number if isinstance(number, Range) else Range(float(number), float(number))


def before(one: Sequence[Any], other: Sequence[Any]) -> bool:
    """Whether one key is less than another wherever the numbers of their ranges are."""
    for a, b in zip(map(range_of, one), map(range_of, other), strict=True):
        if a.high < b.low:
            return True
        if not a.high <= b.low:
            return False
    return False


def _largest(values: Sequence[Any]) -> Range:
    ranges = [range_of(value) for value in values]
    return Range(max(r.low for r in ranges), max(r.high for r in ranges))


def _rounded(value: Any) -> Range:
    r = range_of(value)
    return Range(*(float(round(x)) if math.isfinite(x) else x for x in (r.low, r.high)))


def _decade(value: Any) -> Range:
    size = abs(range_of(value))
    return Range(*(math.log10(min(max(x, LEAST), MOST)) for x in (size.low, size.high)))


def _there(value: Any, other: float) -> Any:
    return other if isinstance(value, float) and math.isnan(value) else value


RANGES = Arithmetic(_there, _largest, _rounded, _decade)
