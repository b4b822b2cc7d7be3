"""Where labels go: each beside its point or stroke, clear of the lines and of each other.

Every label has a few candidate places; one after the other takes the cheapest, in rounds, since a later
one may make room for an earlier (greedy point-feature placement; Christensen, Marks and Shieber 1995).
Everything is in millimetres of paper.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

Place = tuple[float, float]
Segment = tuple[Place, Place]

_ROUNDS = 3
_DIRECTIONS = 16
_CROSSED, _COVERED, _OUTSIDE, _FAR = 6.0, 3.0, 40.0, 0.35
"""Costs: of a mm of line under a label, of a mm² of label or symbol under it, of a mm beyond the window,
of a mm away from the point."""


@dataclass(frozen=True)
class Box:
    """A rectangle by its middle and half its sides."""

    x: float
    y: float
    half_width: float
    half_height: float

    def overlap(self, other: Box) -> float:
        """The common area."""
        wide = self.half_width + other.half_width - abs(self.x - other.x)
        high = self.half_height + other.half_height - abs(self.y - other.y)
        return wide * high if wide > 0.0 and high > 0.0 else 0.0

    def inside(self, segment: Segment) -> float:
        """The length of the part of a segment that lies inside (Liang and Barsky 1984)."""
        (x0, y0), (x1, y1) = segment
        dx, dy = x1 - x0, y1 - y0
        enter, leave = 0.0, 1.0
        for step, low, high in (
            (dx, self.x - self.half_width - x0, self.x + self.half_width - x0),
            (dy, self.y - self.half_height - y0, self.y + self.half_height - y0),
        ):
            if step == 0.0:
                if low > 0.0 or high < 0.0:
                    return 0.0
                continue
            near, far = sorted((low / step, high / step))
            enter, leave = max(enter, near), min(leave, far)
        return max(0.0, leave - enter) * math.hypot(dx, dy)


@dataclass(frozen=True)
class Wish:
    """A label that wants a place: beside a point, or beside a segment (``along``).

    ``width`` and ``height`` are those of its text, ``clear`` how far from the point it has to stay.
    """

    key: str
    width: float
    height: float
    point: Place
    along: Segment | None = None
    clear: float = 1.4


def place(
    wishes: Sequence[Wish],
    segments: Sequence[Segment],
    symbols: Sequence[Box],
    size: Place,
    before: Mapping[str, Place] | None = None,
) -> dict[str, Box]:
    """A box for every wish by its key, in a window [0, width] × [0, height].

    ``before`` are offsets from the point that labels had in an earlier frame, which they keep where they can.
    """
    alone = {
        wish.key: sorted(
            (
                (_cost(box, wish, segments, symbols, size, (before or {}).get(wish.key)), number, box)
                for number, box in enumerate(_candidates(wish))
            ),
            key=lambda candidate: candidate[:2],
        )
        for wish in wishes
    }
    placed: dict[str, Box] = {}
    for _ in range(_ROUNDS):
        for wish in wishes:
            others = [box for key, box in placed.items() if key != wish.key]
            placed[wish.key] = _cheapest(alone[wish.key], others)
    return placed


def _cheapest(candidates: Sequence[tuple[float, int, Box]], others: Sequence[Box]) -> Box:
    """The box that costs least among the others; the candidates come with what they cost alone, ascending."""
    best, chosen = math.inf, candidates[0][2]
    for alone, _, box in candidates:
        if alone >= best:
            break
        cost = alone + 2 * _COVERED * sum(box.overlap(other) for other in others)
        if cost < best:
            best, chosen = cost, box
    return chosen


def _candidates(wish: Wish) -> Iterator[Box]:
    half_width, half_height = wish.width / 2, wish.height / 2
    if wish.along is not None:
        (x0, y0), (x1, y1) = wish.along
        length = math.hypot(x1 - x0, y1 - y0) or 1.0
        normal = (-(y1 - y0) / length, (x1 - x0) / length)
        for part in (0.5, 0.4, 0.6, 0.3, 0.7):
            for side in (1, -1):
                off = abs(normal[0]) * half_width + abs(normal[1]) * half_height + 0.7
                x = x0 + part * (x1 - x0) + side * off * normal[0]
                yield Box(x, y0 + part * (y1 - y0) + side * off * normal[1], half_width, half_height)
        return
    for clear in (wish.clear, wish.clear + 1.5, wish.clear + 3.5):
        for step in range(_DIRECTIONS):
            angle = 2 * math.pi * step / _DIRECTIONS + math.pi / 4
            dx, dy = math.cos(angle), math.sin(angle)
            x, y = wish.point[0] + dx * (clear + half_width), wish.point[1] + dy * (clear + half_height)
            yield Box(x, y, half_width, half_height)


def _cost(
    box: Box,
    wish: Wish,
    segments: Sequence[Segment],
    symbols: Sequence[Box],
    size: Place,
    before: Place | None,
) -> float:
    """What a place costs, other labels not counted."""
    covered = sum(box.overlap(symbol) for symbol in symbols)
    crossed = sum(box.inside(segment) for segment in segments)
    outside = sum(
        max(0.0, half - middle, middle + half - limit)
        for middle, half, limit in ((box.x, box.half_width, size[0]), (box.y, box.half_height, size[1]))
    )
    away = math.hypot(box.x - wish.point[0], box.y - wish.point[1])
    cost = _COVERED * covered + _CROSSED * crossed + _OUTSIDE * outside + _FAR * away
    if before is not None:
        cost += 0.4 * math.hypot(box.x - wish.point[0] - before[0], box.y - wish.point[1] - before[1])
    return round(cost, 6)  # so that rounding decides between no two places that are alike
