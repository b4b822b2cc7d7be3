"""Scales and windows: how many units a millimetre of paper stands for, and what part of the plane is seen.

Scales are the round ones of a drawing office: 1, 1.5, 2, 2.5, 3, 4, 5, 6 or 8 times a power of ten.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from solver.report.drawing.diagram import Diagram, Place

_ROUND = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)
_BAR = 14.0
"""Millimetres that a scale bar should at least have; a round length makes it less than twice as long."""


@dataclass(frozen=True)
class Window:
    """A rectangle of the plane of a diagram."""

    left: float
    bottom: float
    right: float
    top: float

    @property
    def width(self) -> float:
        return self.right - self.left

    @property
    def height(self) -> float:
        return self.top - self.bottom

    @property
    def reach(self) -> float:
        """The size of the largest coordinate."""
        return max(map(abs, (self.left, self.bottom, self.right, self.top)))

    def resized(self, width: float, height: float) -> Window:
        """The window of that size about the same middle."""
        x, y = (self.left + self.right) / 2, (self.bottom + self.top) / 2
        return Window(x - width / 2, y - height / 2, x + width / 2, y + height / 2)


def window(diagrams: Iterable[Diagram]) -> Window:
    """The least window that holds every point of the diagrams."""
    places = [place for diagram in diagrams for place in diagram.places.values()]
    return _around(places or [(0.0, 0.0)])


def _around(places: list[Place]) -> Window:
    xs, ys = zip(*places, strict=True)
    return Window(min(xs), min(ys), max(xs), max(ys))


def scale(width: float, height: float, room: Place) -> float:
    """The smallest round number of units a millimetre that fits width and height into the room (mm).

    A diagram without extent has the scale 1.
    """
    least = max(width / room[0], height / room[1])
    if least <= 0.0 or not math.isfinite(least):
        return 1.0
    power = math.floor(math.log10(least)) - 1
    candidates = (figure * 10.0**exponent for exponent in range(power, power + 4) for figure in _ROUND)
    return next(rounded(number) for number in candidates if number >= least * (1 - 1e-12))


def bar(units_per_mm: float) -> float:
    """A round length in units for the scale bar."""
    least = _BAR * units_per_mm
    power = 10.0 ** math.floor(math.log10(least))
    return rounded(
        next(figure * power for figure in (1.0, 2.0, 5.0, 10.0) if figure * power >= least * (1 - 1e-12))
    )


def rounded(number: float) -> float:
    """Without the noise of the power of ten."""
    return float(f"{number:.6g}")
