"""A function of one unknown seen through its enclosures, and boxes cut into sections of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from solver.numerics.bracket import ScalarFunction, split_point

Array: TypeAlias = NDArray[np.float64]
Mask: TypeAlias = NDArray[np.bool_]
Enclosure: TypeAlias = Callable[[Array, Array], tuple[Array, Array]]


HORIZON = 1e100


class IntervalFunction:
    """f with its enclosures; counts the boxes evaluated."""

    def __init__(
        self,
        enclose: Enclosure,
        enclose_slope: Enclosure | None,
        value: ScalarFunction,
        low: float,
        high: float,
    ) -> None:
        self._enclose, self._enclose_slope = enclose, enclose_slope
        self.value, self.low, self.high = value, low, high
        self.evaluations = 0

    @property
    def has_slope(self) -> bool:
        return self._enclose_slope is not None

    def is_remote(self, lo: Array, hi: Array) -> Mask:
        """Boxes of which nobody asks: beyond ±1e100 where the range is infinite, and nearer to 0 than
        1e-100 without holding it. There enclosures overflow, and a box left open says nothing."""
        far = self.low == -np.inf, self.high == np.inf
        size = np.maximum(abs(lo), abs(hi))
        near = (size <= 1 / HORIZON) & ((lo > 0) | (hi < 0)) & (max(-self.low, self.high) > HORIZON**-0.5)
        remote: Mask = (far[0] & (hi <= -HORIZON)) | (far[1] & (lo >= HORIZON)) | near
        return remote

    def range_on(self, lo: Array, hi: Array) -> tuple[Array, Array, Mask]:
        """Enclosures of f with one-sided nan widened to infinity, and where f is defined at all."""
        self.evaluations += lo.size
        below, above = self._enclose(lo, hi)
        undefined = np.isnan(below) & np.isnan(above)
        return _widened(below, -np.inf), _widened(above, np.inf), ~undefined

    def slope_on(self, lo: Array, hi: Array) -> tuple[Array, Array]:
        """Enclosures of the slope, infinite where unknown."""
        if self._enclose_slope is None:
            return np.full(lo.shape, -np.inf), np.full(lo.shape, np.inf)
        self.evaluations += lo.size
        below, above = self._enclose_slope(lo, hi)
        return _widened(below, -np.inf), _widened(above, np.inf)


def _widened(bound: Array, infinity: float) -> Array:
    return np.where(np.isnan(bound), infinity, bound)


@dataclass(frozen=True, slots=True)
class Sections:
    """Boxes cut at a middle point, with f enclosed at both ends and there; each array (k,).

    ``smooth`` tells where a finite slope is known that agrees with those three values.
    """

    lo: Array
    hi: Array
    middle: Array
    at: tuple[tuple[Array, Array], tuple[Array, Array], tuple[Array, Array]]
    slope: tuple[Array, Array]
    smooth: Mask


def section(function: IntervalFunction, lo: Array, hi: Array) -> Sections:
    """Evaluate f at the ends and at the middle of each box, and its slope on the box."""
    middle = split_points(lo, hi)
    below, above, defined = function.range_on(*(np.concatenate([lo, middle, hi]),) * 2)
    k = lo.size
    at_low, at_middle, at_high = ((below[i * k : i * k + k], above[i * k : i * k + k]) for i in range(3))
    slope = function.slope_on(lo, hi)
    known = defined[:k] & defined[k : 2 * k] & defined[2 * k :]
    for bounds in (slope, at_low, at_middle, at_high):
        known &= np.isfinite(bounds[0]) & np.isfinite(bounds[1])
    known &= _agrees(at_low, at_middle, slope, middle - lo) & _agrees(at_middle, at_high, slope, hi - middle)
    return Sections(lo, hi, middle, (at_low, at_middle, at_high), slope, known)


def _agrees(
    left: tuple[Array, Array], right: tuple[Array, Array], slope: tuple[Array, Array], distance: Array
) -> Mask:
    """Whether f can rise from ``left`` to ``right`` with such slopes. A jump in between mostly can't."""
    slack = 1e-14 * (abs(left[0]) + abs(right[0]) + abs(slope[0] * distance) + abs(slope[1] * distance))
    least, most = left[0] + slope[0] * distance - slack, left[1] + slope[1] * distance + slack
    agrees: Mask = (right[1] >= least) & (right[0] <= most)
    return agrees


def split_points(lo: Array, hi: Array) -> Array:
    return np.array([split_point(a, b) for a, b in zip(lo.tolist(), hi.tolist(), strict=True)])
