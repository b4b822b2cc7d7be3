"""Where a residual of one tear may vanish, for a whole box of the numbers that it depends on.

The range of the tear is cut until on every piece the residual, whatever the known numbers are within their
box, is positive, or negative, or undefined, or defined throughout with a slope of one sign. Neighbouring
pieces of one slope are one bracket, in which no row has more than one root; between a stretch where the
residual is negative and one where it is positive every row has one. What is not cut down to such pieces is
not proven. (Neumaier, Interval Methods for Systems of Equations, 1990, section 5.1.)
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Sequence

    from solver.kernel.code.chain import Chain

    Box = tuple[tuple[float, ...], tuple[float, ...]]

HORIZON = 1e100
ROUNDS = 20
MAX_BOXES = 4000
MAX_PROOFS = 120
EVEN = 128
"""Pieces that a finite range is cut into before anything is known of it."""

SLACK = 1e-12
"""Share of a bound that pays for its own rounding."""

_UNDEFINED, _SLOPED = 0, 2


@dataclass(frozen=True, slots=True)
class Bracket:
    """At most one root of a row lies between ``low`` and ``high``: the residual rises there, or falls
    (``sign`` 1, -1). ``sure``: every row has it."""

    low: float
    high: float
    sign: int
    sure: bool


class Brackets:
    """Proofs for boxes of the known numbers, each made once and kept.

    ``domain`` is the range of the tear; beyond ±1e100 an infinite one is not looked at.
    """

    def __init__(self, chain: Chain, known: Sequence[str], domain: tuple[float, float]) -> None:
        self.chain, self.known = chain, tuple(known)
        self.low, self.high = domain
        self._proven: list[tuple[Box, tuple[Bracket, ...]]] = []
        self._open: set[Box] = set()
        self._enclosure: Any = None

    def around(self, lows: Sequence[float], highs: Sequence[float]) -> tuple[Bracket, ...] | None:
        """The brackets of a box that was proven before and holds these numbers."""
        for place, ((least, most), brackets) in enumerate(self._proven):
            within = zip(least, lows, highs, most, strict=True)
            if all(a <= b and c <= d for a, b, c, d in within):
                if place:  # the next row is likely to be near
                    self._proven.insert(0, self._proven.pop(place))
                return brackets
        return None

    def prove(self, lows: tuple[float, ...], highs: tuple[float, ...]) -> tuple[Bracket, ...] | None:
        """The brackets of a box, ascending; None where they are not proven."""
        box = lows, highs
        if box in self._open or len(self._open) + len(self._proven) >= MAX_PROOFS:
            return None
        brackets = self._searched(lows, highs)
        if brackets is None:
            self._open.add(box)
        else:
            self._proven.insert(0, (box, brackets))
        return brackets

    def _searched(self, lows: tuple[float, ...], highs: tuple[float, ...]) -> tuple[Bracket, ...] | None:
        import numpy as np

        if self._enclosure is None:
            from solver.kernel.code.enclosure import Enclosure

            self._enclosure = Enclosure(replace(self.chain, tears=(*self.chain.tears, *self.known)), ())
        if self._enclosure.slopes is None:
            return None
        ends = [end for pair in zip(lows, highs, strict=True) for end in pair]
        edges = _edges(self.low, self.high)
        lo, hi = edges[:-1], edges[1:]
        pieces: list[tuple[Any, Any]] = []
        for _ in range(ROUNDS):
            hull = [np.full(lo.shape, end) for end in ends]
            below, above = self._enclosure.range_on(lo, hi, hull)
            falls, rises = self._enclosure.slope_on(lo, hi, hull)
            undefined = np.isnan(below) & np.isnan(above)
            least, most = self._mean_value_form(lo, hi, hull, np.maximum(-falls, rises))
            positive, negative = (below > 0) | (least > 0), (above < 0) | (most < 0)
            up, down = falls > 0, rises < 0
            kinds = np.select(
                [undefined, positive, negative, up, down], [_UNDEFINED, 1, -1, _SLOPED, -_SLOPED], default=9
            )
            settled = kinds != 9
            pieces.append((lo[settled], kinds[settled]))
            lo, hi = lo[~settled], hi[~settled]
            if not lo.size:
                break
            middle = middles(lo, hi)
            lo, hi = np.concatenate([lo, middle]), np.concatenate([middle, hi])
            if lo.size > MAX_BOXES:
                break
        if lo.size:
            return None
        starts, kinds = (np.concatenate(column) for column in zip(*pieces, strict=True))
        order = np.argsort(starts, kind="stable")
        return self._merged(starts[order], kinds[order])

    def _mean_value_form(self, lo: Any, hi: Any, hull: list[Any], steepest: Any) -> tuple[Any, Any]:
        """The residual over each box from that in its middle; unbounded where the slope is."""
        import numpy as np

        middle = middles(lo, hi)
        below, above = self._enclosure.range_on(middle, middle, hull)
        with np.errstate(all="ignore"):
            reach = np.maximum(hi - middle, middle - lo)
            spread = (1.0 + SLACK) * np.maximum(steepest, 0.0) * reach
            least = below - spread - SLACK * np.abs(below)
            most = above + spread + SLACK * np.abs(above)
        return least, most

    def _merged(self, starts: Any, kinds: Any) -> tuple[Bracket, ...] | None:
        """Brackets from pieces in order, each told by where it starts."""
        import numpy as np

        first = np.flatnonzero(np.concatenate([[True], kinds[1:] != kinds[:-1]]))
        runs = [int(kind) for kind in kinds[first]]
        ends = [self.low, *(float(start) for start in starts[first][1:]), self.high]
        found = []
        for place, kind in enumerate(runs):
            if abs(kind) != _SLOPED:
                continue
            sign = 1 if kind > 0 else -1
            before = runs[place - 1] if place else _UNDEFINED
            after = runs[place + 1] if place + 1 < len(runs) else _UNDEFINED
            if abs(before) == _SLOPED or abs(after) == _SLOPED:
                return None
            if before != sign and after != -sign:
                sure = before == -sign and after == sign
                found.append(Bracket(ends[place], ends[place + 1], sign, sure))
        return tuple(found)


def between(low: float, high: float) -> float:
    """A point between the ends of a bracket, by size where an end is far."""
    if math.isinf(low) and math.isinf(high):
        return 0.0
    if math.isinf(high):
        return max(2.0 * low, 1.0)
    if math.isinf(low):
        return min(2.0 * high, -1.0)
    if low > 0.0 and high > 4.0 * low:
        return math.sqrt(low) * math.sqrt(high)
    return 0.5 * (low + high)


def middles(low: Any, high: Any) -> Any:
    """The same for arrays; boxes that end at infinity are cut by size as well."""
    import numpy as np

    with np.errstate(all="ignore"):
        middle = 0.5 * (low + high)
        middle = np.where((low > 0) & (high > 4 * low), np.sqrt(low) * np.sqrt(high), middle)
        middle = np.where((high < 0) & (low < 4 * high), -np.sqrt(-low) * np.sqrt(-high), middle)
        middle = np.where(np.isinf(high), np.maximum(2 * low, 1.0), middle)
        middle = np.where(np.isinf(low), np.minimum(2 * high, -1.0), middle)
        return np.where(np.isinf(high) & np.isinf(low), 0.0, middle)


def _edges(low: float, high: float) -> Any:
    """The range of the tear cut into boxes: evenly where it is finite, by size where it is not."""
    import numpy as np

    if math.isfinite(low) and math.isfinite(high):
        return np.linspace(low, high, EVEN + 1)
    sizes = 10.0 ** np.arange(-12, 13)
    edges = np.concatenate([[-HORIZON], -sizes[::-1], [0.0], sizes, [HORIZON]])
    inside = edges[(edges > low) & (edges < high)]
    ends = max(low, -HORIZON), min(high, HORIZON)
    return np.unique(np.concatenate([[ends[0]], inside, [ends[1]]]))
