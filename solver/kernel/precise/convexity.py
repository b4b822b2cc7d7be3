"""Short stretches of a tear on which the residual is convex or concave: it has two roots there at most.

If f'' ≥ m > 0 on a stretch, f ≥ f(x) − f'(x)²/2m there, for any x of it. So a value and a slope, to many
digits, tell that there is no root; and two roots, once they are found, are all.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rulesheets.evaluate import Undefined, extended
from rulesheets.model import Value
from solver.kernel.code.chain import Chain
from solver.kernel.outcome import Stretch

MARGIN = 8.0
"""Widths by which a stretch is widened on both sides to look for its roots."""
CLOSE = 1e-6


class Convex:
    """A stretch with the sign and the least size of f'' on it."""

    def __init__(self, stretch: Stretch, slope: Chain, curvature: float, known: Mapping[str, Value]) -> None:
        self.stretch, self.slope, self.curvature, self.known = stretch, slope, curvature, known

    def holds(self, root: Mapping[str, Any]) -> bool:
        """Whether a root of the block lies on this chain, in this stretch or beside it."""
        low, high = self.stretch.low, self.stretch.high
        pad = MARGIN * (high - low)
        x, turn = float(root[self.stretch.chain.tears[0]]), self.stretch.turn or 0.0
        inside = any(low - pad <= x + k * turn <= high + pad for k in (-1, 0, 1))
        return inside and self._leads_to(root)

    def _leads_to(self, root: Mapping[str, Any]) -> bool:
        """Whether this choice of preimages, and no other, gives the unknowns of a root."""
        values = {**self.known, **root}
        for item in self.stretch.chain.assignments:
            try:
                values[item.name] = found = extended(item.expression, values)
            except (Undefined, OverflowError):
                return False
            meant = root.get(item.name, found)
            if abs(found - meant) > CLOSE * max(abs(found), abs(meant), 1e-300):
                return False
        return True

    def excludes(self, known: Mapping[str, Any], digits: int) -> bool:
        """Whether f has no root on the stretch, for these ``known`` values to many digits."""
        low, high = self.stretch.low, self.stretch.high
        for _ in range(4):
            x = 0.5 * (low + high)
            found = self._value_and_slope(x, known, digits)
            if found is None:
                return False
            value, slope = found
            if value * self.curvature > 0 and abs(value) * 2 * abs(self.curvature) > 1.001 * slope * slope:
                return True
            shift = float(-slope / self.curvature)
            low = high = min(max(x + shift, self.stretch.low), self.stretch.high)
        return False

    def _value_and_slope(self, x: float, known: Mapping[str, Any], digits: int) -> tuple[Any, Any] | None:
        values = {**known, self.slope.tears[0]: x}
        try:
            for item in self.slope.assignments:
                values[item.name] = extended(item.expression, values, digits)
        except (Undefined, OverflowError):
            return None
        return values[self.stretch.chain.residuals[0]], values[self.slope.residuals[0]]


def convex(stretch: Stretch, known: Mapping[str, Value]) -> Convex | None:
    """The stretch, if f'' is proven not to vanish on it (``known`` in floats)."""
    from solver.kernel.code.enclosure import Enclosure, slope_chain

    slope = slope_chain(stretch.chain)
    if slope is None:
        return None
    numbers = {name: v for name, v in known.items() if isinstance(v, float)}
    enclosure = Enclosure(slope, tuple(numbers))
    if enclosure.slopes is None:
        return None
    ((low, high),) = enclosure.slopes_over([(stretch.low, stretch.high)], list(numbers.values()))
    if not (low > 0.0 or high < 0.0):
        return None
    return Convex(stretch, slope, low if low > 0.0 else high, known)


def settled(
    stretches: Sequence[Stretch],
    floats: Mapping[str, Value],
    known: Mapping[str, Any],
    roots: Sequence[Mapping[str, Any]],
    doubles: Sequence[Mapping[str, Any]],
    digits: int,
) -> bool:
    """Whether all roots on the stretches are among ``roots`` (and the ``doubles``, which count twice)."""
    for stretch in stretches:
        found = convex(stretch, floats)
        if found is None:
            return False
        count = sum(map(found.holds, roots)) + 2 * sum(map(found.holds, doubles))
        if count < 2 and not (count == 0 and found.excludes(known, digits)):
            return False
    return bool(stretches)
