"""Short stretches of a tear on which the residual is convex or concave: it has two roots there at most.

If f'' ≥ m > 0 on a stretch, f ≥ f(x) − f'(x)²/2m there, for any x of it. So a value and a slope, in many
digits, tell that there is no root; and two roots, once they are found, are all.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rulesheets.evaluate import Undefined, extended
from rulesheets.model import Value
from solver.kernel.code.chain import Chain
from solver.kernel.code.enclosure import Enclosure, slope_chain
from solver.kernel.outcome import Stretch

MARGIN = 8.0
"""Widths by which a stretch is widened on both sides to look for its roots."""
CLOSE = 1e-6


def settled(
    stretches: Sequence[Stretch],
    floats: Mapping[str, Value],
    known: Mapping[str, Any],
    roots: Sequence[Mapping[str, Any]],
    doubles: Sequence[Mapping[str, Any]],
    digits: int,
) -> bool:
    """Whether all roots on the stretches are among ``roots`` (and the ``doubles``, which count twice).

    ``known``: the values that are given, in many digits; ``floats``: the same in floats.
    """
    for stretch in stretches:
        slope = slope_chain(stretch.chain)
        curvature = None if slope is None else _least_curvature(stretch, slope, floats)
        if slope is None or curvature is None:
            return False
        count = sum(_lies_on(stretch, root, floats) for root in roots)
        count += 2 * sum(_lies_on(stretch, root, floats) for root in doubles)
        if count < 2 and (count or not _excludes(stretch, slope, curvature, known, digits)):
            return False
    return bool(stretches)


def _least_curvature(stretch: Stretch, slope: Chain, floats: Mapping[str, Value]) -> float | None:
    """The value of f'' that is least in size, if f'' is proven not to vanish on the stretch."""
    numbers = {name: v for name, v in floats.items() if isinstance(v, float)}
    enclosure = Enclosure(slope, tuple(numbers))
    if enclosure.slopes is None:
        return None
    ((low, high),) = enclosure.slopes_over([(stretch.low, stretch.high)], list(numbers.values()))
    return float(low) if low > 0.0 else float(high) if high < 0.0 else None


def _lies_on(stretch: Stretch, root: Mapping[str, Any], floats: Mapping[str, Value]) -> bool:
    """Whether a root of the block is in the stretch or beside it, by the preimages of its chain."""
    pad = MARGIN * (stretch.high - stretch.low)
    x, turn = float(root[stretch.chain.tears[0]]), stretch.turn or 0.0
    if not any(stretch.low - pad <= x + k * turn <= stretch.high + pad for k in (-1, 0, 1)):
        return False
    values = {**floats, **root}
    for item in stretch.chain.assignments:
        try:
            values[item.name] = found = extended(item.expression, values)
        except (Undefined, OverflowError):
            return False
        meant = root.get(item.name, found)
        if abs(found - meant) > CLOSE * max(abs(found), abs(meant), 1e-300):
            return False
    return True


def _excludes(
    stretch: Stretch, slope: Chain, curvature: float, known: Mapping[str, Any], digits: int
) -> bool:
    """Whether f has no root on the stretch: tried at its middle, and where Newton's method leads for f'."""
    x = 0.5 * (stretch.low + stretch.high)
    for _ in range(4):
        values = {**known, slope.tears[0]: x}
        try:
            for item in slope.assignments:
                values[item.name] = extended(item.expression, values, digits)
        except (Undefined, OverflowError):
            return False
        value, steepness = values[stretch.chain.residuals[0]], values[slope.residuals[0]]
        if value * curvature > 0 and abs(value) * 2 * abs(curvature) > 1.001 * steepness * steepness:
            return True
        x = min(max(x + float(-steepness / curvature), stretch.low), stretch.high)
    return False
