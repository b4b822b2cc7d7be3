"""A small outward-rounded interval class over arrays, and enclosures made of ordinary
expressions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np


def _out(lo: Any, hi: Any, ulps: int = 1) -> Interval:
    for _ in range(ulps):
        lo, hi = np.nextafter(lo, -np.inf), np.nextafter(hi, np.inf)
    return Interval(lo, hi)


def _of(x: Any) -> Interval:
    return x if isinstance(x, Interval) else Interval(np.float64(x), np.float64(x))


@dataclass(frozen=True)
class Interval:
    lo: Any
    hi: Any

    def __neg__(self) -> Interval:
        return Interval(-self.hi, -self.lo)

    def __add__(self, other: Any) -> Interval:
        other = _of(other)
        return _out(self.lo + other.lo, self.hi + other.hi)

    def __sub__(self, other: Any) -> Interval:
        return self + -_of(other)

    def __rsub__(self, other: Any) -> Interval:
        return _of(other) - self

    def __mul__(self, other: Any) -> Interval:
        other = _of(other)
        pairs = [(a, b) for a in (self.lo, self.hi) for b in (other.lo, other.hi)]
        products = [np.where((a == 0) | (b == 0), 0.0, a * b) for a, b in pairs]
        return _out(np.minimum.reduce(products), np.maximum.reduce(products))

    def __truediv__(self, other: Any) -> Interval:
        return self * reciprocal(_of(other))

    def __rtruediv__(self, other: Any) -> Interval:
        return _of(other) * reciprocal(self)

    def __pow__(self, n: int) -> Interval:
        a, b = self.lo**n, self.hi**n
        lo, hi = np.minimum(a, b), np.maximum(a, b)
        if n % 2 == 0:
            lo = np.where((self.lo <= 0) & (self.hi >= 0), 0.0, lo)
        power = _out(lo, hi)
        return Interval(np.maximum(power.lo, 0.0), power.hi) if n % 2 == 0 else power

    __radd__ = __add__
    __rmul__ = __mul__


def reciprocal(x: Interval) -> Interval:
    """1/x; infinite at a bound of 0, the whole line around 0."""
    lo = np.where(x.hi == 0, -np.inf, 1 / np.where(x.hi == 0, 1.0, x.hi))
    hi = np.where(x.lo == 0, np.inf, 1 / np.where(x.lo == 0, 1.0, x.lo))
    around = (x.lo < 0) & (x.hi > 0)
    return _out(np.where(around, -np.inf, lo), np.where(around, np.inf, hi))


def magnitude(x: Interval) -> Interval:
    ends = abs(x.lo), abs(x.hi)
    return Interval(np.where((x.lo <= 0) & (x.hi >= 0), 0.0, np.minimum(*ends)), np.maximum(*ends))


def increasing(
    function: Callable[[Any], Any], least: float = -np.inf
) -> Callable[[Interval], Interval]:
    """The enclosure of an increasing function defined from ``least`` on, within two ulps."""

    def enclosure(x: Interval) -> Interval:
        inside = x.hi >= least
        lo, hi = function(np.maximum(x.lo, least)), function(np.maximum(x.hi, least))
        box = _out(lo, hi, 2)
        return Interval(np.where(inside, box.lo, np.nan), np.where(inside, box.hi, np.nan))

    return enclosure


exp = increasing(np.exp)
log = increasing(np.log, 0.0)
sqrt = increasing(np.sqrt, 0.0)


def sqrt_slope(x: Interval) -> Interval:
    """The slope of sqrt, infinite where a part of the box is outside the domain."""
    slope = 0.5 / sqrt(Interval(np.maximum(x.lo, 0.0), np.maximum(x.hi, 0.0)))
    return Interval(slope.lo, np.where(x.lo <= 0, np.inf, slope.hi))


def log_slope(x: Interval) -> Interval:
    slope = 1 / Interval(np.maximum(x.lo, 0.0), np.maximum(x.hi, 0.0))
    return Interval(slope.lo, np.where(x.lo <= 0, np.inf, slope.hi))


def sin(x: Interval) -> Interval:
    return cos(x - np.pi / 2)


def cos(x: Interval) -> Interval:
    """Ends, and ±1 where a multiple of π may lie inside."""
    first, last = np.ceil(x.lo / np.pi - 1e-9), np.floor(x.hi / np.pi + 1e-9)
    ends = np.cos(x.lo), np.cos(x.hi)
    even = (last - first >= 1) | ((last == first) & (first % 2 == 0))
    odd = (last - first >= 1) | ((last == first) & (first % 2 == 1))
    lo = np.where(odd, -1.0, np.minimum(*ends) - 4e-16)
    hi = np.where(even, 1.0, np.maximum(*ends) + 4e-16)
    return Interval(lo, hi)


def box_by_box(
    enclose: Callable[[Any, Any], tuple[Any, Any]],
) -> Callable[[Sequence[tuple[float, float]]], list[tuple[float, float]]]:
    """What encloses arrays ``(lo, hi)``, for boxes ``(low, high)``."""

    def boxes(boxes: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
        lo, hi = np.array(boxes).reshape(-1, 2).T
        with np.errstate(all="ignore"):
            below, above = (np.broadcast_to(end, lo.shape).tolist() for end in enclose(lo, hi))
        return list(zip(below, above, strict=True))

    return boxes


def enclosure(
    expression: Callable[[Any], Any],
) -> Callable[[Sequence[tuple[float, float]]], list[tuple[float, float]]]:
    """The enclosures over boxes of an expression written over Interval."""

    def enclose(lo: Any, hi: Any) -> tuple[Any, Any]:
        box = _of(expression(Interval(lo, hi)))
        return box.lo, box.hi

    return box_by_box(enclose)
