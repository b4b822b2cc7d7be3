"""A function of one unknown seen through its enclosures, and boxes cut into sections of it."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite, isnan
from typing import TYPE_CHECKING

from solver.numerics.bracket import split_point, value_at

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from typing import TypeAlias

    from solver.numerics.bracket import ScalarFunction

    Interval: TypeAlias = tuple[float, float]
    Enclosure: TypeAlias = Callable[[Sequence[Interval]], Sequence[Interval]]

HORIZON = 1e100
UNKNOWN = -inf, inf


class NoValue(Exception):
    """A function has no value at a point, not even a sign."""


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

    def is_remote(self, low: float, high: float) -> bool:
        """A box of which nobody asks: beyond ±1e100 where the range is infinite, or nearer to 0 than
        1e-100 without holding it. There enclosures overflow, and a box left open says nothing."""
        if (self.low == -inf and high <= -HORIZON) or (self.high == inf and low >= HORIZON):
            return True
        near = max(abs(low), abs(high)) <= 1 / HORIZON and (low > 0.0 or high < 0.0)
        return near and max(-self.low, self.high) > HORIZON**-0.5

    def ranges(self, boxes: Sequence[Interval]) -> list[Interval | None]:
        """Enclosures of f, a nan that stands alone widened to infinity; None where f is undefined all over
        the box, or known to have no root there."""
        self.evaluations += len(boxes)
        return [
            None if isnan(below) and isnan(above) else _widened(below, above)
            for below, above in self._enclose(boxes)
        ]

    def at(self, x: float) -> Interval | None:
        """The enclosure of f at one point."""
        return self.ranges([(x, x)])[0]

    def signed(self, x: float) -> float:
        """f at one point; where floats have no value, as beside ``0*sin(x*x)`` at 1e200, the nearest to 0
        that its enclosure admits. Raises NoValue where that may be 0."""
        f = value_at(self.value, x)
        if not isnan(f):
            return f
        below, above = self.at(x) or UNKNOWN
        if below > 0.0 or above < 0.0:
            return max(below, min(above, 0.0))
        raise NoValue

    def slopes(self, boxes: Sequence[Interval]) -> list[Interval]:
        """Enclosures of the slope, infinite where unknown."""
        if self._enclose_slope is None:
            return [UNKNOWN] * len(boxes)
        self.evaluations += len(boxes)
        return [_widened(below, above) for below, above in self._enclose_slope(boxes)]


def _widened(below: float, above: float) -> Interval:
    return -inf if isnan(below) else below, inf if isnan(above) else above


@dataclass(frozen=True, slots=True)
class Section:
    """A box cut at a middle point, with f enclosed at both ends and there.

    ``smooth`` tells whether a finite slope is known that agrees with those three values.
    """

    low: float
    middle: float
    high: float
    at_low: Interval
    at_middle: Interval
    at_high: Interval
    slope: Interval
    smooth: bool


def sections(function: IntervalFunction, boxes: Sequence[Interval]) -> list[Section]:
    """Evaluate f at the ends and at the middle of each box, and its slope on the box."""
    middles = [split_point(low, high) for low, high in boxes]
    points = [low for low, _ in boxes] + middles + [high for _, high in boxes]
    values, slopes = function.ranges([(x, x) for x in points]), function.slopes(boxes)
    k = len(boxes)
    return [
        _section(box, middle, at, slope)
        for box, middle, at, slope in zip(
            boxes,
            middles,
            zip(values[:k], values[k : 2 * k], values[2 * k :], strict=True),
            slopes,
            strict=True,
        )
    ]


def _section(
    box: Interval,
    middle: float,
    at: tuple[Interval | None, Interval | None, Interval | None],
    slope: Interval,
) -> Section:
    low, high = box
    at_low, at_middle, at_high = (UNKNOWN if value is None else value for value in at)
    smooth = (
        all(isfinite(below) and isfinite(above) for below, above in (slope, at_low, at_middle, at_high))
        and _agrees(at_low, at_middle, slope, middle - low)
        and _agrees(at_middle, at_high, slope, high - middle)
    )
    return Section(low, middle, high, at_low, at_middle, at_high, slope, smooth)


def _agrees(left: Interval, right: Interval, slope: Interval, distance: float) -> bool:
    """Whether f can rise from ``left`` to ``right`` with such slopes. A jump in between mostly can't."""
    least, most = slope[0] * distance, slope[1] * distance
    slack = 1e-14 * (abs(left[0]) + abs(right[0]) + abs(least) + abs(most))
    return right[1] >= left[0] + least - slack and right[0] <= left[1] + most + slack
